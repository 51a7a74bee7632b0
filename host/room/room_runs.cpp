// Handles the pictures of the X-ray room: stores them in runs, subtracts masks, builds roadmaps, and shows
// stored runs again (review).
#include "host/room/room_screen.hpp"
#include "host/room/subtraction.hpp"
#include "host/xray/detector.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// A roadmap keeps for each pixel the largest of many differences, so the noise of the frames makes every
// pixel brighter. To compensate for the noise, an estimate of it is subtracted from every pixel of the
// roadmap. The estimated noise of a roadmap is the median of the pixels (the background) plus a fixed
// multiple of the difference between the median and the 10th percentile.
constexpr float roadmap_noise_steps = 2.0f;

float background_of(const std::vector<float> &peak)
{
    std::vector<float> sorted = peak;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    const auto tenth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 10);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const float median = *middle;
    std::nth_element(sorted.begin(), tenth, middle);
    return median + roadmap_noise_steps * (median - *tenth);
}

RunCollimator collimator_of(const XrayBeam &beam, int size)
{
    RunCollimator open;
    open.is_circular = beam.circular_field;
    OpenColumns columns;
    open.top = size;
    for (int row = 0; row < size; ++row) {
        columns = open_columns(beam, size, row);
        if (columns.begin >= columns.end) continue;
        if (open.bottom == 0) {
            open.top = row;
            open.left = columns.begin;
            open.right = columns.end;
        }
        open.left = std::min(open.left, columns.begin);
        open.right = std::max(open.right, columns.end);
        open.bottom = row + 1;
    }
    open.top = std::min(open.top, open.bottom);
    open.centre_x_px = open.centre_y_px = 0.5 * size;
    open.radius_px = 0.5 * size * std::min(beam.open_width_share, beam.open_height_share);
    return open;
}

// Sets the display window in which a DICOM viewer first shows the raw values: it leaves out the darkest and
// the brightest hundredth of the exposed values.
void set_window(XrayRun &run, const std::vector<std::uint16_t> &raw)
{
    std::vector<std::uint16_t> open;
    for (std::size_t i = 0; i < raw.size(); i += 7)
        if (raw[i] > 0) open.push_back(raw[i]);
    if (open.size() < 100) return;
    const std::size_t hundredth = open.size() / 100;
    const auto low = open.begin() + static_cast<std::ptrdiff_t>(hundredth);
    const auto high = open.end() - static_cast<std::ptrdiff_t>(hundredth) - 1;
    std::nth_element(open.begin(), low, open.end());
    const double dark = *low;
    std::nth_element(open.begin(), high, open.end());
    run.window_centre = 0.5 * (dark + *high);
    run.window_width = std::max(*high - dark, 1.0);
}

// Sets the collimator, the filters, the focal spot and the display window of an X-ray run. `beam` and
// `picture` belong to the first frame of the run. Exported files of the run contain the values that this
// function sets.
void describe_beam(XrayRun &run, const XrayBeam &beam, const XrayPicture &picture)
{
    run.collimator = collimator_of(beam, picture.size);
    run.filters = {{"aluminum", 2.5}, {"copper", picture.technique.copper_mm}};
    run.focal_spot_mm = picture.technique.focal_spot_mm;
    set_window(run, picture.raw);
}

} // namespace

RoomScreen::RoomScreen(const Room &room, std::size_t store_bytes_max) : room_(room), store_(store_bytes_max)
{
}

XrayRun RoomScreen::describe(const RoomEvent &pulse, const XrayPicture &picture)
{
    XrayRun run;
    run.kind = pulse.run_kind;
    run.number = std::max(pulse.run, 1);
    run.size = picture.size;
    run.pulses_per_s = pulse.pulses_per_s;
    if (run.kind == RunKind::dsa) run.mask = RunMask{{0}, 0.0, 0.0};
    describe_beam(run, pulse.request.beam, picture);
    return run;
}

RunFrame RoomScreen::frame_of(const RoomEvent &pulse, const XrayPicture &picture)
{
    RunFrame frame;
    frame.tick = pulse.tick;
    frame.carm = pulse.request.carm;
    frame.air_kerma_uGy = pulse.exposure.air_kerma_uGy;
    frame.kap_Gy_cm2 = pulse.exposure.kap_Gy_cm2;
    frame.tube_voltage_kV = pulse.exposure.technique.tube_voltage_kV;
    frame.tube_current_mA = pulse.exposure.technique.tube_current_mA;
    frame.pulse_ms = pulse.exposure.technique.pulse_ms;
    if (pulse.request.beam.scatter) frame.raw_open = picture.photons_open * picture.raw_per_photon;
    frame.raw = picture.raw;
    return frame;
}

void RoomScreen::take(const RoomEvent &event, const XrayPicture *picture)
{
    switch (event.kind) {
    case RoomEvent::Kind::command:
        return carry_out(event.tick, event.command);
    case RoomEvent::Kind::beam_on:
        return begin_beam(event);
    case RoomEvent::Kind::beam_off:
        return end_beam(event);
    case RoomEvent::Kind::fluoro_kept:
        store_.keep_passed(event.run, event.tick, event.milliseconds);
        return;
    case RoomEvent::Kind::pulse:
        if (picture) keep(event, *picture);
    }
}

void RoomScreen::carry_out(std::uint32_t tick, const RoomCommand &command)
{
    switch (command.action) {
    case RoomAction::mask:
    case RoomAction::shift:
        return set_mask(tick, command);
    case RoomAction::roadmap:
        return set_roadmap(tick, command.values[0]);
    case RoomAction::review:
        return set_review(tick, command);
    default:; // for the room itself
    }
}

void RoomScreen::begin_beam(const RoomEvent &event)
{
    is_beam_on_ = true;
    is_acquired_ = event.run > 0;
    review_.is_on = false;
    if (is_acquired_) store_.begin(event.run, event.run_kind);
    if (!is_acquired_ && roadmap_.state == RoadmapState::waits) {
        roadmap_.state = RoadmapState::collects;
        roadmap_.carm = event.carm;
    }
    ++version_;
}

void RoomScreen::end_beam(const RoomEvent &event)
{
    is_beam_on_ = false;
    if (is_acquired_) store_.finish(event.run > 0);
    if (roadmap_.state == RoadmapState::collects) finish_roadmap();
    ++version_;
}

// Stores the picture of an X-ray pulse; the picture becomes the image that the screen holds after the beam is
// off.
void RoomScreen::keep(const RoomEvent &event, const XrayPicture &picture)
{
    RunFrame frame = frame_of(event, picture);
    has_held_ = true;
    held_size_ = picture.size;
    held_kind_ = event.run_kind;
    held_pulses_per_s_ = event.pulses_per_s;
    held_frame_ = frame;
    held_grey_ = picture.grey;
    held_run_ = held_index_ = 0;
    ++version_;
    if (!is_acquired_) {
        store_.pass(describe(event, picture), frame, picture.grey);
        if (roadmap_.state == RoadmapState::collects) collect_roadmap(frame, picture.size);
        return;
    }
    StoredRun &stored = *store_.open_run();
    if (stored.run.frames.empty()) stored.run = describe(event, picture);
    if (store_.add(std::move(frame), picture.grey)) {
        held_run_ = stored.run.number;
        held_index_ = static_cast<int>(stored.run.frames.size()) - 1;
        return;
    }
    // If the memory for pictures is full, the beam stays on, because dose and runs must not depend on the
    // size of the pictures.
    notify(event.tick, "IMAGE MEMORY IS FULL - the rest of the run is not kept");
}

// --- masks ---

StoredRun *RoomScreen::shown_dsa(std::uint32_t tick)
{
    StoredRun *run = shown().run;
    if (run && run->run.kind == RunKind::dsa && !run->is_dropped) return run;
    notify(tick, "NO DSA RUN ON THE SCREEN - show one first");
    return nullptr;
}

void RoomScreen::set_mask(std::uint32_t tick, const RoomCommand &command)
{
    StoredRun *stored = shown_dsa(tick);
    if (!stored) return;
    RunMask &mask = *stored->run.mask;
    if (command.action == RoomAction::shift) {
        mask.shift_x_px = command.values[0] * 0.01;
        mask.shift_y_px = -command.values[1] * 0.01; // up is towards row 0
    } else {
        const auto frames = static_cast<std::int32_t>(stored->run.frames.size());
        if (command.values[1] >= frames)
            return notify(tick, "NO SUCH MASK: the run has frames 1 to " + std::to_string(frames));
        mask.frames.clear();
        for (std::int32_t frame = command.values[0]; frame <= command.values[1]; ++frame)
            mask.frames.push_back(frame);
    }
    ++version_;
}

// --- roadmap ---

void RoomScreen::set_roadmap(std::uint32_t tick, std::int32_t wanted)
{
    ++version_;
    roadmap_ = {};
    if (wanted == 2) {
        roadmap_.state = RoadmapState::waits;
    } else if (wanted == 1) {
        StoredRun *stored = store_.last_of(RunKind::dsa);
        if (!stored || stored->is_dropped || stored->run.frames.size() < 2)
            return notify(tick, "NO ROADMAP: it needs a DSA run of two frames or more");
        if (store_.open_run()) return notify(tick, "RELEASE THE PEDAL, then make the roadmap");
        roadmap_from_run(*stored);
    }
}

void RoomScreen::roadmap_from_run(StoredRun &stored)
{
    const int size = stored.run.size;
    std::vector<float> mask, live, density;
    const std::vector<std::uint16_t> still = mean_frame(stored.run, stored.run.mask->frames);
    primary_log2(stored.run.frames.front(), still, size, roadmap_.reference);
    shift_picture(roadmap_.reference, size, stored.run.mask->shift_x_px, -stored.run.mask->shift_y_px, mask);
    for (const RunFrame &frame : stored.run.frames) {
        primary_log2(frame, frame.raw, size, live);
        subtract(mask, live, density);
        hold_peak(density, roadmap_.peak);
    }
    roadmap_.carm = stored.run.frames.front().carm;
    finish_roadmap();
}

// In a roadmap run, the first frame after the press of the pedal is the reference from which the other frames
// are subtracted.
void RoomScreen::collect_roadmap(const RunFrame &frame, int size)
{
    std::vector<float> live, density;
    primary_log2(frame, frame.raw, size, live);
    if (roadmap_.reference.size() != live.size() || !is_same_geometry(frame.carm, roadmap_.carm)) {
        roadmap_.reference = live;
        roadmap_.peak.clear();
        roadmap_.carm = frame.carm;
    }
    subtract(roadmap_.reference, live, density);
    hold_peak(density, roadmap_.peak);
}

void RoomScreen::finish_roadmap()
{
    if (roadmap_.peak.empty()) {
        roadmap_.state = RoadmapState::waits; // a press without a pulse: the next press collects
        return;
    }
    roadmap_.floor = background_of(roadmap_.peak);
    roadmap_.state = RoadmapState::shown;
}

// --- review ---

void RoomScreen::set_review(std::uint32_t tick, const RoomCommand &command)
{
    const auto [mode, run, frame] = command.values;
    ++version_;
    if (mode == 0) {
        review_.is_on = false;
        return;
    }
    if (is_beam_on_) return notify(tick, "RELEASE THE PEDAL, then review");
    const StoredRun *stored = store_.find(run);
    if (!stored)
        return notify(tick, store_.runs().empty() ? "NO RUN TO REVIEW yet"
                                                  : "NO RUN " + std::to_string(run) + " TO REVIEW");
    if (stored->is_dropped)
        return notify(tick,
                      "RUN " + std::to_string(stored->run.number) + " went when the image memory was full");
    const auto frames = static_cast<int>(stored->run.frames.size());
    if (mode == 2 && frame >= frames)
        return notify(tick, "NO SUCH FRAME: the run has 1 to " + std::to_string(frames));
    review_ = {true, mode == 1, stored->run.number, frame, tick};
}

} // namespace crn
