#include "host/script/steer.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

constexpr std::int64_t mm = 1000; // um

// Holds the parameters of the simulated hand that steers a tool. The parameters of the steering were found by
// trials on the shipped aorta and heart, with friction, stiffness and initial angle varied by some per cent
// (tools/check/tests/test_sessions.py). No parameter is adjusted to a single session.
struct Habit {
    double speed_m_s, depth_m, limit_s;
    std::int64_t stall_um;    // displacement without getting nearer: the shaft buckles, or the tip is caught
    std::int64_t rest_ticks;  // waiting time until the tip has followed a turn
    std::int64_t watch_ticks; // waiting time in the goal before it counts; one beat if the heart beats
};
constexpr Habit steering{0.04, 0.020, 120.0, 40 * mm, 300, 200};
constexpr Habit engaging{0.015, 0.004, 180.0, 60 * mm, 400, 1000};

constexpr std::int64_t nearer_um = 1 * mm;     // smallest approach that counts as getting nearer
constexpr std::int64_t mouth_um = 1 * mm;      // a tip this far inside counts as in the ostium
constexpr std::int64_t returned_um = 2 * mm;   // a tip this little off its route counts as back on it
constexpr std::int64_t least_out_um = 12 * mm; // length of a tool beyond the sheath
constexpr std::int64_t turn_counts_per_s = counts_per_turn / 2,
                       engage_turn_counts_per_s = counts_per_turn / 6;
constexpr std::int64_t spin_counts_per_s = 3 * counts_per_turn, spin_push_um_s = 35 * mm;
constexpr std::int64_t seat_stroke_um = 1500, seat_speed_um_s = 10000, seat_gain_um = 300;
constexpr std::int64_t seat_rest_ticks = 100;
constexpr int seat_misses_max = 4;
constexpr int tries_per_step_back = 5; // after this many tries it is pulled back twice as far
constexpr int steps_back_max = 5, engage_steps_back_max = 2;

const Habit &habit_of(bool engages)
{
    return engages ? engaging : steering;
}

// Wraps to +-half a turn.
std::int64_t wrapped(std::int64_t counts)
{
    const std::int64_t turned = ((counts % counts_per_turn) + counts_per_turn) % counts_per_turn;
    return turned > counts_per_turn / 2 ? turned - counts_per_turn : turned;
}

} // namespace

Steering parse_steering(LineParser &line, bool engages, const ToolChoice &selected)
{
    const Habit &habit = habit_of(engages);
    Steering steering_asked;
    steering_asked.engages = engages;
    steering_asked.tool = accept_one_tool(line, selected);
    if (!engages) line.expect("into");
    steering_asked.vessel = vessel_name(line);
    double speed_m_s = habit.speed_m_s, depth_m = habit.depth_m, limit_s = habit.limit_s;
    while (!line.is_at_end()) {
        const std::string word = line.choice("option", {"at", "until", "within"});
        if (word == "at") speed_m_s = line.quantity("speed", speed_units, 1e-3, 0.2);
        if (word == "until") {
            depth_m = line.quantity("depth", length_units, 0.001, 1.6);
            line.accept("inside");
        }
        if (word == "within") limit_s = line.quantity("time", time_units, 1.0, 3600.0);
    }
    steering_asked.speed_um_s = std::llround(speed_m_s * 1e6);
    steering_asked.depth_um = std::llround(depth_m * 1e6);
    steering_asked.limit_ticks = std::llround(limit_s * 1e3);
    return steering_asked;
}

Steerer::Steerer(const Steering &what, const VesselMap &map, std::size_t goal)
    : what_(what), map_(map), goal_(goal)
{
}

// --- motion ---

Steerer::Counts Steerer::next()
{
    tick_++;
    stage_tick_++;
    now_ = base_;
    if (run_) now_.translation += run_->at(stage_tick_);
    if (stroke_) now_.translation += stroke_->at(stage_tick_);
    if (twist_) now_.rotation += twist_->at(stage_tick_);
    if (spin_) now_.rotation += spin_->at(stage_tick_);
    const Counts counts = now_;
    if (run_ && run_->is_done(stage_tick_)) begin(after_);
    if (twist_ && stage_tick_ >= twist_->ticks()) {
        begin(Stage::rest);
        after_ = after_turn_;
    }
    if (stage_ == Stage::rest && has_looked_ && stage_tick_ >= rest_ticks_) begin(after_);
    if (tick_ >= what_.limit_ticks && stage_ != Stage::done) stage_ = Stage::failed;
    return counts;
}

void Steerer::begin(Stage stage)
{
    if (stage_ != Stage::seat) seat_best_um_ = seat_misses_ = 0; // the first stroke into the ostium
    stage_ = stage;
    stage_tick_ = 0;
    base_ = now_;
    run_.reset();
    stroke_.reset();
    twist_.reset();
    spin_.reset();
    if (stage == Stage::push) {
        best_um_ = left_um();
        best_at_ = now_.translation;
        const std::int64_t spin = spin_of(tries_);
        run_.emplace(spin != 0 ? std::min(what_.speed_um_s, spin_push_um_s) : what_.speed_um_s);
        if (spin != 0) spin_.emplace(spin);
    } else if (stage == Stage::pull) {
        run_.emplace(-what_.speed_um_s);
    } else if (stage == Stage::turn) {
        angle_ = wrapped(now_.rotation);
        const std::int64_t angle = spin_of(tries_) != 0 ? angle_ : next_angle();
        twist_.emplace(angle - angle_, what_.engages ? engage_turn_counts_per_s : turn_counts_per_s);
        rest_ticks_ = habit_of(what_.engages).rest_ticks;
    } else if (stage == Stage::seat) {
        stroke_.emplace(seat_stroke_um, seat_speed_um_s);
    }
}

// Brings the hand to rest, and then continues with the stage `next` of steering.
void Steerer::stop_for(Stage next)
{
    run_->stop(stage_tick_);
    if (spin_) spin_->stop(stage_tick_);
    after_ = next;
}

// A bent tip that catches at an ostium at every angle can pass it if the fingers spin the guidewire while
// they push it. The attempts spin the tool in both directions, because the vessel is curved and the two
// directions have different effects.
std::int64_t Steerer::spin_of(int attempt) const
{
    if (what_.engages || attempt % 3 == 1) return 0;
    return attempt % 3 == 2 ? -spin_counts_per_s : spin_counts_per_s;
}

// If every attempt turns the tool further by the golden angle, a few attempts cover all orientations of a
// bent tip. A guiding catheter already has a suitable shape and needs little turning, so small angles to both
// sides are tried first.
std::int64_t Steerer::next_angle()
{
    const std::int64_t k = turns_++;
    if (!what_.engages || k >= 8) return wrapped((k + 1) * counts_per_turn * 3820 / 10000);
    const std::int64_t size = (k / 2 + 1) * counts_per_turn / 9;
    return k % 2 == 0 ? size : -size;
}

// --- observation ---

void Steerer::observe(const TipPlace &tip, std::int64_t inserted_um)
{
    if (!tip.is_known || stage_ == Stage::done || stage_ == Stage::failed) return;
    tip_ = tip;
    way_ = map_.way(tip.place, tip.sheath, goal_);
    if (!has_looked_) {
        has_looked_ = true;
        const auto radius_um = std::llround(map_.mouth_radius_m(tip.sheath, goal_) * 1e6);
        reach_um_ = std::clamp<std::int64_t>(4 * radius_um, 5 * mm, 15 * mm);
        back_um_ = std::clamp<std::int64_t>(5 * radius_um, 10 * mm, 30 * mm);
        begin(is_in_goal(what_.depth_um) ? Stage::watch : Stage::push);
    }
    if (run_ && run_->is_stopping()) return;
    // A turn near the ostium may have moved the tip into the wanted vessel even before the tool is pushed
    // again.
    const bool turns = stage_ == Stage::turn || stage_ == Stage::rest;
    if (what_.engages && turns && is_in_goal(mouth_um)) return begin(Stage::seat);
    if (stage_ == Stage::push) look_pushing();
    if (stage_ == Stage::pull) look_pulling(inserted_um);
    if (stage_ == Stage::seat) look_seating();
    if (stage_ == Stage::watch) look_watching();
}

bool Steerer::is_in_goal(std::int64_t least_um) const
{
    return tip_.place.vessel == goal_ && way_.inside_um >= least_um;
}

// Returns the remaining distance to the wanted vessel along the route; the distance of the tip from the route
// does not count.
std::int64_t Steerer::route_left_um() const
{
    return way_.ahead_um + what_.depth_um - way_.inside_um;
}

std::int64_t Steerer::left_um() const
{
    return route_left_um() + way_.astray_um;
}

void Steerer::look_pushing()
{
    if (is_in_goal(what_.depth_um)) return stop_for(Stage::watch);
    if (what_.engages && is_in_goal(mouth_um)) return stop_for(Stage::seat);
    if (left_um() < best_um_ - nearer_um) {
        best_um_ = left_um();
        best_at_ = now_.translation;
    }
    const bool is_astray = way_.astray_um > reach_um_ || left_um() > best_um_ + reach_um_;
    const bool is_stalled = now_.translation - best_at_ > habit_of(what_.engages).stall_um;
    if (!is_astray && !is_stalled) return;
    // If the tip has passed an ostium in a wide vessel, the hand turns the tool and pulls it back past the
    // ostium, as another attempt to enter it.
    if (what_.engages && is_astray) {
        go_back();
        after_turn_ = Stage::pull;
        return stop_for(Stage::turn);
    }
    go_back();
    stop_for(Stage::pull);
}

// Decides how far the hand pulls back the tool from its present position.
void Steerer::go_back()
{
    wrong_um_ = route_left_um();
    was_in_goal_ = is_in_goal(0);
    tries_++;
}

void Steerer::look_pulling(std::int64_t inserted_um)
{
    was_in_goal_ = was_in_goal_ && is_in_goal(0);
    if (!was_in_goal_ && is_in_goal(mouth_um)) // the tip entered the ostium while it was pulled back
        return stop_for(what_.engages ? Stage::seat : Stage::push);
    const std::int64_t back_um = back_um_ * std::min(1 + tries_ / tries_per_step_back,
                                                     what_.engages ? engage_steps_back_max : steps_back_max);
    const bool is_back = way_.astray_um <= returned_um && route_left_um() >= wrong_um_ + back_um;
    if (!is_back && inserted_um > least_out_um) return;
    after_turn_ = Stage::push;
    stop_for(Stage::turn);
}

void Steerer::look_seating()
{
    if (stage_tick_ < stroke_->ticks() + seat_rest_ticks) return;
    if (!is_in_goal(mouth_um / 2)) {
        go_back();
        return begin(Stage::pull);
    }
    if (is_in_goal(what_.depth_um)) return begin(Stage::watch);
    const bool is_deeper = way_.inside_um > seat_best_um_ + seat_gain_um;
    seat_misses_ = is_deeper ? 0 : seat_misses_ + 1;
    seat_best_um_ = std::max(seat_best_um_, way_.inside_um);
    if (seat_misses_ < seat_misses_max) return begin(Stage::seat);
    // A guiding catheter that cannot go deeper into a narrowed ostium counts as engaged in it.
    if (is_in_goal(what_.depth_um / 2)) return begin(Stage::watch);
    go_back();
    begin(Stage::pull);
}

void Steerer::look_watching()
{
    if (!is_in_goal(what_.depth_um / 2)) {
        if (what_.engages && is_in_goal(mouth_um)) return begin(Stage::seat);
        go_back();
        return begin(Stage::pull);
    }
    if (stage_tick_ >= habit_of(what_.engages).watch_ticks) stage_ = Stage::done;
}

std::string Steerer::failure() const
{
    const std::string &goal = map_.vessels()[goal_].name;
    if (!tip_.is_known)
        return "the tip was nowhere in a vessel; remedy: bake the scene with its tree of vessels";
    return formatted(
        "the %s did not come %.0f mm into %s in %.0f s and %d tries: its tip was %.0f mm inside %s, %.0f mm "
        "of vessel from there; remedy: begin nearer to it, turn the hand before, choose a tool with "
        "another tip, or give it more time (within %.0f s)",
        tool_name(what_.tool).c_str(), what_.depth_um * 1e-3, goal.c_str(), tick_ * 1e-3, tries_,
        tip_.inside_m * 1e3, map_.vessels()[tip_.place.vessel].name.c_str(), left_um() * 1e-3,
        what_.limit_ticks * 2e-3);
}

} // namespace crn
