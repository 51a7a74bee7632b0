// Converts centrelines to the patient's coordinates, and computes positions on a centreline at a given arc
// length.
#include "tools/bake/centreline.hpp"
#include "tools/bake/fault.hpp"
#include "tools/centreline/formats.hpp"

#include <algorithm>
#include <cmath>

namespace crn::bake
{
namespace
{

void check_sizes(const Curve &line)
{
    double largest = 0;
    for (const centreline::Sphere &sphere : line.spheres) largest = std::max(largest, sphere.radius_mm);
    if (largest < 0.2 || largest > 100)
        throw Fault(line.name + ": the largest radius is " + std::to_string(largest) +
                    " mm, a vessel's is 0.2 to 100 mm: check the file's unit (coordinateUnits) and scale");
    for (std::size_t i = 0; i < line.spheres.size(); ++i)
        if (line.spheres[i].centre_mm.cwiseAbs().maxCoeff() > 1800)
            throw Fault(
                line.name + ": control point " + std::to_string(i) +
                " lies farther than 1.8 m from the origin: check the unit, or move it with offset_mm");
}

} // namespace

std::vector<Curve> read_centrelines(const std::filesystem::path &file, const Placement &placement)
{
    const centreline::Tree tree = centreline::read_tree(file);
    // If the scene's text scales the axes unequally, a circular section of a vessel becomes oval. We replace
    // an oval cross-section by the circle that gives the vessel the same volume.
    const double scale = std::cbrt(placement.scale.prod());
    std::vector<Curve> lines;
    for (const centreline::Branch &branch : tree.branches) {
        Curve line;
        line.name = file.string();
        // The file's own name serves where the file holds one vessel without a name of its own.
        if (tree.branches.size() > 1 || (file.extension() == ".csv" && !branch.name.empty()))
            line.name += "/" + (branch.name.empty() ? "branch " + std::to_string(lines.size()) : branch.name);
        for (const centreline::Sphere &sphere : branch.spheres)
            line.spheres.push_back({placement.place(sphere.centre_mm, 1.0), sphere.radius_mm * scale});
        check_sizes(line);
        lines.push_back(std::move(line));
    }
    return lines;
}

Curve read_centreline(const std::filesystem::path &file, const Placement &placement)
{
    return read_centrelines(file, placement).front();
}

CurvePoint along(const Curve &line, bool from_last, double distance_mm)
{
    std::vector<Eigen::Vector3d> points;
    for (const centreline::Sphere &sphere : line.spheres) points.push_back(sphere.centre_mm);
    if (from_last) std::reverse(points.begin(), points.end());
    double left = distance_mm;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Eigen::Vector3d step = points[i + 1] - points[i];
        if (step.norm() > 0 && left <= step.norm()) {
            // We take the tangent of a centreline over a few millimetres, because the direction between
            // neighbouring control points is too rough.
            const Eigen::Vector3d position = points[i] + step * (left / step.norm());
            std::size_t ahead = i + 1;
            while (ahead + 1 < points.size() && (points[ahead] - position).norm() < 5) ++ahead;
            return {position, (points[ahead] - position).normalized()};
        }
        left -= step.norm();
    }
    throw Fault(line.name + ": is shorter than the " + std::to_string(distance_mm) +
                " mm of entry.distance_mm");
}

} // namespace crn::bake
