// Reading centrelines and walking along them.
#include "tools/bake/centreline.hpp"
#include "tools/bake/fault.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace seld::bake
{
namespace
{

using nlohmann::json;

json parse(const std::filesystem::path &file)
{
    std::error_code error;
    const auto bytes = std::filesystem::file_size(file, error);
    if (error || bytes > 256u << 20)
        throw Fault(file.string() + ": cannot be read, or is larger than 256 MiB");
    std::ifstream in(file);
    try {
        return json::parse(in);
    } catch (const json::exception &fault) {
        throw Fault(file.string() + ": is no JSON text: " + fault.what());
    }
}

double finite(const json &value, const std::string &where)
{
    if (!value.is_number() || !std::isfinite(value.get<double>()))
        throw Fault(where + " is not a finite number: correct it in 3D Slicer");
    return value.get<double>();
}

std::vector<double> radii_of(const json &markup, const std::string &name, std::size_t count)
{
    for (const json &m : markup.value("measurements", json::array())) {
        if (m.value("name", "") != "Radius") continue;
        const json values = m.value("controlPointValues", json::array());
        if (values.size() != count)
            throw Fault(name + ": 'Radius' has " + std::to_string(values.size()) + " values for " +
                        std::to_string(count) + " control points: export the centreline again");
        std::vector<double> radii;
        for (std::size_t i = 0; i < count; ++i) {
            radii.push_back(finite(values[i], name + ": Radius of control point " + std::to_string(i)));
            if (radii[i] <= 0)
                throw Fault(name + ": Radius of control point " + std::to_string(i) +
                            " is not above zero: correct it");
        }
        return radii;
    }
    throw Fault(name + ": has no measurement 'Radius' per control point: make the centreline with VMTK's "
                       "\"Extract Centerline\" in 3D Slicer");
}

void check_sizes(const Centreline &line, double unit_mm)
{
    const double largest = *std::max_element(line.radii_mm.begin(), line.radii_mm.end());
    if (largest < 0.2 || largest > 100)
        throw Fault(line.name + ": the largest radius is " + std::to_string(largest) +
                    " mm, a vessel's is 0.2 to 100 mm: check coordinateUnits (" + std::to_string(unit_mm) +
                    " mm per unit) and scale");
    for (std::size_t i = 0; i < line.points_mm.size(); ++i)
        if (line.points_mm[i].cwiseAbs().maxCoeff() > 1800)
            throw Fault(
                line.name + ": control point " + std::to_string(i) +
                " lies farther than 1.8 m from the origin: check the unit, or move it with offset_mm");
}

} // namespace

Centreline read_centreline(const std::filesystem::path &file, const Placement &placement)
try {
    const json root = parse(file);
    Centreline line;
    line.name = file.string();
    const json markups = root.is_object() ? root.value("markups", json::array()) : json::array();
    if (markups.empty()) throw Fault(line.name + ": holds no 'markups': give a 3D Slicer .mrk.json curve");
    const json &markup = markups[0];
    if (markup.value("type", "") != "Curve")
        throw Fault(line.name + ": the first markup is a '" + markup.value("type", "") + "', not a 'Curve'");
    const std::string unit = markup.value("coordinateUnits", "mm");
    const double unit_mm = millimetres_per(unit);
    if (unit_mm == 0) throw Fault(line.name + ": coordinateUnits is '" + unit + "': use m, cm, mm or um");
    const json points = markup.value("controlPoints", json::array());
    if (points.size() < 2 || points.size() > centreline_points_max)
        throw Fault(line.name + ": has " + std::to_string(points.size()) + " control points, 2 to " +
                    std::to_string(centreline_points_max) + " are needed");
    for (std::size_t i = 0; i < points.size(); ++i) {
        const json position = points[i].value("position", json::array());
        const std::string where = line.name + ": position of control point " + std::to_string(i);
        if (position.size() != 3) throw Fault(where + " has not three numbers");
        line.points_mm.push_back(placement.place(
            {finite(position[0], where), finite(position[1], where), finite(position[2], where)}, unit_mm));
    }
    // Scales that differ make a round section an oval one: the circle of the same volume is kept.
    const double scale = std::cbrt(placement.scale.prod());
    for (double radius : radii_of(markup, line.name, points.size()))
        line.radii_mm.push_back(radius * unit_mm * scale);
    check_sizes(line, unit_mm);
    return line;
} catch (const json::exception &fault) {
    throw Fault(file.string() + ": is no 3D Slicer markups file: " + fault.what());
}

CurvePoint along(const Centreline &line, bool from_last, double distance_mm)
{
    std::vector<Eigen::Vector3d> points = line.points_mm;
    if (from_last) std::reverse(points.begin(), points.end());
    double left = distance_mm;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Eigen::Vector3d step = points[i + 1] - points[i];
        if (step.norm() > 0 && left <= step.norm()) {
            // The tangent over a few millimetres: control points stand close and their direction is rough.
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

// With the axis coordinate s of p and its distance q from the axis, the side of the hull is the cone that touches both
// spheres; where the foot of the normal passes an end, the sphere of that end is nearer.
double tapered_capsule_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double radius_a,
                                const Eigen::Vector3d &b, double radius_b)
{
    const Eigen::Vector3d axis = b - a;
    const double length = axis.norm(), taper = radius_a - radius_b;
    if (length <= std::abs(taper)) // one sphere holds the other
        return radius_a > radius_b ? (p - a).norm() - radius_a : (p - b).norm() - radius_b;
    const double s = axis.dot(p - a) / length, sine = taper / length, cosine = std::sqrt(1 - sine * sine);
    const double q = std::sqrt(std::max(0.0, (p - a).squaredNorm() - s * s));
    const double foot = s - q * sine / cosine; // where the cone's normal through p meets the axis
    if (foot <= 0) return (p - a).norm() - radius_a;
    if (foot >= length) return (p - b).norm() - radius_b;
    return s * sine + q * cosine - radius_a;
}

} // namespace seld::bake
