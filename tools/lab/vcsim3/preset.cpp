#include "tools/lab/vcsim3/preset.hpp"
#include <cmath>

namespace vcsim3
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double poisson_ratio = 0.3;

double area_m2(const Preset &preset)
{
    return pi * preset.radius_m() * preset.radius_m();
}

double second_moment_m4(const Preset &preset)
{
    return area_m2(preset) * preset.radius_m() * preset.radius_m() / 4.0;
}

} // namespace

double Preset::bend_N_m2() const
{
    return young_Pa() * second_moment_m4(*this);
}

double Preset::twist_N_m2() const
{
    return bend_N_m2() / (1.0 + poisson_ratio);
}

double Preset::mass_kg_per_m() const
{
    return density_kg_m3() * mass_scale * area_m2(*this);
}

// The number of substeps is the smallest with step_ratio <= 1.5, so that every mode of the thesis' rod stays
// stable when segments are compressed. The command `vcsim3 stability` measures with how few steps each mode
// becomes unstable.
const std::vector<Preset> &presets()
{
    static const std::vector<Preset> rows = {
        {"amplatz", "Amplatz Super Stiff", 3.65, 8.9, 8.47, 1.63, 8, 0.1, 30.0},
        {"cook-straight", "Cook Fixed Core Straight", 3.28, 6.5, 3.09, 39.9, 88, 0.1, 30.0},
        {"bentson", "Bentson", 9.03, 7.5, 88.2, 4.05, 5, 0.1, 30.0},
        {"terumo-stiff", "Terumo Stiff Angled", 5.45, 6.2, 15.0, 31.2, 37, 0.1, 30.0},
        {"cook-j", "Cook J", 17.6, 6.8, 1.33, 10.2, 65, 0.1, 30.0},
        {"rosen", "Rosen", 3.90, 6.7, 7.24, 37.7, 55, 0.1, 30.0},
        {"beacon-5f", "Beacon 5F", 3.53, 7.4, 36.5, 30.2, 20, 0.1, 30.0},
        {"terumo-4f", "Terumo 4F", 3.66, 6.2, 1.80, 8.92, 57, 0.1, 30.0},
        {"terumo-5f", "Terumo 5F", 3.54, 6.3, 11.4, 31.7, 42, 0.1, 30.0},
    };
    return rows;
}

const Preset *find_preset(const std::string &token)
{
    for (const Preset &preset : presets())
        if (token == preset.token) return &preset;
    return nullptr;
}

RodProperties rod_of(const Preset &preset, int element_count, double element_m)
{
    RodProperties rod;
    rod.element_count = element_count;
    rod.element_m = element_m;
    rod.bend_N_m2 = preset.bend_N_m2();
    rod.twist_N_m2 = preset.twist_N_m2();
    rod.parallel_N = preset.parallel_N();
    rod.mass_kg_per_m = preset.mass_kg_per_m();
    rod.inertia_bend_kg_m =
        preset.density_kg_m3() * preset.mass_scale * preset.inertia_scale * second_moment_m4(preset);
    rod.inertia_twist_kg_m = 2.0 * rod.inertia_bend_kg_m;
    rod.radius_m = preset.radius_m();
    rod.friction = wall_friction;
    rod.drag_per_s = drag_per_s;
    rod.spin_drag_per_s = spin_drag_per_s;
    return rod;
}

double step_ratio(const Preset &preset, double element_m, int substeps)
{
    return 2.0 / element_m * std::sqrt(preset.parallel_N() / preset.mass_kg_per_m()) * 1e-3 / substeps;
}

} // namespace vcsim3
