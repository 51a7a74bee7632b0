#include "host/library/handles.hpp"
#include <mutex>
#include <shared_mutex>
#include <vector>

namespace crn::library
{

namespace
{

// A handle consists of three numbers, from the lowest bit: the number of its slot plus 1, its kind, and how
// often the slot has been used.
constexpr int slot_bits = 20, kind_bits = 4;
constexpr std::uintptr_t slot_mask = (std::uintptr_t{1} << slot_bits) - 1;

struct Slot {
    std::uintptr_t handle = 0; // 0: free
    std::uintptr_t uses = 0;
    std::shared_ptr<void> object;
};

struct Table {
    std::shared_mutex mutex;
    std::vector<Slot> slots;
    std::vector<std::size_t> free;
};

// The table of handles is never destroyed, because a handle may still be freed while the program ends.
Table &table()
{
    static Table *const kept = new Table;
    return *kept;
}

Slot *slot_of(Table &in, HandleKind kind, std::uintptr_t handle)
{
    const std::uintptr_t number = handle & slot_mask;
    if (number == 0 || number > in.slots.size()) return nullptr;
    Slot &slot = in.slots[number - 1];
    const bool is_kind = (handle >> slot_bits & ((1u << kind_bits) - 1)) == static_cast<std::uintptr_t>(kind);
    return slot.handle == handle && is_kind ? &slot : nullptr;
}

} // namespace

std::uintptr_t add_handle(HandleKind kind, std::shared_ptr<void> object)
{
    Table &in = table();
    const std::unique_lock lock(in.mutex);
    if (in.free.empty()) {
        if (in.slots.size() == slot_mask)
            throw Refused(COURNAND_NO_MEMORY, "there are a million handles: free some");
        in.free.reserve(in.slots.size() + 1); // so that remove_handle cannot fail
        in.slots.emplace_back();
        in.free.push_back(in.slots.size() - 1);
    }
    const std::size_t number = in.free.back();
    in.free.pop_back();
    Slot &slot = in.slots[number];
    slot.handle = ++slot.uses << (slot_bits + kind_bits) | static_cast<std::uintptr_t>(kind) << slot_bits |
                  static_cast<std::uintptr_t>(number + 1);
    slot.object = std::move(object);
    return slot.handle;
}

std::shared_ptr<void> find_handle(HandleKind kind, std::uintptr_t handle)
{
    Table &in = table();
    const std::shared_lock lock(in.mutex);
    const Slot *slot = slot_of(in, kind, handle);
    return slot ? slot->object : nullptr;
}

std::shared_ptr<void> remove_handle(HandleKind kind, std::uintptr_t handle)
{
    Table &in = table();
    const std::unique_lock lock(in.mutex);
    Slot *slot = slot_of(in, kind, handle);
    if (!slot) return nullptr;
    slot->handle = 0;
    in.free.push_back(static_cast<std::size_t>(slot - in.slots.data()));
    return std::move(slot->object); // destroyed by the caller, outside of the lock
}

} // namespace crn::library
