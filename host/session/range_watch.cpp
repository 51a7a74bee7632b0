#include "host/session/range_watch.hpp"
#include "host/base/format.hpp"
#include "host/link/link.hpp"
#include "host/model/units.hpp"
#include "host/model/vessel_tree.hpp"
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

constexpr std::uint32_t core_saturated = 1u << 0; // bit 0 of core_fault_bits: CORE_SATURATED (docs/faults.md)

std::string place_text(const RangeBreak &left)
{
    if (!left.place_m) return "";
    const Eigen::Vector3d mm = *left.place_m * 1e3;
    return (left.branch.empty() ? "" : " of " + left.branch) +
           formatted(" at (%.1f %.1f %.1f) mm", mm.x(), mm.y(), mm.z());
}

} // namespace

void RangeWatch::take(const crn_wire_tick_state &state)
{
    if (left_) return;
    const double depth_m = units::metres(state.penetration_max_m_q30);
    const double error = std::abs(units::ratio(state.strain_max_q30));
    const bool is_saturated = (state.core_fault_bits & core_saturated) != 0;
    if (!is_saturated && depth_m <= penetration_max_m && error <= length_error_max) return;
    left_ = RangeBreak{state.tick, is_saturated, depth_m, error};
}

bool RangeWatch::wants_place(std::uint32_t tick, bool is_last) const
{
    return left_ && !is_placed_ && (is_last || tick % look_every_ticks == 0);
}

void RangeWatch::find_place(Link &link)
{
    is_placed_ = true;
    const crn_wire_contacts contacts = link.read_contacts();
    const crn_wire_nodes &nodes = link.read_nodes();
    double hardest = 0.0;
    for (std::uint16_t i = 0; i < contacts.contacts_count; i++) {
        const crn_wire_contact &one = contacts.contacts[i];
        const Eigen::Vector3d force(one.force_x_N_q22, one.force_y_N_q22, one.force_z_N_q22);
        if (one.node >= nodes.positions_count || force.norm() <= hardest) continue;
        hardest = force.norm();
        const crn_wire_node_position &at = nodes.positions[one.node];
        left_->place_m =
            Eigen::Vector3d(units::metres(at.x_m_q30), units::metres(at.y_m_q30), units::metres(at.z_m_q30));
    }
}

void RangeWatch::name_branch(const VesselTree &vessels)
{
    if (!left_ || !left_->place_m) return;
    double nearest = std::numeric_limits<double>::infinity();
    for (const VesselBranch &branch : vessels.branches) {
        const double radii = vessel_foot(branch, *left_->place_m).radii;
        if (radii >= nearest) continue;
        nearest = radii;
        left_->branch = branch.name;
    }
}

std::string range_notice(const RangeBreak &left)
{
    const std::uint32_t tenths = left.tick / 100;
    return formatted("physics left its range at %02u:%02u.%u", unsigned{tenths / 600},
                     unsigned{tenths / 10 % 60}, unsigned{tenths % 10});
}

std::string range_text(const RangeBreak &left)
{
    std::string what;
    const auto add = [&](const std::string &more) { what += (what.empty() ? "" : "; ") + more; };
    if (left.penetration_m > RangeWatch::penetration_max_m)
        add(formatted("%.2f mm through the wall", left.penetration_m * 1e3) + place_text(left) +
            formatted(", limit %.0f mm", RangeWatch::penetration_max_m * 1e3));
    if (left.length_error > RangeWatch::length_error_max)
        add(formatted("%.2f %% of length error, limit %.0f %%", left.length_error * 1e2,
                      RangeWatch::length_error_max * 1e2));
    if (left.is_saturated)
        add("a force of the core reached its number format's limit (CORE_SATURATED)" +
            (left.penetration_m > RangeWatch::penetration_max_m ? std::string() : place_text(left)));
    return range_notice(left) + formatted(" (tick %u): ", unsigned{left.tick}) + what +
           "; what came before is valid and recorded. Remedy: move the tool in question more slowly there, "
           "or keep it back; please report the recording";
}

nlohmann::ordered_json range_report(const std::optional<RangeBreak> &left)
{
    if (!left) return {};
    nlohmann::ordered_json report = {{"tick", left->tick},
                                     {"time_s", left->tick * 1e-3},
                                     {"saturated", left->is_saturated},
                                     {"penetration_mm", left->penetration_m * 1e3},
                                     {"penetration_limit_mm", RangeWatch::penetration_max_m * 1e3},
                                     {"length_error_pct", left->length_error * 1e2},
                                     {"length_error_limit_pct", RangeWatch::length_error_max * 1e2}};
    report["place_mm"] = nlohmann::ordered_json();
    if (left->place_m) {
        const Eigen::Vector3d mm = *left->place_m * 1e3;
        report["place_mm"] = {mm.x(), mm.y(), mm.z()};
    }
    report["branch"] = left->branch;
    report["text"] = range_text(*left);
    return report;
}

} // namespace crn
