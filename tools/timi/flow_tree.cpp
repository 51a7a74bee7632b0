#include "tools/timi/flow_tree.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/small/small_tree.hpp"
#include "tools/bake/branches.hpp"
#include "tools/bake/scene_text.hpp"
#include "tools/bake/small_vessels.hpp"

namespace anatomy
{

crn::VesselTree flow_tree(const VesselTree &tree)
{
    constexpr double STEP_MM = 4.0; // of the centrelines in files
    std::vector<crn::bake::Curve> lines;
    crn::bake::TreeText text;
    text.inlet = file_stem(tree.vessels.front().name);
    for (const Vessel &vessel : tree.vessels) {
        crn::bake::Curve line;
        line.name = file_stem(vessel.name) + ".mrk.json";
        for (const CurvePoint &point : vessel_curve(vessel, STEP_MM))
            line.spheres.push_back({point.position_mm, point.radius_mm});
        lines.push_back(std::move(line));
        if (vessel.flow_ml_min > 0) text.flow_ml_min[file_stem(vessel.name)] = vessel.flow_ml_min;
        if (vessel.bed == Bed::left_coronary) text.left_coronary.push_back(file_stem(vessel.name));
        if (vessel.bed == Bed::right_coronary) text.right_coronary.push_back(file_stem(vessel.name));
    }
    crn::VesselTree joined = crn::bake::join_branches(lines, text);
    crn::bake::add_small_vessels(small_vessels_text(small_vessels_of(tree)), "small vessels", joined);
    return joined;
}

} // namespace anatomy
