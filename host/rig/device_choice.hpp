// Selects the device with which a command communicates: the one in this process, the image in an emulator, or
// a rig on USB.
#pragma once
#include "host/link/transport.hpp"
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace crn
{

struct DeviceChoice {
    bool is_usb = false;
    bool is_emulated = false;
    bool has_rig = false; // sim: with a rig whose sensors are healthy and whose hands are at rest
    std::string serial;   // usb: empty for the only one
    std::uint32_t return_limit_ms = 20000; // how long a session waits for a rig that was disconnected
    bool free_run = false;      // the device sets the pace: its own ticks, and hands from its own encoders
    bool powers_motors = false; // FREE_RUN: power on the tracks that have a coupling
    std::uint16_t picture_every_ticks = 16; // FREE_RUN: the device sends the line's shape unasked
    std::function<std::unique_ptr<Transport>()>
        opens{}; // tests: replaces all of the above; may disconnect and reconnect

    bool may_return() const { return is_usb || opens; }
};

// Reads the user's choice of a device, which is "sim", "emulator", "usb" or "usb:SERIAL". Throws UsageError.
DeviceChoice parse_device(const std::string &text);
// Throws LinkError, DeviceLost.
std::unique_ptr<Transport> open_device(const DeviceChoice &choice);
// Waits until the chosen rig is connected again and the program can open it. Returns false when it did not
// come within its limit, or after Ctrl-C.
bool wait_for_device(const DeviceChoice &choice);

} // namespace crn
