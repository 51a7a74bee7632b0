#include "host/link/emulated_transport.hpp"
#include "host/link/link.hpp"
#include <algorithm>

namespace crn
{

namespace
{

constexpr std::uint32_t ring_mask = RIG_RING_BYTES - 1;

} // namespace

EmulatedTransport::EmulatedTransport(Emulator &emulator, std::function<void(std::uint32_t)> pass_time)
    : emulator_(emulator), pass_time_(std::move(pass_time)), boot_count_(emulator.boot_count())
{
}

// A device that has restarted has no memory of the earlier conversation. After a restart of the device, the
// next call throws an error once, and later calls communicate with the restarted device.
void EmulatedTransport::check_life()
{
    const std::uint32_t boots = emulator_.boot_count();
    if (boots == boot_count_) return;
    boot_count_ = boots;
    throw LinkError("the device started again; begin with HELLO");
}

void EmulatedTransport::write(std::span<const std::uint8_t> bytes)
{
    check_life();
    rig_page &page = emulator_.page();
    std::uint32_t head = page.host.to_device_head;
    const auto room = [&] { return RIG_RING_BYTES - (head - rig_read(&page.device.to_device_tail)); };
    // If a frame fits into the ring buffer, the host announces all its bytes at once. The device therefore
    // never begins to process an incomplete frame of data.
    while (!bytes.empty()) {
        const std::size_t wanted = std::min<std::size_t>(bytes.size(), RIG_RING_BYTES / 2);
        emulator_.wait([&] { return room() >= wanted; }, "room in the device's ring");
        for (std::size_t i = 0; i < wanted; i++) page.to_device[(head + i) & ring_mask] = bytes[i];
        head += static_cast<std::uint32_t>(wanted);
        rig_write(&page.host.to_device_head, head);
        bytes = bytes.subspan(wanted);
    }
}

std::size_t EmulatedTransport::read(std::span<std::uint8_t> bytes)
{
    check_life();
    rig_page &page = emulator_.page();
    const std::uint32_t tail = page.host.to_host_tail;
    std::uint32_t count = 0;
    emulator_.wait(
        [&] {
            const bool is_idle = rig_read(&page.device.to_device_tail) == page.host.to_device_head;
            count = rig_read(&page.device.to_host_head) -
                    tail; // read after the line above: the output from before the idle state
            return count > 0 || is_idle;
        },
        "an answer");
    if (count > RIG_RING_BYTES) throw LinkError("the device's ring is out of its bounds");
    count = static_cast<std::uint32_t>(std::min<std::size_t>(count, bytes.size()));
    for (std::uint32_t i = 0; i < count; i++) bytes[i] = page.to_host[(tail + i) & ring_mask];
    rig_write(&page.host.to_host_tail, tail + count);
    return count;
}

void EmulatedTransport::pass_time_ms(std::uint32_t milliseconds)
{
    if (pass_time_) pass_time_(milliseconds);
}

EmulatedDevice::EmulatedDevice(const EmulatorOptions &options) : emulator_(options), pipe_(emulator_)
{
    pass_time_ms(1); // the first sample of the rig
}

void EmulatedDevice::pass_time_ms(std::uint32_t milliseconds)
{
    rig_page &page = emulator_.page();
    for (std::uint32_t i = 0; i < milliseconds; i++) {
        page.host.milliseconds++;
        const std::uint32_t edge = page.host.edge + 1;
        rig_write(&page.host.edge, edge);
        emulator_.wait([&] { return rig_read(&page.device.edge_done) == edge; }, "a tick");
    }
}

} // namespace crn
