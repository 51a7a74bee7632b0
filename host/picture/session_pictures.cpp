#include "host/picture/session_pictures.hpp"
#include <algorithm>
#include <stdexcept>

namespace crn
{

SceneAnatomy read_anatomy(const PictureSettings &settings)
{
    return read_scene_anatomy(settings.scene_path, settings.bodies_path);
}

std::unique_ptr<Patient> make_patient(const PictureSettings &settings, const SceneAnatomy &anatomy,
                                      const std::vector<Instrument> &tools, int chamber_threads)
{
    return std::make_unique<Patient>(
        anatomy, tools,
        PatientSettings{settings.bodies_path, settings.stents, chamber_threads, settings.line});
}

SessionPictures::SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools,
                                 Patient &patient, const SceneAnatomy &anatomy)
    : settings_(settings), patient_(patient), room_(settings, tools, patient.scene(), anatomy, patient.room())
{
    settings_.size = room_.size();
    std::string error;
    const bool needs_movie = !settings_.mp4_path.empty();
    if (needs_movie && !movie_.open(settings_.mp4_path, settings_.size, settings_.size,
                                    static_cast<int>(settings_.pictures_per_second), error)) {
        throw std::runtime_error(error);
    }
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
    info.room = room_.screen().status();
    info.time_s = frame.wire.tick * 1e-3;
    const std::vector<Instrument> &tools = patient_.tools();
    for (std::size_t k = 0; k < frame.tools.size(); k++) {
        if (k < patient_.line().size() && patient_.line()[k] == 0) continue; // a free position
        const ToolReading &tool = frame.tools[k];
        info.tools.push_back({k < tools.size() ? tools[k].name : "", tool.inserted_m * 1e3, tool.turned_deg,
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
// text about the stent is the stage of its treatment, such as "on its balloon".
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
        if (is_pulse) {
            const PulseShot shot = shot_of(patient_, wire, event.tick, settings_);
            room_.take(event, &shot);
        } else {
            room_.take(event, nullptr);
        }
        is_new = is_new || is_pulse;
    }
    return is_new;
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

void SessionPictures::annotate(const std::string &notice, const std::vector<std::string> &panel)
{
    notice_ = notice;
    panel_ = panel;
}

void SessionPictures::redraw(const SessionFrame &frame)
{
    screen_.size = settings_.size;
    room_.screen().compose(settings_.size, screen_.grey);
    image_ = compose_display(screen_, display(frame));
}

void SessionPictures::finish()
{
    std::string error;
    if (movie_.is_open() && !movie_.finish(error)) throw std::runtime_error(error);
    if (!settings_.png_path.empty() && count_ > 0 && !write_png(settings_.png_path, image_, error)) {
        throw std::runtime_error(error);
    }
    if (!settings_.png16_path.empty() && room_.pulse().size > 0 &&
        !write_png16(settings_.png16_path, room_.pulse().size, room_.pulse().size, room_.pulse().raw,
                     error)) {
        throw std::runtime_error(error);
    }
    for (const std::string &path : {settings_.mp4_path, settings_.png_path, settings_.png16_path})
        if (!path.empty()) files_.push_back(path);
    was_stopped_ = !room_.finish_export(patient_, files_);
}

} // namespace crn
