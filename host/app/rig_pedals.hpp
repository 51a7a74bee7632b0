// The pedals of a rig: its button bits become commands to the room. May include: shared/wire, room/command.
// Called by: run_free, window_live.
#pragma once
#include "host/room/command.hpp"
#include "shared/wire/wire.h"
#include <vector>

namespace seld
{

class RigPedals
{
  public:
    // What changed since the last call: bit 0 is the X-ray pedal, bit 1 the cine pedal (docs/wire.md, `encoders`).
    std::vector<RoomCommand> changes(std::uint32_t buttons)
    {
        std::vector<RoomCommand> commands;
        const std::uint32_t changed = buttons ^ buttons_;
        buttons_ = buttons;
        if (changed & SELD_WIRE_BUTTON_XRAY)
            commands.push_back({RoomAction::fluoro_pedal, {(buttons & SELD_WIRE_BUTTON_XRAY) != 0, 0, 0}});
        if (changed & SELD_WIRE_BUTTON_CINE)
            commands.push_back({RoomAction::acquire_pedal, {(buttons & SELD_WIRE_BUTTON_CINE) != 0, 0, 0}});
        return commands;
    }

  private:
    std::uint32_t buttons_ = 0;
};

} // namespace seld
