// Rigs on USB: lists them, opens one by its serial number, and waits for one to be plugged in or unplugged.
#pragma once
#include "host/link/link.hpp"
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

struct libusb_context;
struct libusb_device_handle;

namespace crn
{

// The USB id of a rig; the firmware is built with the same one (make USB_ID=1209:0001).
#ifndef CRN_USB_VENDOR_ID
#define CRN_USB_VENDOR_ID 0x1209
#endif
#ifndef CRN_USB_PRODUCT_ID
#define CRN_USB_PRODUCT_ID 0x0001
#endif
inline constexpr std::uint16_t usb_vendor_id = CRN_USB_VENDOR_ID;
inline constexpr std::uint16_t usb_product_id = CRN_USB_PRODUCT_ID;

// The device disappeared in the middle of a conversation: cable, power, or a restart. It may come back.
class DeviceLost : public LinkError
{
  public:
    using LinkError::LinkError;
};

struct UsbRig {
    std::string place;   // "bus 1, address 4, port 2.1"
    std::string serial;  // empty when it could not be read
    std::string product; // likewise
    std::string trouble; // why it cannot be opened, and the remedy; empty: it can
    std::uint16_t release_bcd = 0;
};

struct UsbContextEnd {
    void operator()(libusb_context *context) const;
};
struct UsbHandleEnd {
    void operator()(libusb_device_handle *handle) const;
};
using UsbContext = std::unique_ptr<libusb_context, UsbContextEnd>;
using UsbHandle = std::unique_ptr<libusb_device_handle, UsbHandleEnd>;

// Throws LinkError when libusb cannot work on this machine.
UsbContext usb_context();
std::vector<UsbRig> usb_rigs(libusb_context *context);

// An empty `serial` means the only rig. Throws LinkError that lists the present rigs, or gives the remedy for
// a refusal; DeviceLost when there is none.
UsbHandle usb_open(libusb_context *context, const std::string &serial);

// Returns a string of the device, printable ASCII only: it is shown on terminals, and a device may send
// anything. `error` gets libusb's code when the device does not send the string, otherwise 0.
std::string usb_text(libusb_device_handle *handle, std::uint8_t index, int &error);

// Returns "ACCESS: the rig ... may not be opened by this user; ..." for a libusb error code.
std::string usb_trouble(int error, const std::string &what);

// Hot plug: the system reports it where it can; otherwise polling 5 times a second finds it.
class UsbWatch
{
  public:
    explicit UsbWatch(bool forces_polling = false);
    ~UsbWatch();
    UsbWatch(const UsbWatch &) = delete;
    UsbWatch &operator=(const UsbWatch &) = delete;
    bool is_told() const { return is_told_; } // false: it polls
    // Returns when a rig was plugged in or out, when it is time to poll, or when the time is over; never
    // later.
    void wait_ms(std::uint32_t milliseconds);
    std::vector<UsbRig> rigs() const { return usb_rigs(context_.get()); }
    // Waits until that rig is there and can be opened. Returns false when the time is over, or when
    // `is_cancelled` returned true.
    bool wait_for(const std::string &serial, std::uint32_t milliseconds,
                  const std::function<bool()> &is_cancelled);

  private:
    UsbContext context_;
    bool is_told_ = false;
    int callback_ = 0;
    int changed_ = 0; // set by libusb, inside wait_ms
};

} // namespace crn
