#include "host/app/session_pictures.hpp"
#include "host/app/progress_line.hpp"
#include "host/app/session_balloon.hpp"
#include "host/model/interrupt.hpp"
#include "host/model/terminal.hpp"
#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace crn
{

namespace
{

constexpr int shown_bits = 12; // of XrayPicture::shown
constexpr std::uint32_t notice_ticks = 4000;

} // namespace

RadiopaqueInstrument instrument_look(const Instrument &instrument)
{
    RadiopaqueInstrument look;
    for (const InstrumentLayer &layer : instrument.layers) {
        const std::optional<Material> material = material_from_name(layer.material);
        if (!material) {
            throw std::runtime_error("instrument '" + instrument.name + "': unknown X-ray material '" +
                                     layer.material + "'; known: " + material_names());
        }
        look.sections.push_back(
            {layer.arc_begin_m, layer.arc_end_m, *material, layer.fill, layer.radius_share});
    }
    for (std::uint16_t i = 0; i < instrument.table.knots_count; i++) {
        const crn_wire_knot &knot = instrument.table.knots[i];
        look.radii.push_back({knot.arc_um * 1e-6, knot.radius_outer_um * 1e-6, knot.radius_inner_um * 1e-6});
    }
    return look;
}

SessionPictures::SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools)
    : settings_(settings), tools_(tools)
{
    for (const Instrument &tool : tools) {
        looks_.push_back(instrument_look(tool));
        names_.push_back(tool.name);
    }
    settings_.size = held_size(settings.size);
    std::string error;
    const SceneAnatomy anatomy = read_scene_anatomy(settings_.scene_path, settings_.bodies_path);
    const Bodies &bodies = anatomy.bodies;
    if (!scene_.set_bodies(bodies, error)) throw std::runtime_error(settings_.bodies_path + ": " + error);
    if (anatomy.motion) moving_.emplace(*anatomy.motion, bodies);
    opened_.emplace(bodies, LesionOpening(bodies.vessels, anatomy.stations), anatomy.motion_or_null());
    xray_ = std::make_unique<Xray>(scene_, settings_.threads,
                                   paths_maker(settings_.xray, settings_.window_context));
    if (settings_.style == "vcsim3") thesis_look_ = std::make_unique<Vcsim3Look>(bodies, settings_.threads);
    contrast_ = contrast_of(anatomy, tools);
    stents_ = stents_of(anatomy, settings_.stents, tools);
    const bool needs_movie = !settings_.mp4_path.empty();
    if (needs_movie && !movie_.open(settings_.mp4_path, settings_.size, settings_.size,
                                    static_cast<int>(settings_.pictures_per_second), error)) {
        throw std::runtime_error(error);
    }
    if (settings_.dicom.folder.empty()) return;
    std::string session;
    for (const std::string &name : names_) session += name + "\n";
    export_ = std::make_unique<DicomExport>(settings_.dicom, session);
}

SessionPictures::~SessionPictures() = default;

std::unique_ptr<SessionStents> make_stents(const PictureSettings &settings,
                                           const std::vector<Instrument> &tools)
{
    if (settings.stents.empty()) return {};
    return stents_of(read_scene_anatomy(settings.scene_path, settings.bodies_path), settings.stents, tools);
}

std::unique_ptr<SessionContrast> contrast_of(const SceneAnatomy &anatomy,
                                             const std::vector<Instrument> &tools)
{
    const VesselTree &vessels = anatomy.bodies.vessels;
    return std::make_unique<SessionContrast>(vessels, tools, anatomy.motion_or_null(),
                                             LesionOpening(vessels, anatomy.stations));
}

std::unique_ptr<SessionStents> stents_of(const SceneAnatomy &anatomy, const std::vector<StentDesign> &designs,
                                         const std::vector<Instrument> &tools)
{
    if (designs.empty()) return {};
    return std::make_unique<SessionStents>(designs, anatomy.bodies.vessels, anatomy.motion_or_null(),
                                           anatomy.stations, tools);
}

bool writes_pictures(const PictureSettings &settings)
{
    return !settings.png_path.empty() || !settings.png16_path.empty() || !settings.mp4_path.empty() ||
           !settings.dicom.folder.empty();
}

OverlayInfo SessionPictures::display(const SessionFrame &frame) const
{
    OverlayInfo info;
    info.room = room_.status();
    info.time_s = frame.wire.tick * 1e-3;
    for (std::size_t k = 0; k < frame.tools.size(); k++) {
        const ToolReading &tool = frame.tools[k];
        info.tools.push_back({k < names_.size() ? names_[k] : "", tool.inserted_m * 1e3, tool.turned_deg,
                              tool.axial_N, tool.torque_N_m * 1e3,
                              frame.tools.size() > 1 && (chosen_tool_ == k || chooses_all_)});
    }
    const DoseMeter &dose = room_.dose();
    info.fluoro_min = dose.fluoro_ticks() / 60e3;
    info.kerma_mGy = dose.total().air_kerma_uGy * 1e-3;
    info.kerma_rate_mGy_min = dose.kerma_rate_mGy_min();
    info.kap_Gy_cm2 = dose.total().kap_Gy_cm2;
    if (dose.unseen_alert()) info.dose_alert_Gy = dose_alert_levels_Gy[*dose.unseen_alert()];
    if (dose.has_unseen_reminder())
        info.fluoro_reminder_min = dose.fluoro_reminders() * fluoro_reminder_ticks / 60'000;
    if (contrast_->was_used()) {
        info.contrast_ml = contrast_->injected_ml();
        info.contrast_ml_s = contrast_->flow_ml_s();
    }
    info.balloon = balloon_display();
    info.pulse = monitor_.has_samples() ? &monitor_ : nullptr;
    info.notice = notice_.empty() ? info.room.notice : notice_;
    if (info.notice.empty() && frame.wire.tick < refused_notice_until_) info.notice = refused_notice_;
    info.panel = panel_;
    return info;
}

void SessionPictures::command(std::uint32_t tick, const RoomCommand &command)
{
    const std::string why = room_.give(tick, command);
    if (!why.empty()) throw std::runtime_error("the X-ray room cannot do this: " + why);
    std::string refused = contrast_->command(tick, command);
    const std::size_t refusals = stents_ ? stents_->refusals().size() : 0;
    if (stents_) stents_->command(tick, command);
    if (stents_ && stents_->refusals().size() > refusals) refused = stents_->refusals().back();
    if (command.action == RoomAction::load_stent && !stents_) refused = "NO STENT - name one with --stent";
    if (!refused.empty()) show_refusal(tick, refused);
}

void SessionPictures::show_refusal(std::uint32_t tick, const std::string &why)
{
    refused_notice_ = why;
    refused_notice_until_ = tick + notice_ticks;
}

std::vector<Refusal> SessionPictures::refusals() const
{
    std::vector<Refusal> all = room_.refusals();
    all.insert(all.end(), contrast_->refusals().begin(), contrast_->refusals().end());
    std::stable_sort(all.begin(), all.end(),
                     [](const Refusal &a, const Refusal &b) { return a.tick < b.tick; });
    return all;
}

void SessionPictures::tick(const crn_wire_encoders &input, const crn_wire_tick_state &state)
{
    monitor_.tick(state);
    const std::size_t refusals = contrast_->refusals().size();
    contrast_->tick(state);
    if (contrast_->refusals().size() > refusals) show_refusal(state.tick, contrast_->refusals().back().why);
    if (stents_) stents_->tick(input, state);
    state_ = state;
}

std::uint32_t SessionPictures::next_look() const
{
    return std::min(contrast_->next_tick(), stents_ ? stents_->next_tick() : UINT32_MAX);
}

void SessionPictures::look(const SessionFrame &frame)
{
    contrast_->advance(frame.wire);
    if (stents_) stents_->advance(frame.wire);
}

std::optional<crn_wire_strut> SessionPictures::strut_order()
{
    return stents_ ? stents_->strut_order() : std::optional<crn_wire_strut>();
}

std::optional<crn_wire_scaffold> SessionPictures::order()
{
    return stents_ ? stents_->order() : std::optional<crn_wire_scaffold>();
}

// Only with a balloon; its stent by what has become of it.
OverlayBalloon SessionPictures::balloon_display() const
{
    OverlayBalloon display;
    display.is_shown = state_.balloon_diameter_max_um > 0;
    display.pressure_bar = state_.balloon_kPa * 1e-2;
    display.diameter_max_mm = state_.balloon_diameter_max_um * 1e-3;
    display.diameter_min_mm = state_.balloon_diameter_min_um * 1e-3;
    display.is_burst = state_.balloon_bits != 0;
    if (stents_) display.stent = stents_->stage_text();
    return display;
}

std::uint32_t SessionPictures::next_tick() const
{
    return std::min({room_.next_tick(), next_look(), picture_tick(count_, settings_.pictures_per_second)});
}

// The room goes on to `tick`; true when there is a new X-ray.
bool SessionPictures::advance(std::uint32_t tick, const SessionFrame &frame)
{
    room_.advance(tick, frame.wire.nodes.empty() ? nullptr : &frame.wire.nodes.front().position_m);
    if (!room_.is_pulse_due()) return false;
    const PulseRequest request = room_.pulse();
    XraySettings xray;
    xray.carm = request.carm;
    xray.beam = request.beam;
    xray.size = settings_.size;
    WireFrame shape = frame.wire;
    shape.tick = tick;
    contrast_->colour(shape);
    const std::vector<MovedBody> moved = moved_at(shape);
    const std::vector<SweptCurve> curves = curves_at(shape);
    const XrayFrame seen{looks_, shape, curves, moved};
    xray_->render(xray, seen, settings_.seed, request.settles_at_once ? nullptr : &memory_, pulse_);
    tell_failure();
    if (export_) export_pulse(); // what is written for measurement stays physical
    if (thesis_look_) thesis_look_->draw(xray, seen, settings_.seed, pulse_);
    room_.expose(pulse_);
    return true;
}

// Medium in the vessels and in the balloon, and struts.
std::vector<SweptCurve> SessionPictures::curves_at(const WireFrame &shape)
{
    std::vector<SweptCurve> curves = balloon_filling(shape, tools_, settings_.balloon_iodine_mg_per_ml);
    if (stents_) {
        std::vector<SweptCurve> struts = stents_->curves_at(shape);
        curves.insert(curves.end(), std::make_move_iterator(struts.begin()),
                      std::make_move_iterator(struts.end()));
    }
    curves.insert(curves.end(), contrast_->curves().begin(), contrast_->curves().end());
    return curves;
}

// Bodies beat with the wire's own tick, and walls stand where the core's lesions have given way to.
std::vector<MovedBody> SessionPictures::moved_at(const WireFrame &shape)
{
    const MotionMoment moment{shape.heart_phase32, shape.breath_phase32};
    std::span<const MovingBodies::Moved> beating;
    if (moving_ && !moving_->is_empty()) beating = moving_->at(moment);
    std::vector<MovedBody> moved;
    for (const MovingBodies::Moved &body : opened_->at(moment, shape.lesions_open, beating))
        moved.push_back({body.body, body.vertices_um});
    return moved;
}

// A rig that leads sends its shapes at its own times: pulses between two of them are made with the later one.
void SessionPictures::frame(const SessionFrame &frame)
{
    const std::uint32_t now = frame.wire.tick;
    look(frame);
    bool is_new = false;
    while (has_begun_ && room_.next_tick() < now) is_new = advance(room_.next_tick(), frame) || is_new;
    is_new = advance(now, frame) || is_new;
    has_begun_ = true;
    const bool is_due = now >= picture_tick(count_, settings_.pictures_per_second);
    if (is_new || is_due) redraw(frame);
    std::string error;
    while (now >= picture_tick(count_, settings_.pictures_per_second)) {
        const bool is_last = now < picture_tick(++count_, settings_.pictures_per_second);
        if (is_last && movie_.is_open() && !movie_.add(image_, error)) throw std::runtime_error(error);
    }
}

// A graphics driver that gives up does not end a session: the rasteriser goes on.
void SessionPictures::tell_failure()
{
    if (told_failure_ || xray_->back_end_error().empty()) return;
    told_failure_ = true;
    say(stderr, "cournand: %s; the rasteriser draws from here on\n", xray_->back_end_error().c_str());
}

// A run is what one press of a pedal gave. Called before the room takes the picture.
void SessionPictures::export_pulse()
{
    const bool shows_display = settings_.dicom.values == "display";
    const std::size_t press = room_.dose().irradiations().size();
    if (exported_presses_.empty() || exported_presses_.back() != press) {
        XrayRun run = room_.describe(pulse_);
        run.window_width = 0.0; // of the whole run, when it is known
        if (shows_display) {
            run.relation = PixelRelation::display;
            run.bits = shown_bits;
            run.window_centre = XrayDisplay{}.level;
            run.window_width = XrayDisplay{}.window;
        }
        export_->begin(run);
        exported_presses_.push_back(press);
    }
    RunFrame frame = room_.take(pulse_);
    if (shows_display) frame.raw = pulse_.shown;
    export_->add(std::move(frame));
}

void SessionPictures::annotate(const std::string &notice, const std::vector<std::string> &panel)
{
    notice_ = notice;
    panel_ = panel;
}

void SessionPictures::redraw(const SessionFrame &frame)
{
    screen_.size = settings_.size;
    room_.compose(settings_.size, screen_.grey);
    image_ = compose_display(screen_, display(frame));
}

void SessionPictures::finish()
{
    std::string error;
    if (movie_.is_open() && !movie_.finish(error)) throw std::runtime_error(error);
    if (!settings_.png_path.empty() && count_ > 0 && !write_png(settings_.png_path, image_, error)) {
        throw std::runtime_error(error);
    }
    if (!settings_.png16_path.empty() && pulse_.size > 0 &&
        !write_png16(settings_.png16_path, pulse_.size, pulse_.size, pulse_.raw, error)) {
        throw std::runtime_error(error);
    }
    for (const std::string &path : {settings_.mp4_path, settings_.png_path, settings_.png16_path})
        if (!path.empty()) files_.push_back(path);
    if (export_) finish_export();
}

// After Ctrl-C in the session what there is of it is written all the same; Ctrl-C from now on stops between two pieces.
void SessionPictures::finish_export()
{
    export_->end();
    if (export_->run_count() == 0) {
        say(stderr, "cournand: --dicom %s: no file, because the pedal was never down\n",
            settings_.dicom.folder.c_str());
        export_.reset();
        return;
    }
    // Masks are chosen while a run is looked at: those of the end count.
    const std::vector<Irradiation> &presses = room_.dose().irradiations();
    for (std::size_t i = 0; i < exported_presses_.size(); i++) {
        const int kept = presses[exported_presses_[i] - 1].run;
        const StoredRun *stored = kept > 0 ? room_.store().find(kept) : nullptr;
        if (stored && stored->run.mask) export_->set_mask(i, *stored->run.mask);
    }
    export_->set_contrast(
        [&](std::uint32_t first, std::uint32_t last) { return contrast_->given(first, last); });
    const bool was_interrupted = is_interrupted();
    std::size_t files = 0;
    ProgressLine line(settings_.shows_progress);
    const std::vector<std::string> written = export_->finish([&](const ExportProgress &now) {
        files = now.files;
        line.show("writing " + now.name + " (" + std::to_string(now.file) + " of " +
                      std::to_string(now.files) + ")",
                  now.bytes_done, now.bytes);
        return was_interrupted || !is_interrupted();
    });
    was_stopped_ = written.size() < files;
    if (was_stopped_)
        say(stderr, "cournand: stopped: %zu of %zu DICOM files were written, each of them whole\n",
            written.size(), files);
    files_.insert(files_.end(), written.begin(), written.end());
    export_.reset();
}

} // namespace crn
