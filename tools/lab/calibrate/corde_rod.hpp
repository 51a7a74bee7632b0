// The thesis' rod (tools/lab/vcsim3) as an instrument in a hand: stiffness along it and the shape of its tip
// from the instrument's file, the rest from the five numbers that the thesis fits.
#pragma once
#include "shared/wire/wire.h"
#include "tools/lab/calibrate/hand.hpp"
#include "tools/lab/vcsim3/simulation.hpp"

namespace crn::calibrate
{

// A round wire: EI = E pi r^4 / 4 at the shaft, E of the tip over that of the shaft, mass per length =
// density pi r^2.
struct CordeValues {
    double young_Pa = 0.0, tip_over_shaft = 0.0, radius_mm = 0.0, density_kg_m3 = 0.0, parallel_N = 0.0;

    double area_m2() const;
    double bend_N_m2() const;
};

// Explicit integration is stable while the steps are short against the fastest motion; a rod that needs more
// of them than `substeps_max` gets more mass. All are measured: docs/calibrate.md, "The thesis' rod".
struct CordeSettings : InsertionSettings {
    double element_mm = 3.0; // with element_factor 1
    int substeps_max = 8;    // per tick of 1 ms
    double drag_per_s = 0.5,
           spin_drag_per_s = 100.0; // of the scaled mass: more drags the rod back as friction would
    vcsim3::Mode mode;              // how lengths are held: one global iteration
};

// What such a rod is for the integration.
struct CordeModel {
    vcsim3::RodProperties properties;
    int substeps = 1;
    double mass_scale = 1.0; // 1 or more
};
CordeModel corde_model(const crn_wire_instrument &table, const CordeValues &values, const insertion::Case &c,
                       const CordeSettings &settings, double length_mm);

// Where the first axis of the instrument's frame is while the hand is not turned, as in the core: across the
// direction and the axis of the world that is most across it.
Vector3d zero_turn_axis(const Vector3d &direction);

class CordeRod final : public HeldRod
{
  public:
    CordeRod(const CordeModel &model, const insertion::Case &c, const vcsim3::Wall &wall,
             const CordeSettings &settings);

    void tick(double hand_mm, double turn_deg) override;
    double inserted_mm() const override;
    double handle_axial_mN() const override; // mean of the last tick
    bool is_sound() const override;
    std::vector<Vector3d> nodes_mm() const override;

  private:
    vcsim3::Simulation simulation_;
};

} // namespace crn::calibrate
