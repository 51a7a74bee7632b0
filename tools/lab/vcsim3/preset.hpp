// Provides the nine instruments of the thesis' Table 5.1 as rods. The mass and inertia of the rods are scaled
// so that explicit integration is stable.
//
// The table gives no units. All nine instruments are consistent in these units: E x 1e7 Pa, radius x 1e-4 m,
// density x 1e5 kg/m^3, and Kp x 10 newtons. With 1e-4 m as the unit of the radius, the table's 8.9 is the
// 0.89 mm of the Super Stiff. If the table's length is the decimetre (0.89 mm is then 8.9e-3), the unit of Kp
// follows, because Kp / (E radius^2) must be the ratio of the table's own numbers. The document
// docs/thesis.md explains why Table 5.1 must have these units.
#pragma once
#include "tools/lab/vcsim3/rod.hpp"
#include <string>

namespace vcsim3
{

struct Preset {
    const char *token;      // for command lines
    const char *instrument; // row of Table 5.1
    // The values of the preset are as printed in the thesis' table, without the powers of ten in its header.
    double young, radius, density, parallel;
    // The same for all modes.
    int substeps;         // steps per millisecond with elements of element_m
    double mass_scale;    // factor of the table's density
    double inertia_scale; // factor of a segment's rotational inertia, in addition to the mass scale

    double young_Pa() const { return young * 1e7; }
    double radius_m() const { return radius * 1e-4; }
    double density_kg_m3() const { return density * 1e5; }
    double parallel_N() const { return parallel * 10.0; }
    double bend_N_m2() const;
    double twist_N_m2() const;    // of a homogeneous round wire with Poisson's ratio 0.3
    double mass_kg_per_m() const; // with mass_scale
};

inline constexpr double preset_element_m = 1.5e-3;
inline constexpr double wall_friction = 0.2;
// The following constants are the drag of the mass points (as in our solver) and of the segments' rotation,
// in 1/s.
inline constexpr double drag_per_s = 20.0, spin_drag_per_s = 200.0;

const std::vector<Preset> &presets();
const Preset *find_preset(const std::string &token); // nullptr when there is none

RodProperties rod_of(const Preset &preset, int element_count, double element_m);

// Returns the time step times the highest angular frequency of the mass points, which the parallel constraint
// sets to 2/l sqrt(Kp / mass per length) for segments of length l. Explicit integration is stable only if the
// product of the time step and the highest angular frequency is below 2.
double step_ratio(const Preset &preset, double element_m, int substeps);

} // namespace vcsim3
