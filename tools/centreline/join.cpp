// Joins separate curves into a vessel tree. For each curve the code finds the parent curve inside which it
// begins, and the point at which it leaves this parent.
#include "tools/centreline/join.hpp"

#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

// A curve counts as part of its parent until its distance from the parent's centreline exceeds `along_share`
// times the parent's radius.
constexpr double along_share = 0.3;
// A curve may begin outside its parent's tube by up to `outside_share` times the curve's own radius, because
// some programs end curves at the vessel's wall.
constexpr double outside_share = 0.5;

double mean_radius_mm(const Branch &branch)
{
    double sum = 0;
    for (const Sphere &sphere : branch.spheres) sum += sphere.radius_mm;
    return sum / static_cast<double>(branch.spheres.size());
}

// Returns the distance of a curve's end from a branch's tube, in radii of the branch. The distance is
// negative inside the tube, and INFINITY when the end lies too far outside.
double depth_in(const Branch &tube, const Sphere &end)
{
    const HullPlace place = hull_place(tube, end.centre_mm);
    if (place.distance_mm > outside_share * end.radius_mm) return INFINITY;
    return place.distance_mm / tube.spheres[place.sphere].radius_mm;
}

// Cuts off the part of a curve that runs along its parent's centreline, and puts the parent's sphere before
// the remaining part.
void attach(Branch &curve, const Branch &parent)
{
    std::size_t left = 0;
    double at = line_place(parent, curve.spheres[0].centre_mm).at;
    for (; left + 2 < curve.spheres.size(); ++left) {
        const LinePlace place = line_place(parent, curve.spheres[left].centre_mm);
        if (place.distance_mm > along_share * place.radius_mm) break;
        at = place.at;
    }
    curve.parent_sphere = std::min(static_cast<std::size_t>(std::lround(at)), parent.spheres.size() - 1);
    curve.spheres.erase(curve.spheres.begin(), curve.spheres.begin() + static_cast<std::ptrdiff_t>(left));
    const Sphere &shared = parent.spheres[curve.parent_sphere];
    const bool is_there =
        (curve.spheres.front().centre_mm - shared.centre_mm).norm() < 0.1 * shared.radius_mm;
    if (is_there && curve.spheres.size() > 2)
        curve.spheres.front() = shared;
    else
        curve.spheres.insert(curve.spheres.begin(), shared);
}

// The curve whose end is nearest to the inlet becomes the first curve. If necessary the code reverses the
// first curve, so that it runs away from the inlet.
void begin_at(std::vector<Branch> &curves, const Eigen::Vector3d &inlet_mm)
{
    std::size_t first = 0;
    bool is_last = false;
    double nearest = INFINITY;
    for (std::size_t c = 0; c < curves.size(); ++c)
        for (bool last : {false, true}) {
            const Sphere &end = last ? curves[c].spheres.back() : curves[c].spheres.front();
            const double distance = (end.centre_mm - inlet_mm).norm();
            if (distance < nearest) nearest = distance, first = c, is_last = last;
        }
    if (is_last) std::reverse(curves[first].spheres.begin(), curves[first].spheres.end());
    std::rotate(curves.begin(), curves.begin() + static_cast<std::ptrdiff_t>(first),
                curves.begin() + static_cast<std::ptrdiff_t>(first) + 1);
}

} // namespace

void grow_tree(std::size_t count, std::size_t first, const DepthOf &depth,
               const std::function<void(const Joint &)> &place)
{
    std::vector<Joint> best(count); // the best place so far for each curve
    for (std::size_t c = 0; c < count; ++c) best[c].curve = c;
    std::vector<bool> is_placed(count, false);
    for (std::size_t branch = 0; branch < count; ++branch) {
        std::size_t next = count;
        for (std::size_t c = 0; c < count; ++c)
            if (!is_placed[c] && (next == count || best[c].depth < best[next].depth)) next = c;
        if (branch == 0) next = first;
        is_placed[next] = true;
        place(best[next]);
        // Only the branch that was added last can be a better parent for a curve than the best one found so
        // far.
        for (std::size_t c = 0; c < count; ++c)
            for (bool is_last : {false, true}) {
                if (is_placed[c]) break;
                const double here = depth(c, is_last, branch);
                if (here < best[c].depth) best[c] = {c, branch, is_last, here};
            }
    }
}

Tree joined(const Tree &tree, const Eigen::Vector3d *inlet_mm)
{
    std::vector<std::size_t> roots;
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        if (tree.branches[b].parent < 0) roots.push_back(b);
    if (roots.size() != tree.branches.size() || roots.size() == 1)
        return tree; // the file says which branch leaves which
    // The widest curve is the trunk. If a curve lies in no tube of the present tree, it becomes another root.
    std::stable_sort(roots.begin(), roots.end(), [&](std::size_t a, std::size_t b) {
        return mean_radius_mm(tree.branches[a]) > mean_radius_mm(tree.branches[b]);
    });
    std::vector<Branch> curves;
    for (std::size_t b : roots) curves.push_back(tree.branches[b]);
    if (inlet_mm) begin_at(curves, *inlet_mm);
    Tree made;
    const auto depth = [&](std::size_t curve, bool is_last, std::size_t branch) {
        const std::vector<Sphere> &spheres = curves[curve].spheres;
        return depth_in(made.branches[branch], is_last ? spheres.back() : spheres.front());
    };
    grow_tree(curves.size(), 0, depth, [&](const Joint &joint) {
        Branch branch = curves[joint.curve];
        if (std::isfinite(joint.depth)) {
            branch.parent = static_cast<int>(joint.parent);
            if (joint.is_last) std::reverse(branch.spheres.begin(), branch.spheres.end());
            attach(branch, made.branches[joint.parent]);
        }
        made.branches.push_back(std::move(branch));
    });
    return made;
}

} // namespace crn::centreline
