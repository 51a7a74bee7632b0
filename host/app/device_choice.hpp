// Which device a command talks to: the one in this process, the image in an emulator, or a rig on USB. May include: link. Called by: device, cli.
#pragma once
#include "host/link/transport.hpp"
#include <cstdint>
#include <memory>
#include <string>

namespace seld
{

struct DeviceChoice {
    bool is_usb = false;
    bool is_emulated = false;
    bool has_rig = false;                  // sim: with a rig whose sensors are healthy and whose hands rest
    std::string serial;                    // usb: empty for the only one
    std::uint32_t return_limit_ms = 20000; // how long a session waits for a rig that went
};

// "sim", "emulator", "usb" or "usb:SERIAL". Throws UsageError.
DeviceChoice parse_device(const std::string &text);
// Throws LinkError, DeviceLost.
std::unique_ptr<Transport> open_device(const DeviceChoice &choice);
// Until that rig can be opened again. False: it did not come within its limit, or Ctrl-C.
bool wait_for_device(const DeviceChoice &choice);

} // namespace seld
