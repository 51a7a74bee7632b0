#include "host/stent/circles.hpp"
#include <Eigen/Geometry>
#include <algorithm>

namespace crn
{

namespace
{

using Eigen::Vector3d;

// Returns certain crowns of a ring of struts: in the stent's first ring those towards the tip, in its last
// ring those towards the hub, and in other rings all crowns.
std::vector<std::size_t> crowns_of(const Stent &stent, int ring)
{
    const StentLattice &lattice = stent.lattice();
    const int side = ring == 0 ? -1 : ring + 1 == lattice.rings ? 1 : 0;
    std::vector<std::size_t> crowns;
    for (int place = 0; place < 2 * lattice.crowns; ++place) {
        const std::size_t point = lattice.point(ring, place);
        if (side == 0 || lattice.side_of(point) == side) crowns.push_back(point);
    }
    return crowns;
}

} // namespace

std::vector<StentCircle> stent_circles(const Stent &stent, std::size_t most,
                                       const std::function<Vector3d(const Vector3d &)> &to_reference)
{
    std::vector<StentCircle> circles;
    if (stent.stage() != StentStage::deployed) return circles;
    const auto rings = static_cast<std::size_t>(stent.lattice().rings);
    const std::size_t count = std::min(rings, std::max<std::size_t>(most, 2));
    std::vector<std::vector<Vector3d>> places(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t ring = (2 * i * (rings - 1) + (count - 1)) / (2 * (count - 1));
        Vector3d middle = Vector3d::Zero();
        for (const std::size_t point : crowns_of(stent, static_cast<int>(ring))) {
            places[i].push_back(to_reference(stent.points()[point].place_mm));
            middle += places[i].back();
        }
        circles.push_back({middle / static_cast<double>(places[i].size())});
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Vector3d way =
            circles[std::min(i + 1, count - 1)].centre_mm - circles[i > 0 ? i - 1 : 0].centre_mm;
        const Vector3d axis = way.norm() > 1e-9 ? Vector3d(way.normalized()) : Vector3d::UnitX();
        double radius = 0.0;
        for (const Vector3d &place : places[i]) radius += (place - circles[i].centre_mm).cross(axis).norm();
        circles[i].inside_mm =
            radius / static_cast<double>(places[i].size()) - stent.design().strut_thickness_mm / 2;
    }
    return circles;
}

} // namespace crn
