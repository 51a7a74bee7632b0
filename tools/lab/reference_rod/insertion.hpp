// The protocol of an insertion (tools/lab/case/case.hpp) by the reference rod: fed through a straight
// frictionless sheath that ends at the mouth, in small steps, each of them at rest.
#pragma once
#include "tools/lab/case/case.hpp"
#include "tools/lab/reference_rod/equilibrium.hpp"

namespace crn::reference
{

struct Sheath {
    Vector mouth_m = Vector::Zero();
    Vector direction = Vector::UnitX(); // unit, into the vessel
};

// One instrument on its way in.
class Insertion
{
  public:
    // With `start_m` out of the sheath: straight, so it should be short.
    Insertion(const Rod &rod, const Physics &physics, const Sheath &sheath, double start_m, double turn_rad);

    // Feeds to `inserted_m` with the hand at `turn_rad`; one step, or several where one does not come to
    // rest. False where even short steps do not: the state is the best found.
    bool advance(double inserted_m, double turn_rad);

    double inserted_m() const { return inserted_m_; }
    double hand_N() const
    {
        return hand_N_;
    } // along the sheath, + pushes the hand back out; its work without friction is what the rod stores
    int free_nodes() const { return free_; }
    const State &state() const { return state_; }
    const Outcome &outcome() const { return outcome_; }
    int iterations() const { return iterations_; }    // of all steps so far
    double depth_m() const { return depth_m_; }       // deepest contact of all steps so far
    double residual_N() const { return residual_N_; } // largest of all steps so far

    // From the mouth to the tip: what lies outside the sheath.
    std::vector<Vector> centreline_m() const;

  private:
    bool step(double inserted_m, double turn_rad);
    void place(double inserted_m, double turn_rad); // first guess, and the held nodes
    Vector followed(int node, double feed_m) const;
    void stiffen_mouth(); // what lies in the sheath does not bend
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
    int curved_ = 0; // nodes before this one are curved at rest
};

// d1 at the mouth with the hand at turn 0: across the direction and the axis least along it, as the device
// has it.
Vector zero_turn_axis(const Vector &direction);

struct Step {
    double feed_m = 0.5e-3; // longest
};

struct Run {
    std::vector<std::vector<Vector>> centrelines_mm; // per depth, from the mouth to the tip
    std::vector<insertion::ForceSample> force;       // per step
    int steps = 0, iterations = 0, unsettled = 0;    // steps that did not come to rest
    double depth_mm = 0.0, residual_mN = 0.0;        // deepest contact and largest force left over
};

// All depths of a case. `progress` is told what is done, and may be empty.
Run insert(const insertion::Case &c, const crn_wire_instrument &table, const Wall &wall, double friction,
           const Cut &cut, const Step &step, const std::function<void(const std::string &)> &progress = {});

} // namespace crn::reference
