#include "tools/bake/branches.hpp"
#include "host/base/format.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/centreline/join.hpp"

#include <algorithm>
#include <cmath>

namespace crn::bake
{
namespace
{

constexpr double apart_max_radii =
    1.25; // an end farther than this many radii from a centreline is not joined to it

// Converts a centreline to a branch of the vessel tree, and leaves out every point that coincides with the
// point before it. Rounds the coordinates to the precision with which the body file stores them.
VesselBranch branch_of(const Curve &line)
{
    VesselBranch branch;
    branch.name = branch_name(line.name);
    for (const centreline::Sphere &sphere : line.spheres) {
        const Eigen::Vector3d at_m = (sphere.centre_mm * 1e3).array().round().matrix() * 1e-6;
        if (!branch.points_m.empty() && branch.points_m.back() == at_m) continue;
        branch.points_m.push_back(at_m);
        branch.radii_m.push_back(std::round(sphere.radius_mm * 1e3) * 1e-6);
    }
    if (branch.points_m.size() < 2) throw Fault(line.name + ": has no length: leave it out of [tree]");
    return branch;
}

void turn(VesselBranch &branch)
{
    std::reverse(branch.points_m.begin(), branch.points_m.end());
    std::reverse(branch.radii_m.begin(), branch.radii_m.end());
}

// If a branch leaves its parent within one radius of the parent's end, it is joined to the end itself.
// Joining a branch at the parent's end leaves no stump of the parent beyond the fork.
std::size_t leaving_point(const VesselBranch &parent, std::size_t point)
{
    const std::size_t last = parent.points_m.size() - 1;
    const double left_m = (parent.points_m[last] - parent.points_m[point]).norm();
    return left_m <= parent.radii_m[last] ? last : point;
}

[[noreturn]] void refuse_apart(const std::string &name, const std::string &nearest, double radii)
{
    throw Fault("[tree] '" + name + "' " + formatted("ends %.1f radii away from", radii) +
                " the nearest vessel, '" + nearest +
                "': lengthen it into that vessel, or leave it out of [tree]");
}

// Sets the parent branch of a new branch, and the parent's point that is nearest to the new branch's first
// point.
void attach(VesselBranch &branch, const VesselTree &tree, std::size_t parent)
{
    const VesselFoot foot = vessel_foot(tree.branches[parent], branch.points_m.front());
    std::size_t point = foot.point + (foot.share < 0.5 ? 0 : 1);
    // A branch that would begin at the first point of its parent instead becomes a child of its parent's
    // parent.
    while (point == 0 && tree.branches[parent].parent >= 0) {
        point = tree.branches[parent].parent_point;
        parent = static_cast<std::size_t>(tree.branches[parent].parent);
    }
    branch.parent = static_cast<int>(parent);
    branch.parent_point = leaving_point(tree.branches[parent], point);
}

std::size_t root_of(const std::vector<VesselBranch> &branches, const TreeText &text, bool &from_last)
{
    std::size_t root = 0;
    double widest_m = 0.0;
    for (std::size_t i = 0; i < branches.size(); ++i) {
        const VesselBranch &branch = branches[i];
        if (text.inlet.empty() ? std::max(branch.radii_m.front(), branch.radii_m.back()) <= widest_m
                               : branch.name != text.inlet)
            continue;
        root = i;
        widest_m = std::max(branch.radii_m.front(), branch.radii_m.back());
        from_last = text.inlet.empty() ? branch.radii_m.back() > branch.radii_m.front() : text.inlet_is_last;
    }
    if (!(widest_m > 0.0)) throw Fault("[tree] has no centreline '" + text.inlet + "' for its inlet");
    return root;
}

VesselBranch &named(VesselTree &tree, const std::string &name, const char *key)
{
    for (VesselBranch &branch : tree.branches)
        if (branch.name == name) return branch;
    throw Fault(std::string("[tree] ") + key + " names '" + name + "', which is no centreline of it");
}

void state_beds_and_flows(VesselTree &tree, const TreeText &text)
{
    for (const std::string &name : text.left_coronary)
        named(tree, name, "left_coronary").bed = VesselBed::left_coronary;
    for (const std::string &name : text.right_coronary)
        named(tree, name, "right_coronary").bed = VesselBed::right_coronary;
    for (const auto &[name, flow_ml_min] : text.flow_ml_min) {
        VesselBranch &branch = named(tree, name, "flow_ml_min");
        if (!tree.is_outlet(static_cast<std::size_t>(&branch - tree.branches.data())))
            throw Fault("[tree] flow_ml_min names '" + name +
                        "', where no blood leaves: state the flows of its branches");
        branch.flow_ml_s = flow_ml_min / 60.0;
    }
}

} // namespace

std::string branch_name(const std::filesystem::path &file)
{
    std::string name = file.filename().string();
    for (const char *ending : {".json", ".mrk", ".csv", ".vtp", ".obj"})
        if (name.ends_with(ending)) name.resize(name.size() - std::char_traits<char>::length(ending));
    name.resize(std::min<std::size_t>(name.size(), CRN_SCENE_BRANCH_NAME_BYTES - 1));
    return name;
}

VesselTree join_branches(const std::vector<Curve> &lines, const TreeText &text)
{
    if (lines.size() > CRN_SCENE_BRANCH_MAX)
        throw Fault("[tree] has more than " + std::to_string(int{CRN_SCENE_BRANCH_MAX}) + " centrelines");
    std::vector<VesselBranch> curves;
    for (const Curve &line : lines) {
        curves.push_back(branch_of(line));
        for (std::size_t i = 0; i + 1 < curves.size(); ++i)
            if (curves[i].name == curves.back().name)
                throw Fault("[tree] has two centrelines called '" + curves.back().name + "': rename one");
    }
    VesselTree tree;
    bool from_last = false;
    const std::size_t root = root_of(curves, text, from_last);
    if (from_last) turn(curves[root]);
    const auto depth = [&](std::size_t curve, bool is_last, std::size_t branch) {
        const std::vector<Eigen::Vector3d> &points_m = curves[curve].points_m;
        return vessel_foot(tree.branches[branch], is_last ? points_m.back() : points_m.front()).radii;
    };
    centreline::grow_tree(curves.size(), root, depth, [&](const centreline::Joint &joint) {
        VesselBranch branch = curves[joint.curve];
        if (!tree.branches.empty()) {
            if (joint.depth > apart_max_radii)
                refuse_apart(branch.name, tree.branches[joint.parent].name, joint.depth);
            if (joint.is_last) turn(branch);
            attach(branch, tree, joint.parent);
        }
        tree.branches.push_back(branch);
    });
    state_beds_and_flows(tree, text);
    std::string error;
    if (!check_vessel_tree(tree, error)) throw Fault("[tree] " + error);
    return tree;
}

std::string branches_report(const VesselTree &tree)
{
    double length_mm = 0.0, volume_ml = 0.0;
    std::size_t outlets = 0, stated = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const VesselBranch &branch = tree.branches[b];
        for (std::size_t i = 1; i < branch.points_m.size(); ++i) {
            const double step_m = (branch.points_m[i] - branch.points_m[i - 1]).norm();
            const double radius_m = 0.5 * (branch.radii_m[i] + branch.radii_m[i - 1]);
            length_mm += step_m * 1e3;
            volume_ml += step_m * 3.14159265358979323846 * radius_m * radius_m * 1e6;
        }
        if (!tree.is_outlet(b)) continue;
        ++outlets;
        stated += branch.flow_ml_s > 0.0;
    }
    return formatted(
        "vessels           %zu branches, %.0f mm, %.0f ml, from %s to %zu outlets (%zu with a stated flow)\n",
        tree.branches.size(), length_mm, volume_ml, tree.branches[0].name.c_str(), outlets, stated);
}

} // namespace crn::bake
