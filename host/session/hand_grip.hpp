// The grip of a hand that a script or the keys move: rigid up to the force that fingers can hold, then the
// tool slips through it. The device receives the wanted hand less the slip, in encoder counts, so that a
// recording includes the slip and a replay does not need this code. It uses only integers, and the ticks at
// which it reads forces depend only on forces. So the same script slips alike with and without pictures, in
// batches of any size, on every machine.
#pragma once
#include "shared/wire/wire.h"
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace crn
{

// How far one tool slipped through its hand, both directions added up.
struct GripFigures {
    double slipped_mm = 0.0, slipped_deg = 0.0;
    std::optional<std::uint32_t> first_tick;
};

class HandGrip
{
  public:
    static constexpr std::int64_t force_limit_N = 25, torque_limit_mN_m = 50;
    // Above a fifth of a limit every tick is checked; below it, one tick in this many.
    static constexpr std::uint32_t look_every_ticks = 16;
    static constexpr std::size_t tools_max = 3;

    // Returns the counts for the device from those of the wanted hands.
    crn_wire_tick_input hold(crn_wire_tick_input wanted) const;
    // If true, the next ticks must be stepped one by one, and each result given to feel() before the next
    // input is made.
    bool is_tense() const { return is_tense_; }
    // Returns how many ticks may be stepped from this one on.
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
