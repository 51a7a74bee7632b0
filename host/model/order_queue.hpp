// Holds commands for the core until a tick (millisecond) can accept them. A tick's list accepts only one
// command ("order") of each kind, as the core does (shared/wire/wire_orders.def). If there is a second
// command of the same kind, it waits for the next tick.
//
//   OrderQueue orders;
//   orders.add(crn_wire_order_of_rhythm({CRN_WIRE_RHYTHM_HEART_RATE, 90}));
//   crn_wire_tick_input input{};
//   orders.move_into(input.orders);
#pragma once
#include "shared/wire/wire.h"
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

namespace crn
{

// Returns the orders (commands for the core) that the list of one tick contains.
inline std::span<const crn_wire_order> orders_of(const crn_wire_order_list &list)
{
    return {list.items, list.items_count};
}
inline std::span<const crn_wire_order> orders_of(const crn_wire_tick_input &input)
{
    return orders_of(input.orders);
}

// Returns the command of this kind (CRN_WIRE_KIND_*) in a tick's list, or nullptr if the list has none.
const crn_wire_order *order_of(const crn_wire_order_list &list, std::uint8_t kind);

class OrderQueue
{
  public:
    void add(const crn_wire_order &order) { waiting_.push_back(order); }
    void clear() { waiting_.clear(); }
    bool is_empty() const { return waiting_.empty(); }
    const std::deque<crn_wire_order> &waiting() const { return waiting_; }
    // Moves into a tick's list the oldest waiting command of each kind that the list does not have yet.
    void move_into(crn_wire_order_list &list);

  private:
    std::deque<crn_wire_order> waiting_;
};

} // namespace crn
