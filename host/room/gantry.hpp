// Simulates the motors of C-arm and table. Every axis starts, moves and stops within the limits of its speed
// and acceleration. The interlock stops all axes before the tube or the detector comes too near to the table.
//
//   Gantry gantry;
//   gantry.place(pose);            // where the session begins: without motion
//   gantry.aim(pose);              // from then on: the target of the motors
//   gantry.tick();                 // 1 ms
//
// docs/room.md has the equations, and describes the boxes that represent table, tube and detector in the
// collision check.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/room/boxes.hpp"
#include "host/xray/paths/carm.hpp"
#include <array>
#include <string>

namespace crn
{

// Lists the motor-driven axes, in the order of the values in GantryPose.
enum GantryAxis {
    axis_primary,
    axis_secondary,
    axis_table_x,
    axis_table_y,
    axis_table_z,
    axis_sid,
    axis_sod
};
inline constexpr int gantry_axes = 7;

// The values in degrees and metres: primary, secondary, patient point at the isocentre (x, y, z), SID, SOD.
using GantryPose = std::array<double, gantry_axes>;

// Angles are in degrees and lengths in metres; speeds are per s and accelerations per s2. The speeds and
// accelerations are assumed values, typical of C-arms mounted on the ceiling or the floor.
struct AxisLimits {
    double speed, acceleration, low, high;
};
const std::array<AxisLimits, gantry_axes> &gantry_limits();

// Returns the boxes that the interlock checks, in the patient's coordinates, for these positions of the
// motors.
struct GantryBoxes {
    Box table, tube, collimator, detector;
};
GantryBoxes gantry_boxes(const GantryPose &pose);

// Returns the smallest gap in metres between the table and the housings of tube and detector; the gap is
// negative if they overlap. All are boxes: docs/room.md.
double table_clearance_m(const GantryPose &pose);

class Gantry
{
  public:
    static constexpr double clearance_min_m = 0.025; // gap at which the interlock brakes; 2 cm remain

    void place(const GantryPose &pose); // moves at once; clamped to the limits of the axes
    void aim(const GantryPose &pose);   // new target of the motors; clamped to the limits
    void aim_axis(GantryAxis axis, double value);
    void halt(); // all motors brake and stay where they stop
    void tick(); // 1 ms

    const GantryPose &pose() const { return pose_; }
    const GantryPose &target() const { return target_; }
    bool is_moving() const;
    // Returns true if the interlock has stopped a motion since the last call of aim().
    bool is_blocked() const { return is_blocked_; }
    CArm carm(double field_m) const;
    void archive(StateArchive &state);

  private:
    double clearance_while_braking_m(const GantryPose &speed) const;
    GantryPose wanted_speed(bool brakes) const;

    GantryPose pose_ = {0.0, 0.0, 0.0, 0.0, 0.0, 1.05, 0.75};
    GantryPose target_ = pose_;
    GantryPose speed_{};
    bool is_blocked_ = false, is_halting_ = false;
};

} // namespace crn
