// Simulates the grip of a hand that a script or the keys move. The grip is rigid up to the force that fingers
// can hold; beyond that, the tool slips. The device receives the position of the hand minus the slip, in
// encoder counts. So a recording includes the slip, and a replay does not need this code. The computation
// uses only integers, and the ticks at which it reads forces depend only on the forces. So a script's tools
// slip equally with and without pictures, in batches of any size, and on every machine.
#pragma once
#include "shared/wire/wire.h"
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace crn
{

// States how far one tool slipped in the grip, summed over both directions.
struct GripFigures {
    double slipped_mm = 0.0, slipped_deg = 0.0;
    std::optional<std::uint32_t> first_tick;
};

class HandGrip
{
  public:
    static constexpr std::int64_t force_limit_N = 25, torque_limit_mN_m = 50;
    // If a force is above a fifth of its limit, every tick is checked. Otherwise only the ticks that are
    // multiples of this number are checked.
    static constexpr std::uint32_t look_every_ticks = 16;
    static constexpr std::size_t tools_max = 3;

    // Returns the encoder counts for the device from the counts of hands without slip.
    crn_wire_tick_input hold(crn_wire_tick_input wanted) const;
    // If is_tense() returns true, ticks must be stepped one by one, and the result of each must be given to
    // feel() before the next input is made.
    bool is_tense() const { return is_tense_; }
    // Returns how many ticks from this one on may be stepped in one batch.
    std::uint32_t batch_max(std::uint32_t tick) const
    {
        return is_tense_ ? 1 : look_every_ticks - tick % look_every_ticks;
    }
    void feel(const crn_wire_tick_state &state); // every tick, in order
    GripFigures figures(std::size_t tool) const;

  private:
    struct Axis {
        std::int64_t slip_counts = 0, way_counts = 0; // present slip; sum of all slips
    };
    struct Hand {
        Axis along, about;
        std::optional<std::uint32_t> first_tick;
    };
    std::array<Hand, tools_max> hands_;
    bool is_tense_ = false;
};

} // namespace crn
