#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

Curve vessel_curve(const Vessel &vessel, double step_mm)
{
    std::vector<Vec3> points;
    std::vector<double> radii_mm;
    for (const Station &station : vessel.stations) {
        points.push_back(station.position_mm);
        radii_mm.push_back(0.5 * station.diameter_mm);
    }
    return sample_curve(points, radii_mm, step_mm);
}

void put_mouth(VesselTree &tree, double y_mm)
{
    const Curve curve = vessel_curve(tree.vessels[1], 1.0);
    size_t mouth = 0;
    for (size_t i = 0; i < curve.size(); i++)
        if (curve[i].position_mm.y() > y_mm) mouth = i;
    tree.entry_position_mm = curve[mouth].position_mm;
    tree.entry_direction = -curve_tangent(curve, mouth);
}

Solid tree_solid(const VesselTree &tree, double wall_mm)
{
    constexpr double CORONARY_FILLET_MM = 1.0;
    const auto coronaries = tree.vessels.end() - static_cast<std::ptrdiff_t>(tree.coronary_count);
    Solid solid = vessels_solid({tree.vessels.begin(), coronaries}, wall_mm, tree.fillet_mm);
    if (tree.coronary_count > 0)
        solid.add(vessels_solid({coronaries, tree.vessels.end()}, wall_mm, CORONARY_FILLET_MM));
    return solid;
}

Solid vessels_solid(const std::vector<Vessel> &vessels, double wall_mm, double fillet_mm)
{
    Part part(fillet_mm);
    for (const Vessel &vessel : vessels) {
        Curve curve = vessel_curve(vessel, 1.0);
        for (CurvePoint &point : curve) point.radius_mm += wall_mm;
        part.add<Tube>(curve);
    }
    Solid solid;
    solid.add(part);
    return solid;
}

} // namespace anatomy
