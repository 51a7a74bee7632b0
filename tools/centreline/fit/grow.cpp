// Adds a branch to the tree in three steps: find the branch's junction, fit its spheres, and find its end.
#include "tools/centreline/fit/grow.hpp"

#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

using Points = std::vector<Eigen::Vector3d>;
constexpr double merge_share = 0.75; // junctions closer than this many radii become one

// Returns the opening through which a path leaves the vessel at its end, or null if the path does not leave
// the vessel.
const Opening *opening_near(const Lumen &lumen, const Eigen::Vector3d &p_mm)
{
    const Opening *nearest = nullptr;
    for (const Opening &opening : lumen.openings()) {
        const double reach = 1.2 * opening.radius_mm + 2 * lumen.voxels().voxel_mm();
        if ((opening.centre_mm - p_mm).norm() > reach) continue;
        if (!nearest || (opening.centre_mm - p_mm).norm() < (nearest->centre_mm - p_mm).norm())
            nearest = &opening;
    }
    return nearest;
}

void append_straight(Points &line, const Eigen::Vector3d &to, double step_mm)
{
    const Eigen::Vector3d from = line.back();
    const int pieces = std::max(1, static_cast<int>((to - from).norm() / step_mm));
    for (int i = 1; i <= pieces; ++i) line.push_back(from + (to - from) * (static_cast<double>(i) / pieces));
}

// If another branch leaves the same parent at nearly the same point, the two branches get one common
// junction.
std::size_t shared_junction(const Tree &tree, int parent, std::size_t sphere)
{
    const std::vector<Sphere> &spheres = tree.branches[parent].spheres;
    sphere = std::clamp<std::size_t>(sphere, 1, spheres.size() - 1);
    for (const Branch &other : tree.branches) {
        if (other.parent != parent) continue;
        const double apart = (spheres[other.parent_sphere].centre_mm - spheres[sphere].centre_mm).norm();
        if (apart < merge_share * spheres[sphere].radius_mm) return other.parent_sphere;
    }
    const double to_end = (spheres.back().centre_mm - spheres[sphere].centre_mm).norm();
    return to_end < merge_share * spheres[sphere].radius_mm ? spheres.size() - 1 : sphere;
}

// Returns the path of a branch, including the piece that connects the branch to its parent. The path begins
// in the middle of the parent vessel and goes straight to the point where it leaves the parent's tube. After
// the point where the path leaves the parent's tube, the path continues as given.
Points from_junction(const Tree &tree, const Lumen &lumen, const Way &way, std::size_t &sphere)
{
    const Branch &parent = tree.branches[way.parent];
    std::size_t left = way.points_mm.size() - 1;
    while (left > 0 && hull_place(parent, way.points_mm[left - 1]).distance_mm > 0) --left;
    sphere = way.leaves_at_end
                 ? parent.spheres.size() - 1
                 : shared_junction(tree, way.parent, hull_place(parent, way.points_mm[left]).sphere);
    Points line{parent.spheres[sphere].centre_mm};
    append_straight(line, way.points_mm[left], lumen.voxels().voxel_mm());
    line.insert(line.end(), way.points_mm.begin() + static_cast<std::ptrdiff_t>(left) + 1,
                way.points_mm.end());
    return line;
}

// Finds the first sphere that touches, or nearly touches, the end of the vessel, and removes all later
// spheres. If the vessel's end is round, the last remaining sphere has its centre at the centre of the
// rounding.
void cut_at_last_sphere(const Lumen &lumen, std::vector<Sphere> &spheres)
{
    const Sphere end = spheres.back();
    const double slack_mm = 0.5 * lumen.voxels().voxel_mm();
    for (std::size_t i = 1; i + 1 < spheres.size(); ++i) {
        const double reach_mm = (end.centre_mm - spheres[i].centre_mm).norm() + end.radius_mm;
        if (reach_mm > 1.1 * spheres[i].radius_mm + slack_mm) continue;
        spheres.resize(i + 1);
        return;
    }
}

Points centres(const std::vector<Sphere> &spheres)
{
    Points points;
    for (const Sphere &sphere : spheres) points.push_back(sphere.centre_mm);
    return points;
}

} // namespace

void finish_last(const Lumen &lumen, Points &points_mm)
{
    const Opening *opening = opening_near(lumen, points_mm.back());
    if (!opening) return;
    while (points_mm.size() > 2 && (points_mm.back() - opening->centre_mm).norm() < opening->radius_mm)
        points_mm.pop_back();
    append_straight(points_mm, opening->centre_mm, lumen.voxels().voxel_mm());
}

int parent_of(const Tree &tree, const Points &way_mm)
{
    int best = -1;
    std::size_t farthest = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        for (std::size_t k = way_mm.size(); k-- > farthest;) {
            if (hull_place(tree.branches[b], way_mm[k]).distance_mm >= 0) continue;
            best = static_cast<int>(b);
            farthest = k + 1;
            break;
        }
    return best;
}

int grow_branch(Tree &tree, const Lumen &lumen, const Way &way, const GrowWish &wish)
{
    Branch branch;
    branch.name = way.name;
    branch.parent = way.parent;
    Points line = way.points_mm;
    if (way.parent >= 0) line = from_junction(tree, lumen, way, branch.parent_sphere);
    const bool ends_open = !way.is_last_given && opening_near(lumen, line.back());
    const bool begins_open = way.parent < 0 && !way.is_first_given && opening_near(lumen, line.front());
    if (ends_open) finish_last(lumen, line);
    if (begins_open) {
        std::reverse(line.begin(), line.end());
        finish_last(lumen, line);
        std::reverse(line.begin(), line.end());
    }
    // A point that the user has given keeps its position along the vessel; the fit may only move it sideways
    // towards the middle.
    constexpr double fine_spacing = 0.1; // ends are cut more finely than the final spacing of the spheres
    const LineWish fit{fine_spacing, way.parent >= 0 ? &tree.branches[way.parent] : nullptr,
                       way.parent >= 0 || !way.is_first_given, !way.is_last_given};
    branch.spheres = fit_line(lumen, line, fit);
    if (!way.is_last_given && !ends_open) cut_at_last_sphere(lumen, branch.spheres);
    if (way.parent < 0 && !way.is_first_given && !begins_open) {
        std::reverse(branch.spheres.begin(), branch.spheres.end());
        cut_at_last_sphere(lumen, branch.spheres);
        std::reverse(branch.spheres.begin(), branch.spheres.end());
    }
    // When a branch has been cut at its ends, its spheres are no longer evenly spaced, so the code spaces all
    // of them again.
    branch.spheres = spaced(lumen, centres(branch.spheres), wish.spacing);
    if (way.parent >= 0) branch.spheres.front() = tree.branches[way.parent].spheres[branch.parent_sphere];
    branch.spheres.front().is_manual |= way.is_first_given && way.parent < 0;
    branch.spheres.back().is_manual = way.is_last_given;
    tree.branches.push_back(std::move(branch));
    return static_cast<int>(tree.branches.size()) - 1;
}

} // namespace crn::centreline
