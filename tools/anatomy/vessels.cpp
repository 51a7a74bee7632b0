#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

namespace
{

auto first_coronary(const VesselTree &tree)
{
    return tree.vessels.end() - static_cast<std::ptrdiff_t>(tree.coronary_count);
}

} // namespace

std::vector<Vessel> body_vessels(const VesselTree &tree)
{
    return {tree.vessels.begin(), first_coronary(tree)};
}

std::vector<Vessel> coronary_arteries(const VesselTree &tree)
{
    return {first_coronary(tree), tree.vessels.end()};
}

std::vector<Vessel> moved_with_spine(std::vector<Vessel> vessels, const SpineBend &bend)
{
    for (Vessel &vessel : vessels)
        for (Station &station : vessel.stations)
            station.position_mm = moved_with_spine(bend, station.position_mm);
    return vessels;
}

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

Solid tree_solid(const VesselTree &tree, double wall_mm)
{
    Solid solid = vessels_solid(body_vessels(tree), wall_mm, tree.fillet_mm);
    if (tree.coronary_count > 0)
        solid.add(vessels_solid(coronary_arteries(tree), wall_mm, tree.coronary_fillet_mm));
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
