#include "host/effects/small_flows.hpp"
#include "host/effects/flow_cells.hpp"
#include <algorithm>

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
    for (std::size_t v = 0; v < tree.small.size(); ++v)
        if (tree.small[v].joins >= 0) continued[v] = true;
    return continued;
}

namespace
{

// Blood that leaves a vessel at a point, or joins it there (negative).
struct Leaving {
    std::size_t point;
    double flow_ml_s;
};

// Returns the flow into the beginning of a vessel that others join: so much that no part of it runs dry.
double needed_ml_s(std::vector<Leaving> places)
{
    std::sort(places.begin(), places.end(), [](const Leaving &a, const Leaving &b) {
        return a.point < b.point || (a.point == b.point && a.flow_ml_s > b.flow_ml_s);
    });
    double sum_ml_s = 0.0, needed_ml_s = 0.0;
    for (const Leaving &place : places) {
        sum_ml_s += place.flow_ml_s;
        needed_ml_s = std::max(needed_ml_s, sum_ml_s);
    }
    return needed_ml_s;
}

} // namespace

std::vector<double> small_vessel_flows_ml_s(const VesselTree &tree)
{
    const std::vector<bool> continued = small_vessels_continued(tree);
    const auto small_index = [&](int number) {
        return static_cast<std::size_t>(number) - tree.branches.size();
    };
    std::vector<double> flows_ml_s(tree.small.size(), 0.0);
    std::vector<std::vector<Leaving>> places(tree.small.size()); // of vessels that others join
    for (const VesselBranch &vessel : tree.small) {
        if (vessel.joins < 0) continue;
        places[small_index(vessel.joins)].push_back({tree.joined_piece(vessel), -vessel.flow_ml_s});
    }
    for (std::size_t v = tree.small.size(); v-- > 0;) { // parents come before their branches
        const VesselBranch &vessel = tree.small[v];
        if (vessel.is_vein) continue;
        double end_ml_s = vessel.joins >= 0 ? vessel.flow_ml_s : 0.0;
        if (!continued[v])
            end_ml_s =
                vessel.flow_ml_s > 0.0 ? vessel.flow_ml_s : murray_flow_ml_s(vessel.radii_m.back() * 1e3);
        flows_ml_s[v] += end_ml_s;
        if (!places[v].empty()) {
            places[v].push_back({vessel.points_m.size() - 1, end_ml_s});
            flows_ml_s[v] = needed_ml_s(places[v]);
        }
        if (vessel.parent < static_cast<int>(tree.branches.size())) continue;
        const std::size_t parent = small_index(vessel.parent);
        if (places[parent].empty())
            flows_ml_s[parent] += flows_ml_s[v];
        else
            places[parent].push_back({std::max<std::size_t>(vessel.parent_point, 1), flows_ml_s[v]});
    }
    return flows_ml_s;
}

} // namespace crn
