// Determines first the order of the user's points, then the paths between these points, and then the
// branches.
#include "tools/centreline/fit/guided.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace crn::centreline
{
namespace
{

constexpr double outside_max_mm = 5.0; // a point farther from the inside is a mistake

struct Placed {
    const Point *point;
    std::size_t voxel; // the middle of the vessel near it
    int before = -1;   // the preceding point; -1: none found yet, or a start
    double length_mm = -1;
    int branch = -1;
};

std::string title(const Point &point, std::size_t number)
{
    return std::string(kind_name(point.kind)) + " point " +
           (point.name.empty() ? std::to_string(number + 1) : "'" + point.name + "'") + " at " +
           bake::place_text(point.position_mm);
}

Placed placed(const Lumen &lumen, const Point &point, std::size_t number, std::vector<std::string> &notes)
{
    const Voxels &voxels = lumen.voxels();
    long voxel = -1;
    for (double reach = voxels.voxel_mm(); voxel < 0 && reach < 2 * outside_max_mm; reach *= 2)
        voxel = voxels.nearest(point.position_mm, std::min(reach, outside_max_mm));
    if (voxel < 0)
        throw Fault("the " + title(point, number) + " lies over 5 mm outside the vessel: move it inside");
    Placed made{&point, static_cast<std::size_t>(voxel)};
    // A point that the user has set may lie beside the middle of the vessel. The code searches for a middle
    // voxel only across the vessel, because the fit could not undo a shift of a branch's end along the
    // vessel.
    made.voxel = voxels.middle_near(made.voxel);
    const double moved_mm = (voxels.centre_mm(made.voxel) - point.position_mm).norm();
    if (moved_mm > voxels.depth_mm(made.voxel))
        notes.push_back("the " + title(point, number) + " was moved " +
                        std::to_string(moved_mm).substr(0, 4) + " mm into the vessel");
    return made;
}

void follow(Placed &point, int before, double length_mm)
{
    if (length_mm > point.length_mm) point.before = before, point.length_mm = length_mm;
}

// The path from a start point to an end point passes bifurcation points; these points have the same order on
// the path and in the tree.
void find_order(const Lumen &lumen, std::vector<Placed> &points, const Ways &ways,
                const std::vector<int> &starts)
{
    const Voxels &voxels = lumen.voxels();
    for (std::size_t e = 0; e < points.size(); ++e) {
        if (points[e].point->kind != PointKind::end) continue;
        const std::vector<std::size_t> way = ways.to(points[e].voxel);
        std::vector<std::pair<std::size_t, int>> passed; // place on the path, point
        for (std::size_t b = 0; b < points.size(); ++b) {
            if (points[b].point->kind != PointKind::bifurcation) continue;
            const Eigen::Vector3d centre = voxels.centre_mm(points[b].voxel);
            double nearest = std::max(voxels.depth_mm(points[b].voxel), 2 * voxels.voxel_mm());
            std::size_t place = way.size();
            for (std::size_t k = 0; k < way.size(); ++k) {
                const double distance = (voxels.centre_mm(way[k]) - centre).norm();
                if (distance < nearest) nearest = distance, place = k;
            }
            if (place < way.size()) passed.emplace_back(place, static_cast<int>(b));
        }
        std::sort(passed.begin(), passed.end());
        int before = starts[static_cast<std::size_t>(ways.source[points[e].voxel])];
        for (const auto &[place, b] : passed) {
            if (b == before) continue;
            follow(points[b], before, ways.length_mm[way[place]]);
            before = b;
        }
        follow(points[e], before, ways.length_mm[points[e].voxel]);
    }
}

void apply_names(std::vector<Placed> &points)
{
    std::map<std::string, int> number;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!points[i].point->name.empty() &&
            !number.emplace(points[i].point->name, static_cast<int>(i)).second)
            throw Fault("two points are called '" + points[i].point->name + "': rename one");
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string &after = points[i].point->after;
        if (after.empty()) continue;
        const auto found = number.find(after);
        if (found == number.end() || points[found->second].point->kind == PointKind::end)
            throw Fault("the " + title(*points[i].point, i) + " comes after '" + after +
                        "', which is no start or bifurcation: correct `after`");
        points[i].before = found->second;
    }
}

void check_order(const std::vector<Placed> &points)
{
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].point->kind == PointKind::start) continue;
        if (points[i].before < 0)
            throw Fault(
                "the " + title(*points[i].point, i) +
                " lies on no way from a start to an end: add an end beyond it, move it into the vessel's "
                "middle, or say with `after` which point it follows");
        std::size_t steps = 0;
        for (int up = static_cast<int>(i); points[up].point->kind != PointKind::start; up = points[up].before)
            if (points[up].before < 0 || ++steps > points.size())
                throw Fault("the " + title(*points[i].point, i) +
                            " follows itself in a circle: correct `after`");
    }
}

// Returns the path through the vessel from one point to the next, by way of the given intermediate points.
std::vector<Eigen::Vector3d> way_between(const Lumen &lumen, const Placed &from, const Placed &to)
{
    const Voxels &voxels = lumen.voxels();
    const Ways ways = find_ways(voxels, {from.voxel}, static_cast<long>(to.voxel));
    std::vector<Eigen::Vector3d> points;
    for (std::size_t voxel : ways.to(to.voxel)) points.push_back(voxels.centre_mm(voxel));
    return points;
}

std::string branch_name(const std::vector<Placed> &points, std::size_t i)
{
    const Point &point = *points[i].point;
    if (!point.name.empty()) return point.name;
    return std::string(kind_name(point.kind)) + " " + std::to_string(i + 1);
}

} // namespace

Tree fit_points(const Lumen &lumen, const std::vector<Point> &points, const GrowWish &wish,
                std::vector<std::string> &notes, bake::Progress &progress)
{
    std::vector<Placed> all;
    std::vector<int> starts;
    std::vector<std::size_t> sources;
    std::size_t ends = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        all.push_back(placed(lumen, points[i], i, notes));
        ends += points[i].kind == PointKind::end;
        if (points[i].kind != PointKind::start) continue;
        starts.push_back(static_cast<int>(i));
        sources.push_back(all.back().voxel);
    }
    if (starts.empty()) throw Fault("there is no start point: add one where the blood comes in");
    if (ends == 0) throw Fault("there is no end point: add one at the far end of every branch");
    progress.stage("finding ways", 0);
    const Ways ways = find_ways(lumen.voxels(), sources, -1);
    for (std::size_t i = 0; i < all.size(); ++i)
        if (ways.from[all[i].voxel] < 0)
            throw Fault(
                "the " + title(points[i], i) +
                " cannot be reached from a start: the vessel is closed between, or narrower than about " +
                std::to_string(2 * lumen.voxels().voxel_mm()).substr(0, 4) +
                " mm there: mend the mesh, or make --voxel-mm smaller");
    find_order(lumen, all, ways, starts);
    apply_names(all);
    check_order(all);
    // The code makes each parent branch before its children, and branches of equal level in the order of the
    // user's points.
    std::vector<std::pair<std::size_t, std::size_t>> order;
    std::vector<std::size_t> children(all.size(), 0);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (points[i].kind == PointKind::start) continue;
        std::size_t depth = 0;
        for (int up = static_cast<int>(i); points[up].kind != PointKind::start; up = all[up].before) ++depth;
        order.emplace_back(depth, i);
        ++children[all[i].before];
    }
    std::sort(order.begin(), order.end());
    std::vector<bool> is_first(all.size(), true); // no branch begins at this point so far
    Tree tree;
    progress.stage("fitting spheres", order.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
        Placed &to = all[order[n].second];
        const Placed &from = all[to.before];
        Way way{
            way_between(lumen, from, to), branch_name(all, order[n].second), from.branch, true, true, true};
        // If several end points follow one point without a bifurcation point between them, the paths to them
        // determine where the branches separate.
        if (from.branch < 0 && !is_first[to.before]) {
            way.parent = parent_of(tree, way.points_mm);
            way.leaves_at_end = false;
        }
        is_first[to.before] = false;
        to.branch = grow_branch(tree, lumen, way, wish);
        progress.step(n + 1);
    }
    progress.finish();
    for (std::size_t i = 0; i < all.size(); ++i)
        if (points[i].kind == PointKind::bifurcation && children[i] < 2)
            notes.push_back("only " + std::to_string(children[i]) + " branch leaves the " +
                            title(points[i], i) + ": an end point seems to be missing");
    tree = split_at_junctions(tree);
    check_tree(tree, "the tree");
    return tree;
}

std::vector<Point> points_of(const Tree &tree)
{
    std::vector<Point> points;
    std::vector<bool> has_children(tree.branches.size(), false);
    for (const Branch &branch : tree.branches)
        if (branch.parent >= 0) has_children[branch.parent] = true;
    std::size_t roots = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &branch = tree.branches[b];
        if (branch.parent < 0) {
            const std::string name = roots++ ? "inlet " + std::to_string(roots) : "inlet";
            points.push_back({PointKind::start, name, "", branch.spheres.front().centre_mm});
        }
        points.push_back({has_children[b] ? PointKind::bifurcation : PointKind::end, branch.name, "",
                          branch.spheres.back().centre_mm});
    }
    return points;
}

} // namespace crn::centreline
