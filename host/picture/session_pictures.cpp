#include "host/picture/session_pictures.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/patient/balloon.hpp"
#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace crn
{

namespace
{

constexpr int shown_bits = 12; // of XrayPicture::shown

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

SceneAnatomy read_anatomy(const PictureSettings &settings)
{
    return read_scene_anatomy(settings.scene_path, settings.bodies_path);
}

std::unique_ptr<Patient> make_patient(const PictureSettings &settings, const SceneAnatomy &anatomy,
                                      const std::vector<Instrument> &tools)
{
    return std::make_unique<Patient>(anatomy, tools, PatientSettings{settings.bodies_path, settings.stents});
}

SessionPictures::SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools,
                                 Patient &patient, const SceneAnatomy &anatomy)
    : settings_(settings), patient_(patient), room_screen_(patient.room()), tools_(tools)
{
    for (const Instrument &tool : tools) {
        looks_.push_back(instrument_look(tool));
        names_.push_back(tool.name);
    }
    settings_.size = held_size(settings.size);
    xray_ = std::make_unique<Xray>(patient.scene(), settings_.threads,
                                   paths_maker(settings_.xray, settings_.window_context));
    if (settings_.style == "vcsim3")
        thesis_look_ = std::make_unique<Vcsim3Look>(anatomy.bodies, settings_.threads);
    std::string error;
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

bool writes_pictures(const PictureSettings &settings)
{
    return !settings.png_path.empty() || !settings.png16_path.empty() || !settings.mp4_path.empty() ||
           !settings.dicom.folder.empty();
}

OverlayInfo SessionPictures::display(const SessionFrame &frame) const
{
    OverlayInfo info;
    info.room = room_screen_.status();
    info.time_s = frame.wire.tick * 1e-3;
    for (std::size_t k = 0; k < frame.tools.size(); k++) {
        const ToolReading &tool = frame.tools[k];
        info.tools.push_back({k < names_.size() ? names_[k] : "", tool.inserted_m * 1e3, tool.turned_deg,
                              tool.axial_N, tool.torque_N_m * 1e3,
                              frame.tools.size() > 1 && (chosen_tool_ == k || chooses_all_)});
    }
    const DoseMeter &dose = patient_.room().dose();
    info.fluoro_min = dose.fluoro_ticks() / 60e3;
    info.kerma_mGy = dose.total().air_kerma_uGy * 1e-3;
    info.kerma_rate_mGy_min = dose.kerma_rate_mGy_min();
    info.kap_Gy_cm2 = dose.total().kap_Gy_cm2;
    if (dose.unseen_alert()) info.dose_alert_Gy = dose_alert_levels_Gy[*dose.unseen_alert()];
    if (dose.has_unseen_reminder())
        info.fluoro_reminder_min = dose.fluoro_reminders() * fluoro_reminder_ticks / 60'000;
    const PatientContrast &contrast = patient_.contrast();
    if (contrast.was_used()) {
        info.contrast_ml = contrast.injected_ml();
        info.contrast_ml_s = contrast.flow_ml_s();
    }
    info.balloon = balloon_display();
    info.pulse = patient_.monitor().has_samples() ? &patient_.monitor() : nullptr;
    info.is_pressure_damped = patient_.catheter_pressure().is_damped();
    info.notice = notice_.empty() ? info.room.notice : notice_;
    const RoomNotice &refused = refused_.from > patient_.notice().from ? refused_ : patient_.notice();
    if (info.notice.empty() && refused.is_shown_at(frame.wire.tick)) info.notice = refused.text;
    info.panel = panel_;
    return info;
}

void SessionPictures::show_refusal(std::uint32_t tick, const std::string &why)
{
    refused_ = {why, tick};
}

// Returns the values of balloon and stent for the display, which are shown only if a tool has a balloon. The
// text about the stent is its stage, such as "on its balloon".
OverlayBalloon SessionPictures::balloon_display() const
{
    OverlayBalloon display;
    const crn_wire_tick_state &state = patient_.state();
    display.is_shown = state.balloon_diameter_max_um > 0;
    display.pressure_bar = state.balloon_kPa * 1e-2;
    display.diameter_max_mm = state.balloon_diameter_max_um * 1e-3;
    display.diameter_min_mm = state.balloon_diameter_min_um * 1e-3;
    display.is_burst = state.balloon_bits != 0;
    if (patient_.stents()) display.stent = patient_.stents()->stage_text();
    return display;
}

std::uint32_t SessionPictures::next_tick() const
{
    return std::min(patient_.next_look(), picture_tick(count_, settings_.pictures_per_second));
}

// Processes the events of the X-ray room up to this frame, and returns true when there is a new X-ray
// picture.
bool SessionPictures::see_events(const WireFrame &wire)
{
    bool is_new = false;
    for (const RoomEvent &event : patient_.room().events()) {
        const bool is_pulse = event.kind == RoomEvent::Kind::pulse;
        if (is_pulse) expose(event, wire);
        room_screen_.take(event, is_pulse ? &pulse_ : nullptr);
        is_new = is_new || is_pulse;
    }
    return is_new;
}

// Computes the picture of an X-ray pulse, with the exposure technique that automatic exposure control has
// chosen.
void SessionPictures::expose(const RoomEvent &pulse, const WireFrame &wire)
{
    XraySettings xray;
    xray.carm = pulse.request.carm;
    xray.beam = pulse.request.beam;
    xray.beam.fixed_technique = pulse.exposure.technique;
    xray.size = settings_.size;
    WireFrame shape = wire;
    shape.tick = pulse.tick;
    patient_.contrast().colour(shape);
    const std::vector<SweptCurve> curves = curves_at(shape);
    const XrayFrame seen{looks_, shape, curves, patient_.bodies_at(shape)};
    xray_->render(xray, seen, settings_.seed, pulse.request.settles_at_once ? nullptr : &memory_, pulse_);
    tell_failure();
    if (export_) export_pulse(pulse); // exported data stay physical
    if (thesis_look_) thesis_look_->draw(xray, seen, settings_.seed, pulse_);
}

// Returns the curves that are drawn in addition to the tools: the medium in the vessels and in the balloon,
// and the struts of stents.
std::vector<SweptCurve> SessionPictures::curves_at(const WireFrame &shape)
{
    std::vector<SweptCurve> curves = balloon_filling(shape, tools_, settings_.balloon_iodine_mg_per_ml);
    if (PatientStents *stents = patient_.stents()) {
        std::vector<SweptCurve> struts = stents->curves_at(shape);
        curves.insert(curves.end(), std::make_move_iterator(struts.begin()),
                      std::make_move_iterator(struts.end()));
    }
    const std::vector<SweptCurve> &medium = patient_.contrast().curves();
    curves.insert(curves.end(), medium.begin(), medium.end());
    return curves;
}

void SessionPictures::frame(const SessionFrame &frame)
{
    const std::uint32_t now = frame.wire.tick;
    const bool is_new = see_events(frame.wire);
    const bool is_due = now >= picture_tick(count_, settings_.pictures_per_second);
    if (is_new || is_due) redraw(frame);
    std::string error;
    while (now >= picture_tick(count_, settings_.pictures_per_second)) {
        const bool is_last = now < picture_tick(++count_, settings_.pictures_per_second);
        if (is_last && movie_.is_open() && !movie_.add(image_, error)) throw std::runtime_error(error);
    }
}

// If a graphics driver fails, the session goes on, and the rasteriser computes the path lengths.
void SessionPictures::tell_failure()
{
    if (told_failure_ || xray_->back_end_error().empty()) return;
    told_failure_ = true;
    say(stderr, "cournand: %s; the rasteriser draws from here on\n", xray_->back_end_error().c_str());
}

// All X-ray pulses from pressing a pedal to releasing it form one run.
void SessionPictures::export_pulse(const RoomEvent &pulse)
{
    const bool shows_display = settings_.dicom.values == "display";
    if (exported_presses_.empty() || exported_presses_.back() != pulse.press) {
        XrayRun run = RoomScreen::describe(pulse, pulse_);
        run.window_width = 0.0; // set for the whole run at its end
        if (shows_display) {
            run.relation = PixelRelation::display;
            run.bits = shown_bits;
            run.window_centre = XrayDisplay{}.level;
            run.window_width = XrayDisplay{}.window;
        }
        export_->begin(run);
        exported_presses_.push_back(pulse.press);
    }
    RunFrame frame = RoomScreen::frame_of(pulse, pulse_);
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
    room_screen_.compose(settings_.size, screen_.grey);
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

// If the user presses Ctrl-C during the session, the runs made so far are written nevertheless. Another
// Ctrl-C stops the export between two pieces of a file.
void SessionPictures::finish_export()
{
    export_->end();
    if (export_->run_count() == 0) {
        say(stderr, "cournand: --dicom %s: no file, because the pedal was never down\n",
            settings_.dicom.folder.c_str());
        export_.reset();
        return;
    }
    // The user may change the mask while reviewing a run, and the files contain the last mask of each run.
    const std::vector<Irradiation> &presses = patient_.room().dose().irradiations();
    for (std::size_t i = 0; i < exported_presses_.size(); i++) {
        const int kept = presses[exported_presses_[i]].run;
        const StoredRun *stored = kept > 0 ? room_screen_.store().find(kept) : nullptr;
        if (stored && stored->run.mask) export_->set_mask(i, *stored->run.mask);
    }
    export_->set_contrast(
        [&](std::uint32_t first, std::uint32_t last) { return patient_.contrast().given(first, last); });
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
