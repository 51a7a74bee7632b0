#include "hil_tests/plant/axis.hpp"
#include <algorithm>
#include <cmath>

namespace hil
{

namespace
{

constexpr int sweeps_max =
    200; // it converges by the ratio of the inertias: 50 sweeps for 1e-12 when they are equal

} // namespace

void Axis::step(double command, bool powered)
{
    double impulse = 0.0;
    motor_peak_ = 0.0;
    is_slipping_ = is_limited_ = false;
    const double step_s = 1e-3 / settings_.steps_per_ms;
    for (int i = 0; i < settings_.steps_per_ms; i++) {
        advance(command, powered, step_s);
        impulse += hand_force_ * step_s;
        motor_peak_ = std::max(motor_peak_, std::abs(motor_force_));
    }
    hand_force_ = impulse / 1e-3;
}

void Axis::advance(double command, bool powered, double step_s)
{
    const AxisSettings &s = settings_;
    // current: exact for a constant command
    double asked = std::clamp(command, -s.motor_limit, s.motor_limit);
    if (motor_fault_ == MotorFault::stuck_on) asked = s.motor_limit;
    if (motor_fault_ == MotorFault::dead || !powered) asked = 0.0;
    is_limited_ = is_limited_ ||
                  (powered && (std::abs(command) > s.motor_limit || motor_fault_ == MotorFault::stuck_on));
    const double lag_s = powered ? s.motor_lag_s : s.motor_decay_s;
    if (lag_s != decay_lag_s_) {
        decay_lag_s_ = lag_s;
        decay_ = std::exp(-step_s / lag_s);
    }
    motor_force_ = asked + (motor_force_ - asked) * decay_;

    // speeds without the two frictions
    const double hand_before = hand_place_;
    hand_place_ += hand_speed_ * step_s;
    double applied = 0.0; // by the hand's spring
    if (hand_ == Hand::spring) {
        applied = s.hand_stiffness * (hand_before - tool_) + s.hand_damping * (hand_speed_ - tool_speed_);
    }
    const double tool_before = tool_speed_, roller_before = roller_speed_;
    const bool is_held = hand_ == Hand::prescribed;
    const double tool_free = is_held ? hand_speed_ : tool_speed_ + applied / s.tool_inertia * step_s;
    const double roller_free =
        roller_speed_ + (-motor_force_ - s.viscous * roller_speed_) / s.roller_inertia * step_s;
    solve(tool_free, is_held ? 0.0 : 1.0 / s.tool_inertia, roller_free, step_s);

    // the mean of both speeds: exact for constant forces
    tool_ = is_held ? tool_ + hand_speed_ * step_s : tool_ + 0.5 * (tool_before + tool_speed_) * step_s;
    roller_ += 0.5 * (roller_before + roller_speed_) * step_s;
    hand_force_ =
        is_held ? grip_impulse_ / step_s + s.tool_inertia * (tool_speed_ - tool_before) / step_s : applied;
    if (hand_ == Hand::none) hand_force_ = 0.0;
}

// Computes the impulses of two limited frictions: the grip between tool and roller, and the friction in the
// roller's bearing. At each of the two frictions, either the sliding speed is zero or the impulse is at its
// limit. The two unknown impulses are found by projected Gauss-Seidel iteration.
void Axis::solve(double tool_free, double tool_mobility, double roller_free, double step_s)
{
    const double roller_mobility = 1.0 / settings_.roller_inertia;
    const double grip_max = settings_.grip_limit * step_s, bearing_max = settings_.coulomb * step_s;
    double grip = std::clamp(grip_impulse_, -grip_max, grip_max), bearing = 0.0;
    int sweeps = sweeps_max;
    const auto tool = [&] { return tool_free - grip * tool_mobility; };
    const auto roller = [&] { return roller_free + (grip + bearing) * roller_mobility; };
    const double last = settings_.sweep_tolerance * bearing_max;
    double grip_kept = grip, bearing_kept = bearing;
    for (int i = 1, kept = 0; i <= sweeps; i++) {
        const double grip_before = grip, bearing_before = bearing;
        bearing = std::clamp(bearing - roller() / roller_mobility, -bearing_max, bearing_max);
        grip =
            std::clamp(grip + (tool() - roller()) / (tool_mobility + roller_mobility), -grip_max, grip_max);
        if (std::abs(grip - grip_before) <= last && std::abs(bearing - bearing_before) <= last) break;
        // Rounding may let the last bits go round in a circle. Whole rounds of it change nothing, so they are
        // left out.
        if (grip == grip_kept && bearing == bearing_kept) sweeps = i + (sweeps - i) % (i - kept);
        if ((i & (i - 1)) != 0) continue;
        kept = i;
        grip_kept = grip;
        bearing_kept = bearing;
    }
    grip_impulse_ = grip;
    tool_speed_ = tool();
    roller_speed_ = roller();
    is_slipping_ = is_slipping_ || std::abs(grip) >= grip_max;
}

} // namespace hil
