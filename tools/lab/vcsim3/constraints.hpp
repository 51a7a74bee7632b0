// Keeps the distances between neighbouring mass points constant by constraints on their velocities, with
// Baumgarte's term (thesis 5.4.2). For segment j with e = x[j+1] - x[j], direction n = e/|e| and length error
// C = |e| - l, the constraint demands a relative velocity of -beta C / h along n, where h is the time step
// and beta Baumgarte's factor.
//   local    one sweep of pairwise impulses (Gauss-Seidel), from the hand to the tip; N sweeps per step
//   global   all impulses of the chain at once by one tridiagonal solve
#pragma once
#include "tools/lab/vcsim3/rod.hpp"

namespace vcsim3
{

struct DistanceSettings {
    double mixing = 1.0;    // share of each impulse that is applied
    double baumgarte = 0.1; // share of the length error removed per step
};

// Within one step, the directions n and the demanded velocities stay constant over all iterations.
class DistanceConstraints
{
  public:
    explicit DistanceConstraints(const DistanceSettings &settings) : settings_(settings) {}

    // Reads the present positions.
    void prepare(const Rod &rod, double step_s);

    // The following functions change the velocities of free nodes only.
    void sweep_local(Rod &rod);
    void solve_global(Rod &rod);

    int count() const { return static_cast<int>(normal_.size()); }

    // Returns the sum, in N s, of the impulses that this step applied to the first node that the hand holds.
    const Vector &hand_impulse() const { return hand_impulse_; }

  private:
    void apply(Rod &rod, int segment, double impulse_N_s);

    DistanceSettings settings_;
    std::vector<Vector> normal_;
    std::vector<double> wanted_m_s_, share_, impulse_;
    std::vector<double> gain_[2]; // velocity per impulse of either end, including mixing
    std::vector<double> mass_kg_; // effective mass of both ends
    Vector hand_impulse_ = Vector::Zero();
};

} // namespace vcsim3
