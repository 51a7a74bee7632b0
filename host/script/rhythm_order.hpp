// What heart and breath are asked for, one order per tick, as the wire's `encoders` carry it (docs/heart.md).
#pragma once
#include "shared/wire/wire.h"
#include <cstdint>
#include <deque>

namespace crn
{

struct RhythmOrder {
    std::uint8_t action = 0; // CRN_WIRE_RHYTHM_*
    std::uint16_t value = 0;

    bool operator==(const RhythmOrder &) const = default;
};

inline constexpr std::uint16_t premature_usual_milli = 600; // of the interval: when a premature beat comes

// Orders that wait for the ticks to come.
class RhythmOrders
{
  public:
    void add(const RhythmOrder &order) { waiting_.push_back(order); }
    void put_next(crn_wire_encoders &input) // into the next tick's input
    {
        if (waiting_.empty()) return;
        input.rhythm_action = waiting_.front().action;
        input.rhythm_value = waiting_.front().value;
        waiting_.pop_front();
    }

  private:
    std::deque<RhythmOrder> waiting_;
};

} // namespace crn
