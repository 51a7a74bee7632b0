// The grip of a hand that a script or the keys move: rigid as far as fingers hold, then the tool slips
// through it. What a device is told is the wanted hand less what has slipped, in encoder counts, so a
// recording has the slip in it and a replay needs nothing of this. Integers only, and forces are looked at on
// ticks that depend on nothing but forces: the same script slips alike with and without pictures, in batches
// of any size, on every machine.
#pragma once
#include "shared/wire/wire.h"
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace crn
{

// How far one tool slipped through its hand, to and fro added up.
struct GripFigures {
    double slipped_mm = 0.0, slipped_deg = 0.0;
    std::optional<std::uint32_t> first_tick;
};

class HandGrip
{
  public:
    static constexpr std::int64_t force_limit_N = 25, torque_limit_mN_m = 50;
    // Above a fifth of a limit every tick is looked at, below it one in so many.
    static constexpr std::uint32_t look_every_ticks = 16;
    static constexpr std::size_t tools_max = 3;

    // The counts that a device is told for the hands that are wanted.
    crn_wire_encoders hold(crn_wire_encoders wanted) const;
    // The next ticks are stepped one by one, each result given to feel() before the next input is made.
    bool is_tense() const { return is_tense_; }
    // How many ticks may be stepped from this one on.
    std::uint32_t batch_max(std::uint32_t tick) const
    {
        return is_tense_ ? 1 : look_every_ticks - tick % look_every_ticks;
    }
    void feel(const crn_wire_tick_state &state); // every tick, in order
    GripFigures figures(std::size_t tool) const;

  private:
    struct Axis {
        std::int64_t slip_counts = 0, way_counts = 0; // where it is; added up
    };
    struct Hand {
        Axis along, about;
        std::optional<std::uint32_t> first_tick;
    };
    std::array<Hand, tools_max> hands_;
    bool is_tense_ = false;
};

} // namespace crn
