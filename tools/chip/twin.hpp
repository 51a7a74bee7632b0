// One session on two devices: the core of this process computes every tick, and an emulated Cortex-M7
// computes and prices single ticks of it from the same state.
#pragma once
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/instrument.hpp"
#include "host/model/tool_line.hpp"
#include "host/session/recording.hpp"
#include "host/session/scene_file.hpp"
#include "tools/chip/device.hpp"
#include <optional>
#include <span>
#include <vector>

namespace chip
{

struct TwinSetUp {
    std::string scene;
    std::vector<crn::Instrument> tools;
    crn::LineNumbers line; // empty: all tools
    crn_wire_entry entry{};
    crn_wire_rig rig{};
};

struct PricedTick {
    crn_wire_tick_state state{}; // after the tick
    TickPrice price, around;     // around: the app's own work on the request that holds the tick
};

class Twin
{
  public:
    // Loads scene and tools into both. Throws LinkError, PriceError.
    Twin(ChipDevice &chip, const TwinSetUp &set_up);

    std::uint32_t tick() const { return here_.tick(); }
    // Computes ticks in this process alone.
    std::span<const crn_wire_tick_state> advance(std::span<const crn_wire_tick_input> inputs);
    // Computes two ticks on both, and prices the second. The first one fills the cache, and computes anew
    // what a state keeps between ticks. Returns nothing when the core does not restore the present state: it
    // refuses a tangent whose length is off by more than its bound, as hard jerks leave one. Throws
    // PriceError when the two states differ.
    std::optional<PricedTick> price(const crn_wire_tick_input &before, const crn_wire_tick_input &input);

  private:
    ChipDevice &chip_;
    crn::SceneFile scene_;
    crn::LineNumbers line_;
    crn::SimTransport here_pipe_;
    std::unique_ptr<crn::Transport> there_pipe_;
    crn::Link here_, there_;
};

TwinSetUp set_up_of(const crn::Recording &recording);

// Prices ticks of a recording; `ticks` ascends, and each is at least 2: the number of ticks done after it.
std::vector<PricedTick> price_recording(ChipDevice &chip, const crn::Recording &recording,
                                        const std::vector<std::uint32_t> &ticks);

} // namespace chip
