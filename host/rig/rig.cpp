// Implements the commands of cournand rig that only read data, and calls the functions of the other commands.
#include "host/rig/rig.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include "host/link/usb_transport.hpp"
#include "host/rig/device_choice.hpp"
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <unistd.h>

namespace crn
{

// --- dialogue ---

std::string RigTalk::ask(const std::string &question) const
{
    std::fprintf(out, "%s ", question.c_str());
    std::fflush(out);
    std::string answer;
    if (read_line(answer)) return answer;
    std::fputc('\n', out);
    throw RigStopped("stopped at the question above; nothing was changed");
}

namespace
{

// Reads the terminal by read(2) after poll(2), so that Ctrl-C works while the user types nothing.
bool read_line_console(std::string &line)
{
    line.clear();
    while (!is_interrupted()) {
        pollfd wait = {STDIN_FILENO, POLLIN, 0};
        if (poll(&wait, 1, 100) <= 0) continue;
        char one;
        if (read(STDIN_FILENO, &one, 1) != 1) return false;
        if (one == '\n') return true;
        line += one;
    }
    return false;
}

} // namespace

RigTalk console_talk()
{
    RigTalk talk;
    talk.is_terminal = isatty(STDOUT_FILENO) != 0;
    talk.read_line = read_line_console;
    talk.is_interrupted = is_interrupted;
    return talk;
}

// --- words ---

std::string state_name(unsigned state)
{
    static const char *const names[] = {"INIT", "READY", "ARMED", "RUNNING", "FAULT"};
    return state < 5 ? names[state] : "unknown state " + std::to_string(state);
}

std::string sensor_name(unsigned status)
{
    static const char *const names[] = {"good", "absent", "out of its electrical range", "signal error"};
    return status < 4 ? names[status] : "unknown status " + std::to_string(status);
}

std::string serial_of(const crn_wire_hello_reply &hello)
{
    std::string text;
    for (std::uint16_t i = 0; i < hello.serial_count; i++)
        text += hello.serial[i] >= 0x20 && hello.serial[i] < 0x7f ? static_cast<char>(hello.serial[i]) : '?';
    return text;
}

void require_ready(Link &link, bool may_reset)
{
    const crn_wire_status status = link.read_status();
    if (status.state == CRN_WIRE_STATE_READY) return;
    if (may_reset) {
        if (link.reset().state == CRN_WIRE_STATE_READY) return;
    }
    std::string text = "the rig is in " + state_name(status.state);
    if (status.fault_code != 0) {
        text += std::string(" (") + crn_wire_fault_name(status.fault_code) + ": " +
                crn_wire_fault_text(status.fault_code) + ")";
    }
    throw LinkError(text + ", and this needs READY. Remedy: " +
                    (status.fault_code != 0 ? crn_wire_fault_remedy(status.fault_code) : "end its session") +
                    "; then give --reset");
}

// --- list, info, log ---

namespace
{

// The command `list` contacts every connected rig, and these time limits end the command even if a rig does
// not answer.
constexpr auto list_patience = std::chrono::milliseconds(1500);
constexpr auto list_limit = std::chrono::seconds(6);

struct Listed {
    UsbRig usb;
    std::string firmware = "-", state = "-", trouble;
};

Listed look_at(const UsbRig &usb)
{
    Listed listed{usb, "-", "-", usb.trouble};
    if (!usb.trouble.empty()) return listed;
    try {
        UsbTransport pipe(usb.serial, {.read_ms = 500, .write_ms = 500});
        Link link(pipe, list_patience);
        const crn_wire_hello_reply hello = link.hello();
        listed.firmware = std::to_string(hello.protocol_major) + "." + std::to_string(hello.protocol_minor) +
                          " core " + std::to_string(hello.core_version);
        listed.state = state_name(link.read_status().state);
    } catch (const LinkError &error) {
        listed.trouble = error.what();
    }
    return listed;
}

int list_rigs(const RigOptions &options, const RigTalk &talk)
{
    const UsbContext context = usb_context();
    std::vector<Listed> rigs;
    const auto end = std::chrono::steady_clock::now() + list_limit;
    bool has_trouble = false;
    for (const UsbRig &usb : usb_rigs(context.get())) {
        const bool is_late = std::chrono::steady_clock::now() > end || talk.is_interrupted();
        rigs.push_back(is_late ? Listed{usb, "-", "-", "not contacted: the others took too long"}
                               : look_at(usb));
        has_trouble = has_trouble || !rigs.back().trouble.empty();
    }
    if (options.json) {
        nlohmann::ordered_json list = nlohmann::json::array();
        for (const Listed &rig : rigs) {
            list.push_back({{"serial", rig.usb.serial},
                            {"product", rig.usb.product},
                            {"firmware", rig.firmware},
                            {"state", rig.state},
                            {"place", rig.usb.place},
                            {"trouble", rig.trouble}});
        }
        std::fprintf(talk.out, "%s\n", list.dump(2).c_str());
        return has_trouble ? 1 : 0;
    }
    if (rigs.empty()) {
        std::fprintf(talk.out, "no rig is on USB (looked for %04x:%04x); check cable and power\n",
                     unsigned{usb_vendor_id}, unsigned{usb_product_id});
        return 0;
    }
    std::fprintf(talk.out, "%-24s %-16s %-16s %-8s %s\n", "serial", "product", "firmware", "state", "place");
    for (const Listed &rig : rigs) {
        say(talk.out, "%-24s %-16s %-16s %-8s %s\n", rig.usb.serial.empty() ? "?" : rig.usb.serial.c_str(),
            rig.usb.product.empty() ? "?" : rig.usb.product.c_str(), rig.firmware.c_str(), rig.state.c_str(),
            rig.usb.place.c_str());
        if (!rig.trouble.empty()) say(talk.out, "  %s\n", rig.trouble.c_str());
    }
    return has_trouble ? 1 : 0;
}

std::string capability_text(std::uint32_t bits)
{
    static const char *const names[] = {"LOCKSTEP", "FREE_RUN", "snapshots", "own encoders", "motors"};
    std::string text;
    for (unsigned i = 0; i < 5; i++)
        if (bits >> i & 1) text += (text.empty() ? "" : ", ") + std::string(names[i]);
    return text.empty() ? "none" : text;
}

nlohmann::ordered_json track_json(const crn_wire_track &track)
{
    return {{"translation_pm_per_count", track.translation_pm_per_count},
            {"rotation_counts_per_turn", track.rotation_counts_per_turn},
            {"force_gain_milli", track.force_gain_milli},
            {"force_limit_mN", track.force_limit_mN},
            {"torque_limit_uN_m", track.torque_limit_uN_m},
            {"force_slew_mN_per_tick", track.force_slew_mN_per_tick},
            {"torque_slew_uN_m_per_tick", track.torque_slew_uN_m_per_tick},
            {"options", track.options},
            {"force_zero_counts", track.force_zero_counts},
            {"force_uN_per_count", track.force_uN_per_count},
            {"damping_mN_s_per_m", track.damping_mN_s_per_m},
            {"damping_nN_m_s_per_rad", track.damping_nN_m_s_per_rad}};
}

void print_track(std::FILE *out, unsigned number, const crn_wire_track &track)
{
    std::fprintf(out, "track %u       %.6g um/count%s, %u counts/turn%s\n", number,
                 track.translation_pm_per_count * 1e-6,
                 track.options & CRN_WIRE_OPTION_TRANSLATION_REVERSED ? " (reversed)" : "",
                 unsigned{track.rotation_counts_per_turn},
                 track.options & CRN_WIRE_OPTION_ROTATION_REVERSED ? " (reversed)" : "");
    std::fprintf(out, "  sensor      zero at %d counts, %.6g mN/count\n", track.force_zero_counts,
                 track.force_uN_per_count * 1e-3);
    std::fprintf(out, "  limits      %.3f N, %.3f N mm; %.1f N/s, %.1f N mm/s; gain %.3f\n",
                 track.force_limit_mN * 1e-3, track.torque_limit_uN_m * 1e-3,
                 1.0 * track.force_slew_mN_per_tick, 1.0 * track.torque_slew_uN_m_per_tick,
                 track.force_gain_milli * 1e-3);
}

} // namespace

int rig_info(Link &link, const crn_wire_hello_reply &hello, const RigOptions &options, const RigTalk &talk)
{
    const crn_wire_status status = link.read_status();
    const crn_wire_rig rig = link.read_rig();
    const std::string schema = hex_text(hello.schema_hash);
    if (options.json) {
        nlohmann::ordered_json report = {{"serial", serial_of(hello)},
                                         {"protocol_major", hello.protocol_major},
                                         {"protocol_minor", hello.protocol_minor},
                                         {"schema_hash", schema},
                                         {"core_version", hello.core_version},
                                         {"capabilities", hello.capabilities},
                                         {"tick_us", hello.tick_us},
                                         {"scene_bytes_max", hello.scene_bytes_max},
                                         {"state", state_name(status.state)},
                                         {"tick", status.tick},
                                         {"fault_code", status.fault_code},
                                         {"tick_overruns", status.tick_overruns},
                                         {"tick_us_max", status.tick_us_max}};
        report["tracks"] = nlohmann::json::array();
        for (std::uint16_t k = 0; k < rig.tracks_count; k++)
            report["tracks"].push_back(track_json(rig.tracks[k]));
        std::fprintf(talk.out, "%s\n", report.dump(2).c_str());
        return 0;
    }
    std::fprintf(talk.out, "serial        %s\n", serial_of(hello).c_str());
    std::fprintf(talk.out, "firmware      protocol %u.%u, schema %s, core version %u\n",
                 unsigned{hello.protocol_major}, unsigned{hello.protocol_minor}, schema.c_str(),
                 unsigned{hello.core_version});
    std::fprintf(talk.out, "can           %s; tick %u us, scenes up to %u bytes\n",
                 capability_text(hello.capabilities).c_str(), unsigned{hello.tick_us},
                 unsigned{hello.scene_bytes_max});
    std::fprintf(talk.out, "state         %s, %u ticks done%s%s\n", state_name(status.state).c_str(),
                 unsigned{status.tick}, status.fault_code != 0 ? ", " : "",
                 status.fault_code != 0 ? crn_wire_fault_name(status.fault_code) : "");
    std::fprintf(talk.out, "health        longest tick %u us, %u overruns, %u bad frames, %u gaps\n",
                 unsigned{status.tick_us_max}, unsigned{status.tick_overruns}, unsigned{status.frames_bad},
                 unsigned{status.sequence_gaps});
    for (std::uint16_t k = 0; k < rig.tracks_count; k++) print_track(talk.out, k + 1u, rig.tracks[k]);
    return 0;
}

int rig_log(Link &link, const RigTalk &talk)
{
    const crn_wire_fault_log log = link.read_fault_log();
    if (log.entries_count == 0) std::fprintf(talk.out, "no faults since power-up\n");
    for (std::uint16_t i = 0; i < log.entries_count; i++) {
        const crn_wire_fault_entry &entry = log.entries[i];
        std::fprintf(talk.out, "%s: %s\n", crn_wire_fault_name(entry.code), crn_wire_fault_text(entry.code));
        std::fprintf(talk.out, "  %u times, tick %u to %u; last values %d, %d\n  remedy: %s\n",
                     unsigned{entry.count}, unsigned{entry.tick_first}, unsigned{entry.tick_last},
                     entry.value1, entry.value2, crn_wire_fault_remedy(entry.code));
    }
    return 0;
}

// The function waits up to one second for a report, in short steps, so that Ctrl-C soon takes effect.
int rig_monitor_hid(const HidApi &api, const std::string &serial, const RigOptions &options,
                    const RigTalk &talk)
{
    constexpr unsigned slice_ms = 200, slices = 5;
    HidRig rig(api, serial);
    return rig_monitor(
        [&]() -> std::optional<crn_hid_state> {
            for (unsigned i = 0; i < slices && !talk.is_interrupted(); i++)
                if (const auto state = rig.read_state(slice_ms)) return state;
            return {};
        },
        options, talk);
}

// --- the command line ---

namespace
{

int monitor(const RigOptions &options, const DeviceChoice &choice, const RigTalk &talk)
{
    check_outputs({}, {{"--csv", options.csv}});
    if (choice.is_usb) {
        return rig_monitor_hid(hid_api(options.hid == "libusb" ? HidBackEnd::libusb : HidBackEnd::hidraw),
                               choice.serial, options, talk);
    }
    const std::unique_ptr<Transport> pipe = open_device(choice);
    Link link(*pipe);
    link.hello();
    std::uint32_t tick = 0;
    return rig_monitor(
        [&]() -> std::optional<crn_hid_state> {
            pipe->pass_time_ms(1);
            const crn_wire_sensors sensors = link.read_sensors();
            crn_hid_state state{};
            state.tick = ++tick;
            state.state = link.read_status().state;
            state.lines = sensors.lines;
            state.syringe_counts = sensors.syringe_counts;
            state.inflator_raw = sensors.inflator_raw;
            for (std::uint16_t k = 0; k < sensors.tracks_count; k++) {
                state.tracks[k].translation_counts = sensors.tracks[k].translation_counts;
                state.tracks[k].rotation_counts = sensors.tracks[k].rotation_counts;
                state.tracks[k].sensor_axial_mN = static_cast<std::int16_t>(sensors.tracks[k].force_mN);
            }
            return state;
        },
        options, talk);
}

int with_link(const RigOptions &options, const DeviceChoice &choice, const RigTalk &talk)
{
    const std::unique_ptr<Transport> pipe = open_device(choice);
    Link link(*pipe);
    const crn_wire_hello_reply hello = link.hello();
    if (options.command == "info") return rig_info(link, hello, options, talk);
    if (options.command == "log") return rig_log(link, talk);
    if (options.command == "selftest") return rig_selftest(link, hello, options, talk);
    if (options.command == "calibrate") return rig_calibrate(link, options, talk);
    return rig_force(link, options, talk);
}

} // namespace

int command_rig(const RigOptions &options)
{
    DeviceChoice choice = parse_device(options.device);
    choice.has_rig = true;
    watch_for_interrupt();
    const RigTalk talk = console_talk();
    try {
        if (options.command == "list") return list_rigs(options, talk);
        if (options.command == "monitor") return monitor(options, choice, talk);
        return with_link(options, choice, talk);
    } catch (const RigStopped &stopped) {
        say(stderr, "cournand: %s\n", stopped.what());
        return 1;
    }
}

} // namespace crn
