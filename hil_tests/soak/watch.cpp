#include "hil_tests/soak/watch.hpp"
#include "host/model/units.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace soak
{

namespace
{

// Three fault codes of the core do not mean that its physics is wrong. The three harmless fault codes report
// a step that was scaled down in a snap (a sudden motion), a tool that slips because it is completely out or
// in, and a hand that is too fast.
bool is_allowed(std::uint16_t code)
{
    return code == CRN_FAULT_CODE_CORE_STEP_CAPPED || code == CRN_FAULT_CODE_CORE_INSERT_END ||
           code == CRN_FAULT_CODE_CORE_FEED_LIMIT;
}

std::string sentence(const char *format, double a, double b, const char *unit)
{
    char text[160];
    std::snprintf(text, sizeof text, format, a, unit, b, unit);
    return text;
}

} // namespace

Watch::Watch(const TrialSettings &settings, const crn::PatientContrast &contrast,
             std::function<crn_wire_fault_log()> log)
    : settings_(settings), contrast_(contrast), log_(std::move(log))
{
}

void Watch::hold(const char *bar, double value, double most, const char *unit, std::uint32_t tick) const
{
    if (value <= most) return;
    throw Enough{bar, std::string(bar) + sentence(" of %.4g %s, at most %.4g %s", value, most, unit), tick};
}

void Watch::tick(const crn_wire_tick_input &, const crn_wire_tick_state &state)
{
    seen_tick_ = state.tick;
    worst_.ticks = state.tick;
    const double depth_mm = crn::units::metres(state.penetration_max_m_q30) * 1e3;
    const double length_pct = std::abs(crn::units::ratio(state.strain_max_q30)) * 1e2;
    double force_N = 0;
    for (std::uint16_t k = 0; k < state.tools_count; k++)
        force_N = std::max(force_N, std::abs(crn::units::newtons(state.tools[k].handle_axial_N_q22)));
    worst_.penetration_mm = std::max(worst_.penetration_mm, depth_mm);
    worst_.length_pct = std::max(worst_.length_pct, length_pct);
    worst_.force_N = std::max(worst_.force_N, force_N);
    hold("penetration", depth_mm, settings_.bars.penetration_mm, "mm", state.tick);
    hold("length", length_pct, settings_.bars.length_pct, "%", state.tick);
    hold("force", force_N, settings_.bars.force_N, "N", state.tick);
    const std::uint32_t batch = crn::SessionPlayer::observe_every_ticks;
    if ((state.core_fault_bits & ~fault_bits_) != 0 && news_tick_ == UINT32_MAX)
        news_tick_ = ((state.tick + batch - 1) / batch + 1) * batch;
    fault_bits_ = state.core_fault_bits;
}

// If the core sets a new fault bit, this class reads the device's fault log at the end of the next batch of
// ticks. If a session reaches its maximum length, it ends at the end of a batch of ticks, because device and
// recording have then reached the same tick. The value that next_tick() returns must not change while a batch
// of ticks is processed.
std::uint32_t Watch::next_tick() const
{
    const std::uint32_t end = seen_tick_ <= settings_.ticks_max ? settings_.ticks_max : UINT32_MAX;
    return std::min(news_tick_, end);
}

void Watch::frame(const crn::SessionFrame &frame)
{
    if (frame.wire.tick >= news_tick_) {
        look_at_faults(frame.wire.tick);
        news_tick_ = UINT32_MAX;
    }
    if (frame.wire.tick >= settings_.ticks_max) throw Enough{"", "", frame.wire.tick};
}

void Watch::look_at_faults(std::uint32_t tick)
{
    const crn_wire_fault_log log = log_();
    for (std::uint16_t i = 0; i < log.entries_count; i++) {
        const crn_wire_fault_entry &entry = log.entries[i];
        if (entry.code == CRN_FAULT_CODE_CORE_STEP_CAPPED) worst_.capped = entry.count;
        if (is_allowed(entry.code)) continue;
        const std::uint32_t when = entry.tick_first <= tick ? entry.tick_first : tick;
        throw Enough{entry.code == CRN_FAULT_CODE_CORE_SATURATED ? "saturation" : "fault",
                     std::string(crn_wire_fault_name(entry.code)) + ": " + crn_wire_fault_text(entry.code),
                     when};
    }
}

void Watch::balance_iodine(std::uint32_t tick) const
{
    if (!contrast_.was_used()) return;
    const crn::IodineBudget &budget = contrast_.flow().budget();
    const std::optional<crn::RunContrast> given = contrast_.given(0, tick);
    const double asked_mg = given ? given->volume_ml * given->iodine_mg_ml : 0.0;
    const double found_mg = contrast_.flow().held_mg() + budget.out_mg + budget.reflux_mg;
    const double most_mg = settings_.bars.iodine_share * asked_mg + 1e-9;
    const auto differs = [&](double mg) { return !(std::abs(mg - asked_mg) <= most_mg); };
    if (!differs(found_mg) && !differs(budget.injected_mg)) return;
    char text[160];
    std::snprintf(text, sizeof text,
                  "iodine: %.9g mg left the syringe, %.9g mg came in, %.9g mg are in the vessels or went out",
                  asked_mg, budget.injected_mg, found_mg);
    throw Enough{"iodine", text, tick};
}

} // namespace soak
