#include "host/model/vessel_tree.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr double reach_m = 2.0, radius_min_m = 10e-6, radius_max_m = 0.1;

std::string fault_of(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = tree.numbered(index);
    const bool has_parent = index > 0 && !(branch.is_vein && branch.parent == -1);
    if (!has_parent ? branch.parent != -1
                    : branch.parent < 0 || static_cast<std::size_t>(branch.parent) >= index)
        return "its parent is no earlier branch";
    if (has_parent &&
        branch.parent_point >= tree.numbered(static_cast<std::size_t>(branch.parent)).points_m.size())
        return "it leaves its parent at a point that is not there";
    if (branch.points_m.size() < 2 || branch.radii_m.size() != branch.points_m.size())
        return "it needs two points at least, each with a radius";
    for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
        if (!(branch.points_m[i].cwiseAbs().maxCoeff() <= reach_m))
            return "point " + std::to_string(i) + " lies beyond 2 m";
        if (!(branch.radii_m[i] >= radius_min_m && branch.radii_m[i] <= radius_max_m))
            return "its radius at point " + std::to_string(i) + " is not 0.01 to 100 mm";
        if (i > 0 && branch.points_m[i] == branch.points_m[i - 1])
            return "point " + std::to_string(i) + " lies on the one before it";
    }
    if (!(branch.flow_ml_s >= 0.0 && branch.flow_ml_s <= 1000.0)) return "its flow is not 0 to 1000 ml/s";
    if (branch.joins == -1) return "";
    const std::size_t all = tree.branches.size() + tree.small.size();
    const auto joined = static_cast<std::size_t>(branch.joins);
    if (index < tree.branches.size() || branch.is_vein) return "only a small artery can join another one";
    if (branch.joins < static_cast<int>(tree.branches.size()) || joined >= all || joined == index ||
        tree.numbered(joined).is_vein)
        return "it joins no other small artery";
    if (!(branch.flow_ml_s > 0.0)) return "it joins another vessel, so its flow must be stated";
    return "";
}

std::string fault_of(const VesselTree &tree, const VesselLesion &lesion)
{
    const std::size_t count = lesion.healthy_radii_m.size();
    if (lesion.branch >= tree.branches.size()) return "it lies on a branch that is not there";
    if (count < 3 || lesion.healthy_points_m.size() != count)
        return "it needs three points at least, each with a radius";
    const std::size_t points = tree.branches[lesion.branch].points_m.size();
    if (lesion.first_point >= points || count > points - lesion.first_point)
        return "it reaches beyond the end of its branch";
    for (std::size_t i = 0; i < count; ++i) {
        if (!(lesion.healthy_points_m[i].cwiseAbs().maxCoeff() <= reach_m)) return "it reaches beyond 2 m";
        if (!(lesion.healthy_radii_m[i] >= radius_min_m && lesion.healthy_radii_m[i] <= radius_max_m))
            return "the healthy radius at its point " + std::to_string(i) + " is not 0.01 to 100 mm";
    }
    return "";
}

constexpr double walk_step_m = 0.25e-3;
constexpr double start_share_max = 0.8; // largest share of a branch that may lie in its parent
constexpr double division_start_radii =
    0.5; // a branch from its parent's end begins this many of its radii further on

} // namespace

VesselFoot vessel_foot(const VesselBranch &branch, const Eigen::Vector3d &place_m)
{
    VesselFoot foot;
    for (std::size_t i = 0; i + 1 < branch.points_m.size(); ++i) {
        const Eigen::Vector3d &a = branch.points_m[i], step = branch.points_m[i + 1] - a;
        const double share = std::clamp((place_m - a).dot(step) / step.squaredNorm(), 0.0, 1.0);
        const double radius_m = branch.radii_m[i] + share * (branch.radii_m[i + 1] - branch.radii_m[i]);
        const double radii = (place_m - a - share * step).norm() / radius_m;
        if (radii < foot.radii) foot = {radii, i, share};
    }
    return foot;
}

std::size_t VesselTree::joined_piece(const VesselBranch &small_artery) const
{
    const std::vector<Eigen::Vector3d> &points_m =
        numbered(static_cast<std::size_t>(small_artery.joins)).points_m;
    const auto square = [&](const Eigen::Vector3d &point_m) {
        return (point_m - small_artery.points_m.back()).squaredNorm();
    };
    const auto nearest =
        std::min_element(points_m.begin(), points_m.end(),
                         [&](const auto &a, const auto &b) { return square(a) < square(b); });
    return std::min(static_cast<std::size_t>(nearest - points_m.begin()), points_m.size() - 2);
}

double VesselLesion::length_m() const
{
    double sum_m = 0.0;
    for (std::size_t i = 1; i < size(); ++i) sum_m += (healthy_points_m[i] - healthy_points_m[i - 1]).norm();
    return sum_m;
}

std::size_t VesselTree::throat(const VesselLesion &lesion) const
{
    const std::vector<double> &radii_m = branches[lesion.branch].radii_m;
    std::size_t least = 0;
    for (std::size_t i = 1; i < lesion.size(); ++i)
        if (radii_m[lesion.first_point + i] * lesion.healthy_radii_m[least] <
            radii_m[lesion.first_point + least] * lesion.healthy_radii_m[i])
            least = i;
    return lesion.first_point + least;
}

double vessel_start_m(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = tree.branches[index];
    if (branch.parent < 0) return 0.0;
    const VesselBranch &parent = tree.branches[static_cast<std::size_t>(branch.parent)];
    double length_m = 0.0;
    for (std::size_t i = 1; i < branch.points_m.size(); ++i)
        length_m += (branch.points_m[i] - branch.points_m[i - 1]).norm();
    const double latest_m = start_share_max * length_m;
    if (branch.parent_point + 1 == parent.points_m.size())
        return std::min(division_start_radii * parent.radii_m.back(), latest_m);
    double arc_m = 0.0, begin_m = 0.0; // arc of the whole walk, and begin of the current piece
    for (std::size_t i = 0; i + 1 < branch.points_m.size(); ++i) {
        const Eigen::Vector3d &a = branch.points_m[i], step = branch.points_m[i + 1] - a;
        const double piece_m = step.norm();
        for (; arc_m < latest_m && arc_m < begin_m + piece_m; arc_m += walk_step_m)
            if (vessel_foot(parent, a + (arc_m - begin_m) / piece_m * step).radii >= 1.0) return arc_m;
        begin_m += piece_m;
    }
    return std::min(arc_m, latest_m);
}

bool VesselTree::is_outlet(std::size_t branch) const
{
    const std::size_t last = branches[branch].points_m.size() - 1;
    for (const VesselBranch &other : branches)
        if (other.parent == static_cast<int>(branch) && other.parent_point == last) return false;
    return true;
}

bool check_vessel_tree(const VesselTree &tree, std::string &error)
{
    for (std::size_t i = 0; i < tree.branches.size() + tree.small.size(); ++i) {
        const std::string fault = fault_of(tree, i);
        if (fault.empty()) continue;
        error = "vessel " + std::to_string(i) + " \"" + tree.numbered(i).name + "\": " + fault;
        return false;
    }
    for (const VesselLesion &lesion : tree.lesions) {
        const std::string fault = fault_of(tree, lesion);
        if (fault.empty()) continue;
        error = "lesion \"" + lesion.name + "\": " + fault;
        return false;
    }
    return true;
}

} // namespace crn
