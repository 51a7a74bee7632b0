// Runs the protocol of an insertion (tools/lab/case/case.hpp) with the reference rod. The simulation feeds
// the rod in small steps through a straight frictionless sheath that ends at the vessel, and finds the rod's
// rest position after each step.
#pragma once
#include "tools/lab/case/case.hpp"
#include "tools/lab/reference_rod/equilibrium.hpp"

namespace crn::reference
{

struct Sheath {
    Vector mouth_m = Vector::Zero();
    Vector direction = Vector::UnitX(); // unit, into the vessel
};

// The insertion of one instrument.
class Insertion
{
  public:
    // At the beginning, a length of `start_m` of the rod is outside the sheath. The part of the rod that is
    // outside the sheath at the beginning is straight, so `start_m` should be small.
    Insertion(const Rod &rod, const Physics &physics, const Sheath &sheath, double start_m, double turn_rad);

    // Advances the rod to the inserted length `inserted_m`, with the hand at the angle `turn_rad`. The rod
    // advances in one step, or in several shorter ones if it does not come to rest. Returns false if the rod
    // does not come to rest even with short steps; the object then holds the state nearest to rest.
    bool advance(double inserted_m, double turn_rad);

    double inserted_m() const { return inserted_m_; }
    double hand_N() const
    {
        return hand_N_;
    } // along the sheath, + pushes the hand back out; without friction its work is the energy that the rod
      // stores
    int free_nodes() const { return free_; }
    const State &state() const { return state_; }
    const Outcome &outcome() const { return outcome_; }
    int iterations() const { return iterations_; }    // of all steps so far
    double depth_m() const { return depth_m_; }       // deepest contact of all steps so far
    double residual_N() const { return residual_N_; } // largest of all steps so far

    // Returns the curve of the rod outside the sheath, from the sheath's end to the tip.
    std::vector<Vector> centreline_m() const;

  private:
    bool step(double inserted_m, double turn_rad);
    void place(double inserted_m, double turn_rad); // sets the first guess and the held nodes
    Vector followed(int node, double feed_m) const;
    void stiffen_mouth(); // the part in the sheath does not bend
    double cell_front_m(int joint) const;
    double held_N() const;

    Rod rod_;
    Physics physics_;
    Sheath sheath_;
    State state_;
    std::vector<Anchor> anchors_;
    Outcome outcome_;
    double inserted_m_ = 0.0, turn_rad_ = 0.0, hand_N_ = 0.0, depth_m_ = 0.0, residual_N_ = 0.0;
    int free_ = 0, iterations_ = 0;
    int curved_ = 0; // number of nodes from the tip that are curved at rest
};

// Returns the rod's first material axis d1 at the sheath's end while the hand's angle is 0. As on the device,
// d1 is perpendicular to `direction` and to the coordinate axis that is least parallel to `direction`.
Vector zero_turn_axis(const Vector &direction);

struct Step {
    double feed_m = 0.5e-3; // longest step
};

struct Run {
    std::vector<std::vector<Vector>> centrelines_mm; // per depth, from the sheath's end to the tip
    std::vector<insertion::ForceSample> force;       // per step
    int steps = 0, iterations = 0, unsettled = 0;    // unsettled: steps that did not come to rest
    double depth_mm = 0.0, residual_mN = 0.0;        // deepest contact and largest remaining force
};

// Simulates the insertion to all depths of a case. The function `progress` receives messages about the work;
// it may be empty.
Run insert(const insertion::Case &c, const crn_wire_instrument &table, const Wall &wall, double friction,
           const Cut &cut, const Step &step, const std::function<void(const std::string &)> &progress = {});

} // namespace crn::reference
