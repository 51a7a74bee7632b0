#include "tools/anatomy/small/winding.hpp"
#include "tools/anatomy/chance.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

using std::numbers::pi;

/* Two sine waves across the course, in two planes. */
struct Waves {
    double amplitude_mm, wavelength_mm[2], phase[2];
    double at(int plane, double arc_mm) const
    {
        return amplitude_mm * std::sin(2.0 * pi * arc_mm / wavelength_mm[plane] + phase[plane]);
    }
};

/* A wave with the amplitude A and the length l makes a path longer by (pi A / l)^2; two planes have twice as
 * much. */
Waves waves_of(double diameter_mm, double winding, Chance &chance)
{
    const double length_mm = std::clamp(16.0 * diameter_mm, 22.0, 60.0);
    Waves waves{length_mm / pi * std::sqrt(0.5 * std::max(0.0, winding - 1.0)), {}, {}};
    for (int plane = 0; plane < 2; plane++) {
        waves.wavelength_mm[plane] = length_mm * chance.uniform(0.8, 1.25);
        waves.phase[plane] = chance.uniform(0.0, 2.0 * pi);
    }
    return waves;
}

} // namespace

Vessel wound(const Vessel &vessel, std::uint64_t seed, std::uint64_t stream)
{
    constexpr double STEP_MM = 3.0, SHORTEST_MM = 20.0;
    const Curve curve = vessel_curve(vessel, STEP_MM);
    const double length_mm = curve.back().arc_mm;
    if (vessel.winding <= 1.0 || length_mm < SHORTEST_MM) return vessel;
    Chance chance(seed, stream);
    const Waves waves = waves_of(2.0 * curve[curve.size() / 2].radius_mm, vessel.winding, chance);
    const double fade_mm = std::min(0.35 * length_mm, 0.5 * waves.wavelength_mm[0]);
    Vessel winding = vessel;
    winding.stations.clear();
    Vec3 across = curve_tangent(curve, 0).unitOrthogonal();
    for (size_t i = 0; i < curve.size(); i++) {
        // The direction across the course is carried along it, so that it never turns suddenly.
        const Vec3 along = curve_tangent(curve, i);
        across = (across - along * along.dot(across)).normalized();
        const double arc_mm = curve[i].arc_mm;
        const double share = smooth_step(0.0, fade_mm, std::min(arc_mm, length_mm - arc_mm));
        const Vec3 offset = waves.at(0, arc_mm) * across + waves.at(1, arc_mm) * along.cross(across);
        winding.stations.push_back({curve[i].position_mm + share * offset, 2.0 * curve[i].radius_mm, "", ""});
    }
    return winding;
}

} // namespace anatomy
