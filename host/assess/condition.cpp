#include "host/assess/condition.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

using Kind = ConditionAtom::Kind;

constexpr double damped_share = 0.9; // of the lumen's diameter: a wider tip fills the vessel (our assumption)

bool names_a_tool(Kind kind)
{
    return (kind >= Kind::hand_advances && kind <= Kind::damped);
}

bool names_a_balloon(Kind kind)
{
    return kind >= Kind::balloon_bar && kind <= Kind::balloon_beyond_stent;
}

std::string missing_tool(const SessionLog &log, std::size_t tool)
{
    return tool < log.tools.size() ? "" : "the session has no device '" + tool_name(tool) + "'";
}

// Returns what this simple condition (atom) needs and the session lacks; vessels are not checked here.
std::string missing(const ConditionAtom &atom, const SessionLog &log)
{
    if (names_a_tool(atom.kind)) {
        if (const std::string why = missing_tool(log, atom.tool); !why.empty()) return why;
        if (const std::string why = missing_tool(log, atom.other); !why.empty()) return why;
    }
    const bool is_about_lumen =
        atom.kind == Kind::pressure_damped || atom.kind == Kind::unaspirated_injection;
    if (is_about_lumen && !log.has_transducer) return "no device of the session has a lumen";
    if (names_a_balloon(atom.kind) && !log.has_balloon) return "the session has no balloon";
    if (atom.kind == Kind::balloon_above_rated && !log.rated_burst_bar)
        return "the balloon's label states no rated burst pressure";
    const bool is_about_stents = atom.kind == Kind::balloon_beyond_stent || atom.kind == Kind::stent_loaded ||
                                 atom.kind == Kind::stent_deployed || atom.kind == Kind::stent_lost;
    if (is_about_stents && !log.has_stents) return "the session has no stent";
    if (atom.kind == Kind::lesion_open_pct && !log.has_lesions) return "the scene has no lesion";
    if (atom.kind == Kind::wall_N && !log.has_contacts) return "the forces of the walls are not known";
    const bool is_about_vessels =
        atom.kind == Kind::tip_in_vessel || atom.kind == Kind::tip_off_the_way || atom.kind == Kind::damped;
    if (is_about_vessels && log.map.is_empty()) return "the scene has no vessels";
    return "";
}

std::size_t find_vessel(const SessionLog &log, const std::string &name, const std::string &file, int line,
                        int column)
{
    if (const auto found = log.map.find(name)) return *found;
    throw FileError(file, line, column, "the scene has no vessel '" + name + "'" + log.map.suggestion(name));
}

std::string bind_vessels(ConditionAtom &atom, const SessionLog &log, const PlanVessels &vessels)
{
    if (atom.kind == Kind::tip_off_the_way) {
        if (vessels.way.empty()) return "the plan states no way ([vessels] way)";
        atom.way.clear();
        for (const std::string &name : vessels.way)
            atom.way.push_back(find_vessel(log, name, vessels.file, vessels.line, 0));
    }
    if (atom.kind != Kind::tip_in_vessel) return "";
    // A plan for many scenes does not state which vessels are `target` and `ostium`; a case or the command
    // line names these vessels.
    const auto named = vessels.names.find(atom.vessel);
    if (named == vessels.names.end() && (atom.vessel == "target" || atom.vessel == "ostium"))
        return "the plan does not say which vessel is the " + atom.vessel + " ([vessels] " + atom.vessel +
               ")";
    const std::string &name = named == vessels.names.end() ? atom.vessel : named->second;
    atom.vessel_number = find_vessel(log, name, atom.file, atom.line, atom.column);
    return "";
}

double depth_off_the_way_mm(const ConditionAtom &atom, const ToolMoment &tool)
{
    return std::find(atom.way.begin(), atom.way.end(), tool.vessel) == atom.way.end() ? tool.inside_mm : -1.0;
}

bool tool_holds(const ConditionAtom &atom, const SessionSignals &signals, std::size_t i)
{
    const SessionMoment &moment = signals.log().moments[i];
    const ToolMoment &tool = moment.tools[atom.tool];
    const ToolSignals &signal = signals.tool(atom.tool);
    switch (atom.kind) {
    case Kind::hand_advances:
        return atom.allows(signal.hand_mm_s[i]);
    case Kind::hand_withdraws:
        return atom.allows(-signal.hand_mm_s[i]);
    case Kind::hand_moves:
        return atom.allows(std::fabs(signal.hand_mm_s[i]));
    case Kind::hand_turns:
        return atom.allows(std::fabs(signal.turn_deg_s[i]));
    case Kind::inserted_mm:
        return atom.allows(tool.inserted_mm);
    case Kind::hand_force_N:
        return atom.allows(std::fabs(tool.hand_force_N));
    case Kind::tip_moves:
        return atom.allows(signal.tip_mm_s[i]);
    case Kind::tip_in_vessel:
        return tool.has_place && tool.vessel == atom.vessel_number && atom.allows(tool.inside_mm);
    case Kind::tip_in_picture:
        return tool.is_in_picture;
    case Kind::tip_off_the_way:
        return tool.has_place && atom.allows(depth_off_the_way_mm(atom, tool));
    case Kind::tip_ahead:
        return tool.has_tip && atom.allows(tool.ahead_mm - moment.tools[atom.other].ahead_mm);
    case Kind::tip_fixed:
        return tool.has_tip && atom.allows(signal.fixed_mm[i]);
    case Kind::damped:
        return tool.has_place && tool.lumen_share >= damped_share;
    default:
        return false;
    }
}

bool session_holds(const ConditionAtom &atom, const SessionLog &log, std::size_t i, std::size_t since)
{
    const SessionMoment &now = log.moments[i], &then = log.moments[since];
    switch (atom.kind) {
    case Kind::xray:
        return now.is_xray_on;
    case Kind::acquiring:
        return now.is_acquiring;
    case Kind::gantry_moves:
        return now.is_gantry_moving;
    case Kind::injecting:
        return now.is_injecting;
    case Kind::pressure_damped:
        return now.is_pressure_damped;
    case Kind::unaspirated_injection:
        return i > 0 && now.unaspirated_injections > log.moments[i - 1].unaspirated_injections;
    case Kind::injected_ml:
        return atom.allows(now.injected_ml - then.injected_ml);
    case Kind::runs:
        return atom.allows(now.runs - then.runs);
    case Kind::filled_runs:
        return atom.allows(now.filled_runs - then.filled_runs);
    case Kind::empty_runs:
        return atom.allows(now.empty_runs - then.empty_runs);
    case Kind::empty_run_ends:
        return i > 0 && now.empty_runs > log.moments[i - 1].empty_runs;
    case Kind::time_s:
        return atom.allows((now.tick - then.tick) * 1e-3);
    case Kind::balloon_bar:
        return atom.allows(now.balloon_bar);
    case Kind::balloon_above_rated:
        return log.rated_burst_bar && now.balloon_bar > *log.rated_burst_bar;
    case Kind::balloon_burst:
        return now.is_balloon_burst;
    case Kind::balloon_beyond_stent:
        return now.stents_deployed > 0 && atom.allows(now.balloon_beyond_stent_mm);
    case Kind::stent_loaded:
        return now.stents_loaded > 0;
    case Kind::stent_deployed:
        return now.stents_deployed > 0;
    case Kind::stent_lost:
        return now.stents_lost > 0;
    case Kind::lesion_open_pct:
        return atom.allows(now.lesion_open_pct);
    case Kind::wall_N:
        return atom.allows(now.wall_N);
    case Kind::line_without_wire:
        return !now.has_wire;
    case Kind::perforated:
        return i > 0 && now.perforations > log.moments[i - 1].perforations;
    case Kind::dissected:
        return i > 0 && now.dissections > log.moments[i - 1].dissections;
    case Kind::blood_loss_ml:
        return atom.allows(now.blood_loss_ml - then.blood_loss_ml);
    default:
        return false;
    }
}

} // namespace

std::string Condition::bind(const SessionLog &log, const PlanVessels &vessels)
{
    if (join_ == Join::atom) {
        const std::string why = missing(atom_, log);
        return why.empty() ? bind_vessels(atom_, log, vessels) : why;
    }
    // If one true condition of several is enough, the conditions that do not apply to the session are left
    // out.
    std::vector<Condition> applying;
    std::string why;
    for (Condition &part : parts_) {
        const std::string why_not = part.bind(log, vessels);
        if (why_not.empty())
            applying.push_back(part);
        else if (why.empty())
            why = why_not;
    }
    if (join_ != Join::any || applying.empty()) return why;
    parts_ = std::move(applying);
    return "";
}

bool Condition::holds(const SessionSignals &signals, std::size_t i, std::size_t since) const
{
    const auto part_holds = [&](const Condition &part) { return part.holds(signals, i, since); };
    switch (join_) {
    case Join::all:
        return std::all_of(parts_.begin(), parts_.end(), part_holds);
    case Join::any:
        return std::any_of(parts_.begin(), parts_.end(), part_holds);
    case Join::negation:
        return !parts_.front().holds(signals, i, since);
    case Join::atom:
        break;
    }
    return names_a_tool(atom_.kind) ? tool_holds(atom_, signals, i)
                                    : session_holds(atom_, signals.log(), i, since);
}

} // namespace crn
