// Lists the rigs on USB, opens a rig by its serial number, and waits until a rig is plugged in or unplugged.
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

// Defines the USB id of a rig, with which the firmware is built as well (make USB_ID=1209:0001).
#ifndef CRN_USB_VENDOR_ID
#define CRN_USB_VENDOR_ID 0x1209
#endif
#ifndef CRN_USB_PRODUCT_ID
#define CRN_USB_PRODUCT_ID 0x0001
#endif
inline constexpr std::uint16_t usb_vendor_id = CRN_USB_VENDOR_ID;
inline constexpr std::uint16_t usb_product_id = CRN_USB_PRODUCT_ID;

// DeviceLost means that the device disappeared during a conversation because of its cable, its power, or a
// restart. It may come back.
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

// An empty `serial` selects the only rig that is plugged in. Throws a LinkError that lists the present rigs
// or gives the remedy for a refusal; throws DeviceLost when no rig is plugged in.
UsbHandle usb_open(libusb_context *context, const std::string &serial);

// Returns one of the text strings that a USB device reports about itself. Only printable ASCII characters of
// the string remain, because the text is shown on terminals, and a device may send anything. When the device
// does not send the string, `error` is set to libusb's error code, otherwise to 0.
std::string usb_text(libusb_device_handle *handle, std::uint8_t index, int &error);

// Returns the message for a libusb error code, such as "ACCESS: the rig ... may not be opened by this user;
// ...".
std::string usb_trouble(int error, const std::string &what);

// Detects when a rig is plugged in or unplugged. If the operating system reports that rigs were plugged in or
// unplugged, this class uses the reports; otherwise it looks for changes 5 times a second.
class UsbWatch
{
  public:
    explicit UsbWatch(bool forces_polling = false);
    ~UsbWatch();
    UsbWatch(const UsbWatch &) = delete;
    UsbWatch &operator=(const UsbWatch &) = delete;
    bool is_told() const { return is_told_; } // false: it polls
    // Returns when a rig was plugged in or unplugged, when the class must look for changes again, or when the
    // time is over.
    void wait_ms(std::uint32_t milliseconds);
    std::vector<UsbRig> rigs() const { return usb_rigs(context_.get()); }
    // Waits until a rig with this serial number is plugged in and can be opened. Returns false when the time
    // is over, or when `is_cancelled` returned true.
    bool wait_for(const std::string &serial, std::uint32_t milliseconds,
                  const std::function<bool()> &is_cancelled);

  private:
    UsbContext context_;
    bool is_told_ = false;
    int callback_ = 0;
    int changed_ = 0; // set by libusb, inside wait_ms
};

} // namespace crn
