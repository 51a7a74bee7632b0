#include "tools/chip/drive.hpp"

namespace chip
{

namespace
{

constexpr std::int32_t feed_max = 400; // um in a tick: 0.4 m/s
constexpr std::int32_t turn_max = 125; // of 65,536 counts a turn, in a tick: 12 rad/s
constexpr std::int32_t pressure_max_kPa = 1400;

} // namespace

Drive::Drive(std::uint32_t seed, std::uint32_t tools, bool has_balloon)
    : engine_(seed * 2654435761u + 1), tools_(tools), has_balloon_(has_balloon)
{
    engine_.discard(16);
    push_ticks_ = static_cast<std::uint32_t>(between(3000, 7000));
    input_.hands_count = static_cast<std::uint16_t>(tools);
}

std::int32_t Drive::between(std::int32_t low, std::int32_t high)
{
    return low + static_cast<std::int32_t>(engine_() % static_cast<std::uint32_t>(high - low + 1));
}

void Drive::choose(std::uint32_t tool, bool pushes)
{
    Motion &motion = motions_[tool];
    motion.ticks_left = static_cast<std::uint32_t>(between(20, pushes ? 600 : 200));
    // while it pushes, the tool goes in three times as far as it goes back
    motion.feed = pushes ? between(-feed_max / 4, feed_max) : between(-feed_max, feed_max);
    motion.turn = between(-turn_max, turn_max);
    if (between(0, 3) == 0) motion.turn = 0;
}

const crn_wire_tick_input &Drive::next()
{
    const bool pushes = tick_ < push_ticks_;
    for (std::uint32_t k = 0; k < tools_; k++) {
        if (motions_[k].ticks_left == 0) choose(k, pushes);
        motions_[k].ticks_left--;
        input_.hands[k].translation_counts += motions_[k].feed;
        input_.hands[k].rotation_counts += motions_[k].turn;
    }
    if (has_balloon_ && !pushes && tick_ % 500 == 0) input_.inflator_raw = between(0, pressure_max_kPa);
    tick_++;
    return input_;
}

} // namespace chip
