#include "tools/patient/practice.hpp"
#include "host/base/format.hpp"
#include "tools/bake/bake.hpp"
#include "tools/patient/ways.hpp"

#include <algorithm>
#include <cmath>

namespace crn::patient
{
namespace
{

using centreline::Branch;
using centreline::Tree;
using Eigen::Vector3d;

// A pair of shipped instruments, and the least radius of a vessel in which both can be moved.
struct Instruments {
    const char *wire, *wire_words, *catheter;
    double wire_needs_mm, catheter_needs_mm;
};
// A J of 3 mm opens in 2 mm of radius. In a winding vessel, a catheter that fills it holds the wire so firmly
// that the wire cannot be withdrawn, and blocks the blood: 0.3 mm remain around it.
constexpr Instruments usual = {"j_wire", "J wire", "terumo_5f", 2.0, 2.0};
constexpr Instruments thin = {"coronary_014", "coronary wire", "terumo_4f", 0.4, 1.0};

// How far the hands advance, in mm, and why.
struct Plan {
    const Instruments *take;
    double wire_mm, catheter_mm;
    std::string why;
};

constexpr double begins_mm = 20.0; // at most this length of a tool is in the vessel at the start

Plan plan_for(const Tree &tree, const std::vector<WayPlace> &ways)
{
    constexpr double behind_mm = 20.0, way_max_mm = 150.0, way_min_mm = 10.0, push_min_mm = 5.0,
                     spare_mm = 3.0;
    double reach_mm = 0.0;
    for (const WayPlace &one : ways) reach_mm = std::max(reach_mm, one.from_entry_mm);
    Plan plan{&usual, std::clamp(std::floor(0.5 * reach_mm / 10) * 10, way_min_mm, way_max_mm), 0.0,
              "half of the way to the farthest end, at most 150 mm"};
    const WayPlace *narrow = narrowest(ways, begins_mm + plan.wire_mm);
    plan.catheter_mm = std::max(plan.wire_mm - behind_mm, push_min_mm);
    if (!narrow) return plan;
    const std::string where = formatted(
        "the narrowest place of the way has a radius of %.1f mm, %.0f mm from the entry in %s, and ",
        narrow->radius_mm, narrow->from_entry_mm, tree.branches[narrow->branch].name.c_str());
    if (narrow->radius_mm >= usual.wire_needs_mm) {
        plan.why += "; " + where + formatted("%s needs %.1f mm", usual.wire, usual.wire_needs_mm);
        return plan;
    }
    plan.take = &thin;
    plan.why += "; " + where +
                formatted("%s with %s would need %.1f mm", usual.wire, usual.catheter, usual.wire_needs_mm);
    // Where a vessel is too narrow, the catheter stops before it, and the wire is ahead of the catheter.
    const double catheter_mm = wide_up_to_mm(ways, thin.catheter_needs_mm) - begins_mm - spare_mm;
    if (catheter_mm < plan.catheter_mm) {
        plan.catheter_mm = std::max(std::floor(catheter_mm), push_min_mm);
        plan.wire_mm = std::min(plan.wire_mm, plan.catheter_mm + behind_mm);
        plan.why += formatted("; %s stops before a radius of %.1f mm", thin.catheter, thin.catheter_needs_mm);
    }
    const double wire_mm = wide_up_to_mm(ways, thin.wire_needs_mm) - begins_mm - spare_mm;
    plan.wire_mm = std::min(plan.wire_mm, std::max(std::floor(wire_mm), push_min_mm));
    return plan;
}

} // namespace

std::string practice_session(const std::filesystem::path &scene, const Tree &tree, const TreeEnd &end,
                             double inside_mm, Choices &choices)
{
    constexpr double trunk_mm = 6.0, shown_mm = 80.0;
    const std::vector<WayPlace> ways = ways_from(tree, end, inside_mm);
    const Plan plan = plan_for(tree, ways);
    double widest_mm = 0.0; // blood dilutes the medium: a trunk needs more
    for (const Branch &branch : tree.branches)
        widest_mm = std::max(widest_mm, branch.spheres[branch.spheres.size() / 2].radius_mm);
    const std::string injection = plan.take == &thin      ? "5 ml at 3 ml/s"
                                  : widest_mm >= trunk_mm ? "20 ml at 15 ml/s"
                                                          : "10 ml at 6 ml/s";
    choices.add("session",
                formatted("%s, advanced by %.0f mm; %s by %.0f mm; DSA with %s", plan.take->wire,
                          plan.wire_mm, plan.take->catheter, plan.catheter_mm, injection.c_str()),
                plan.why, "practice.session may be changed");
    // At a distance of 105 cm from the source, the detector shows the patient's middle 1.4 times as large.
    constexpr double larger = 1.4, margin = 1.2;
    const Eigen::AlignedBox3d shown =
        shown_from(tree, ways, plan.catheter_mm, begins_mm + plan.catheter_mm, shown_mm);
    const Vector3d middle = shown.center();
    const double size_mm = std::max(shown.sizes().x(), shown.sizes().y());
    const int field_cm = std::clamp(static_cast<int>(std::ceil(size_mm * larger * margin / 10)), 16, 32);
    choices.add("picture", bake::place_text(middle) + formatted(", field of %d cm", field_cm),
                formatted("the middle of the vessels up to %.0f mm behind the catheter's end", shown_mm),
                "table and field of practice.session may be changed");
    return formatted(
        "# A %s goes from the entry into the vessel, and a catheter follows it. Then contrast medium shows "
        "the\n"
        "# vessels. Made by `cournand patient new`; it may be changed.\n"
        "needs scene %s\nneeds tools %s, %s\nfluoro on\nfollow tip\nfield %d cm\nwait 0.7 s\n"
        "advance wire %.0f mm at 30 mm/s in strokes of 50 mm\nwait 0.5 s\nexpect inserted at least %.0f mm\n"
        "table x %.0f mm y %.0f mm z %.0f mm\nadvance catheter %.0f mm at 30 mm/s in strokes of 50 mm\n"
        "withdraw wire until inserted 0 mm at 50 mm/s\naspirate 3 ml\nfluoro off\nwait 0.5 s\n"
        "# The first frame is the mask: medium comes after it.\n"
        "dsa on rate 6 f/s\nwait 0.7 s\ninject %s\nwait 3 s\ndsa off\nreview run 1 frame 11\nwait 0.2 s\n",
        plan.take->wire_words, std::filesystem::absolute(scene).lexically_normal().c_str(), plan.take->wire,
        plan.take->catheter, field_cm, plan.wire_mm, 0.9 * plan.wire_mm, middle.x(), middle.y(), middle.z(),
        plan.catheter_mm, injection.c_str());
}

} // namespace crn::patient
