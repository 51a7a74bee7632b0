#include "tools/anatomy/small/stated.hpp"
#include "tools/anatomy/small/beside_bones.hpp"
#include "tools/anatomy/small/twigs.hpp"
#include "tools/anatomy/small/winding.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <algorithm>

namespace anatomy
{

namespace
{

const Vessel *vessel_of(const VesselTree &tree, const std::string &name)
{
    const Vessel *vessel = named(tree.vessels, name);
    return vessel ? vessel : named(tree.small, name);
}

Vec3 nearest_point(const Vessel &line, const Vec3 &to)
{
    Vec3 best = line.stations.front().position_mm;
    for (const CurvePoint &point : vessel_curve(line, 1.0))
        if ((point.position_mm - to).squaredNorm() < (best - to).squaredNorm()) best = point.position_mm;
    return best;
}

/* Moves the first of the stations from `begin` on, and the next ones less: nothing moves `fades_mm` behind
 * it. */
template <class Place> void drag(Place begin, Place end, const Vec3 &moved_mm, double fades_mm)
{
    double arc_mm = 0.0;
    Vec3 before = begin->position_mm;
    for (; begin != end; ++begin) {
        arc_mm += (begin->position_mm - before).norm();
        before = begin->position_mm;
        begin->position_mm += std::max(0.0, 1.0 - arc_mm / fades_mm) * moved_mm;
    }
}

/* Moves the start of a vessel with its parent. Its far end, which lies in an organ or beside a bone, moves
 * less. */
void follow(Vessel &vessel, const Vec3 &moved_mm)
{
    constexpr double FADES_MM = 80.0;
    drag(vessel.stations.begin(), vessel.stations.end(), moved_mm, FADES_MM);
}

/* Adds the arteries of one shipped file, in the order in which they are given, beside spine and bones. */
void add_all(VesselTree &tree, const VesselTree &shipped, const std::vector<Vessel> &arteries,
             std::uint64_t stream, const Solid &bones)
{
    constexpr double USUAL_WINDING = 1.04;
    VesselTree straight = shipped;
    straight.vessels = moved_with_spine(shipped.vessels, tree.skeleton.bend);
    straight.small = moved_with_spine(arteries, tree.skeleton.bend);
    for (Vessel vessel : straight.small) {
        stream++;
        const Vessel *parent = vessel_of(tree, vessel.parent);
        if (!parent || vessel_of(tree, vessel.name)) continue;
        const Vec3 start = vessel.stations.front().position_mm;
        follow(vessel,
               nearest_point(*parent, start) - nearest_point(*vessel_of(straight, vessel.parent), start));
        if (vessel.winding == 0.0) vessel.winding = USUAL_WINDING;
        tree.small.push_back(beside_bones(wound(vessel, tree.seed.value_or(0), stream), bones));
    }
}

/* Moves the end of an artery that joins another one onto it; the first station stays in its parent. */
void reach_joined(Vessel &artery, const Vessel &joined)
{
    constexpr double FADES_MM = 30.0;
    const Vec3 end_mm = artery.stations.back().position_mm;
    drag(artery.stations.rbegin(), artery.stations.rend() - 1, nearest_point(joined, end_mm) - end_mm,
         FADES_MM);
}

} // namespace

void add_stated_branches(VesselTree &tree)
{
    constexpr std::uint64_t OWN = 3800, TRUNK = 4000, HEAD = 4200, ARMS = 4400; // streams of chance
    for (size_t i = 0; i < tree.small.size(); i++)                              // those of a user's file
        tree.small[i] = wound(tree.small[i], tree.seed.value_or(0), OWN + i);
    const VesselTree trunk = shipped_vessels("trunk_branches"), head = shipped_vessels("head_branches"),
                     arms = shipped_vessels(tree.skeleton.arms == Arms::raised ? "arm_branches"
                                                                               : "arm_branches_beside");
    const Solid bones = bones_beside(tree.skeleton);
    add_all(tree, trunk, trunk.small, TRUNK, bones);
    const CircleOfWillis circle = tree.seed ? drawn_circle(*tree.seed) : CircleOfWillis{};
    add_all(tree, head, with_circle(head.small, circle), HEAD, bones);
    add_all(tree, arms, arms.small, ARMS, bones);
    for (Vessel &artery : tree.small)
        if (const Vessel *joined = named(tree.small, artery.joins)) reach_joined(artery, *joined);
}

} // namespace anatomy
