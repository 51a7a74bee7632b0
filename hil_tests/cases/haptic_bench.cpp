#include "hil_tests/cases/haptic_bench.hpp"
#include <cmath>

namespace hil
{

crn_wire_instrument haptic_wire(double bend_N_m2)
{
    crn_wire_instrument wire{};
    wire.axial_stiffness_max_N = 3000;
    wire.element_tip_um = 2000;
    wire.element_shaft_um = 4000;
    wire.element_fine_um = 20000;
    wire.knots_count = 2;
    for (std::uint32_t i = 0; i < 2; i++) {
        crn_wire_knot &knot = wire.knots[i];
        knot.arc_um = i * 350000;
        knot.bend_stiffness_nN_m2 = static_cast<std::uint32_t>(std::lround(bend_N_m2 * 1e9));
        knot.twist_stiffness_nN_m2 = static_cast<std::uint32_t>(std::lround(bend_N_m2 / 1.3 * 1e9));
        knot.mass_mg_per_m = 5000;
        knot.radius_outer_um = 445;
        knot.friction_kinetic_milli = 100;
        knot.friction_static_milli = 120;
    }
    return wire;
}

PlantSettings haptic_plant(double hand_stiffness, double hand_damping)
{
    PlantSettings settings;
    settings.translation.tool_inertia = 0.06;
    settings.translation.roller_inertia = 0.02;
    settings.translation.coulomb = 0.02;
    settings.translation.motor_lag_s = 0.0005;
    settings.translation.hand_stiffness = hand_stiffness;
    settings.translation.hand_damping = hand_damping;
    settings.translation_encoder.jitter_counts = 0.7;
    return settings;
}

} // namespace hil
