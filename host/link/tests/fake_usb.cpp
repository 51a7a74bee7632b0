#include "host/link/tests/fake_usb.hpp"
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <libusb-1.0/libusb.h>
#include <list>
#include <mutex>
#include <thread>

struct libusb_device {
    fake_usb::Rig *rig;
    std::uint32_t generation; // number of times it has been plugged in
};
struct libusb_device_handle {
    libusb_device *device;
    libusb_context *context;
};
struct libusb_context {
    libusb_hotplug_callback_fn callback = nullptr;
    void *user = nullptr;
    std::vector<std::pair<libusb_device *, libusb_hotplug_event>> plugs; // not reported yet
    bool is_woken = false;
};

namespace
{

using Clock = std::chrono::steady_clock;

struct Flight {
    libusb_transfer *transfer;
    Clock::time_point end; // end of its time limit
    bool is_cancelled = false;
};

struct Bus {
    std::mutex lock;
    std::condition_variable changed;
    std::list<fake_usb::Rig> rigs;
    std::list<libusb_device> devices; // kept for ever, because handles point to them
    std::vector<libusb_context *> contexts;
    std::vector<Flight> flights;
    std::size_t transfers = 0;
    bool is_told = true;
    std::uint32_t generation = 0;
};

Bus bus;

fake_usb::Rig *find(const std::string &serial)
{
    for (fake_usb::Rig &rig : bus.rigs)
        if (rig.serial == serial) return &rig;
    return nullptr;
}

libusb_device *device_of(fake_usb::Rig &rig)
{
    for (libusb_device &device : bus.devices)
        if (device.rig == &rig && device.generation != 0) return &device;
    return nullptr;
}

void tell(libusb_device *device, libusb_hotplug_event event)
{
    for (libusb_context *context : bus.contexts)
        if (context->callback != nullptr) context->plugs.push_back({device, event});
    bus.changed.notify_all();
}

void pull(fake_usb::Rig &rig)
{
    if (!rig.is_plugged) return;
    libusb_device *device = device_of(rig);
    rig.is_plugged = false;
    rig.is_claimed = false;
    device->generation = 0; // invalidates its handles
    tell(device, LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT);
}

// Decides whether a USB transfer is finished now, and with which status.
bool is_done(Flight &flight, libusb_transfer_status &status)
{
    libusb_transfer *transfer = flight.transfer;
    libusb_device *device = transfer->dev_handle->device;
    fake_usb::Rig &rig = *device->rig;
    transfer->actual_length = 0;
    if (device->generation == 0) return status = LIBUSB_TRANSFER_NO_DEVICE, true;
    if (flight.is_cancelled) return status = LIBUSB_TRANSFER_CANCELLED, true;
    status = LIBUSB_TRANSFER_COMPLETED;
    if ((transfer->endpoint & LIBUSB_ENDPOINT_IN) == 0 && rig.takes_bytes) {
        int count = transfer->length;
        if (rig.unplug_after_bytes != 0 &&
            rig.out_bytes + static_cast<unsigned>(count) >= rig.unplug_after_bytes) {
            count = static_cast<int>(rig.unplug_after_bytes - rig.out_bytes);
            rig.unplug_after_bytes = 0;
            status = LIBUSB_TRANSFER_NO_DEVICE;
        }
        if (rig.take)
            rig.take({transfer->buffer, static_cast<std::size_t>(count)});
        else
            crn_sim_write(rig.sim, transfer->buffer, static_cast<std::size_t>(count));
        rig.out_bytes += static_cast<unsigned>(count);
        transfer->actual_length = count;
        if (status != LIBUSB_TRANSFER_COMPLETED) pull(rig);
        return true;
    }
    if ((transfer->endpoint & LIBUSB_ENDPOINT_IN) != 0 && rig.gives_bytes) {
        std::vector<std::uint8_t> bytes(
            std::min<std::size_t>(rig.in_bytes_max, static_cast<std::size_t>(transfer->length)));
        if (rig.flood_bytes > 0) {
            bytes.resize(std::min(bytes.size(), rig.flood_bytes));
            for (std::uint8_t &byte : bytes) byte = static_cast<std::uint8_t>(rig.flood_given++ * 7);
            rig.flood_bytes -= bytes.size();
        } else if (rig.give) {
            bytes.resize(rig.give(bytes));
        } else {
            bytes.resize(crn_sim_read(rig.sim, bytes.data(), bytes.size()));
        }
        if (bytes.empty() && rig.read_status == 0)
            return status = LIBUSB_TRANSFER_TIMED_OUT, transfer->timeout != 0 && Clock::now() >= flight.end;
        if (rig.spoil) rig.spoil(bytes);
        bytes.resize(std::min<std::size_t>(bytes.size(), static_cast<std::size_t>(transfer->length)));
        std::copy(bytes.begin(), bytes.end(), transfer->buffer);
        transfer->actual_length = static_cast<int>(bytes.size());
        status = static_cast<libusb_transfer_status>(rig.read_status);
        rig.read_status = 0;
        return true;
    }
    status = LIBUSB_TRANSFER_TIMED_OUT;
    return transfer->timeout != 0 && Clock::now() >= flight.end;
}

// Removes one finished USB transfer of this context from the list; each endpoint finishes its transfers in
// the order of submission.
libusb_transfer *take_done(libusb_context *context)
{
    std::vector<std::pair<libusb_device_handle *, unsigned char>> waits;
    for (auto flight = bus.flights.begin(); flight != bus.flights.end(); ++flight) {
        libusb_transfer *transfer = flight->transfer;
        if (transfer->dev_handle->context != context) continue;
        const std::pair<libusb_device_handle *, unsigned char> pipe{transfer->dev_handle, transfer->endpoint};
        const bool is_behind = std::find(waits.begin(), waits.end(), pipe) != waits.end();
        libusb_transfer_status status;
        if (is_behind && !flight->is_cancelled) continue;
        if (!is_done(*flight, status)) {
            waits.push_back(pipe);
            continue;
        }
        transfer->status = status;
        bus.flights.erase(flight);
        return transfer;
    }
    return nullptr;
}

} // namespace

namespace fake_usb
{

void reset()
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    for (Rig &rig : bus.rigs) crn_sim_destroy(rig.sim);
    bus.rigs.clear();
    bus.devices.clear();
    bus.is_told = true;
}

Rig &add(const std::string &serial)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    Rig &rig = bus.rigs.emplace_back();
    rig.serial = serial;
    rig.sim = crn_sim_create(1 << 20);
    bus.devices.push_back({&rig, ++bus.generation});
    return rig;
}

void unplug(const std::string &serial)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    pull(*find(serial));
}

void plug(const std::string &serial)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    Rig *rig = find(serial);
    if (rig->is_plugged) return;
    rig->is_plugged = true;
    bus.devices.push_back({rig, ++bus.generation});
    tell(&bus.devices.back(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED);
}

void set_hotplug(bool is_told)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    bus.is_told = is_told;
}

void change(const std::function<void()> &what)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    what();
}

std::size_t transfers()
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    return bus.transfers;
}

std::size_t contexts()
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    return bus.contexts.size();
}

} // namespace fake_usb

// --- libusb's names ---
extern "C" {

int LIBUSB_CALL libusb_init(libusb_context **context)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    *context = new libusb_context;
    bus.contexts.push_back(*context);
    return 0;
}

void LIBUSB_CALL libusb_exit(libusb_context *context)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    std::erase(bus.contexts, context);
    delete context;
}

const char *LIBUSB_CALL libusb_error_name(int error)
{
    switch (error) {
    case LIBUSB_ERROR_ACCESS:
        return "LIBUSB_ERROR_ACCESS";
    case LIBUSB_ERROR_BUSY:
        return "LIBUSB_ERROR_BUSY";
    case LIBUSB_ERROR_NO_DEVICE:
        return "LIBUSB_ERROR_NO_DEVICE";
    default:
        return "LIBUSB_ERROR";
    }
}

ssize_t LIBUSB_CALL libusb_get_device_list(libusb_context *, libusb_device ***list)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    auto **entries = new libusb_device *[bus.rigs.size() + 1];
    ssize_t count = 0;
    for (fake_usb::Rig &rig : bus.rigs)
        if (rig.is_plugged) entries[count++] = device_of(rig);
    entries[count] = nullptr;
    *list = entries;
    return count;
}

void LIBUSB_CALL libusb_free_device_list(libusb_device **list, int)
{
    delete[] list;
}

int LIBUSB_CALL libusb_get_device_descriptor(libusb_device *, libusb_device_descriptor *descriptor)
{
    *descriptor = {};
    descriptor->idVendor = 0x1209;
    descriptor->idProduct = 0x0001;
    descriptor->iProduct = 2;
    descriptor->iSerialNumber = 3;
    return 0;
}

uint8_t LIBUSB_CALL libusb_get_bus_number(libusb_device *)
{
    return 1;
}
uint8_t LIBUSB_CALL libusb_get_device_address(libusb_device *)
{
    return 4;
}
int LIBUSB_CALL libusb_get_port_numbers(libusb_device *, uint8_t *ports, int)
{
    ports[0] = 2;
    return 1;
}

int LIBUSB_CALL libusb_open(libusb_device *device, libusb_device_handle **handle)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    if (device->generation == 0) return LIBUSB_ERROR_NO_DEVICE;
    if (device->rig->open_error != 0) return device->rig->open_error;
    device->rig->opens++;
    // The tests open devices only in the libusb context that was made last.
    *handle = new libusb_device_handle{device, bus.contexts.back()};
    return 0;
}

void LIBUSB_CALL libusb_close(libusb_device_handle *handle)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    handle->device->rig->opens--;
    delete handle;
}

libusb_device *LIBUSB_CALL libusb_get_device(libusb_device_handle *handle)
{
    return handle->device;
}

// Answers the USB request GET_DESCRIPTOR for string 0 (the language), 2 (the product) and 3 (the serial
// number).
int LIBUSB_CALL libusb_control_transfer(libusb_device_handle *handle, uint8_t, uint8_t, uint16_t value,
                                        uint16_t, unsigned char *bytes, uint16_t capacity,
                                        unsigned int timeout_ms)
{
    std::unique_lock<std::mutex> hold(bus.lock);
    if (handle->device->generation == 0) return LIBUSB_ERROR_NO_DEVICE;
    fake_usb::Rig &rig = *handle->device->rig;
    if (!rig.answers_control) {
        hold.unlock();
        std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
        return LIBUSB_ERROR_TIMEOUT;
    }
    const std::string text = (value & 0xff) == 3 ? rig.serial : "Cournand rig";
    std::vector<unsigned char> all = {0, 3};
    if ((value & 0xff) == 0) {
        all.insert(all.end(), {0x09, 0x04});
    } else {
        for (const char one : text) all.insert(all.end(), {static_cast<unsigned char>(one), 0});
    }
    all[0] = static_cast<unsigned char>(all.size());
    const std::size_t count = std::min<std::size_t>(capacity, all.size());
    std::copy_n(all.begin(), count, bytes);
    return static_cast<int>(count);
}

int LIBUSB_CALL libusb_get_active_config_descriptor(libusb_device *device,
                                                    libusb_config_descriptor **configuration)
{
    static const libusb_endpoint_descriptor endpoints[2] = {{.bLength = 7,
                                                             .bDescriptorType = 5,
                                                             .bEndpointAddress = 0x82,
                                                             .bmAttributes = 2,
                                                             .wMaxPacketSize = 512,
                                                             .bInterval = 0,
                                                             .bRefresh = 0,
                                                             .bSynchAddress = 0,
                                                             .extra = nullptr,
                                                             .extra_length = 0},
                                                            {.bLength = 7,
                                                             .bDescriptorType = 5,
                                                             .bEndpointAddress = 0x02,
                                                             .bmAttributes = 2,
                                                             .wMaxPacketSize = 512,
                                                             .bInterval = 0,
                                                             .bRefresh = 0,
                                                             .bSynchAddress = 0,
                                                             .extra = nullptr,
                                                             .extra_length = 0}};
    static libusb_interface_descriptor stream{}, status{};
    static libusb_interface interfaces[2];
    static libusb_config_descriptor whole{};
    const std::lock_guard<std::mutex> hold(bus.lock);
    status.bInterfaceClass = 3;
    stream.bInterfaceNumber = 1;
    stream.bInterfaceClass = 0xff;
    stream.bNumEndpoints = device->rig->has_stream ? 2 : 0;
    stream.endpoint = endpoints;
    interfaces[0] = {&status, 1};
    interfaces[1] = {&stream, 1};
    whole.bNumInterfaces = 2;
    whole.interface = interfaces;
    *configuration = &whole;
    return 0;
}

void LIBUSB_CALL libusb_free_config_descriptor(libusb_config_descriptor *) {}

int LIBUSB_CALL libusb_claim_interface(libusb_device_handle *handle, int)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    if (handle->device->generation == 0) return LIBUSB_ERROR_NO_DEVICE;
    if (handle->device->rig->claim_error != 0) return handle->device->rig->claim_error;
    if (handle->device->rig->is_claimed) return LIBUSB_ERROR_BUSY;
    handle->device->rig->is_claimed = true;
    return 0;
}

int LIBUSB_CALL libusb_release_interface(libusb_device_handle *handle, int)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    if (handle->device->generation != 0) handle->device->rig->is_claimed = false;
    return 0;
}

int LIBUSB_CALL libusb_clear_halt(libusb_device_handle *handle, unsigned char endpoint)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    if (handle->device->generation == 0) return LIBUSB_ERROR_NO_DEVICE;
    static const std::uint8_t zero = 0; // the stream restarts: docs/usb.md
    if ((endpoint & LIBUSB_ENDPOINT_IN) == 0) crn_sim_write(handle->device->rig->sim, &zero, 1);
    return 0;
}

libusb_transfer *LIBUSB_CALL libusb_alloc_transfer(int)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    bus.transfers++;
    return new libusb_transfer{};
}

void LIBUSB_CALL libusb_free_transfer(libusb_transfer *transfer)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    bus.transfers--;
    delete transfer;
}

int LIBUSB_CALL libusb_submit_transfer(libusb_transfer *transfer)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    if (transfer->dev_handle->device->generation == 0) return LIBUSB_ERROR_NO_DEVICE;
    bus.flights.push_back({transfer, Clock::now() + std::chrono::milliseconds(transfer->timeout), false});
    bus.changed.notify_all();
    return 0;
}

int LIBUSB_CALL libusb_cancel_transfer(libusb_transfer *transfer)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    for (Flight &flight : bus.flights) {
        if (flight.transfer != transfer) continue;
        flight.is_cancelled = true;
        bus.changed.notify_all();
        return 0;
    }
    return LIBUSB_ERROR_NOT_FOUND;
}

void LIBUSB_CALL libusb_interrupt_event_handler(libusb_context *context)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    context->is_woken = true;
    bus.changed.notify_all();
}

int LIBUSB_CALL libusb_handle_events_timeout_completed(libusb_context *context, timeval *time, int *completed)
{
    const Clock::time_point end =
        Clock::now() + std::chrono::seconds(time->tv_sec) + std::chrono::microseconds(time->tv_usec);
    std::unique_lock<std::mutex> hold(bus.lock);
    while (Clock::now() < end && !context->is_woken && (completed == nullptr || *completed == 0)) {
        if (!context->plugs.empty()) {
            const auto plug = context->plugs.front();
            context->plugs.erase(context->plugs.begin());
            hold.unlock();
            context->callback(context, plug.first, plug.second, context->user);
            return 0;
        }
        if (libusb_transfer *transfer = take_done(context)) {
            hold.unlock();
            transfer->callback(transfer);
            return 0;
        }
        bus.changed.wait_until(hold, std::min(end, Clock::now() + std::chrono::milliseconds(1)));
    }
    context->is_woken = false;
    return 0;
}

int LIBUSB_CALL libusb_has_capability(uint32_t)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    return bus.is_told ? 1 : 0;
}

int LIBUSB_CALL libusb_hotplug_register_callback(libusb_context *context, int, int, int, int, int,
                                                 libusb_hotplug_callback_fn callback, void *user,
                                                 libusb_hotplug_callback_handle *handle)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    context->callback = callback;
    context->user = user;
    *handle = 1;
    return 0;
}

void LIBUSB_CALL libusb_hotplug_deregister_callback(libusb_context *context, libusb_hotplug_callback_handle)
{
    const std::lock_guard<std::mutex> hold(bus.lock);
    context->callback = nullptr;
}
}
