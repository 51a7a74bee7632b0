#include "tools/lab/figures/stability.hpp"
#include <algorithm>

namespace vcsim3
{
namespace
{

constexpr int elements = 64, push_ticks = 760, hold_ticks = 50;
constexpr double tube_radius_m = 8e-3, tube_length_m = 85e-3, start_m = 20e-3;
constexpr double stretch_allowed = 1.1, reach_m = 0.3;

bool is_stretched(const Rod &rod)
{
    const double longest = stretch_allowed * rod.properties.element_m;
    for (int j = 0; j < std::min(rod.free_count, rod.properties.element_count); j++)
        if (!((rod.position[j + 1] - rod.position[j]).norm() <= longest)) return true;
    return false;
}

} // namespace

Wall tube_wall(double radius_m, double length_m)
{
    return [radius_m, length_m](const Vector &p) {
        const Vector across(0.0, p.y(), p.z());
        const double offset = across.norm();
        LumenSample sample;
        if (offset - radius_m > p.x() - length_m) {
            sample.distance_m = offset - radius_m;
            if (offset > 0.0) sample.inward = -across / offset;
        } else {
            sample.distance_m = p.x() - length_m;
            sample.inward = -Vector::UnitX();
        }
        return sample;
    };
}

bool survives_crowding(const Preset &preset, const Mode &mode, int substeps)
{
    SimulationSettings settings;
    settings.mode = mode;
    settings.substeps = substeps;
    // The tube is oblique to the axes, so that the rod is bent when it reaches the closed end. In a tube
    // along an axis, a single iteration of the global solver does not transmit the wall's force along the
    // rod, so that the first segment is crushed (docs/thesis.md).
    const Vector direction = Vector(1.0, 0.25, 0.1).normalized();
    Simulation simulation(rod_of(preset, elements + 2, preset_element_m), Inserter(Vector::Zero(), direction),
                          tube_wall(tube_radius_m, tube_length_m), settings, start_m);
    const double feed_m = (elements * preset_element_m - start_m) / push_ticks;
    for (int i = 0; i < push_ticks + hold_ticks; i++) {
        simulation.tick(i < push_ticks ? feed_m : 0.0);
        if (!is_sound_within(simulation.rod(), reach_m) || is_stretched(simulation.rod())) return false;
    }
    return true;
}

int smallest_stable_substeps(const Preset &preset, const Mode &mode, const Watch &watch)
{
    int failing = 0, stable = 2 * preset.substeps;
    if (!survives_crowding(preset, mode, stable)) return 0;
    while (stable - failing > 1) {
        const int middle = (failing + stable) / 2;
        (survives_crowding(preset, mode, middle) ? stable : failing) = middle;
        if (watch && !watch(1.0 - static_cast<double>(stable - failing) / (2 * preset.substeps)))
            throw Interrupted();
    }
    return stable;
}

} // namespace vcsim3
