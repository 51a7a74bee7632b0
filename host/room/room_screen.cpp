// Composes the screen: the live picture, the held image or a loop, combined with mask or roadmap, and the
// texts around the picture.
#include "host/room/room_screen.hpp"
#include "host/room/subtraction.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr float dsa_window_doublings = 3.0f; // of attenuation, from white to black
constexpr std::uint8_t dsa_background = 160;

bool is_near(double a, double b, double tolerance)
{
    return std::fabs(a - b) <= tolerance;
}

int frame_at(const StoredRun &stored, std::int64_t milliseconds)
{
    const auto frame =
        static_cast<std::int64_t>(static_cast<double>(milliseconds) * stored.run.pulses_per_s * 1e-3);
    return static_cast<int>(frame % static_cast<std::int64_t>(stored.run.frames.size()));
}

} // namespace

int RoomScreen::loop_frame(const StoredRun &stored) const
{
    if (!review_.is_loop) return review_.frame;
    return frame_at(stored, room_.tick() - review_.tick_begin);
}

RoomScreen::Source RoomScreen::shown() const
{
    if (review_.is_on) {
        StoredRun *stored = store_.find(review_.run);
        if (stored && !stored->run.frames.empty()) {
            const int frame = loop_frame(*stored);
            const auto at = static_cast<std::size_t>(frame);
            return {&stored->run.frames[at].raw, &stored->grey[at], stored, frame, stored->run.size,
                    &stored->run.frames[at]};
        }
    }
    if (!has_held_) return {};
    StoredRun *stored = held_run_ > 0 ? store_.find(held_run_) : nullptr;
    return {&held_frame_.raw, &held_grey_, stored, held_index_, held_size_, &held_frame_};
}

// Every frame of a subtraction run (DSA) is shown subtracted. A frame that alone forms the mask is shown
// unsubtracted, because its difference from itself would be empty.
bool RoomScreen::is_subtracted(const Source &source) const
{
    if (!source.run || source.run->run.kind != RunKind::dsa || source.run->is_dropped) return false;
    const std::vector<int> &mask = source.run->run.mask->frames;
    return !(mask.size() == 1 && mask.front() == source.frame);
}

bool is_same_geometry(const CArm &a, const CArm &b)
{
    return is_near(a.primary_deg, b.primary_deg, 0.1) && is_near(a.secondary_deg, b.secondary_deg, 0.1) &&
           is_near(a.source_detector_m, b.source_detector_m, 5e-4) &&
           is_near(a.source_isocentre_m, b.source_isocentre_m, 5e-4) && a.field_m == b.field_m &&
           (a.isocentre_m - b.isocentre_m).squaredNorm() <= 0.25e-6;
}

void RoomScreen::compose_subtracted(const Source &source, std::vector<std::uint8_t> &grey)
{
    const RunMask &mask = *source.run->run.mask;
    if (mask_cache_.run != source.run || mask_cache_.mask.frames != mask.frames ||
        mask_cache_.mask.shift_x_px != mask.shift_x_px || mask_cache_.mask.shift_y_px != mask.shift_y_px ||
        mask_cache_.log2_values.size() != source.raw->size()) {
        std::vector<float> still;
        primary_log2(source.run->run.frames.front(), mean_frame(source.run->run, mask.frames), source.size,
                     still);
        shift_picture(still, source.size, mask.shift_x_px, -mask.shift_y_px, mask_cache_.log2_values);
        mask_cache_.run = source.run;
        mask_cache_.mask = mask;
    }
    std::vector<float> live, density;
    primary_log2(*source.pulse, *source.raw, source.size, live);
    subtract(mask_cache_.log2_values, live, density);
    const RunCollimator &open = source.run->run.collimator;
    std::vector<std::uint8_t> inside(source.raw->size(), 0);
    for (int y = open.top; y < open.bottom; ++y)
        for (int x = open.left; x < open.right; ++x) {
            const double dx = x + 0.5 - open.centre_x_px, dy = y + 0.5 - open.centre_y_px;
            const bool is_in = !open.is_circular || dx * dx + dy * dy <= open.radius_px * open.radius_px;
            inside[static_cast<std::size_t>(y) * source.size + x] = is_in ? 1 : 0;
        }
    grey_of_density(density, inside, dsa_window_doublings, dsa_background, grey);
}

bool RoomScreen::compose(int size, std::vector<std::uint8_t> &grey)
{
    const Source source = shown();
    const bool has_roadmap = roadmap_.state == RoadmapState::shown || roadmap_.state == RoadmapState::moved;
    if (has_roadmap) {
        const RoadmapState now = is_same_geometry(room_.gantry().carm(room_.field_m()), roadmap_.carm)
                                     ? RoadmapState::shown
                                     : RoadmapState::moved;
        if (now != roadmap_.state) ++version_;
        roadmap_.state = now;
    }
    if (version_ == composed_version_ && source.frame == composed_frame_ && !grey.empty()) return false;
    composed_version_ = version_;
    composed_frame_ = source.frame;
    if (!source.grey || source.size != size) {
        grey.assign(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0);
        return true;
    }
    if (is_subtracted(source))
        compose_subtracted(source, grey);
    else
        grey = *source.grey;
    if (!source.run && roadmap_.state == RoadmapState::shown)
        lay_roadmap(roadmap_.peak, source.size, roadmap_.floor, grey);
    return true;
}

bool RoomScreen::compose_stored(int run, int frame, std::vector<std::uint8_t> &grey, RoomStatus &status)
{
    StoredRun *stored = store_.find(run);
    if (!stored || stored->is_dropped || stored->run.frames.empty()) return false;
    const bool is_loop = frame < 0;
    const int last = static_cast<int>(stored->run.frames.size()) - 1;
    const int shown =
        is_loop ? frame_at(*stored, std::max<std::int64_t>(room_.tick(), 0)) : std::min(frame, last);
    const auto at = static_cast<std::size_t>(shown);
    const Source source{&stored->run.frames[at].raw, &stored->grey[at], stored, shown, stored->run.size,
                        &stored->run.frames[at]};
    RoomStatus now;
    now.source = is_loop ? ScreenSource::loop : ScreenSource::still;
    fill_run(source, now);
    now.runs_kept = static_cast<int>(store_.runs().size());
    const bool is_same = !grey.empty() && now.run == status.run && now.frame == status.frame &&
                         now.mask_first == status.mask_first && now.mask_last == status.mask_last &&
                         now.shift_right_px == status.shift_right_px && now.shift_up_px == status.shift_up_px;
    if (is_same) return false;
    status = now;
    if (is_subtracted(source))
        compose_subtracted(source, grey);
    else
        grey = *source.grey;
    return true;
}

RoomStatus RoomScreen::status() const
{
    RoomStatus status;
    static_cast<RoomState &>(status) = room_.state();
    status.runs_kept = static_cast<int>(room_.runs().size());
    status.roadmap = roadmap_.state;
    if (notice_.is_shown_at(room_.tick()) && notice_.from >= room_.notice().from)
        status.notice = notice_.text;
    fill_shown(status);
    return status;
}

void RoomScreen::fill_shown(RoomStatus &status) const
{
    const Source source = shown();
    status.picture_carm = source.pulse ? source.pulse->carm : status.carm;
    if (!source.grey) return;
    status.source = room_.is_beam_on() ? ScreenSource::live : ScreenSource::held;
    if (review_.is_on && source.run)
        status.source = review_.is_loop ? ScreenSource::loop : ScreenSource::still;
    status.kind = held_kind_;
    status.pulses_per_s = held_pulses_per_s_;
    if (source.run) fill_run(source, status);
}

void RoomScreen::fill_run(const Source &source, RoomStatus &status) const
{
    const XrayRun &run = source.run->run;
    status.kind = run.kind;
    status.pulses_per_s = run.pulses_per_s;
    status.run = run.number;
    status.frame = source.frame;
    status.frames = static_cast<int>(run.frames.size());
    status.is_subtracted = is_subtracted(source);
    if (!run.mask || run.mask->frames.empty()) return;
    status.mask_first = run.mask->frames.front();
    status.mask_last = run.mask->frames.back();
    status.shift_right_px = run.mask->shift_x_px;
    status.shift_up_px = -run.mask->shift_y_px + 0.0;
}

} // namespace crn
