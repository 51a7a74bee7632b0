#include "host/effects/small_flows.hpp"
#include "host/effects/flow_cells.hpp"

namespace crn
{

std::vector<bool> small_vessels_continued(const VesselTree &tree)
{
    std::vector<bool> continued(tree.small.size(), false);
    for (const VesselBranch &vessel : tree.small) {
        const std::size_t parent = static_cast<std::size_t>(vessel.parent) - tree.branches.size();
        if (vessel.parent < static_cast<int>(tree.branches.size())) continue;
        if (vessel.parent_point + 1 == tree.small[parent].points_m.size()) continued[parent] = true;
    }
    return continued;
}

std::vector<double> small_vessel_flows_ml_s(const VesselTree &tree)
{
    const std::vector<bool> continued = small_vessels_continued(tree);
    std::vector<double> flows_ml_s(tree.small.size(), 0.0);
    for (std::size_t v = tree.small.size(); v-- > 0;) { // parents come before their branches
        const VesselBranch &vessel = tree.small[v];
        if (vessel.is_vein) continue;
        if (!continued[v])
            flows_ml_s[v] +=
                vessel.flow_ml_s > 0.0 ? vessel.flow_ml_s : murray_flow_ml_s(vessel.radii_m.back() * 1e3);
        if (vessel.parent >= static_cast<int>(tree.branches.size()))
            flows_ml_s[static_cast<std::size_t>(vessel.parent) - tree.branches.size()] += flows_ml_s[v];
    }
    return flows_ml_s;
}

} // namespace crn
