#include "host/session/hand_grip.hpp"
#include <algorithm>
#include <cstdlib>

namespace crn
{

namespace
{

// Describes the force limit of a hand for one axis, and the stiffness that determines how far the tool slips
// above this limit. The slip is the excess force divided by a stiffness like that of the skin of a finger (10
// N/mm, 1 N m/rad). The slip is never faster than a hand can move. If the tool meets a contact that is
// stiffer than the finger's skin, the force still returns to the limit within some ticks.
struct Limits {
    std::int64_t force;          // in the format of tick_state
    std::int64_t counts_per_one; // counts of slip for one newton or newton metre of excess
    unsigned fraction_bits;      // of that format
    std::int64_t counts_max;     // per tick
};
constexpr Limits along{HandGrip::force_limit_N << 22, 100, 22, 500};                // um; 0.5 m/s
constexpr Limits about{(HandGrip::torque_limit_mN_m << 24) / 1000, 10430, 24, 208}; // 1/65 536 turn; 20 rad/s

std::int64_t slip_of(const Limits &limits, std::int64_t force)
{
    const std::int64_t excess = std::llabs(force) - limits.force;
    if (excess <= 0) return 0;
    const std::int64_t counts =
        std::min(((excess * limits.counts_per_one) >> limits.fraction_bits) + 1, limits.counts_max);
    return force > 0 ? counts : -counts; // a force that pushes the tool out makes it lag behind the hand
}

bool is_a_fifth(const Limits &limits, std::int64_t force)
{
    return std::llabs(force) * 5 > limits.force;
}

std::int32_t less(std::int32_t counts, std::int64_t slip)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) - static_cast<std::uint32_t>(slip));
}

} // namespace

crn_wire_tick_input HandGrip::hold(crn_wire_tick_input wanted) const
{
    for (std::size_t k = 0; k < std::min<std::size_t>(wanted.hands_count, hands_.size()); k++) {
        wanted.hands[k].translation_counts =
            less(wanted.hands[k].translation_counts, hands_[k].along.slip_counts);
        wanted.hands[k].rotation_counts = less(wanted.hands[k].rotation_counts, hands_[k].about.slip_counts);
    }
    return wanted;
}

void HandGrip::feel(const crn_wire_tick_state &state)
{
    const bool is_look = is_tense_ || state.tick % look_every_ticks == 0;
    if (!is_look) return;
    bool is_tense = false;
    for (std::size_t k = 0; k < std::min<std::size_t>(state.tools_count, hands_.size()); k++) {
        const crn_wire_tool_state &tool = state.tools[k];
        is_tense = is_tense || is_a_fifth(along, tool.handle_axial_N_q22) ||
                   is_a_fifth(about, tool.handle_torque_N_m_q24);
        const auto give = [&](Axis &axis, std::int64_t slip) {
            axis.slip_counts += slip;
            axis.way_counts += std::llabs(slip);
            if (slip != 0 && !hands_[k].first_tick) hands_[k].first_tick = state.tick;
        };
        give(hands_[k].along, slip_of(along, tool.handle_axial_N_q22));
        give(hands_[k].about, slip_of(about, tool.handle_torque_N_m_q24));
    }
    if (state.tick % look_every_ticks == 0) is_tense_ = is_tense;
}

GripFigures HandGrip::figures(std::size_t tool) const
{
    if (tool >= hands_.size()) return {};
    const Hand &hand = hands_[tool];
    return {static_cast<double>(hand.along.way_counts) * 1e-3,
            static_cast<double>(hand.about.way_counts) * 360.0 / 65536.0, hand.first_tick};
}

} // namespace crn
