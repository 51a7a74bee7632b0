#include "tools/patient/outflow.hpp"
#include "host/base/format.hpp"
#include "tools/bake/branches.hpp"
#include "tools/centreline/end_width.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::patient
{
namespace
{

using centreline::Branch;
using centreline::Sphere;
using centreline::Tree;

constexpr double shear_per_s = 500.0, speed_max_mm_s = 160.0;

// The spheres from the inlet on, through the widest vessels, as far as a cap's taper may reach. An opened
// mesh may divide shortly behind its inlet.
std::vector<Sphere *> from_inlet(Tree &tree)
{
    constexpr double reach_radii = 6.0;
    std::vector<Sphere *> line;
    double passed_mm = 0, widest_mm = 0;
    for (std::size_t branch = 0;;) {
        std::vector<Sphere> &spheres = tree.branches[branch].spheres;
        for (std::size_t i = branch == 0 ? 0 : 1; i < spheres.size(); ++i) {
            if (!line.empty()) passed_mm += (spheres[i].centre_mm - line.back()->centre_mm).norm();
            line.push_back(&spheres[i]);
            widest_mm = std::max(widest_mm, spheres[i].radius_mm);
            if (passed_mm > reach_radii * widest_mm) return line;
        }
        std::size_t next = 0;
        double next_mm = 0;
        for (std::size_t b = branch + 1; b < tree.branches.size(); ++b) {
            const Branch &child = tree.branches[b];
            const double mm = child.spheres[child.spheres.size() / 2].radius_mm;
            if (child.parent == static_cast<int>(branch) && child.parent_sphere + 1 == spheres.size() &&
                mm > next_mm)
                next = b, next_mm = mm;
        }
        if (next == 0) return line;
        branch = next;
    }
}

// The own spheres of a branch from its last one back to its parent's wall.
std::vector<Sphere *> from_end(Tree &tree, std::size_t branch)
{
    std::vector<Sphere> &spheres = tree.branches[branch].spheres;
    const std::size_t first = std::min(centreline::first_own_sphere(tree, branch), spheres.size() - 1);
    std::vector<Sphere *> line;
    for (std::size_t i = spheres.size(); i-- > first;) line.push_back(&spheres[i]);
    return line;
}

void open(const std::vector<Sphere *> &line)
{
    std::vector<Sphere> inwards;
    for (const Sphere *sphere : line) inwards.push_back(*sphere);
    centreline::open_end(inwards);
    for (std::size_t i = 0; i < line.size(); ++i) line[i]->radius_mm = inwards[i].radius_mm;
}

// The width of the vessel behind the end of a branch; what lies inside the parent does not count.
double end_radius_mm(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = tree.branches[index];
    const double start_m = vessel_start_m(tree, index);
    double from_first_m = 0;
    std::vector<Sphere> line;
    for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
        if (i > 0) from_first_m += (branch.points_m[i] - branch.points_m[i - 1]).norm();
        if (from_first_m >= start_m || i + 1 == branch.points_m.size())
            line.push_back({branch.points_m[i] * 1e3, branch.radii_m[i] * 1e3});
    }
    std::reverse(line.begin(), line.end());
    return centreline::width_inside(line).radius_mm;
}

} // namespace

double outlet_flow_ml_s(double radius_mm)
{
    const double murray_mm_s = shear_per_s * radius_mm / 4; // mean speed in Poiseuille's flow
    return std::numbers::pi * radius_mm * radius_mm * std::min(murray_mm_s, speed_max_mm_s) * 1e-3;
}

void open_ends(Tree &tree)
{
    std::vector<bool> has_child(tree.branches.size(), false);
    for (const Branch &branch : tree.branches)
        if (branch.parent >= 0) has_child[static_cast<std::size_t>(branch.parent)] = true;
    open(from_inlet(tree));
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        if (!has_child[b]) open(from_end(tree, b));
}

std::vector<Outflow> outflows(const Tree &tree)
{
    bake::TreeText text;
    text.inlet = bake::branch_name(tree.branches.front().name);
    const VesselTree joined = bake::join_branches(tree.branches, text);
    std::vector<Outflow> flows;
    for (std::size_t b = 0; b < joined.branches.size(); ++b) {
        if (!joined.is_outlet(b)) continue;
        const double radius_mm = end_radius_mm(joined, b);
        flows.push_back({joined.branches[b].name, radius_mm, outlet_flow_ml_s(radius_mm)});
    }
    return flows;
}

double sum_ml_s(const std::vector<Outflow> &flows)
{
    double sum = 0;
    for (const Outflow &flow : flows) sum += flow.flow_ml_s;
    return sum;
}

std::string scene_text(const std::vector<Outflow> &flows)
{
    std::string text = "\n# Mean flow out of every end, by Murray's law up to a mean speed of 160 mm/s: a "
                       "cap of the mesh\n# says nothing about it.\n[tree.flow_ml_min]\n";
    for (const Outflow &flow : flows)
        text += formatted("\"%s\" = %.4g # radius %.2f mm\n", flow.branch.c_str(), 60 * flow.flow_ml_s,
                          flow.radius_mm);
    return text;
}

} // namespace crn::patient
