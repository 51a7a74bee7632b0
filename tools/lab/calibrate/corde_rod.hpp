// Makes a rod with the thesis' rod model (tools/lab/vcsim3) from an instrument file; the simulated hand holds
// one end of the rod. The instrument file gives the distribution of stiffness along the rod and the shape of
// its tip; the five fitted numbers of the thesis give everything else.
#pragma once
#include "shared/wire/wire.h"
#include "tools/lab/calibrate/hand.hpp"
#include "tools/lab/vcsim3/simulation.hpp"

namespace crn::calibrate
{

// The formulas are those of a round wire. The shaft of radius r has EI = E pi r^4 / 4 with Young's modulus E;
// alpha is E of the tip divided by E of the shaft, and the mass per length is density pi r^2.
struct CordeValues {
    double young_Pa = 0.0, tip_over_shaft = 0.0, radius_mm = 0.0, density_kg_m3 = 0.0, parallel_N = 0.0;

    double area_m2() const;
    double bend_N_m2() const;
};

// Explicit integration is stable while the time steps are short compared with the period of the fastest
// oscillation. A rod that would need more than `substeps_max` substeps gets more mass instead. The page
// docs/calibrate.md, "The thesis' rod", gives the measurements behind all values.
struct CordeSettings : InsertionSettings {
    double element_mm = 3.0; // with element_factor 1
    int substeps_max = 8;    // per tick of 1 ms
    double drag_per_s = 0.5,
           spin_drag_per_s = 100.0; // of the scaled mass: more would drag the rod back as friction does
    vcsim3::Mode mode;              // the method that keeps lengths: one global iteration
};

// Returns the parameters with which the program simulates the thesis' rod.
struct CordeModel {
    vcsim3::RodProperties properties;
    int substeps = 1;
    double mass_scale = 1.0; // 1 or more
};
CordeModel corde_model(const crn_wire_instrument &table, const CordeValues &values, const insertion::Case &c,
                       const CordeSettings &settings, double length_mm);

// Returns the direction of the first axis of the instrument's frame while the hand's angle is 0, as in the
// core. The returned vector is perpendicular to `direction`, and to the coordinate axis that is most nearly
// perpendicular to `direction`.
Vector3d zero_turn_axis(const Vector3d &direction);

class CordeRod final : public HeldRod
{
  public:
    CordeRod(const CordeModel &model, const insertion::Case &c, const vcsim3::Wall &wall,
             const CordeSettings &settings);

    void tick(double hand_mm, double turn_deg) override;
    double inserted_mm() const override;
    double handle_axial_mN() const override; // mean over the last tick
    bool is_sound() const override;
    std::vector<Vector3d> nodes_mm() const override;

  private:
    vcsim3::Simulation simulation_;
};

} // namespace crn::calibrate
