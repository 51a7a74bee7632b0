#include "host/model/vessel_tree.hpp"

namespace seld
{
namespace
{

constexpr double reach_m = 2.0, radius_min_m = 10e-6, radius_max_m = 0.1;

std::string fault_of(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = tree.branches[index];
    if (index == 0 ? branch.parent != -1
                   : branch.parent < 0 || static_cast<std::size_t>(branch.parent) >= index)
        return "its parent is no earlier branch";
    if (index > 0 &&
        branch.parent_point >= tree.branches[static_cast<std::size_t>(branch.parent)].points_m.size())
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
    return "";
}

} // namespace

bool VesselTree::is_outlet(std::size_t branch) const
{
    const std::size_t last = branches[branch].points_m.size() - 1;
    for (const VesselBranch &other : branches)
        if (other.parent == static_cast<int>(branch) && other.parent_point == last) return false;
    return true;
}

bool check_vessel_tree(const VesselTree &tree, std::string &error)
{
    for (std::size_t i = 0; i < tree.branches.size(); ++i) {
        const std::string fault = fault_of(tree, i);
        if (fault.empty()) continue;
        error = "vessel " + std::to_string(i) + " \"" + tree.branches[i].name + "\": " + fault;
        return false;
    }
    return true;
}

} // namespace seld
