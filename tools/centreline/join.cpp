// Joins separate curves into a vessel tree. For each curve the code finds the parent curve inside which it
// begins, and the point at which it leaves this parent.
#include "tools/centreline/join.hpp"
#include "host/base/format.hpp"

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

// A tree that a file states: its branches stand one behind the other, the root first. A single curve is one
// too.
using Part = std::vector<Branch>;

// Cuts off the part of the root that runs along its new parent's centreline, and puts the parent's sphere
// before the remaining part. Spheres at which other branches leave the root stay.
void attach(Part &part, const Branch &parent)
{
    Branch &root = part.front();
    std::size_t most = root.spheres.size() - 2;
    for (std::size_t b = 1; b < part.size(); ++b)
        if (part[b].parent == 0) most = std::min(most, part[b].parent_sphere);
    std::size_t left = 0;
    double at = line_place(parent, root.spheres[0].centre_mm).at;
    for (; left < most; ++left) {
        const LinePlace place = line_place(parent, root.spheres[left].centre_mm);
        if (place.distance_mm > along_share * place.radius_mm) break;
        at = place.at;
    }
    root.parent_sphere = std::min(static_cast<std::size_t>(std::lround(at)), parent.spheres.size() - 1);
    root.spheres.erase(root.spheres.begin(), root.spheres.begin() + static_cast<std::ptrdiff_t>(left));
    const Sphere &shared = parent.spheres[root.parent_sphere];
    const bool is_there = (root.spheres.front().centre_mm - shared.centre_mm).norm() < 0.1 * shared.radius_mm;
    const bool replaces = is_there && root.spheres.size() > 2;
    if (replaces)
        root.spheres.front() = shared;
    else
        root.spheres.insert(root.spheres.begin(), shared);
    for (std::size_t b = 1; b < part.size(); ++b) {
        if (part[b].parent != 0) continue;
        part[b].parent_sphere = part[b].parent_sphere - left + (replaces ? 0 : 1);
        part[b].spheres.front() = root.spheres[part[b].parent_sphere];
    }
}

std::vector<Part> parts_of(const Tree &tree)
{
    std::vector<Part> parts;
    std::vector<std::pair<std::size_t, int>> places; // of each branch: its part, and its number there
    for (const Branch &branch : tree.branches) {
        const std::size_t part = branch.parent < 0 ? parts.size() : places[branch.parent].first;
        if (branch.parent < 0) parts.emplace_back();
        places.emplace_back(part, static_cast<int>(parts[part].size()));
        parts[part].push_back(branch);
        if (branch.parent >= 0) parts[part].back().parent = places[branch.parent].second;
    }
    return parts;
}

// A stretch of a part between two junctions or ends, which are numbered.
struct Stretch {
    Branch branch;
    std::size_t from, to;
};

std::vector<Stretch> stretches_of(const Part &part)
{
    const Tree split = split_at_junctions({part});
    std::vector<Stretch> stretches;
    for (std::size_t b = 0; b < split.branches.size(); ++b) {
        const int parent = split.branches[b].parent;
        // Node 0 is the root's beginning. A branch that leaves there has no parent of its own.
        stretches.push_back({split.branches[b], parent < 0 ? 0 : stretches[parent].to, b + 1});
    }
    return stretches;
}

// Lists, for each end of a part, the sphere and the number of its node: 0 is the root's beginning.
std::vector<std::pair<std::size_t, Sphere>> ends_of(const std::vector<Stretch> &stretches)
{
    std::vector<std::size_t> meeting(stretches.size() + 1, 0);
    for (const Stretch &stretch : stretches) ++meeting[stretch.from], ++meeting[stretch.to];
    std::vector<std::pair<std::size_t, Sphere>> ends;
    if (meeting[0] == 1) ends.emplace_back(0, stretches.front().branch.spheres.front());
    for (const Stretch &stretch : stretches)
        if (meeting[stretch.to] == 1) ends.emplace_back(stretch.to, stretch.branch.spheres.back());
    return ends;
}

// The same part, but its root begins at the node `node`: stretches on the way are reversed.
Part begun_at(const std::vector<Stretch> &stretches, std::size_t node)
{
    Part part;
    std::vector<bool> is_placed(stretches.size(), false);
    std::vector<std::pair<std::size_t, int>> front{{node, -1}}; // a node, and the branch that leads to it
    for (std::size_t f = 0; f < front.size(); ++f)
        for (std::size_t p = 0; p < stretches.size(); ++p) {
            const auto [at, parent] = front[f];
            if (is_placed[p] || (stretches[p].from != at && stretches[p].to != at)) continue;
            is_placed[p] = true;
            Branch branch = stretches[p].branch;
            const bool is_reversed = stretches[p].to == at;
            if (is_reversed) std::reverse(branch.spheres.begin(), branch.spheres.end());
            branch.parent = parent;
            branch.parent_sphere = parent < 0 ? 0 : part[parent].spheres.size() - 1;
            if (parent >= 0) branch.spheres.front() = part[parent].spheres.back();
            front.emplace_back(is_reversed ? stretches[p].from : stretches[p].to,
                               static_cast<int>(part.size()));
            part.push_back(std::move(branch));
        }
    return part;
}

std::string place_of(const Eigen::Vector3d &p_mm)
{
    return formatted("(%.1f, %.1f, %.1f) mm", p_mm.x(), p_mm.y(), p_mm.z());
}

// The part with the end nearest to the inlet becomes the first one, and begins there.
void begin_at(std::vector<Part> &parts, const Eigen::Vector3d &inlet_mm, std::vector<std::string> &notes)
{
    constexpr double reach_mm = 5.0;
    std::size_t first = 0, node = 0;
    double nearest_mm = INFINITY;
    Sphere end;
    for (std::size_t p = 0; p < parts.size(); ++p)
        for (const auto &[number, sphere] : ends_of(stretches_of(parts[p]))) {
            const double distance_mm = (sphere.centre_mm - inlet_mm).norm();
            if (distance_mm < nearest_mm) nearest_mm = distance_mm, first = p, node = number, end = sphere;
        }
    if (!(nearest_mm <= reach_mm + end.radius_mm))
        throw Fault(
            formatted("the inlet at %s is %.1f mm from the nearest end of a curve, at %s: give that place, "
                      "or the end at which blood enters",
                      place_of(inlet_mm).c_str(), nearest_mm, place_of(end.centre_mm).c_str()));
    if (node != 0) {
        const bool is_tree = parts[first].size() > 1;
        parts[first] = begun_at(stretches_of(parts[first]), node);
        notes.push_back(
            "the tree begins at " + place_of(end.centre_mm) +
            (is_tree ? ": branches on the way from the old beginning are reversed and cut at junctions"
                     : ": the curve was reversed"));
    }
    std::rotate(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(first),
                parts.begin() + static_cast<std::ptrdiff_t>(first) + 1);
}

// Appends a part to the tree; `parent` is the number of the branch that its root leaves, or -1.
void append(Tree &tree, Part part, int parent)
{
    const int before = static_cast<int>(tree.branches.size());
    for (Branch &branch : part) {
        branch.parent = branch.parent < 0 ? parent : branch.parent + before;
        tree.branches.push_back(std::move(branch));
    }
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

Tree joined(const Tree &tree, const Eigen::Vector3d *inlet_mm, std::vector<std::string> *notes)
{
    std::vector<std::string> unread;
    std::vector<std::string> &said = notes ? *notes : unread;
    std::vector<Part> parts = parts_of(tree);
    // The widest curve is the trunk. If a curve lies in no tube of the present tree, it becomes another root.
    std::stable_sort(parts.begin(), parts.end(), [](const Part &a, const Part &b) {
        return mean_radius_mm(a.front()) > mean_radius_mm(b.front());
    });
    if (inlet_mm) begin_at(parts, *inlet_mm, said);
    if (parts.size() == 1 && !inlet_mm) return tree;
    Tree made;
    std::vector<std::pair<std::size_t, std::size_t>>
        ranges; // branches of each placed part: first, behind last
    // The branch of a placed part in which a sphere lies deepest.
    const auto deepest = [&](const Sphere &end, std::size_t placed) {
        std::pair<double, std::size_t> best{INFINITY, 0};
        for (std::size_t b = ranges[placed].first; b < ranges[placed].second; ++b)
            best = std::min(best, {depth_in(made.branches[b], end), b});
        return best;
    };
    const auto end_of = [&](std::size_t part, bool is_last) -> const Sphere & {
        const std::vector<Sphere> &spheres = parts[part].front().spheres;
        return is_last ? spheres.back() : spheres.front();
    };
    const auto depth = [&](std::size_t part, bool is_last, std::size_t placed) {
        // The blood enters a tree that a file states at its root, so only a single curve may be reversed.
        if (is_last && parts[part].size() > 1) return static_cast<double>(INFINITY);
        return deepest(end_of(part, is_last), placed).first;
    };
    grow_tree(parts.size(), 0, depth, [&](const Joint &joint) {
        Part part = parts[joint.curve];
        const std::size_t before = made.branches.size();
        int parent = -1;
        if (std::isfinite(joint.depth)) {
            parent = static_cast<int>(deepest(end_of(joint.curve, joint.is_last), joint.parent).second);
            if (joint.is_last) std::reverse(part.front().spheres.begin(), part.front().spheres.end());
            attach(part, made.branches[parent]);
        } else if (before > 0) {
            said.push_back("'" + part.front().name +
                           "' touches no other curve with an end: it stays a root, from " +
                           place_of(part.front().spheres.front().centre_mm));
        }
        append(made, std::move(part), parent);
        ranges.emplace_back(before, made.branches.size());
    });
    return made;
}

} // namespace crn::centreline
