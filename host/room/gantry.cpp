// Simulates the motors of C-arm and table. The speed of a motor has the shape of a trapezium and changes in
// steps of 1 ms. Before every step the interlock computes the path along which all axes would brake to rest,
// and checks it for collisions. The computation uses only sums, products, quotients and square roots, so that
// every compiler gives bit-identical results.
#include "host/room/gantry.hpp"
#include "host/room/boxes.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr double tick_s = 1e-3;

// Housings, in metres. The table top is 42 cm wide and 6 cm thick with its mattress. The upper face of the
// table lies 13 cm behind the patient's origin. The table reaches from its head end, 85 cm above the origin,
// to its pedestal, 120 cm below it.
constexpr double table_half_width_m = 0.21, table_top_z_m = -0.13, table_thickness_m = 0.06;
constexpr double table_foot_y_m = -1.20, table_head_y_m = 0.85;
// The tube housing is 32 x 32 cm and reaches from 20 cm behind the focal spot to 10 cm in front of it. The
// tube's collimator is 20 x 20 cm and reaches to 25 cm in front of the focal spot.
constexpr double tube_half_m = 0.16, tube_behind_m = 0.20, tube_front_m = 0.10;
constexpr double collimator_half_m = 0.10, collimator_front_m = 0.25;
// The detector housing is 40 x 40 cm. The detector housing reaches from its cover, 2 cm in front of the image
// plane, to 22 cm behind that plane.
constexpr double detector_half_m = 0.20, detector_front_m = 0.02, detector_behind_m = 0.22;

Box along_beam(const View &view, double from_source_m, double to_source_m, double half_m)
{
    Box box;
    box.centre = view.source_m + 0.5 * (from_source_m + to_source_m) * view.forward;
    box.axes = {view.right, view.up, view.forward};
    box.half = {half_m, half_m, 0.5 * (to_source_m - from_source_m)};
    return box;
}

Box table_box()
{
    Box box;
    box.centre = {0.0, 0.5 * (table_foot_y_m + table_head_y_m), table_top_z_m - 0.5 * table_thickness_m};
    box.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
    box.half = {table_half_width_m, 0.5 * (table_head_y_m - table_foot_y_m), 0.5 * table_thickness_m};
    return box;
}

CArm carm_of(const GantryPose &pose, double field_m)
{
    CArm carm;
    carm.primary_deg = pose[axis_primary];
    carm.secondary_deg = pose[axis_secondary];
    carm.isocentre_m = {pose[axis_table_x], pose[axis_table_y], pose[axis_table_z]};
    carm.source_detector_m = pose[axis_sid];
    carm.source_isocentre_m = pose[axis_sod];
    carm.field_m = field_m;
    return carm;
}

GantryPose held(const GantryPose &pose)
{
    GantryPose result = pose;
    for (int i = 0; i < gantry_axes; ++i)
        result[i] = std::clamp(pose[i], gantry_limits()[i].low, gantry_limits()[i].high);
    return result;
}

// Returns the highest speed from which an axis can stop within the distance `gap`. While an axis brakes, its
// speed falls in every tick by its acceleration x 1 ms.
double braking_speed(double gap, double acceleration)
{
    const double half_step = 0.5 * acceleration * tick_s;
    return std::sqrt(half_step * half_step + 2.0 * acceleration * gap) - half_step;
}

} // namespace

const std::array<AxisLimits, gantry_axes> &gantry_limits()
{
    static constexpr std::array<AxisLimits, gantry_axes> limits = {{{25.0, 40.0, -120.0, 120.0},
                                                                    {25.0, 40.0, -50.0, 50.0},
                                                                    {0.15, 0.40, -1.9, 1.9},
                                                                    {0.15, 0.40, -1.9, 1.9},
                                                                    {0.05, 0.20, -1.9, 1.9},
                                                                    {0.08, 0.20, 0.90, 1.30},
                                                                    {0.05, 0.20, 0.60, 0.85}}};
    return limits;
}

GantryBoxes gantry_boxes(const GantryPose &pose)
{
    static const Box table = table_box();
    const View view = make_view(carm_of(pose, 0.32), 512);
    const double sid_m = pose[axis_sid];
    return {table, along_beam(view, -tube_behind_m, tube_front_m, tube_half_m),
            along_beam(view, tube_front_m, collimator_front_m, collimator_half_m),
            along_beam(view, sid_m - detector_front_m, sid_m + detector_behind_m, detector_half_m)};
}

double table_clearance_m(const GantryPose &pose)
{
    const GantryBoxes boxes = gantry_boxes(pose);
    return std::min({gap_between(boxes.tube, boxes.table), gap_between(boxes.collimator, boxes.table),
                     gap_between(boxes.detector, boxes.table)});
}

void Gantry::place(const GantryPose &pose)
{
    pose_ = target_ = held(pose);
    speed_ = {};
    is_blocked_ = is_halting_ = false;
}

void Gantry::aim(const GantryPose &pose)
{
    target_ = held(pose);
    is_blocked_ = is_halting_ = false;
}

void Gantry::aim_axis(GantryAxis axis, double value)
{
    target_[axis] = std::clamp(value, gantry_limits()[axis].low, gantry_limits()[axis].high);
    is_blocked_ = is_halting_ = false;
}

void Gantry::halt()
{
    is_halting_ = is_moving();
    if (!is_halting_) target_ = pose_;
}

bool Gantry::is_moving() const
{
    return std::any_of(speed_.begin(), speed_.end(), [](double speed) { return speed != 0.0; });
}

CArm Gantry::carm(double field_m) const
{
    return carm_of(pose_, field_m);
}

// Returns the smallest gap between C-arm and table during a stop: in this tick the axes still move at
// `speed`, and then every axis brakes to rest.
double Gantry::clearance_while_braking_m(const GantryPose &speed) const
{
    constexpr int looks = 6;
    double longest_s = 0.0, gap_m = 1e9;
    for (int i = 0; i < gantry_axes; ++i)
        longest_s = std::max(longest_s, std::fabs(speed[i]) / gantry_limits()[i].acceleration);
    for (int look = 0; look <= looks; ++look) {
        GantryPose at = pose_;
        for (int i = 0; i < gantry_axes; ++i) {
            const double acceleration = gantry_limits()[i].acceleration, magnitude = std::fabs(speed[i]);
            const double time_s = std::min(longest_s * look / looks, magnitude / acceleration);
            at[i] += speed[i] * tick_s +
                     std::copysign(magnitude * time_s - 0.5 * acceleration * time_s * time_s, speed[i]);
        }
        gap_m = std::min(gap_m, table_clearance_m(at));
    }
    return gap_m;
}

// Returns the speed of every axis for the next tick: towards its target or, if `brakes` is true, slowing down
// to rest.
GantryPose Gantry::wanted_speed(bool brakes) const
{
    GantryPose wanted = speed_;
    for (int i = 0; i < gantry_axes; ++i) {
        const AxisLimits &limits = gantry_limits()[i];
        const double gap = target_[i] - pose_[i], step = limits.acceleration * tick_s;
        const double magnitude = std::min(limits.speed, braking_speed(std::fabs(gap), limits.acceleration));
        const double goal = brakes ? 0.0 : std::copysign(magnitude, gap);
        wanted[i] += std::clamp(goal - speed_[i], -step, step);
    }
    return wanted;
}

void Gantry::tick()
{
    if (!is_moving() && pose_ == target_) return;
    GantryPose next = wanted_speed(is_halting_);
    const double gap_m = clearance_while_braking_m(next);
    // If the gap between C-arm and table is already too narrow, only motions that widen the gap are allowed.
    if (gap_m < clearance_min_m && gap_m < table_clearance_m(pose_)) {
        is_blocked_ = is_halting_ = true;
        next = wanted_speed(true);
    }
    bool is_still = true;
    for (int i = 0; i < gantry_axes; ++i) {
        const double gap = target_[i] - pose_[i];
        const double near = 1.5 * gantry_limits()[i].acceleration * tick_s * tick_s;
        speed_[i] = next[i];
        if (!is_halting_ && std::fabs(gap) <= near && std::fabs(speed_[i]) <= near / tick_s) {
            pose_[i] = target_[i];
            speed_[i] = 0.0;
        }
        pose_[i] += speed_[i] * tick_s;
        is_still = is_still && speed_[i] == 0.0;
    }
    if (!is_halting_ || !is_still) return;
    target_ = pose_;
    is_halting_ = false;
}

} // namespace crn
