// Runs the core for the validation cases; inputs and outputs are in SI units and double precision. Of all
// files in this folder, only rig.hpp and rig.cpp call the core, so that a change of the core's interface
// affects only them.
//
// Arc lengths count from the tip of tool 0, and node 0 is the tip of the tool that reaches farthest. The
// introducer ends at the origin and points along +x unless a validation case states another position or
// direction.
#pragma once
#include "tools/lab/validate/lumen_field.hpp"

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

namespace crn::validate
{

using Eigen::Vector3d;

// Holds the properties of a tool at an arc length from the tip. Properties of a tool change linearly between
// knots; if two knots have the same arc length, the properties change abruptly there.
struct Knot {
    double arc_m = 0;
    double bend_N_m2 = 1e-3;
    double twist_N_m2 = 1e-3 / 1.3; // nu = 0.3
    double mass_kg_per_m = 0.005;
    double radius_m = 445e-6;
    double radius_inner_m = 0;
    double friction = 0;         // kinetic, and static unless stated below
    double friction_static = -1; // below 0: as the kinetic one
    double rest_curvature_per_m = 0;
};

struct Tool {
    std::vector<Knot> knots;
    double axial_stiffness_max_N = 3000;
    double lumen_friction = 0;
    double element_m = 0.003; // of the whole tool
};

// Makes a tool of length `length_m` with constant properties along its whole length.
Tool uniform_tool(const Knot &knot, double length_m, double element_m);

// Springs of 2e5 N/m hold the tip at fixed points: one spring acts on node 0, and another spring on node
// `second` if `second` is not 0.
struct Hold {
    Vector3d anchor_m = Vector3d::Zero();
    unsigned second = 0;
    Vector3d second_anchor_m = Vector3d::Zero();
    bool axial_free = false; // free along x
    bool turn = false;       // the tip does not turn in space
};

struct Start {
    std::vector<double> inserted_m; // per tool
    Vector3d mouth_m = Vector3d::Zero();
    Vector3d direction = Vector3d::UnitX();
    unsigned blood_kg_m3 = 0; // around the tools and in their lumens
};

class Rig
{
  public:
    // Throws std::runtime_error when the core rejects the tools. The lumen field must outlive the rig, which
    // keeps a pointer to it.
    Rig(const std::vector<Tool> &tools, const LumenField *field, const Start &start);
    ~Rig();
    Rig(Rig &&) noexcept;

    void set_gravity(const Vector3d &m_s2);
    void set_tip_load(const Vector3d &N);
    void set_hold(const Hold &hold);
    void set_stall(double N); // handle force at which the feed stops; initially 400 N, which is never reached

    void feed(double m, unsigned tool = 0); // the hand's position since the start
    void turn(double rad,
              unsigned tool = 0); // the hand's angle, right-handed about the direction of insertion
    void step(int ticks = 1);

    // Sets the positions of the rod's free nodes, and sets their velocities to zero.
    void place(const std::vector<Vector3d> &positions_m);

    unsigned free_count() const;
    Vector3d position(unsigned node) const;
    std::vector<Vector3d> shape() const; // free nodes, tip first, and the inserter's end
    double arc(unsigned node) const;     // from the leading tip
    double inserted(unsigned tool = 0) const;
    double handle_axial(unsigned tool = 0) const;  // N, + pushes the hand back out
    double handle_torque(unsigned tool = 0) const; // N m, + opposes positive rotation
    double
    base_angle(unsigned tool = 0) const; // angle of the inserter's frame, unwrapped, in the sense of turn()
    double
    tip_angle(unsigned tool = 0) const; // angle of the tip's frame against the frame carried without twist
    double length_error() const;        // relative, + stretched
    double penetration() const;         // m
    Vector3d
    hold_force(unsigned node) const; // N, force of the springs of a held node on the rod; node 0 or `second`
    double motion_per_tick() const;  // largest displacement of any node in the last tick, m
    std::optional<Vector3d>
    contact_force(unsigned node) const; // N; empty where the node is clear of the wall
    unsigned contact_count() const;
    unsigned solve_count() const;
    bool saturated() const; // sticky
    bool capped() const;    // sticky: the motion of a tick was scaled down

  private:
    struct Core;
    std::unique_ptr<Core> core_;
    void hold_in_space();
};

} // namespace crn::validate
