#include "host/link/usb_devices.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>
#include <array>
#include <chrono>
#include <libusb-1.0/libusb.h>
#include <span>
#include <thread>

namespace crn
{

namespace
{

using Clock = std::chrono::steady_clock;
constexpr std::uint32_t look_again_ms = 200;

// Holds the list of devices that libusb returned, and frees the list in the destructor.
class DeviceList
{
  public:
    explicit DeviceList(libusb_context *context) : count_(libusb_get_device_list(context, &list_))
    {
        if (count_ < 0) throw LinkError(usb_trouble(static_cast<int>(count_), "the list of USB devices"));
    }
    ~DeviceList() { libusb_free_device_list(list_, 1); }
    DeviceList(const DeviceList &) = delete;
    DeviceList &operator=(const DeviceList &) = delete;
    libusb_device **begin() const { return list_; }
    libusb_device **end() const { return list_ + count_; }

  private:
    libusb_device **list_ = nullptr;
    ssize_t count_ = 0;
};

bool is_rig(libusb_device *device)
{
    libusb_device_descriptor descriptor;
    return libusb_get_device_descriptor(device, &descriptor) == 0 && descriptor.idVendor == usb_vendor_id &&
           descriptor.idProduct == usb_product_id;
}

std::string place_of(libusb_device *device)
{
    std::string text = "bus " + std::to_string(libusb_get_bus_number(device)) + ", address " +
                       std::to_string(libusb_get_device_address(device));
    std::uint8_t ports[8];
    const int count = libusb_get_port_numbers(device, ports, sizeof ports);
    for (int i = 0; i < count; i++) text += (i == 0 ? ", port " : ".") + std::to_string(ports[i]);
    return text;
}

// libusb's own function waits 1 s for each text string, although USB 2.0 allows a device only half a second
// (9.2.6.4).
int string_descriptor(libusb_device_handle *handle, std::uint8_t index, std::uint16_t language,
                      std::span<unsigned char> bytes)
{
    constexpr std::uint8_t get_descriptor = 6, string_type = 3;
    constexpr unsigned limit_ms = 700;
    if (is_interrupted()) return LIBUSB_ERROR_INTERRUPTED;
    const int length = libusb_control_transfer(
        handle, LIBUSB_ENDPOINT_IN, get_descriptor, static_cast<std::uint16_t>(string_type << 8 | index),
        language, bytes.data(), static_cast<std::uint16_t>(bytes.size()), limit_ms);
    if (length < 0) return length;
    const int count = std::min({length, static_cast<int>(bytes.size()), int{bytes[0]}});
    return length >= 2 && bytes[1] == string_type ? count : 0;
}

struct Opened {
    UsbRig rig;
    UsbHandle handle;
    int error = 0;
};

Opened open_one(libusb_device *device)
{
    Opened opened;
    libusb_device_descriptor descriptor{};
    libusb_get_device_descriptor(device, &descriptor);
    opened.rig.place = place_of(device);
    opened.rig.release_bcd = descriptor.bcdDevice;
    libusb_device_handle *handle = nullptr;
    opened.error = libusb_open(device, &handle);
    if (opened.error != 0) {
        opened.rig.trouble = usb_trouble(opened.error, "the rig at " + opened.rig.place);
        return opened;
    }
    opened.handle.reset(handle);
    int error = 0;
    opened.rig.serial = usb_text(handle, descriptor.iSerialNumber, error);
    if (error != LIBUSB_ERROR_TIMEOUT) opened.rig.product = usb_text(handle, descriptor.iProduct, error);
    if (error != LIBUSB_ERROR_TIMEOUT && error != LIBUSB_ERROR_INTERRUPTED) return opened;
    // A device that does not answer the request for its name will not answer other requests either, and each
    // request would take the same time.
    opened.error = error;
    opened.rig.trouble = usb_trouble(error, "the rig at " + opened.rig.place);
    return opened;
}

std::string list_of(const std::vector<UsbRig> &rigs)
{
    std::string text;
    for (const UsbRig &rig : rigs) {
        text += "\n  " + (rig.serial.empty() ? "(serial unknown)" : rig.serial) + " at " + rig.place +
                (rig.trouble.empty() ? "" : ": " + rig.trouble);
    }
    return text;
}

std::string id_text()
{
    return formatted("%04x:%04x", unsigned{usb_vendor_id}, unsigned{usb_product_id});
}

int LIBUSB_CALL on_plug(libusb_context *, libusb_device *, libusb_hotplug_event, void *changed) noexcept
{
    *static_cast<int *>(changed) = 1;
    return 0;
}

} // namespace

void UsbContextEnd::operator()(libusb_context *context) const
{
    libusb_exit(context);
}

void UsbHandleEnd::operator()(libusb_device_handle *handle) const
{
    libusb_close(handle);
}

std::string usb_text(libusb_device_handle *handle, std::uint8_t index, int &error)
{
    std::array<unsigned char, 255> bytes;
    error = 0;
    if (index == 0) return "";
    int count = string_descriptor(handle, 0, 0, bytes);
    if (count >= 4)
        count = string_descriptor(handle, index, static_cast<std::uint16_t>(bytes[2] | bytes[3] << 8), bytes);
    error = std::min(count, 0);
    std::string text; // UTF-16, little-endian
    for (int i = 2; i + 1 < count; i += 2) {
        const auto at = static_cast<std::size_t>(i);
        const bool is_plain = bytes[at + 1] == 0 && bytes[at] >= 0x20 && bytes[at] < 0x7f;
        text += is_plain ? static_cast<char>(bytes[at]) : '?';
    }
    return text;
}

std::string usb_trouble(int error, const std::string &what)
{
    const std::string name = std::string(" (") + libusb_error_name(error) + ")";
    switch (error) {
    case LIBUSB_ERROR_ACCESS:
        return what + " may not be opened by this user" + name +
               ". Remedy: sudo make install-udev, then plug the rig in again (docs/rig.md)";
    case LIBUSB_ERROR_BUSY:
        return what + " is used by another program" + name + ". Remedy: end that program; one host at a time";
    case LIBUSB_ERROR_NO_DEVICE:
        return what + " is gone" + name + ". Remedy: check cable and power of the rig";
    case LIBUSB_ERROR_NOT_SUPPORTED:
        return what + " has no driver that libusb can use" + name +
               ". Remedy: on Windows let it install WinUSB (docs/rig.md)";
    case LIBUSB_ERROR_TIMEOUT:
        return what + " does not answer" + name +
               ". Remedy: plug the rig out and in; if it stays so, use another firmware";
    case LIBUSB_ERROR_INTERRUPTED:
        return what + " was not read: Ctrl-C";
    case LIBUSB_ERROR_PIPE:
        return what + " refuses" + name +
               ". Remedy: plug the rig out and in; install the same release on both";
    default:
        return what + " does not work" + name +
               ". Remedy: plug the rig out and in; try another port or cable";
    }
}

UsbContext usb_context()
{
    libusb_context *context = nullptr;
    const int error = libusb_init(&context);
    if (error != 0) throw LinkError(usb_trouble(error, "USB on this machine"));
    return UsbContext(context);
}

std::vector<UsbRig> usb_rigs(libusb_context *context)
{
    std::vector<UsbRig> rigs;
    for (libusb_device *device : DeviceList(context)) {
        if (is_rig(device)) rigs.push_back(open_one(device).rig);
    }
    return rigs;
}

UsbHandle usb_open(libusb_context *context, const std::string &serial)
{
    std::vector<Opened> found;
    std::vector<UsbRig> rigs;
    const DeviceList list(context);
    for (libusb_device *device : list) {
        if (!is_rig(device)) continue;
        Opened opened = open_one(device);
        rigs.push_back(opened.rig);
        // A rig that this user may not open has no known serial number. If no other rig has the wanted serial
        // number, this rig could have it.
        if (serial.empty() || opened.rig.serial == serial) found.push_back(std::move(opened));
    }
    if (found.size() == 1 && found[0].error == 0) return std::move(found[0].handle);
    if (found.size() == 1) throw LinkError(found[0].rig.trouble);
    if (found.size() > 1) {
        throw LinkError("several rigs are there" + list_of(rigs) +
                        "\nRemedy: name one by its serial number, --device usb:SERIAL");
    }
    if (rigs.empty()) {
        throw DeviceLost("no rig is on USB (looked for " + id_text() +
                         "). Remedy: check cable and power; cournand rig list");
    }
    throw DeviceLost("no rig has the serial number '" + serial + "'; there are" + list_of(rigs) +
                     "\nRemedy: name one of these, or check the cable of the other");
}

UsbWatch::UsbWatch(bool forces_polling) : context_(usb_context())
{
    if (forces_polling || libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) return;
    const int events = LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT;
    is_told_ =
        libusb_hotplug_register_callback(context_.get(), static_cast<libusb_hotplug_event>(events),
                                         static_cast<libusb_hotplug_flag>(0), usb_vendor_id, usb_product_id,
                                         LIBUSB_HOTPLUG_MATCH_ANY, on_plug, &changed_, &callback_) == 0;
}

UsbWatch::~UsbWatch()
{
    if (is_told_) libusb_hotplug_deregister_callback(context_.get(), callback_);
}

void UsbWatch::wait_ms(std::uint32_t milliseconds)
{
    if (!is_told_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(std::min(milliseconds, look_again_ms)));
        return;
    }
    // If a rig is plugged in or unplugged between two waits, the next wait ends at once. Each wait for the
    // USB bus is short, so that Ctrl-C works soon.
    const std::uint32_t wait = std::min(milliseconds, look_again_ms);
    timeval time{0, static_cast<suseconds_t>(wait * 1000)};
    libusb_handle_events_timeout_completed(context_.get(), &time, &changed_);
    changed_ = 0;
}

bool UsbWatch::wait_for(const std::string &serial, std::uint32_t milliseconds,
                        const std::function<bool()> &is_cancelled)
{
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(milliseconds);
    for (;;) {
        // A libusb context learns of new devices from the system's device manager, which a container may not
        // have. A new libusb context scans the bus itself.
        const UsbContext fresh = usb_context();
        for (const UsbRig &rig : usb_rigs(fresh.get())) {
            if (rig.trouble.empty() && (serial.empty() || rig.serial == serial)) return true;
        }
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        if (left <= 0 || is_cancelled()) return false;
        wait_ms(static_cast<std::uint32_t>(left));
    }
}

} // namespace crn
