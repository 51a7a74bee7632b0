#include "host/patient/catheter_pressure.hpp"
#include "host/patient/contrast.hpp"
#include "host/patient/tool_balls.hpp"
#include <algorithm>
#include <limits>

namespace crn
{
namespace
{

constexpr double tick_s = 1e-3;
constexpr double viscosity_mPa_s = ContrastSettings{}.viscosity_mPa_s;
constexpr std::uint32_t longest_beat_ms = 3000;

} // namespace

void CatheterPressure::BeatFigures::take(double mmHg)
{
    highest_ = std::max(highest_, mmHg);
    lowest_ = std::min(lowest_, mmHg);
    sum_ += mmHg;
    ++count_;
}

BeatPressure CatheterPressure::BeatFigures::end()
{
    BeatPressure beat;
    if (count_ > 0) beat = {highest_, lowest_, sum_ / count_};
    *this = {};
    return beat;
}

CatheterPressure::CatheterPressure(const VesselTree &vessels, const std::vector<Instrument> &tools,
                                   const Motion *motion, LesionOpening opening)
    : vessels_(vessels), opening_(std::move(opening)), tool_(injecting_tool(tools, 0)),
      name_(tool_ ? tools[*tool_].name : ""), moved_(vessels, motion, opening_), cells_(vessels),
      network_(cells_, viscosity_mPa_s)
{
}

void CatheterPressure::set_tools(const std::vector<Instrument> &tools, ChangedPositions changed)
{
    const std::optional<std::size_t> now = injecting_tool(tools, 0);
    if (now == tool_ && (!now || !has_changed(changed, *now))) return;
    tool_ = now;
    name_ = tool_ ? tools[*tool_].name : "";
    leave();
}

void CatheterPressure::leave()
{
    is_inserted_ = has_place_ = is_whole_beat_ = is_damped_ = false;
    share_ = 1.0;
}

// The caller asks for next_tick() before each tick, when it cannot know yet that the tip will enter the
// vessels. The tools' shape is therefore first read after the tick in which the tip entered the vessels.
std::uint32_t CatheterPressure::next_tick() const
{
    if (!is_inserted_ || cells_.size() == 0) return std::numeric_limits<std::uint32_t>::max();
    return (look_tick_ / look_every_ticks + 1) * look_every_ticks;
}

void CatheterPressure::open_vessels(const WireFrame &wire)
{
    if (opening_.is_empty() || wire.lesions_open == open_) return;
    open_ = wire.lesions_open;
    reopen();
}

void CatheterPressure::reopen()
{
    VesselTree opened = vessels_;
    opening_.open(vessels_, open_, opened);
    cells_.reshape(opened);
    network_.reshape(cells_, tool_mm_);
}

// Solves for the mean blood flow with the tools in the vessels. The catheter measures the pressure at the
// inlet times the ratio of the pressure in the tip's cell to the inlet's pressure.
void CatheterPressure::advance(const WireFrame &wire)
{
    if (wire.tick < next_tick() || wire.nodes.empty() ||
        *tool_ >= std::max(wire.tip_arc_m.size(), std::size_t{1}))
        return;
    look_tick_ = wire.tick;
    open_vessels(wire);
    if (moved_.can_move())
        cells_.place(moved_.at({wire.heart_phase32, wire.breath_phase32}, opening_, open_));
    find_thickest(cells_, balls_of(wire), tool_mm_);
    network_.set_tools(tool_mm_);
    const FlowDrive mean;
    network_.settle(mean);
    const double tip_arc_m = wire.tip_arc_m.empty() ? 0.0 : wire.tip_arc_m[*tool_];
    const std::size_t cell = cells_.nearest(place_at(wire, tip_arc_m));
    const double direct = std::clamp(network_.pressure_mmHg(cell) / mean.pressure_mmHg, 0.0, 1.0);
    share_ = collateral_share + (1.0 - collateral_share) * direct;
    has_place_ = true;
}

void CatheterPressure::set_wounds(std::span<const CellHole> holes, std::span<const double> open_share)
{
    network_.set_wounds(holes, open_share, tool_mm_);
}

bool CatheterPressure::is_blocked() const
{
    constexpr double blocked_share = 0.1;
    return has_place_ && direct_share() < blocked_share;
}

void CatheterPressure::end_beat()
{
    beat_ = measured_.end();
    const BeatPressure aortic = aortic_.end();
    is_damped_ = is_whole_beat_ && beat_.pulse() < damped_pulse_share * aortic.pulse();
    is_whole_beat_ = has_place_;
}

void CatheterPressure::BeatFigures::archive(StateArchive &state)
{
    for (double *value : {&highest_, &lowest_, &sum_}) state.real(*value);
    state.integer(count_);
}

void CatheterPressure::archive(StateArchive &state, std::uint32_t now, const std::vector<Instrument> &tools)
{
    if (state.restores()) {
        tool_ = injecting_tool(tools, 0);
        name_ = tool_ ? tools[*tool_].name : "";
    }
    const std::vector<double> before = open_;
    state.list(open_, [&](double &share) { state.real(share, 0.0, 4.0); });
    std::vector<double> throats = network_.throat_flows_ml_s();
    state.reals(throats, 0.0, 1e6);
    state.integer<std::uint32_t>(look_tick_, 0, now);
    for (bool *flag : {&is_inserted_, &has_place_, &is_damped_, &is_whole_beat_}) state.flag(*flag);
    if (state.restores()) state.require(tool_ || !(is_inserted_ || has_place_));
    state.real(share_, 0.0, 1.0);
    state.real(pressure_mmHg_, -1e6, 1e6);
    state.integer(beat_ms_);
    state.integer(damped_ticks_);
    for (BeatFigures *figures : {&measured_, &aortic_}) figures->archive(state);
    for (double *value : {&beat_.systolic, &beat_.diastolic, &beat_.mean}) state.real(*value);
    if (!state.restores() || state.is_refused()) return;
    if (open_ != before) {
        cells_ = FlowCells(vessels_);
        network_ = FlowNetwork(cells_, viscosity_mPa_s);
        if (!open_.empty()) reopen();
    }
    network_.set_throat_flows(throats);
}

void CatheterPressure::tick(double aortic_mmHg, const crn_wire_tick_state &state)
{
    const bool was_inserted = is_inserted_;
    is_inserted_ = tool_ && *tool_ < state.tools_count && is_in_patient(state.tools[*tool_]);
    if (!is_inserted_) leave();
    if (is_inserted_ && !was_inserted) look_tick_ = state.tick;
    if (!has_place_) pressure_mmHg_ = aortic_mmHg;
    const double wanted_mmHg = venous_mmHg + share_ * (aortic_mmHg - venous_mmHg);
    pressure_mmHg_ +=
        (wanted_mmHg - pressure_mmHg_) * tick_s / (tick_s + bed_time_s * (1.0 - direct_share()));
    if (state.beat_ms < beat_ms_ || state.beat_ms > longest_beat_ms) end_beat();
    beat_ms_ = state.beat_ms;
    measured_.take(pressure_mmHg_);
    aortic_.take(aortic_mmHg);
    damped_ticks_ += is_damped_ ? 1u : 0u;
}

} // namespace crn
