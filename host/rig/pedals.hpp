// Converts the states of a rig's pedals and the counts of its syringe's plunger to commands for the X-ray
// room.
#pragma once
#include "host/room/command.hpp"
#include "shared/wire/wire.h"
#include <algorithm>
#include <optional>
#include <vector>

namespace crn
{

class RigPedals
{
  public:
    // Returns commands for those pedals whose state has changed since the last call. In `buttons`, bit 0 is
    // the X-ray pedal and bit 1 the cine pedal (docs/wire.md, `encoders`).
    std::vector<RoomCommand> changes(std::uint32_t buttons)
    {
        std::vector<RoomCommand> commands;
        const std::uint32_t changed = buttons ^ buttons_;
        buttons_ = buttons;
        if (changed & CRN_WIRE_BUTTON_XRAY)
            commands.push_back({RoomAction::fluoro_pedal, {(buttons & CRN_WIRE_BUTTON_XRAY) != 0, 0, 0}});
        if (changed & CRN_WIRE_BUTTON_CINE)
            commands.push_back({RoomAction::acquire_pedal, {(buttons & CRN_WIRE_BUTTON_CINE) != 0, 0, 0}});
        return commands;
    }

  private:
    std::uint32_t buttons_ = 0;
};

// Converts the motion of the syringe's plunger to injections: the volume displaced in 20 ms is injected
// during the next 20 ms. A count is 1 ul. Drawing back fills the syringe.
class RigSyringe
{
  public:
    static constexpr std::uint32_t window_ticks = 20;

    // Receives the position of the plunger in counts at `tick`. The counts may wrap round, and the first
    // received position is the zero of the plunger.
    std::optional<RoomCommand> change(std::uint32_t tick, std::int32_t counts)
    {
        const auto moved = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) -
                                                     static_cast<std::uint32_t>(counts_));
        counts_ = counts;
        if (!has_begun_) {
            has_begun_ = true;
            window_ = tick / window_ticks;
            return {};
        }
        // The program's limit for the flow is higher than the flow that a hand can inject with the syringe.
        // If the plunger seems to move faster than a hand can, its sensor has jumped, and nothing is
        // injected.
        if (moved > 0 && moved <= inject_rate_max_ul_s) volume_ul_ += moved;
        if (tick / window_ticks == window_) return {};
        window_ = tick / window_ticks;
        const std::int32_t volume_ul =
            std::min<std::int32_t>(volume_ul_, inject_rate_max_ul_s / (1000 / int{window_ticks}));
        volume_ul_ = 0;
        if (volume_ul == 0) return {};
        return RoomCommand{RoomAction::inject, {volume_ul, volume_ul * (1000 / int{window_ticks}), 0}};
    }

  private:
    bool has_begun_ = false;
    std::int32_t counts_ = 0, volume_ul_ = 0;
    std::uint32_t window_ = 0;
};

} // namespace crn
