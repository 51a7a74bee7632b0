#include "tools/bake/lesion.hpp"
#include "host/base/format.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crn::bake
{
namespace
{

using Eigen::Vector3d;

constexpr double pi = 3.14159265358979323846;
constexpr double point_step_mm = 0.5; // largest spacing of the branch's points in a lesion
constexpr double throat_off_mm = 0.1,
                 throat_off_share = 0.15; // difference of mesh and tree above which the report warns
constexpr double touch_m = 10e-6;         // lesions may end and begin at one place, which rounding moves

Vector3d rounded_m(const Vector3d &p_m) // as the file will hold it
{
    return (p_m * 1e6).array().round().matrix() * 1e-6;
}

std::vector<double> arcs_m(const VesselBranch &branch)
{
    std::vector<double> arcs = {0.0};
    for (std::size_t i = 1; i < branch.points_m.size(); ++i)
        arcs.push_back(arcs.back() + (branch.points_m[i] - branch.points_m[i - 1]).norm());
    return arcs;
}

struct Axis { // a place of a centreline
    Vector3d point_m, tangent;
    double radius_m;
};

Axis axis_at(const VesselBranch &branch, const std::vector<double> &arcs, double arc_m)
{
    const auto after = std::upper_bound(arcs.begin() + 1, arcs.end() - 1, arc_m);
    const auto i = static_cast<std::size_t>(after - arcs.begin()) - 1;
    const double share = std::clamp((arc_m - arcs[i]) / (arcs[i + 1] - arcs[i]), 0.0, 1.0);
    const Vector3d step = branch.points_m[i + 1] - branch.points_m[i];
    return {branch.points_m[i] + share * step, step.normalized(),
            branch.radii_m[i] + share * (branch.radii_m[i + 1] - branch.radii_m[i])};
}

// Computes unit vectors that are perpendicular to the healthy vessel, at each point of a lesion. In the
// lesion's middle, the direction called front is the patient's front, or the patient's left if the vessel
// itself runs to the front there. The direction called front is carried along the vessel without twist, so
// that plaque stays on one side of the vessel in a bend.
class Across
{
  public:
    explicit Across(const VesselLesion &lesion)
    {
        const std::vector<Vector3d> &points_m = lesion.healthy_points_m;
        const std::size_t last = points_m.size() - 1, middle = last / 2;
        for (std::size_t i = 0; i <= last; ++i)
            tangents_.push_back((points_m[std::min(i + 1, last)] - points_m[i > 0 ? i - 1 : 0]).normalized());
        fronts_.resize(points_m.size());
        const Vector3d &along = tangents_[middle];
        const bool runs_forwards = Vector3d(Vector3d::UnitZ() - along.z() * along).norm() < 0.3;
        carry(runs_forwards ? Vector3d::UnitX() : Vector3d::UnitZ(), middle);
        for (std::size_t i = middle; i < last; ++i) carry(fronts_[i], i + 1);
        for (std::size_t i = middle; i > 0; --i) carry(fronts_[i], i - 1);
    }

    // Returns the direction across the vessel at `deg` degrees from the front at a point of the lesion; the
    // angle is right-handed about the flow.
    Vector3d at(std::size_t point, double deg) const
    {
        const double angle = deg * pi / 180;
        return std::cos(angle) * fronts_[point] + std::sin(angle) * tangents_[point].cross(fronts_[point]);
    }

  private:
    void carry(const Vector3d &front, std::size_t point)
    {
        const Vector3d &along = tangents_[point];
        fronts_[point] = (front - front.dot(along) * along).normalized();
    }

    std::vector<Vector3d> tangents_, fronts_;
};

std::string named(const LesionText &text)
{
    return "[[lesion]] '" + text.name + "' ";
}

std::size_t branch_of(const VesselTree &tree, const LesionText &text)
{
    std::string names;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        if (tree.branches[b].name == text.branch) return b;
        names += (names.empty() ? "" : ", ") + tree.branches[b].name;
    }
    throw Fault(named(text) + "lies on '" + text.branch + "', which is no branch: " +
                (names.empty() ? "the scene has no [tree]" : "there are " + names));
}

// Inserts points into the branch of the vessel, one every half a millimetre, from `begin_m` to `end_m`. The
// branch keeps its other points, and other vessels still leave it at the same positions.
VesselLesion divide(VesselTree &tree, std::size_t index, double begin_m, double end_m)
{
    const VesselBranch old = tree.branches[index];
    const std::vector<double> arcs = arcs_m(old);
    std::vector<double> wanted;
    for (double arc : arcs)
        if (arc < begin_m - 1e-4) wanted.push_back(arc);
    VesselLesion lesion;
    lesion.branch = index;
    lesion.first_point = wanted.size();
    // The number of steps is even, so that one point lies exactly where the vessel is narrowest.
    const double steps = std::max(2 * std::ceil((end_m - begin_m) / (2e-3 * point_step_mm)), 16.0);
    for (int i = 0; i <= static_cast<int>(steps); ++i)
        wanted.push_back(begin_m + i / steps * (end_m - begin_m));
    const std::size_t behind = wanted.size();
    for (double arc : arcs)
        if (arc > end_m + 1e-4) wanted.push_back(arc);

    VesselBranch &branch = tree.branches[index];
    branch.points_m.clear();
    branch.radii_m.clear();
    for (double arc : wanted) {
        const Axis axis = axis_at(old, arcs, arc);
        branch.points_m.push_back(rounded_m(axis.point_m));
        branch.radii_m.push_back(std::round(axis.radius_m * 1e6) * 1e-6);
    }
    const auto now_at = [&](std::size_t point) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < wanted.size(); ++i)
            if (std::abs(wanted[i] - arcs[point]) < std::abs(wanted[best] - arcs[point])) best = i;
        return point + 1 == arcs.size() ? wanted.size() - 1 : best;
    };
    for (std::vector<VesselBranch> *vessels : {&tree.branches, &tree.small})
        for (VesselBranch &other : *vessels)
            if (other.parent == static_cast<int>(index)) other.parent_point = now_at(other.parent_point);
    for (VesselLesion &other : tree.lesions)
        if (other.branch == index && other.first_point > lesion.first_point)
            other.first_point = now_at(other.first_point);
    for (std::size_t i = lesion.first_point; i < behind; ++i) {
        lesion.healthy_points_m.push_back(branch.points_m[i]);
        lesion.healthy_radii_m.push_back(branch.radii_m[i]);
    }
    return lesion;
}

// Replaces the branch's points and radii by the points and radii of the narrowed channel.
void narrow(VesselBranch &branch, const VesselLesion &lesion, const LesionText &text)
{
    const std::size_t count = lesion.size();
    const Across across(lesion);
    for (std::size_t i = 0; i < count; ++i) {
        const double u = static_cast<double>(i) / static_cast<double>(count - 1) - 0.5;
        const double healthy_m = lesion.healthy_radii_m[i];
        const double lost = text.stenosis_percent / 100 * 0.5 * (1 + std::cos(2 * pi * u));
        const Vector3d off_m = -text.eccentricity * lost * healthy_m * across.at(i, text.plaque_deg);
        branch.points_m[lesion.first_point + i] = rounded_m(lesion.healthy_points_m[i] + off_m);
        branch.radii_m[lesion.first_point + i] = std::round((1 - lost) * healthy_m * 1e6) * 1e-6;
    }
}

// Stores the points of one lesion, in a vessel tree that is still without lesions. Positions of lesions refer
// to the healthy vessel, so lesions may be placed in any order.
void place(VesselTree &tree, const LesionText &text)
{
    const std::size_t index = branch_of(tree, text);
    const double length_m = arcs_m(tree.branches[index]).back();
    const double start_m = vessel_start_m(tree, index), middle_m = start_m + text.at_mm * 1e-3;
    const double begin_m = middle_m - text.length_mm * 0.5e-3, end_m = middle_m + text.length_mm * 0.5e-3;
    if (begin_m < 0 || end_m > length_m) {
        const std::string range = formatted(
            "reaches from %.1f to %.1f mm behind the ostium, but the branch from %.1f to %.1f",
            (begin_m - start_m) * 1e3, (end_m - start_m) * 1e3, -start_m * 1e3, (length_m - start_m) * 1e3);
        throw Fault(named(text) + range + ": change at_mm or length_mm");
    }
    for (const VesselLesion &other : tree.lesions) {
        if (other.branch != index) continue;
        const std::vector<double> arcs = arcs_m(tree.branches[index]);
        if (begin_m < arcs[other.first_point + other.size() - 1] - touch_m &&
            end_m > arcs[other.first_point] + touch_m)
            throw Fault(named(text) + "overlaps '" + other.name +
                        "' on the same branch: make one of the two");
    }
    VesselLesion lesion = divide(tree, index, begin_m, end_m);
    lesion.name = text.name;
    tree.lesions.push_back(std::move(lesion));
}

} // namespace

void place_lesions(VesselTree &tree, const std::vector<LesionText> &lesions)
{
    for (const LesionText &text : lesions) place(tree, text);
    for (std::size_t k = 0; k < lesions.size(); ++k)
        narrow(tree.branches[tree.lesions[k].branch], tree.lesions[k], lesions[k]);
    std::string error;
    if (!check_vessel_tree(tree, error)) throw Fault("[[lesion]] " + error);
}

Eigen::AlignedBox3d lesion_box_mm(const VesselLesion &lesion, double radii)
{
    const Eigen::AlignedBox3d box_m = lesion_box_m(lesion, radii);
    return {box_m.min() * 1e3, box_m.max() * 1e3};
}

std::vector<FineRegion> fine_regions(const VesselTree &tree)
{
    std::vector<FineRegion> regions;
    for (const VesselLesion &lesion : tree.lesions) {
        const double throat_mm = tree.branches[lesion.branch].radii_m[tree.throat(lesion)] * 1e3;
        int level = 0;
        while (level < CRN_LUMEN_LEVELS - 1 && voxel0_mm / (1 << level) > 0.7 * throat_mm) ++level;
        regions.push_back({lesion_box_mm(lesion, 1.0), std::max(0.03, throat_mm / 15), level});
    }
    return regions;
}

std::vector<bool> narrow_lesions(std::vector<Vector3d> &vertices_mm, const VesselTree &tree)
{
    std::vector<bool> moved(vertices_mm.size(), false);
    for (std::size_t k = 0; k < tree.lesions.size(); ++k) {
        const LesionWall wall(tree, k);
        for (std::size_t v = 0; v < vertices_mm.size(); ++v) {
            if (!wall.reach_m().contains(vertices_mm[v] * 1e-3))
                continue; // most vertices are skipped here quickly
            const Vector3d way_mm = wall.way_m(vertices_mm[v] * 1e-3) * 1e3;
            if (way_mm.norm() < 1e-3) continue;
            vertices_mm[v] += way_mm;
            moved[v] = true;
        }
    }
    return moved;
}

VesselTree lesions_within(const VesselTree &tree, const TriangleTree &body)
{
    const VesselTree healthy = healthy_tree(tree);
    VesselTree within = tree;
    within.lesions.clear();
    for (const VesselLesion &lesion : tree.lesions) {
        const auto is_inside = [&](const Vector3d &p_m) { return body.nearest(p_m * 1e3).distance_mm < 0; };
        if (std::any_of(lesion.healthy_points_m.begin(), lesion.healthy_points_m.end(), is_inside)) {
            within.lesions.push_back(lesion);
            continue;
        }
        const auto first = static_cast<std::ptrdiff_t>(lesion.first_point),
                   end = first + static_cast<std::ptrdiff_t>(lesion.size());
        const VesselBranch &from = healthy.branches[lesion.branch];
        VesselBranch &to = within.branches[lesion.branch];
        std::copy(from.points_m.begin() + first, from.points_m.begin() + end, to.points_m.begin() + first);
        std::copy(from.radii_m.begin() + first, from.radii_m.begin() + end, to.radii_m.begin() + first);
    }
    return within;
}

BakedBody calcium_of(const VesselTree &tree, const VesselLesion &lesion, const LesionText &text)
{
    constexpr std::size_t columns = 24;
    constexpr double along_share = 0.3; // of the lesion's length, to either side of its narrowest point
    BakedBody body;
    body.name = text.name + "_calcium";
    body.material = "bone_cortical"; // the mineral of plaque is apatite too
    body.mesh.name = body.name;
    std::vector<std::size_t> rows;
    const Across across(lesion);
    const auto last = static_cast<double>(lesion.size() - 1);
    for (std::size_t i = 0; i < lesion.size(); ++i)
        if (std::abs(static_cast<double>(i) / last - 0.5) <= along_share) rows.push_back(i);
    for (std::size_t i : rows) {
        const Vector3d &centre = lesion.healthy_points_m[i];
        const Vector3d off = tree.branches[lesion.branch].points_m[lesion.first_point + i] - centre;
        const double channel = tree.branches[lesion.branch].radii_m[lesion.first_point + i];
        for (std::size_t j = 0; j <= columns; ++j) {
            const double turn = static_cast<double>(j) / columns - 0.5;
            const Vector3d ray = across.at(i, text.plaque_deg + turn * text.calcified_deg);
            // `begin` is the distance from the vessel's centre at which the ray leaves the narrowed channel,
            // or 0 if the ray does not cross the channel.
            const double inwards = off.dot(ray);
            const double square = channel * channel - off.squaredNorm() + inwards * inwards;
            const double begin = square > 0 ? std::max(inwards + std::sqrt(square), 0.0) : 0.0;
            const double plaque = std::max(lesion.healthy_radii_m[i] - begin, 0.06e-3);
            const double outer = lesion.healthy_radii_m[i] - 0.1 * plaque;
            const double inner = outer - std::min(0.5 * plaque, 0.8e-3);
            body.mesh.vertices_mm.push_back((centre + inner * ray) * 1e3);
            body.mesh.vertices_mm.push_back((centre + outer * ray) * 1e3);
        }
    }
    // Returns the index of the shell's vertex at row i and column j, on the inner sheet (0) or the outer
    // sheet (1) of the shell.
    const auto at = [&](std::size_t i, std::size_t j, std::size_t sheet) {
        return static_cast<std::uint32_t>(2 * (i * (columns + 1) + j) + sheet);
    };
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        body.mesh.triangles.push_back({a, b, c});
        body.mesh.triangles.push_back({a, c, d});
    };
    const std::size_t end = rows.size() - 1;
    for (std::size_t i = 0; i < end; ++i)
        for (std::size_t j = 0; j < columns; ++j) {
            quad(at(i, j, 1), at(i, j + 1, 1), at(i + 1, j + 1, 1), at(i + 1, j, 1));
            quad(at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0));
        }
    for (std::size_t i = 0; i < end; ++i) {
        quad(at(i, 0, 0), at(i, 0, 1), at(i + 1, 0, 1), at(i + 1, 0, 0));
        quad(at(i, columns, 1), at(i, columns, 0), at(i + 1, columns, 0), at(i + 1, columns, 1));
    }
    for (std::size_t j = 0; j < columns; ++j) {
        quad(at(0, j, 0), at(0, j + 1, 0), at(0, j + 1, 1), at(0, j, 1));
        quad(at(end, j, 1), at(end, j + 1, 1), at(end, j + 1, 0), at(end, j, 0));
    }
    check_closed(body.mesh, Cap::none); // also orients its triangles outwards
    return body;
}

// Whether blood that passes a branch may enter a bed of the heart.
static bool leads_to_the_heart(const VesselTree &tree, std::size_t branch)
{
    std::vector<bool> is_behind(tree.branches.size(), false);
    for (std::size_t b = branch; b < tree.branches.size(); ++b) { // parents come before their branches
        const VesselBranch &one = tree.branches[b];
        is_behind[b] = b == branch || (one.parent >= 0 && is_behind[static_cast<std::size_t>(one.parent)]);
        if (is_behind[b] && (one.bed == VesselBed::left_coronary || one.bed == VesselBed::right_coronary))
            return true;
    }
    return false;
}

std::string lesions_report(const VesselTree &tree, const TriangleTree &surface)
{
    std::string report;
    for (const VesselLesion &lesion : tree.lesions) {
        const VesselBranch &branch = tree.branches[lesion.branch];
        const std::size_t throat = tree.throat(lesion);
        const double reference_mm = 2e3 * lesion.healthy_radii_m[throat - lesion.first_point];
        const double left = branch.radii_m[throat] * 2e3 / reference_mm;
        double measured_mm = std::numeric_limits<double>::infinity();
        for (std::size_t i = lesion.first_point; i < lesion.first_point + lesion.size(); ++i)
            measured_mm = std::min(measured_mm, -2 * surface.nearest(branch.points_m[i] * 1e3).distance_mm);
        std::string line =
            formatted("lesion            %s in %s: %.2f of %.2f mm diameter left at %s, %.0f %% by diameter, "
                      "%.0f %% by "
                      "area; %.2f mm on the surface\n",
                      lesion.name.c_str(), branch.name.c_str(), left * reference_mm, reference_mm,
                      place_text(branch.points_m[throat] * 1e3).c_str(), 100 * (1 - left),
                      100 * (1 - left * left), measured_mm);
        report += line;
        if (!leads_to_the_heart(tree, lesion.branch))
            report += "note: " + branch.name +
                      " is not among left_coronary and right_coronary of [tree], so the " + "FFR of " +
                      lesion.name + " is with resting flow\n";
        const double wanted_mm = left * reference_mm, off_mm = std::abs(measured_mm - wanted_mm);
        if (off_mm <= std::max(throat_off_mm, throat_off_share * wanted_mm)) continue;
        line = formatted(
            "warning: lesion %s: the mesh leaves %.2f mm where the tree says %.2f mm, so flow and wire "
            "meet different throats: correct the centreline's middle and radii on %s, or the mesh\n",
            lesion.name.c_str(), measured_mm, wanted_mm, branch.name.c_str());
        report += line;
    }
    for (std::size_t i = CRN_SCENE_PLAQUE_MAX; i < tree.lesions.size(); ++i)
        report += "note: " + tree.lesions[i].name + " stays rigid under a balloon: only the first " +
                  std::to_string(int{CRN_SCENE_PLAQUE_MAX}) + " lesions of a scene give way\n";
    return report;
}

} // namespace crn::bake
