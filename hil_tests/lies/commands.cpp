#include "hil_tests/lies/commands.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/lies/hid_liar.hpp"
#include "hil_tests/lies/liar.hpp"
#include "host/base/interrupt.hpp"
#include "host/command/cli.hpp"
#include "host/link/tests/fake_usb.hpp"
#include "host/rig/rig.hpp"
#include "host/session/device.hpp"
#include "host/session/recording.hpp"
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace hil
{

namespace
{

constexpr const char *wire_file = "shared/examples/instruments/j_wire.toml";

std::vector<std::string> arguments(const std::string &name, const std::string &folder)
{
    if (name == "rig list") return {"cournand", "rig", "list"};
    if (name == "rig info") return {"cournand", "rig", "info", "--device", "usb"};
    if (name == "rig selftest") return {"cournand", "rig", "selftest", "--device", "usb"};
    std::vector<std::string> run = {
        "cournand",        "run",    "--device", "usb",      "--scene",
        folder + "/scene", "--tool", wire_file,  "--record", folder + "/lied.rec"};
    if (name == "run --record") run.insert(run.end(), {"--session", folder + "/lied.session"});
    if (name == "run --free-run") run.insert(run.end(), {"--free-run", "0.4"});
    return run;
}

// Implements the clock of the rig, which makes a tick every millisecond as long as the process lives.
[[noreturn]] void keep_time(crn_sim *sim)
{
    auto next = std::chrono::steady_clock::now();
    for (;;) {
        next += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(next);
        fake_usb::change([&] { crn_sim_timer(sim, 1); });
    }
}

int monitor(const Lie &lie, const std::function<void()> &struck)
{
    crn::RigOptions options;
    options.seconds = 1.0;
    crn::watch_for_interrupt();
    try {
        const crn::HidApi api = lying_hid(lie, struck);
        return crn::rig_monitor_hid(api, "", options, crn::console_talk());
    } catch (const crn::LinkError &error) {
        std::fprintf(stderr, "cournand: %s\n", error.what());
        return 1;
    }
}

} // namespace

const std::vector<LiedTo> &lied_to()
{
    static const std::vector<LiedTo> commands = {
        {"rig list", 2, false, ""},
        {"rig info", 3, false, ""},
        {"rig selftest", 14, false, ""},
        {"run --record", 60, false, "lied.rec"},
        {"run --free-run", 40, false, "lied.rec"},
        {"rig monitor", 1, true, ""},
    };
    return commands;
}

void write_inputs(const std::string &folder, unsigned ticks)
{
    const std::vector<std::uint8_t> &scene = tube_scene();
    std::ofstream(folder + "/scene", std::ios::binary)
        .write(reinterpret_cast<const char *>(scene.data()), static_cast<std::streamsize>(scene.size()));
    std::ofstream(folder + "/lied.session")
        << "begin inserted 30 mm\nadvance 20 mm at 40 mm/s while rotate 90 deg\nwait " << ticks / 1000.0
        << " s\n";
}

int run_command(const LiedTo &command, const Lie &lie, const std::string &folder,
                const std::function<void()> &struck)
{
    if (command.is_by_hid) return monitor(lie, struck);
    fake_usb::reset();
    fake_usb::Rig &rig = fake_usb::add("LIAR-0001");
    const crn_port_inputs inputs = crn_sim_healthy_inputs();
    Liar liar(lie, command.frames, rig.sim, struck);
    fake_usb::change([&] {
        crn_sim_set_inputs(rig.sim, &inputs);
        crn_sim_timer(rig.sim, 1);
        rig.in_bytes_max = 16384;
        rig.take = [&](std::span<const std::uint8_t> bytes) { liar.take(bytes); };
        rig.give = [&](std::span<std::uint8_t> bytes) { return liar.give(bytes); };
    });
    std::thread(keep_time, rig.sim).detach();
    std::vector<std::string> words = arguments(command.name, folder);
    std::vector<char *> argv;
    for (std::string &word : words) argv.push_back(word.data());
    const int code = crn::command_line(static_cast<int>(argv.size()), argv.data(), nullptr);
    fake_usb::change([&] { // the lying device ends here, and the clock goes on
        rig.take = {};
        rig.give = {};
    });
    return code;
}

// --- truth ---

namespace
{

// Replays a recording tick by tick on a device in this process.
class Referee
{
  public:
    explicit Referee(const crn::Recording &recording)
        : recording_(recording), device_(scene_of(recording.header), recording.header.tools,
                                         recording.header.entry, recording.header.rig)
    {
    }

    std::string falsehood()
    {
        const crn::RecordingHeader &header = recording_.header;
        if (header.core_version != device_.identity().core_version ||
            header.schema_hash != device_.identity().schema_hash)
            return "another core or schema than the firmware's";
        const std::string hash0 = check_hashes(0);
        for (std::uint32_t tick = 0; tick < recording_.ticks.size(); tick++) {
            const crn::RecordedTick &recorded = recording_.ticks[tick];
            if (const crn::RecordedSnapshot *resumed = recording_.resumed_at(tick))
                device_.restore(resumed->bytes);
            const crn_wire_tick_state state = device_.step({&recorded.input, 1}, false).front();
            if (state.hash_lane0 != recorded.hash_lane[0] || state.hash_lane1 != recorded.hash_lane[1])
                return "the hash of tick " + std::to_string(tick + 1);
            const std::string wrong = check_hashes(tick + 1) + check_snapshots(tick + 1);
            if (!wrong.empty()) return wrong;
        }
        if (hashes_ != recording_.hashes.size()) return "a full hash of a tick that is not in it";
        return snapshots_ != recording_.snapshots.size() ? "a snapshot of a tick that is not in it" : hash0;
    }

  private:
    static crn::SceneFile scene_of(const crn::RecordingHeader &header)
    {
        return header.scene_bytes == 0 ? crn::read_scene("") : crn::read_scene(header.scene_path);
    }
    std::string check_hashes(std::uint32_t tick)
    {
        for (const crn::RecordedHash &recorded : recording_.hashes) {
            if (recorded.tick != tick) continue;
            hashes_++;
            if (device_.read_hash64().hash != recorded.hash)
                return "the full hash of tick " + std::to_string(tick);
        }
        return "";
    }
    // Of the states in the snapshots, only the hashes are compared. The other data in the snapshots differ,
    // because the replaying device has no rig, and therefore no hands and motors.
    std::string check_snapshots(std::uint32_t tick)
    {
        for (const crn::RecordedSnapshot &recorded : recording_.snapshots) {
            if (recorded.tick != tick) continue;
            snapshots_++;
            const std::uint64_t before = device_.read_hash64().hash;
            try {
                device_.restore(recorded.bytes);
            } catch (const crn::LinkError &) {
                return "the snapshot of tick " + std::to_string(tick) + ", which no device takes";
            }
            if (device_.read_hash64().hash != before) return "the snapshot of tick " + std::to_string(tick);
        }
        return "";
    }

    const crn::Recording &recording_;
    crn::Device device_;
    std::size_t hashes_ = 0, snapshots_ = 0;
};

} // namespace

std::string falsehood(const std::string &path, bool has_to_be_complete)
{
    if (!std::filesystem::exists(path)) return has_to_be_complete ? "there is no recording" : "";
    try {
        const crn::Recording recording = crn::read_recording(path);
        if (has_to_be_complete && !recording.is_complete) return "the recording is cut off";
        return Referee(recording).falsehood();
    } catch (const std::exception &error) {
        return error.what();
    }
}

} // namespace hil
