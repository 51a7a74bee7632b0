// Uses the HID interface of a rig through hidapi: its state every millisecond, commands, and settings
// (docs/usb.md, "Reports").
//
// Debian has two builds of hidapi with the same function names: one uses the kernel's hidraw, the other
// libusb. Both builds of hidapi are loaded at run time, not linked. The caller can therefore choose one of
// the two builds of hidapi, and a machine without hidapi can still run all other functions of the program.
// Only one thread at a time may call the functions of a HidRig.
#pragma once
#include "host/link/link.hpp"
#include "shared/wire/hid.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct hid_device_;
struct hid_device_info;

namespace crn
{

enum class HidBackEnd { hidraw, libusb };

// Holds the functions of hidapi that this code uses, from one of hidapi's two builds (hidraw or libusb);
// tests provide functions of their own.
struct HidApi {
    std::string name; // "hidraw", "libusb"
    int (*init)() = nullptr;
    int (*exit)() = nullptr;
    hid_device_info *(*enumerate)(unsigned short vendor, unsigned short product) = nullptr;
    void (*free_enumeration)(hid_device_info *list) = nullptr;
    hid_device_ *(*open_path)(const char *path) = nullptr;
    void (*close)(hid_device_ *device) = nullptr;
    int (*read_timeout)(hid_device_ *device, unsigned char *bytes, std::size_t capacity,
                        int milliseconds) = nullptr;
    int (*write)(hid_device_ *device, const unsigned char *bytes, std::size_t count) = nullptr;
    int (*get_feature_report)(hid_device_ *device, unsigned char *bytes, std::size_t capacity) = nullptr;
    int (*send_feature_report)(hid_device_ *device, const unsigned char *bytes, std::size_t count) = nullptr;
    const wchar_t *(*error)(hid_device_ *device) = nullptr;
};

// Throws a LinkError that names the missing hidapi library and its package. A loaded library stays in memory
// until the program ends.
const HidApi &hid_api(HidBackEnd back_end);

struct HidEntry {
    std::string path, serial, product;
};

class HidRig
{
  public:
    static std::vector<HidEntry> list(const HidApi &api);

    // An empty `serial` selects the only rig that is plugged in. Throws LinkError. The constructor refuses a
    // rig whose definition of the reports differs from this program's; the error message contains the hashes
    // of both definitions.
    HidRig(const HidApi &api, const std::string &serial);
    ~HidRig();
    HidRig(const HidRig &) = delete;
    HidRig &operator=(const HidRig &) = delete;

    const crn_hid_identity &identity() const { return identity_; }
    const std::string &serial() const { return serial_; }
    // Returns the next state report of the rig, or nothing if no report arrives within the time. Throws
    // DeviceLost when the rig was disconnected, and LinkError when the received data are not a report.
    std::optional<crn_hid_state> read_state(std::uint32_t milliseconds);
    std::uint32_t reports_bad() const { return reports_bad_; } // too short, or with another id: ignored
    // Sends a command and waits for the state report that answers it. Throws LinkError with the reason that
    // the device gives when it refuses the command.
    crn_hid_state command(std::uint8_t action, std::int32_t value1, std::int32_t value2,
                          std::uint32_t milliseconds = 1000);

    crn_hid_capabilities read_capabilities();
    crn_hid_calibration read_calibration();
    crn_hid_limits read_limits();
    // Writes the calibration, and returns the calibration that is then read back from the device. Throws
    // LinkError when the device refuses the calibration or keeps other values.
    crn_hid_calibration write_calibration(const crn_hid_calibration &calibration);
    crn_hid_limits write_limits(const crn_hid_limits &limits);

  private:
    template <class Report, class Decode>
    Report get(std::uint8_t id, std::size_t bytes, Decode decode, const char *what);
    template <class Report, class Put>
    void set(std::uint8_t id, const Report &report, Put put, const char *what);
    std::string reason() const;
    [[noreturn]] void lost(const char *doing) const;

    struct End {
        const HidApi *api;
        void operator()(hid_device_ *device) const { api->close(device); }
    };
    const HidApi &api_;
    std::unique_ptr<hid_device_, End> device_;
    std::string serial_;
    crn_hid_identity identity_{};
    std::uint8_t number_ = 0;
    std::uint32_t reports_bad_ = 0;
};

} // namespace crn
