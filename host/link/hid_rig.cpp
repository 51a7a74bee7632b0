#include "host/link/hid_rig.hpp"
#include "host/base/number_text.hpp"
#include "host/link/usb_devices.hpp"
#include <chrono>
#include <cstring>
#include <dlfcn.h>
#include <hidapi/hidapi.h>

namespace crn
{

namespace
{

using Clock = std::chrono::steady_clock;

// Characters that are not printable ASCII become '?', because a device may send anything, and the text is
// shown on terminals.
std::string narrow(const wchar_t *wide)
{
    std::string text;
    for (; wide != nullptr && *wide != 0; wide++)
        text += *wide >= 0x20 && *wide < 0x7f ? static_cast<char>(*wide) : '?';
    return text;
}

template <class Function>
void look_up(void *library, const char *name, Function &function, const std::string &file)
{
    void *symbol = dlsym(library, name);
    if (symbol == nullptr)
        throw LinkError(file + " has no function " + name + ". Remedy: install hidapi 0.9 or later");
    std::memcpy(&function, &symbol, sizeof symbol);
}

HidApi load(const std::string &name)
{
    const std::string file = "libhidapi-" + name + ".so.0";
    void *library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        throw LinkError(file + " is not on this machine. Remedy: apt install libhidapi-" + name +
                        "0, or choose the other back end (--hid hidraw or --hid libusb)");
    }
    HidApi api;
    api.name = name;
    look_up(library, "hid_init", api.init, file);
    look_up(library, "hid_exit", api.exit, file);
    look_up(library, "hid_enumerate", api.enumerate, file);
    look_up(library, "hid_free_enumeration", api.free_enumeration, file);
    look_up(library, "hid_open_path", api.open_path, file);
    look_up(library, "hid_close", api.close, file);
    look_up(library, "hid_read_timeout", api.read_timeout, file);
    look_up(library, "hid_write", api.write, file);
    look_up(library, "hid_get_feature_report", api.get_feature_report, file);
    look_up(library, "hid_send_feature_report", api.send_feature_report, file);
    look_up(library, "hid_error", api.error, file);
    if (api.init() != 0)
        throw LinkError(file + " cannot work on this machine. Remedy: choose the other back end");
    return api;
}

HidEntry choose(const HidApi &api, const std::string &serial)
{
    const std::vector<HidEntry> there = HidRig::list(api);
    std::vector<HidEntry> meant;
    std::string names;
    for (const HidEntry &entry : there) {
        names += "\n  " + entry.serial + " at " + entry.path;
        if (serial.empty() || entry.serial == serial) meant.push_back(entry);
    }
    if (there.empty())
        throw DeviceLost("no rig is on USB (HID by " + api.name + "). Remedy: check cable and power");
    if (meant.empty()) throw DeviceLost("no rig has the serial number '" + serial + "'; there are" + names);
    if (meant.size() > 1) {
        throw LinkError("several rigs are there" + names +
                        "\nRemedy: name one by its serial number, --device usb:SERIAL");
    }
    return meant[0];
}

} // namespace

const HidApi &hid_api(HidBackEnd back_end)
{
    if (back_end == HidBackEnd::hidraw) {
        static const HidApi hidraw = load("hidraw");
        return hidraw;
    }
    static const HidApi libusb = load("libusb");
    return libusb;
}

std::vector<HidEntry> HidRig::list(const HidApi &api)
{
    std::vector<HidEntry> entries;
    hid_device_info *list = api.enumerate(usb_vendor_id, usb_product_id);
    for (const hid_device_info *one = list; one != nullptr; one = one->next) {
        if (one->path == nullptr) continue;
        entries.push_back({one->path, narrow(one->serial_number), narrow(one->product_string)});
    }
    api.free_enumeration(list);
    return entries;
}

HidRig::HidRig(const HidApi &api, const std::string &serial) : api_(api)
{
    const HidEntry entry = choose(api, serial);
    device_ = std::unique_ptr<hid_device_, End>(api.open_path(entry.path.c_str()), End{&api});
    if (!device_) {
        throw LinkError("the rig '" + entry.serial + "' at " + entry.path +
                        " may not be opened by this user, or another program holds it. Remedy: sudo make "
                        "install-udev, then plug the rig in again (docs/rig.md)");
    }
    serial_ = entry.serial;
    identity_ = get<crn_hid_identity>(CRN_HID_ID_identity, CRN_HID_BYTES_identity, crn_hid_decode_identity,
                                      "identity");
    if (identity_.report_hash != crn_hid_report_hash()) {
        throw LinkError("the rig '" + serial_ + "' has other reports: device " +
                        hex_text(identity_.report_hash) + ", host " + hex_text(crn_hid_report_hash()) +
                        ". Remedy: install the same release on both");
    }
}

HidRig::~HidRig() = default;

std::string HidRig::reason() const
{
    const std::string text = narrow(api_.error(device_.get()));
    return text.empty() ? "" : " (" + text + ")";
}

void HidRig::lost(const char *doing) const
{
    throw DeviceLost("the rig '" + serial_ + "' is gone or started anew while " + doing + reason() +
                     ". Remedy: check cable and power");
}

std::optional<crn_hid_state> HidRig::read_state(std::uint32_t milliseconds)
{
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(milliseconds);
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        unsigned char bytes[CRN_HID_REPORT_BYTES_MAX];
        const int count =
            api_.read_timeout(device_.get(), bytes, sizeof bytes, left > 0 ? static_cast<int>(left) : 0);
        if (count < 0) lost("its state was read");
        crn_hid_state state;
        // The system may pad a report to the length of the longest report; any report shorter than a state
        // report is ignored.
        if (count > CRN_HID_BYTES_state && count <= static_cast<int>(sizeof bytes) &&
            bytes[0] == CRN_HID_ID_state && crn_hid_decode_state(bytes + 1, CRN_HID_BYTES_state, &state))
            return state;
        if (count > 0) reports_bad_++;
        if (left <= 0) return std::nullopt;
    }
}

crn_hid_state HidRig::command(std::uint8_t action, std::int32_t value1, std::int32_t value2,
                              std::uint32_t milliseconds)
{
    unsigned char bytes[1 + CRN_HID_BYTES_command] = {CRN_HID_ID_command};
    number_ = static_cast<std::uint8_t>(number_ % 255 + 1);
    const crn_hid_command command = {number_, action, 0, value1, value2};
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    crn_hid_put_command(&writer, &command);
    if (api_.write(device_.get(), bytes, sizeof bytes) != static_cast<int>(sizeof bytes))
        lost("a command was sent");
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(milliseconds);
    while (Clock::now() < end) {
        const std::optional<crn_hid_state> state = read_state(100);
        if (!state || state->command_number != number_) continue;
        if (state->command_result == 0) return *state;
        throw LinkError(describe({CRN_WIRE_TYPE_command, state->command_result, 0, 0}),
                        {CRN_WIRE_TYPE_command, state->command_result, 0, 0});
    }
    throw LinkError("the rig '" + serial_ + "' did not answer a command within " +
                    std::to_string(milliseconds) + " ms. Remedy: plug it out and in");
}

// --- features ---

template <class Report, class Decode>
Report HidRig::get(std::uint8_t id, std::size_t bytes, Decode decode, const char *what)
{
    unsigned char report[CRN_HID_REPORT_BYTES_MAX] = {id};
    const int count = api_.get_feature_report(device_.get(), report, sizeof report);
    if (count < 0) lost(what);
    Report value{};
    if (count <= static_cast<int>(bytes) || count > static_cast<int>(sizeof report) || report[0] != id ||
        !decode(report + 1, bytes, &value)) {
        throw LinkError(std::string("the rig sent a report '") + what + "' that does not have its form (" +
                        std::to_string(count) + " bytes, id " + std::to_string(report[0]) + ", expected " +
                        std::to_string(bytes + 1) + ", id " + std::to_string(id) +
                        "). Remedy: install the same release on both");
    }
    return value;
}

template <class Report, class Put>
void HidRig::set(std::uint8_t id, const Report &report, Put put, const char *what)
{
    unsigned char bytes[CRN_HID_REPORT_BYTES_MAX] = {id};
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    put(&writer, &report);
    if (api_.send_feature_report(device_.get(), bytes, writer.length + 1) < 0) {
        throw LinkError(std::string("the rig refused to change its ") + what + reason() +
                        ": only in READY, in range, and limits only downwards. Remedy: cournand rig info");
    }
}

crn_hid_capabilities HidRig::read_capabilities()
{
    return get<crn_hid_capabilities>(CRN_HID_ID_capabilities, CRN_HID_BYTES_capabilities,
                                     crn_hid_decode_capabilities, "capabilities");
}

crn_hid_calibration HidRig::read_calibration()
{
    return get<crn_hid_calibration>(CRN_HID_ID_calibration, CRN_HID_BYTES_calibration,
                                    crn_hid_decode_calibration, "calibration");
}

crn_hid_limits HidRig::read_limits()
{
    return get<crn_hid_limits>(CRN_HID_ID_limits, CRN_HID_BYTES_limits, crn_hid_decode_limits, "limits");
}

crn_hid_calibration HidRig::write_calibration(const crn_hid_calibration &calibration)
{
    set(CRN_HID_ID_calibration, calibration, crn_hid_put_calibration, "calibration");
    const crn_hid_calibration back = read_calibration();
    if (std::memcmp(&back, &calibration, sizeof back) != 0)
        throw LinkError("the rig keeps another calibration than it was given. Remedy: cournand rig info");
    return back;
}

crn_hid_limits HidRig::write_limits(const crn_hid_limits &limits)
{
    set(CRN_HID_ID_limits, limits, crn_hid_put_limits, "limits");
    const crn_hid_limits back = read_limits();
    if (std::memcmp(&back, &limits, sizeof back) != 0)
        throw LinkError("the rig keeps other limits than it was given. Remedy: cournand rig info");
    return back;
}

} // namespace crn
