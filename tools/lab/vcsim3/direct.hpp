// Simulates a rod with our own solver for comparison with the baseline. The solver is the firmware core,
// which receives the same vessel through its public header. Of all files in this folder, only direct.hpp and
// direct.cpp call the core.
#pragma once
#include "tools/lab/vcsim3/lumen.hpp"
#include "tools/lab/vcsim3/rod.hpp"
#include <memory>

namespace vcsim3
{

// Holds the properties of a uniform, straight rod that are passed to the core. Ranges: firmware/core/core.h.
struct DirectProperties {
    double length_m = 0.0;
    double element_m = 0.0;
    double bend_N_m2 = 0.0, twist_N_m2 = 0.0;
    double mass_kg_per_m = 0.0;
    double radius_m = 0.0;
    double friction = 0.0;
    double axial_max_N = 0.0; // upper limit of EA
};

class DirectRod
{
  public:
    // `lumen` must outlive this object; the rod enters the lumen at `mouth_m` along the unit vector
    // `direction`. Throws std::runtime_error when the core rejects the rod.
    DirectRod(const DirectProperties &properties, const crn_lumen &lumen, const Vector &mouth_m,
              const Vector &direction, double inserted_m);
    DirectRod(DirectRod &&) noexcept;
    ~DirectRod();

    // Simulates a tick of 1 ms, in which the hand pushes the rod in by feed_m. For our solver, one tick is
    // one time step.
    void tick(double feed_m);

    double inserted_m() const;
    double handle_axial_N() const;         // + pushes the hand back out
    double length_error() const;           // of the free part, as in the baseline
    double depth_max_m() const;            // of the last tick
    int contact_count() const;             // as the core counts them
    int solve_count() const;               // of the last tick
    std::vector<Vector> positions() const; // free nodes and the first held one
    std::vector<bool> touching() const;    // for each of these nodes

    // The following functions convert the state of the rod to bytes and back; restore() returns false when
    // the bytes do not belong to this rod.
    std::vector<std::uint8_t> save() const;
    bool restore(const std::vector<std::uint8_t> &bytes);

  private:
    struct Core;
    std::unique_ptr<Core> core_;
};

} // namespace vcsim3
