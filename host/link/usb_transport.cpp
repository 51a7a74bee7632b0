#include "host/link/usb_transport.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>
#include <chrono>
#include <libusb-1.0/libusb.h>

namespace crn
{

namespace
{

constexpr std::size_t ring_bytes = 1 << 20;
constexpr auto end_limit = std::chrono::seconds(5);

bool is_lost(int error)
{
    return error == LIBUSB_ERROR_NO_DEVICE || error == LIBUSB_ERROR_IO || error == LIBUSB_ERROR_PIPE;
}

int error_of(libusb_transfer_status status)
{
    switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
        return 0;
    case LIBUSB_TRANSFER_TIMED_OUT:
        return LIBUSB_ERROR_TIMEOUT;
    case LIBUSB_TRANSFER_CANCELLED:
        return LIBUSB_ERROR_INTERRUPTED;
    case LIBUSB_TRANSFER_STALL:
        return LIBUSB_ERROR_PIPE;
    case LIBUSB_TRANSFER_NO_DEVICE:
        return LIBUSB_ERROR_NO_DEVICE;
    case LIBUSB_TRANSFER_OVERFLOW:
        return LIBUSB_ERROR_OVERFLOW;
    default:
        return LIBUSB_ERROR_IO;
    }
}

// Holds the addresses of a vendor interface's bulk endpoints; 0 means that there is no such endpoint.
struct Pair {
    std::uint8_t in = 0, out = 0;
};

Pair pair_of(const libusb_interface_descriptor &interface)
{
    Pair pair;
    if (interface.bInterfaceClass != LIBUSB_CLASS_VENDOR_SPEC) return pair;
    for (int i = 0; i < interface.bNumEndpoints; i++) {
        const libusb_endpoint_descriptor &endpoint = interface.endpoint[i];
        if ((endpoint.bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
        (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN ? pair.in : pair.out) = endpoint.bEndpointAddress;
    }
    return pair;
}

} // namespace

UsbTransport::UsbTransport(const std::string &serial, const UsbLimits &limits)
    : limits_(limits), context_(usb_context()), handle_(usb_open(context_.get(), serial)), ring_(ring_bytes)
{
    find_stream();
    const int error = libusb_claim_interface(handle_.get(), interface_);
    if (error != 0) throw LinkError(usb_trouble(error, "the rig's stream"));
    try {
        begin_stream();
        make_slots();
        thread_ = std::thread([this] { serve(); });
        const std::lock_guard<std::mutex> hold(lock_);
        submit_reads();
    } catch (...) {
        end();
        throw;
    }
}

UsbTransport::~UsbTransport()
{
    end();
}

// --- opening ---

void UsbTransport::find_stream()
{
    libusb_config_descriptor *configuration = nullptr;
    libusb_device_descriptor descriptor{};
    libusb_device *device = libusb_get_device(handle_.get());
    libusb_get_device_descriptor(device, &descriptor);
    int error = 0;
    serial_ = usb_text(handle_.get(), descriptor.iSerialNumber, error);
    error = libusb_get_active_config_descriptor(device, &configuration);
    if (error != 0) throw LinkError(usb_trouble(error, "the rig's configuration"));
    for (int i = 0; i < configuration->bNumInterfaces; i++) {
        if (configuration->interface[i].num_altsetting < 1) continue;
        const Pair pair = pair_of(configuration->interface[i].altsetting[0]);
        if (pair.in == 0 || pair.out == 0) continue;
        interface_ = configuration->interface[i].altsetting[0].bInterfaceNumber;
        in_ = pair.in;
        out_ = pair.out;
    }
    libusb_free_config_descriptor(configuration);
    if (interface_ < 0) {
        throw LinkError(
            "the device '" + serial_ +
            "' has the rig's number but no vendor interface with a pair of bulk endpoints. Remedy: "
            "install this release's firmware, or unplug what uses the same test number");
    }
}

// Another program may have left bytes in the buffers, so both ends of the byte stream start again
// (docs/usb.md, "The stream").
void UsbTransport::begin_stream()
{
    for (const std::uint8_t endpoint : {out_, in_}) {
        const int error = libusb_clear_halt(handle_.get(), endpoint);
        if (error == LIBUSB_ERROR_NO_DEVICE) throw DeviceLost(usb_trouble(error, "the rig"));
        if (error != 0) throw LinkError(usb_trouble(error, "the rig's stream"));
    }
}

void UsbTransport::make_slots()
{
    for (std::size_t i = 0; i < in_count + out_count; i++) {
        auto slot = std::make_unique<Slot>();
        slot->owner = this;
        slot->transfer = libusb_alloc_transfer(0);
        if (slot->transfer == nullptr) throw std::bad_alloc();
        const bool reads = i < in_count;
        libusb_fill_bulk_transfer(slot->transfer, handle_.get(), reads ? in_ : out_, slot->bytes.data(),
                                  transfer_bytes, reads ? read_done : write_done, slot.get(),
                                  reads ? 0 : limits_.write_ms);
        (reads ? reads_ : writes_).push_back(std::move(slot));
    }
}

// --- the thread ---

void UsbTransport::serve()
{
    while (!is_over_) {
        timeval time{0, 100000};
        libusb_handle_events_timeout_completed(context_.get(), &time, nullptr);
    }
}

void UsbTransport::submit(Slot &slot)
{
    const int error = libusb_submit_transfer(slot.transfer);
    slot.is_flying = error == 0;
    if (error != 0 && failure_ == 0) failure_ = error;
}

// Submits as many USB reads as the ring buffer has space for. When the host does not read, the device must
// wait, and no byte is lost. USB transfers finish in the order in which they were submitted, so the program
// may use any free transfer next.
void UsbTransport::submit_reads()
{
    const auto flying = std::count_if(reads_.begin(), reads_.end(),
                                      [](const std::unique_ptr<Slot> &slot) { return slot->is_flying; });
    std::size_t promised = ring_count_ + static_cast<std::size_t>(flying) * transfer_bytes;
    for (const std::unique_ptr<Slot> &slot : reads_) {
        if (slot->is_flying || failure_ != 0 || is_ending_) continue;
        if (promised + transfer_bytes > ring_.size()) return;
        promised += transfer_bytes;
        submit(*slot);
    }
}

void UsbTransport::on_read_done(Slot &slot)
{
    const std::lock_guard<std::mutex> hold(lock_);
    slot.is_flying = false;
    const int error = error_of(slot.transfer->status);
    if (error != 0 && failure_ == 0) failure_ = error;
    // Bytes that arrived before a USB transfer ended with an error are kept too; the ring buffer has space
    // reserved for them.
    const std::size_t count =
        static_cast<std::size_t>(std::clamp<int>(slot.transfer->actual_length, 0, transfer_bytes));
    for (std::size_t i = 0; i < count && ring_count_ < ring_.size(); i++)
        ring_[(ring_begin_ + ring_count_++) % ring_.size()] = slot.bytes[i];
    submit_reads();
    changed_.notify_all();
}

void UsbTransport::on_write_done(Slot &slot)
{
    const std::lock_guard<std::mutex> hold(lock_);
    slot.is_flying = false;
    int error = error_of(slot.transfer->status);
    if (error == 0 && slot.transfer->actual_length != slot.transfer->length) error = LIBUSB_ERROR_IO;
    if (error != 0 && failure_ == 0) failure_ = error;
    changed_.notify_all();
}

// In this callback only a failure to lock the mutex could throw an exception. The caller of this callback is
// C code, through which no exception may pass, so an exception would end the program (noexcept).
void UsbTransport::read_done(libusb_transfer *transfer) noexcept
{
    Slot &slot = *static_cast<Slot *>(transfer->user_data);
    slot.owner->on_read_done(slot);
}

void UsbTransport::write_done(libusb_transfer *transfer) noexcept
{
    Slot &slot = *static_cast<Slot *>(transfer->user_data);
    slot.owner->on_write_done(slot);
}

// The thread that serves libusb receives the cancelled transfers and then ends. The memory of a transfer that
// libusb never returned is not freed, because the system could still write into this memory.
void UsbTransport::end()
{
    bool all_are_back = true;
    {
        std::unique_lock<std::mutex> hold(lock_);
        is_ending_ = true;
        for (auto *slots : {&reads_, &writes_}) {
            for (const std::unique_ptr<Slot> &slot : *slots)
                if (slot->is_flying) libusb_cancel_transfer(slot->transfer);
        }
        const auto is_back = [](const std::unique_ptr<Slot> &slot) { return !slot->is_flying; };
        all_are_back = !thread_.joinable() || wait(hold, end_limit, [&] {
            return std::all_of(reads_.begin(), reads_.end(), is_back) &&
                   std::all_of(writes_.begin(), writes_.end(), is_back);
        });
    }
    is_over_ = true;
    libusb_interrupt_event_handler(context_.get());
    if (thread_.joinable()) thread_.join();
    for (auto *slots : {&reads_, &writes_}) {
        for (std::unique_ptr<Slot> &slot : *slots) {
            if (!slot->is_flying)
                libusb_free_transfer(slot->transfer);
            else
                static_cast<void>(slot.release());
        }
        slots->clear();
    }
    if (interface_ >= 0 && all_are_back) libusb_release_interface(handle_.get(), interface_);
}

// --- the caller's side ---

void UsbTransport::throw_failure() const
{
    const std::string who = name();
    if (failure_ == LIBUSB_ERROR_TIMEOUT && is_interrupted())
        throw LinkError(who + " took no bytes before Ctrl-C");
    if (failure_ == LIBUSB_ERROR_TIMEOUT) {
        throw LinkError(who + " took no bytes for " + std::to_string(limits_.write_ms) +
                        " ms. Remedy: plug it out and in; report it with the firmware's release");
    }
    if (failure_ == LIBUSB_ERROR_OVERFLOW) {
        throw LinkError(who + " sent a longer packet than its endpoint has (" + libusb_error_name(failure_) +
                        "). Remedy: install this release's firmware");
    }
    if (is_lost(failure_)) {
        throw DeviceLost(who + " is gone or started anew (" + libusb_error_name(failure_) +
                         "). Remedy: check cable and power");
    }
    throw LinkError(usb_trouble(failure_, who));
}

// The caller waits in short periods, because a signal does not wake a thread that waits for a condition
// variable.
bool UsbTransport::wait(std::unique_lock<std::mutex> &hold, std::chrono::milliseconds limit,
                        const std::function<bool()> &is_done)
{
    using Steady = std::chrono::steady_clock;
    constexpr auto slice = std::chrono::milliseconds(50);
    Steady::time_point end = Steady::now() + limit;
    bool was_interrupted = false;
    while (!is_done()) {
        if (Steady::now() >= end) return false;
        changed_.wait_until(hold, std::min(end, Steady::now() + slice));
        if (was_interrupted || !is_interrupted()) continue;
        was_interrupted = true;
        end = std::min(end, Steady::now() + std::chrono::milliseconds(after_interrupt_ms));
    }
    return true;
}

void UsbTransport::write(std::span<const std::uint8_t> bytes)
{
    std::unique_lock<std::mutex> hold(lock_);
    takes_only_what_came_ = false;
    while (!bytes.empty()) {
        Slot *free = nullptr;
        const auto find = [&] {
            const auto slot = std::find_if(writes_.begin(), writes_.end(),
                                           [](const std::unique_ptr<Slot> &one) { return !one->is_flying; });
            free = slot == writes_.end() ? nullptr : slot->get();
            return free != nullptr || failure_ != 0;
        };
        // libusb ends each transfer after write_ms. If twice write_ms passes without a result, the thread
        // that serves libusb is not running.
        if (!wait(hold, std::chrono::milliseconds(2 * limits_.write_ms), find))
            failure_ = LIBUSB_ERROR_TIMEOUT;
        if (failure_ != 0) throw_failure();
        const std::size_t count = std::min(bytes.size(), transfer_bytes);
        std::copy_n(bytes.begin(), count, free->bytes.begin());
        free->transfer->length = static_cast<int>(count);
        bytes = bytes.subspan(count);
        submit(*free);
        if (failure_ != 0) throw_failure();
    }
}

void UsbTransport::flush()
{
    std::unique_lock<std::mutex> hold(lock_);
    const auto is_done = [&] {
        return failure_ != 0 ||
               std::none_of(writes_.begin(), writes_.end(),
                            [](const std::unique_ptr<Slot> &slot) { return slot->is_flying; });
    };
    if (!wait(hold, std::chrono::milliseconds(2 * limits_.write_ms), is_done))
        failure_ = LIBUSB_ERROR_TIMEOUT;
    if (failure_ != 0) throw_failure();
}

std::size_t UsbTransport::read(std::span<std::uint8_t> bytes)
{
    std::unique_lock<std::mutex> hold(lock_);
    const auto limit = std::chrono::milliseconds(takes_only_what_came_ ? 0 : limits_.read_ms);
    wait(hold, limit, [&] { return ring_count_ > 0 || failure_ != 0; });
    if (ring_count_ == 0 && failure_ != 0) throw_failure();
    const std::size_t count = std::min(bytes.size(), ring_count_);
    const std::size_t first = std::min(count, ring_.size() - ring_begin_);
    std::copy_n(ring_.begin() + static_cast<std::ptrdiff_t>(ring_begin_), first, bytes.begin());
    std::copy_n(ring_.begin(), count - first, bytes.begin() + static_cast<std::ptrdiff_t>(first));
    ring_begin_ = (ring_begin_ + count) % ring_.size();
    ring_count_ -= count;
    submit_reads();
    return count;
}

void UsbTransport::pass_time_ms(std::uint32_t milliseconds)
{
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    takes_only_what_came_ = true;
}

} // namespace crn
