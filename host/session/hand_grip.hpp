// Simulates how firmly a hand holds its tool; a script or the keys move this hand. The grip is rigid up to
// the force that fingers can hold; above this force, the tool slips in the hand. The device receives the
// position of the hand minus the slip, in encoder counts. A recording therefore includes the slip, and a
// replay does not need to compute it. The simulated grip uses only integers, and the ticks at which it reads
// forces depend only on the forces. The tools of a script therefore slip equally with and without pictures,
// in batches of any size, and on every machine.
#pragma once
#include "shared/wire/wire.h"
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace crn
{

// States how far one tool has slipped in the hand, as the sum of the slips in both directions.
struct GripFigures {
    double slipped_mm = 0.0, slipped_deg = 0.0;
    std::optional<std::uint32_t> first_tick;
};

class HandGrip
{
  public:
    static constexpr std::int64_t force_limit_N = 25, torque_limit_mN_m = 50;
    // If the force or torque on a hand is above a fifth of its limit, the grip is checked at every tick. If
    // both force and torque are at most a fifth of their limits, the grip is checked only at ticks that are
    // multiples of this number.
    static constexpr std::uint32_t look_every_ticks = 16;
    static constexpr std::size_t tools_max = 3;

    // Converts the positions of the hands to the encoder counts for the device, by subtracting the slip.
    crn_wire_tick_input hold(crn_wire_tick_input wanted) const;
    // If is_tense() returns true, the caller must step single ticks, and pass the result of each tick to
    // feel() before it makes the next input.
    bool is_tense() const { return is_tense_; }
    // Returns how many ticks, starting with this tick, may be stepped in one batch.
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
