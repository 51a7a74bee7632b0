#include "host/model/order_queue.hpp"

namespace crn
{

const crn_wire_order *order_of(const crn_wire_order_list &list, std::uint8_t kind)
{
    for (const crn_wire_order &order : orders_of(list))
        if (order.kind == kind) return &order;
    return nullptr;
}

void OrderQueue::move_into(crn_wire_order_list &list)
{
    for (std::size_t i = 0; i < waiting_.size() && list.items_count < CRN_WIRE_MAX_order_list_items;) {
        if (order_of(list, waiting_[i].kind)) {
            i++;
            continue;
        }
        list.items[list.items_count++] = waiting_[i];
        waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

} // namespace crn
