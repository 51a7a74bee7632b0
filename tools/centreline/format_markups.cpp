// In a markups file of 3D Slicer (.mrk.json) every curve is a branch of the tree, with a measurement 'Radius'
// per control point. The description of a branch's first control point states where the branch leaves its
// parent; 3D Slicer shows and keeps this description.
#include "tools/centreline/formats.hpp"
#include "tools/mesh/json_depth.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace crn::centreline
{
namespace
{

using nlohmann::json;

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

// Returns the curve's name for a point's label, such as "LAD" for "LAD-1", because 3D Slicer labels the
// points of a curve in this way.
std::string curve_name(const json &point)
{
    const std::string label = point.value("label", "");
    const std::size_t dash = label.rfind('-');
    const bool is_numbered = dash != label.npos && dash + 1 < label.size() &&
                             label.find_first_not_of("0123456789", dash + 1) == label.npos;
    return plain_name(is_numbered ? label.substr(0, dash) : label);
}

Branch branch_of(const json &markup, const std::string &name)
{
    if (markup.value("type", "") != "Curve")
        throw Fault(name + ": is a '" + markup.value("type", "") +
                    "', not a 'Curve': leave out what is no open curve");
    const std::string unit = markup.value("coordinateUnits", "mm");
    const double unit_mm = millimetres_per(unit);
    if (unit_mm == 0) throw Fault(name + ": coordinateUnits is '" + unit + "': use m, cm, mm or um");
    const json points = markup.value("controlPoints", json::array());
    if (points.size() < 2 || points.size() > spheres_max)
        throw Fault(name + ": has " + std::to_string(points.size()) + " control points, 2 to " +
                    std::to_string(spheres_max) + " are needed");
    const std::vector<double> radii = radii_of(markup, name, points.size());
    Branch branch;
    branch.name = curve_name(points[0]);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const json position = points[i].value("position", json::array());
        const std::string where = name + ": position of control point " + std::to_string(i);
        if (position.size() != 3) throw Fault(where + " has not three numbers");
        Sphere sphere;
        for (int k = 0; k < 3; ++k) sphere.centre_mm[k] = unit_mm * finite(position[k], where);
        sphere.radius_mm = unit_mm * radii[i];
        sphere.is_manual = i > 0 && points[i].value("description", "") == "manual";
        branch.spheres.push_back(sphere);
    }
    const std::string first = points[0].value("description", "");
    if (std::sscanf(first.c_str(), "leaves branch %d at sphere %zu", &branch.parent, &branch.parent_sphere) !=
        2)
        branch.parent = -1, branch.parent_sphere = 0;
    return branch;
}

nlohmann::ordered_json control_point(const Branch &branch, std::size_t index)
{
    const Sphere &sphere = branch.spheres[index];
    const auto rounded = [](double value) { return std::round(value * 1e6) / 1e6; };
    const std::string number = std::to_string(index + 1);
    std::string description = sphere.is_manual ? "manual" : "";
    if (index == 0 && branch.parent >= 0)
        description = "leaves branch " + std::to_string(branch.parent) + " at sphere " +
                      std::to_string(branch.parent_sphere);
    return {{"id", number},
            {"label", branch.name + "-" + number},
            {"description", description},
            {"associatedNodeID", ""},
            {"position",
             {rounded(sphere.centre_mm.x()), rounded(sphere.centre_mm.y()), rounded(sphere.centre_mm.z())}},
            {"selected", true},
            {"locked", false},
            {"visibility", true},
            {"positionStatus", "defined"}};
}

} // namespace

Tree read_markups(const std::string &text, const std::string &name)
try {
    if (json_depth(text) > json_depth_max)
        throw Fault(name + ": its brackets lie " + std::to_string(json_depth(text)) +
                    " deep in each other: give a 3D Slicer .mrk.json curve");
    const json root = json::parse(text);
    const json markups = root.is_object() ? root.value("markups", json::array()) : json::array();
    if (!markups.is_array() || markups.empty())
        throw Fault(name + ": holds no 'markups': give a 3D Slicer .mrk.json curve");
    Tree tree;
    for (std::size_t i = 0; i < markups.size(); ++i)
        tree.branches.push_back(
            branch_of(markups[i], markups.size() == 1 ? name : name + ": markup " + std::to_string(i)));
    check_tree(tree, name);
    return tree;
} catch (const json::parse_error &fault) {
    throw Fault(name + ": is no JSON text: " + fault.what());
} catch (const json::exception &fault) {
    throw Fault(name + ": is no 3D Slicer markups file: " + fault.what());
}

std::string markups_text(const Tree &tree)
{
    nlohmann::ordered_json markups = nlohmann::ordered_json::array();
    for (const Branch &branch : tree.branches) {
        nlohmann::ordered_json points = nlohmann::ordered_json::array(), radii = points;
        for (std::size_t i = 0; i < branch.spheres.size(); ++i) {
            points.push_back(control_point(branch, i));
            radii.push_back(std::round(branch.spheres[i].radius_mm * 1e6) / 1e6);
        }
        markups.push_back(
            {{"type", "Curve"},
             {"coordinateSystem", "LPS"},
             {"coordinateUnits", "mm"},
             {"controlPoints", points},
             {"measurements",
              {{{"name", "Radius"}, {"enabled", true}, {"units", "mm"}, {"controlPointValues", radii}}}}});
    }
    return nlohmann::ordered_json{
               {"@schema", "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
                           "Resources/Schema/markups-schema-v1.0.3.json#"},
               {"markups", markups}}
               .dump(1) +
           "\n";
}

} // namespace crn::centreline
