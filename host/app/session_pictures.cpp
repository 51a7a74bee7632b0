#include "host/app/session_pictures.hpp"
#include "host/model/bodies.hpp"
#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace seld
{

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
        const seld_wire_knot &knot = instrument.table.knots[i];
        look.radii.push_back({knot.arc_um * 1e-6, knot.radius_outer_um * 1e-6, knot.radius_inner_um * 1e-6});
    }
    return look;
}

SessionPictures::SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools)
    : settings_(settings)
{
    for (const Instrument &tool : tools) {
        looks_.push_back(instrument_look(tool));
        names_.push_back(tool.name);
    }
    settings_.size = held_size(settings.size);
    std::string error;
    Bodies bodies;
    if (!settings_.bodies_path.empty() && !read_bodies(settings_.bodies_path, bodies, error)) {
        throw std::runtime_error(error);
    }
    if (!scene_.set_bodies(bodies, error)) throw std::runtime_error(settings_.bodies_path + ": " + error);
    xray_ = std::make_unique<Xray>(scene_, settings_.threads,
                                   paths_maker(settings_.xray, settings_.window_context));
    const bool needs_movie = !settings_.mp4_path.empty();
    if (needs_movie && !movie_.open(settings_.mp4_path, settings_.size, settings_.size,
                                    static_cast<int>(settings_.pictures_per_second), error)) {
        throw std::runtime_error(error);
    }
}

SessionPictures::~SessionPictures() = default;

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
    info.notice = notice_.empty() ? info.room.notice : notice_;
    info.panel = panel_;
    return info;
}

void SessionPictures::command(std::uint32_t tick, const RoomCommand &command)
{
    const std::string why = room_.give(tick, command);
    if (!why.empty()) throw std::runtime_error("the X-ray room cannot do this: " + why);
}

std::uint32_t SessionPictures::next_tick() const
{
    return std::min(room_.next_tick(), picture_tick(count_, settings_.pictures_per_second));
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
    if (request.settles_at_once)
        xray_->render(xray, looks_, shape, settings_.seed, pulse_);
    else
        xray_->render(xray, looks_, shape, settings_.seed, memory_, pulse_);
    tell_failure();
    room_.expose(pulse_);
    return true;
}

// A rig that leads sends its shapes at its own times: pulses between two of them are made with the later one.
void SessionPictures::frame(const SessionFrame &frame)
{
    const std::uint32_t now = frame.wire.tick;
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
    std::fprintf(stderr, "seldinger: %s; the rasteriser draws from here on\n",
                 xray_->back_end_error().c_str());
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
}

} // namespace seld
