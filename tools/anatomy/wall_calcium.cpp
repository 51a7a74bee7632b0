#include "tools/anatomy/wall_calcium.hpp"
#include <cmath>
#include <cstdint>
#include <numbers>

namespace anatomy
{

namespace
{

/* Marsaglia's xorshift: the same numbers from 0 to 1 on every machine. */
class Numbers
{
  public:
    explicit Numbers(std::uint32_t seed) : state_(seed * 2654435761u | 1u) {}
    double next()
    {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 17;
        state_ ^= state_ << 5;
        return state_ / 4294967296.0;
    }
    double between(double low, double high) { return low + (high - low) * next(); }

  private:
    std::uint32_t state_;
};

/* How likely a plaque is at a point of the aorta, relative to other points; 0 near the heart. All are
 * assumed. */
double likelihood(const Vec3 &p, bool is_aorta)
{
    if (!is_aorta) return p.y() > -250 ? 0.8 : 0.3;
    if (p.z() > 5 && p.y() > 130) return 0.0; // the ascending aorta
    return p.y() < -40 ? 1.0 : p.y() > 200 ? 0.9 : 0.25;
}

} // namespace

std::vector<Plaque> wall_plaques(const VesselTree &tree, const SoftShape &shape)
{
    constexpr double PLAQUES_MOST = 46, THICKNESS_MM = 1.4, OFF_LUMEN_MM = 0.25, LENGTH_MOST_MM = 13;
    struct Place {
        Vec3 centre, along;
        double radius_mm;
    };
    std::vector<Place> places;
    Numbers numbers(shape.calcium_seed);
    for (const Vessel &vessel : tree.vessels) {
        const bool is_aorta = vessel.parent.empty();
        if (!is_aorta && vessel.name.find("iliac") == std::string::npos) continue;
        const Curve curve = vessel_curve(vessel, 1.0);
        for (size_t i = 0; i < curve.size(); i++)
            if (numbers.next() < likelihood(curve[i].position_mm, is_aorta))
                places.push_back({curve[i].position_mm, curve_tangent(curve, i), curve[i].radius_mm});
    }
    const Solid lumen = tree_solid(tree, 0.0);
    std::vector<Plaque> plaques;
    const int count = static_cast<int>(std::lround(PLAQUES_MOST * shape.wall_calcium));
    for (int k = 0; k < count && !places.empty(); k++) {
        const Place &at = places[static_cast<size_t>(numbers.next() * static_cast<double>(places.size()))];
        const double angle = numbers.between(0, 2 * std::numbers::pi);
        const Vec3 one = at.along.unitOrthogonal(), other = at.along.cross(one);
        const Vec3 out = std::cos(angle) * one + std::sin(angle) * other;
        const double half = 0.5 * THICKNESS_MM * numbers.between(0.6, 1.0);
        Plaque plaque;
        plaque.rotation << out, at.along.cross(out), at.along;
        plaque.half_axes_mm = {half, std::min(0.45 * at.radius_mm, numbers.between(1.5, 4.5)),
                               0.5 * numbers.between(3.0, LENGTH_MOST_MM)};
        plaque.centre_mm = at.centre + (at.radius_mm + OFF_LUMEN_MM + half) * out;
        // Where vessels meet, the wall of one may run inside another one.
        if (lumen.distance(plaque.centre_mm) > 0.0) plaques.push_back(plaque);
    }
    return plaques;
}

Solid plaque_solid(const std::vector<Plaque> &plaques)
{
    Solid solid;
    for (const Plaque &plaque : plaques) {
        Part part(0.0);
        part.add<Ellipsoid>(plaque.centre_mm, plaque.half_axes_mm, plaque.rotation);
        solid.add(part);
    }
    return solid;
}

} // namespace anatomy
