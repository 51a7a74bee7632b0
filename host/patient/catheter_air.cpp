#include "host/patient/catheter_air.hpp"
#include "host/patient/contrast.hpp"

namespace crn
{

CatheterAir::CatheterAir(const std::vector<Instrument> &tools) : tool_(injecting_tool(tools, 0)) {}

void CatheterAir::set_tools(const std::vector<Instrument> &tools, ChangedPositions changed)
{
    const std::optional<std::size_t> now = injecting_tool(tools, 0);
    if (now == tool_ && (!now || !has_changed(changed, *now))) return;
    tool_ = now;
    inside_bits_ = 0;
    aspirated_ul_ = 0;
    may_hold_air_ = false;
}

void CatheterAir::tick(const crn_wire_tick_state &state)
{
    std::uint32_t inside = 0;
    for (std::size_t k = 0; tool_ && k < *tool_ && k < state.tools_count; ++k)
        if (is_in_patient(state.tools[k])) inside |= 1u << k;
    if ((inside_bits_ & ~inside) != 0) {
        may_hold_air_ = true;
        aspirated_ul_ = 0;
    }
    inside_bits_ = inside;
}

void CatheterAir::aspirate(std::int32_t volume_ul)
{
    aspirated_ul_ += volume_ul;
    if (aspirated_ul_ >= enough_ul) may_hold_air_ = false;
}

void CatheterAir::inject(std::uint32_t tick)
{
    if (may_hold_air_) injections_.push_back(tick);
}

void CatheterAir::archive(StateArchive &state, const std::vector<Instrument> &tools)
{
    if (state.restores()) tool_ = injecting_tool(tools, 0);
    state.integer(inside_bits_);
    state.integer<std::int32_t>(aspirated_ul_, 0, 1'000'000'000);
    state.flag(may_hold_air_);
    state.list(injections_, [&](std::uint32_t &tick) { state.integer(tick); });
}

} // namespace crn
