#include "host/rig/device_choice.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/link/emulated_transport.hpp"
#include "host/link/sim_transport.hpp"
#include "host/link/usb_transport.hpp"

namespace crn
{

DeviceChoice parse_device(const std::string &text)
{
    DeviceChoice choice;
    if (text == "sim") return choice;
    if (text == "emulator") {
        choice.is_emulated = true;
        return choice;
    }
    choice.is_usb = true;
    if (text == "usb") return choice;
    if (text.starts_with("usb:") && text.size() > 4) {
        choice.serial = text.substr(4);
        return choice;
    }
    throw UsageError("--device '" + text +
                     "' is not sim, emulator, usb or usb:SERIAL; cournand rig list shows the rigs");
}

std::unique_ptr<Transport> open_device(const DeviceChoice &choice)
{
    if (choice.opens) return choice.opens();
    if (choice.is_usb) return std::make_unique<UsbTransport>(choice.serial);
    if (choice.is_emulated) return std::make_unique<EmulatedDevice>(EmulatorOptions{.icount_shift = 0});
    auto sim = std::make_unique<SimTransport>();
    if (choice.has_rig) sim->attach_rig();
    return sim;
}

bool wait_for_device(const DeviceChoice &choice)
{
    return !choice.is_usb || UsbWatch().wait_for(choice.serial, choice.return_limit_ms, is_interrupted);
}

} // namespace crn
