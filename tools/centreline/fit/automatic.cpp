// As in TEASAR (Sato et al. 2000), the code repeatedly traces a path back from the voxel farthest from the
// source, until branches cover every voxel.
#include "tools/centreline/fit/automatic.hpp"
#include "host/base/format.hpp"
#include "tools/centreline/end_width.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace crn::centreline
{
namespace
{

constexpr double cover_radii = 1.5, cover_voxels = 2.0; // reach of a branch's cover about its line
constexpr std::size_t tries_max = 20000;

std::vector<Eigen::Vector3d> places(const Voxels &voxels, const std::vector<std::size_t> &way)
{
    std::vector<Eigen::Vector3d> points;
    for (std::size_t voxel : way) points.push_back(voxels.centre_mm(voxel));
    return points;
}

// Records which voxels lie near the branches that are already part of the tree.
class Cover
{
  public:
    explicit Cover(const Voxels &voxels) : voxels_(voxels), is_covered_(voxels.size(), false) {}

    bool has(std::size_t voxel) const { return is_covered_[voxel]; }

    void add(const std::vector<std::size_t> &way)
    {
        double since_mm = INFINITY;
        for (std::size_t k = 0; k < way.size(); ++k) {
            if (k > 0) since_mm += (voxels_.centre_mm(way[k]) - voxels_.centre_mm(way[k - 1])).norm();
            // The centres of the covering balls are a fifth of their radius apart, so that no relevant gap
            // remains between the balls.
            const double reach = cover_radii * voxels_.depth_mm(way[k]) + cover_voxels * voxels_.voxel_mm();
            if (since_mm < 0.2 * reach && k + 1 < way.size()) continue;
            since_mm = 0;
            ball(way[k], reach);
        }
    }

  private:
    // Marks as covered the voxels in the ball that are connected to `middle`; the voxels of a neighbouring
    // vessel are not connected and stay unmarked.
    void ball(std::size_t middle, double reach_mm)
    {
        const Eigen::Vector3d centre = voxels_.centre_mm(middle);
        std::vector<std::size_t> front{middle};
        ++stamp_;
        if (seen_.empty()) seen_.assign(is_covered_.size(), 0);
        seen_[middle] = stamp_;
        while (!front.empty()) {
            const std::size_t here = front.back();
            front.pop_back();
            is_covered_[here] = true;
            voxels_.each_neighbour(here, [&](std::size_t other, double) {
                if (seen_[other] == stamp_ || (voxels_.centre_mm(other) - centre).norm() > reach_mm) return;
                seen_[other] = stamp_;
                front.push_back(other);
            });
        }
    }

    const Voxels &voxels_;
    std::vector<bool> is_covered_;
    std::vector<std::uint32_t> seen_;
    std::uint32_t stamp_ = 0;
};

// Returns the voxels that the search has reached, from the farthest to the nearest.
std::vector<std::size_t> by_length(const Ways &ways)
{
    std::vector<std::size_t> order;
    for (std::size_t v = 0; v < ways.from.size(); ++v)
        if (ways.from[v] >= 0) order.push_back(v);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return ways.length_mm[a] > ways.length_mm[b]; });
    return order;
}

// Finds the tips of the vessel that are far enough from the source to form a branch, and returns their paths
// from the source, longest path first.
std::vector<std::vector<std::size_t>> ways_to_tips(const Voxels &voxels, const Ways &ways,
                                                   const AutoWish &wish, bake::Progress &progress)
{
    Cover cover(voxels);
    std::vector<std::vector<std::size_t>> kept;
    std::size_t tries = 0;
    const std::vector<std::size_t> order = by_length(ways);
    for (std::size_t n = 0; n < order.size() && tries < tries_max; ++n) {
        if (cover.has(order[n])) continue;
        ++tries;
        progress.step(n);
        const std::vector<std::size_t> way = ways.to(order[n]);
        std::size_t begin = way.size() - 1; // where the part that no branch covers yet begins
        while (begin > 0 && !cover.has(way[begin - 1])) --begin;
        const double own_mm = ways.length_mm[way.back()] - ways.length_mm[way[begin]];
        const double least_mm =
            std::max(wish.shortest_mm, wish.prune * voxels.depth_mm(way[begin ? begin - 1 : 0]));
        if (kept.empty() || own_mm >= least_mm) kept.push_back(way);
        cover.add({way.begin() + static_cast<std::ptrdiff_t>(begin), way.end()});
    }
    return kept;
}

// Returns the width of the vessel behind a tip, whatever the shape of its cap.
double width_at(const Voxels &voxels, const std::vector<std::size_t> &way)
{
    std::vector<Sphere> inwards;
    for (std::size_t k = way.size(); k-- > 0;)
        inwards.push_back({voxels.centre_mm(way[k]), voxels.depth_mm(way[k])});
    return width_inside(inwards).radius_mm;
}

// The number of voxels that are connected with each voxel, itself included. Near a cap or in a thin place,
// voxels of little depth are connected with none: no path leads away from them.
std::vector<std::size_t> connected_counts(const Voxels &voxels)
{
    std::vector<std::size_t> count(voxels.size(), 0), piece;
    for (std::size_t seed = 0; seed < voxels.size(); ++seed) {
        if (count[seed] > 0) continue;
        piece.assign(1, seed);
        count[seed] = 1;
        for (std::size_t i = 0; i < piece.size(); ++i)
            voxels.each_neighbour(piece[i], [&](std::size_t other, double) {
                if (count[other] > 0) return;
                count[other] = 1;
                piece.push_back(other);
            });
        for (std::size_t voxel : piece) count[voxel] = piece.size();
    }
    return count;
}

// Returns the voxel nearest to a point from which paths lead away, or -1.
long near_point(const Voxels &voxels, const std::vector<std::size_t> &connected, const Eigen::Vector3d &p_mm)
{
    constexpr double reach_mm = 6.0, least_share = 1e-3;
    const auto least =
        std::max<std::size_t>(2, static_cast<std::size_t>(least_share * static_cast<double>(voxels.size())));
    long best = -1;
    double best_mm = reach_mm;
    for (std::size_t v = 0; v < voxels.size(); ++v) {
        if (connected[v] < least) continue;
        const double distance_mm = (voxels.centre_mm(v) - p_mm).norm();
        if (distance_mm < best_mm) best_mm = distance_mm, best = static_cast<long>(v);
    }
    return best;
}

struct WideEnd {
    std::size_t voxel = 0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    double width_mm = 0;
};

constexpr double clearly_wider = 1.1, aorta_mm = 6.0;

// The widest of the ends; of the ends of an aorta that are nearly as wide, the highest.
const WideEnd &inlet_among(const std::vector<WideEnd> &ends, const AutoWish &wish)
{
    const WideEnd *best = &ends.front();
    for (const WideEnd &end : ends)
        if (end.width_mm > best->width_mm) best = &end;
    const double least_mm = best->width_mm / clearly_wider;
    if (!wish.head || least_mm < aorta_mm) return *best;
    for (const WideEnd &end : ends)
        if (end.width_mm >= least_mm && end.place_mm.dot(*wish.head) > best->place_mm.dot(*wish.head))
            best = &end;
    return *best;
}

// The voxel with the longest path from the deepest voxel is a tip of the tree. From this first tip the code
// finds all other tips of the tree.
std::vector<WideEnd> tips_of(const Voxels &voxels, const AutoWish &wish, bake::Progress &progress)
{
    std::size_t deepest = 0;
    for (std::size_t v = 0; v < voxels.size(); ++v)
        if (voxels.depth_mm(v) > voxels.depth_mm(deepest)) deepest = v;
    const std::size_t first = by_length(find_ways(voxels, {deepest}, -1)).front();
    const Ways ways = find_ways(voxels, {first}, -1);
    std::vector<std::vector<std::size_t>> tips = ways_to_tips(voxels, ways, wish, progress);
    tips.push_back({tips.front().rbegin(), tips.front().rend()}); // the path back to the first tip itself
    std::vector<WideEnd> ends;
    for (const std::vector<std::size_t> &way : tips)
        ends.push_back({way.back(), voxels.centre_mm(way.back()), width_at(voxels, way)});
    return ends;
}

std::size_t inlet_of(const Lumen &lumen, const AutoWish &wish, std::vector<std::string> &notes,
                     bake::Progress &progress)
{
    const Voxels &voxels = lumen.voxels();
    const std::vector<std::size_t> connected = connected_counts(voxels);
    const auto inside_near = [&](const Eigen::Vector3d &p_mm) { return near_point(voxels, connected, p_mm); };
    if (wish.inlet_mm) {
        const long voxel = inside_near(*wish.inlet_mm);
        if (voxel < 0)
            throw Fault("the inlet at " + bake::place_text(*wish.inlet_mm) +
                        " lies outside the vessel: move it inside");
        return static_cast<std::size_t>(voxel);
    }
    std::vector<WideEnd> openings;
    for (const Opening &opening : lumen.openings())
        if (const long voxel = inside_near(opening.centre_mm); voxel >= 0)
            openings.push_back({static_cast<std::size_t>(voxel), opening.centre_mm, opening.radius_mm});
    const WideEnd tip = inlet_among(tips_of(voxels, wish, progress), wish);
    // A mesh may be open at some of its ends only.
    if (!openings.empty()) {
        const WideEnd opening = inlet_among(openings, wish);
        if (tip.width_mm <= clearly_wider * opening.width_mm) {
            notes.push_back("the inlet is the widest opening, at " + bake::place_text(opening.place_mm));
            return opening.voxel;
        }
    }
    notes.push_back("the inlet is the widest end, at " + bake::place_text(tip.place_mm));
    return tip.voxel;
}

// Adds a note about each piece of the mesh that the tree does not reach.
void note_unreached(const Voxels &voxels, const Ways &ways, std::vector<std::string> &notes)
{
    std::size_t reached = 0, sample = 0;
    for (std::size_t v = 0; v < voxels.size(); ++v) {
        if (ways.from[v] >= 0)
            ++reached;
        else if (voxels.depth_mm(v) > voxels.depth_mm(sample) || ways.from[sample] >= 0)
            sample = v;
    }
    const double share = 1 - static_cast<double>(reached) / static_cast<double>(voxels.size());
    if (share < 1e-3) return;
    const std::string text =
        formatted("%.1f %% of the inside cannot be reached from the inlet, its widest place is at %s: "
                  "another vessel, or one closed between",
                  100 * share, bake::place_text(voxels.centre_mm(sample)).c_str());
    notes.push_back(text);
}

// A tree that ends where it begins is of no use, so it is refused.
void check_length(const Tree &tree, const Voxels &voxels, const Ways &ways, std::size_t inlet,
                  const std::vector<std::string> &notes)
{
    double all_mm = 0;
    for (const Branch &branch : tree.branches) all_mm += length_mm(branch);
    std::size_t reached = 0;
    for (const std::int32_t from : ways.from) reached += from >= 0;
    if (all_mm > 0.5 * voxels.depth_mm(voxels.middle_near(inlet)) && all_mm > 2 * voxels.voxel_mm()) return;
    std::string text;
    for (const std::string &note : notes) text += "; " + note;
    throw Fault(
        formatted("the tree from the inlet at %s is only %.1f mm long, because %.1f %% of the inside is "
                  "connected with it%s: give --inlet inside the vessel, --part for one vessel of "
                  "several, or a smaller --voxel-mm for a thin one",
                  bake::place_text(voxels.centre_mm(inlet)).c_str(), all_mm,
                  100.0 * static_cast<double>(reached) / static_cast<double>(voxels.size()), text.c_str()));
}

void name_branches(Tree &tree)
{
    std::vector<int> children(tree.branches.size() + 1, 0);
    for (Branch &branch : tree.branches) {
        const int number = ++children[branch.parent + 1];
        const std::string before = branch.parent < 0 ? "" : tree.branches[branch.parent].name + ".";
        branch.name = before + std::to_string(number);
        if (branch.name.size() > 50) branch.name = "b" + std::to_string(&branch - tree.branches.data());
    }
}

} // namespace

Tree fit_automatic(const Lumen &lumen, const AutoWish &wish, std::vector<std::string> &notes,
                   bake::Progress &progress)
{
    const Voxels &voxels = lumen.voxels();
    progress.stage("finding ends", 0);
    const std::size_t inlet = inlet_of(lumen, wish, notes, progress);
    const Ways ways = find_ways(voxels, {inlet}, -1);
    note_unreached(voxels, ways, notes);
    const std::vector<std::vector<std::size_t>> tips = ways_to_tips(voxels, ways, wish, progress);
    Tree tree;
    progress.stage("fitting spheres", tips.size());
    for (std::size_t n = 0; n < tips.size(); ++n) {
        Way way;
        way.points_mm = places(voxels, tips[n]);
        if (n > 0) way.parent = std::max(0, parent_of(tree, way.points_mm));
        grow_branch(tree, lumen, way, wish.grow);
        progress.step(n + 1);
    }
    progress.finish();
    check_length(tree, voxels, ways, inlet, notes);
    tree = split_at_junctions(tree);
    name_branches(tree);
    check_tree(tree, "the tree");
    return tree;
}

} // namespace crn::centreline
