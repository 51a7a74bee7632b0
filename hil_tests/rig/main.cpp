// This is the program hil_rig. The program starts a simulated rig with an emulated device, runs a command,
// and ends when this command ends.
//
//   hil_rig [--serial S] [--image FILE] [--live] -- COMMAND ARGUMENT...
//
// The device's image runs in an emulator. The device gets its clock and its sensor values from one of two
// sources. With --live, a simulated rig in this process makes clock and sensor values in real time, and its
// hand pushes, turns and pulls back against the motors. Without --live, the client of the bench socket sends
// the clock and the sensor values. In COMMAND, {mailbox} is replaced by the location of the device's USB
// tokens (a memory file and an offset), as bridge and mock_bus expect it. {bench} is replaced by the path of
// the socket. The exit code is that of COMMAND, or 1 if COMMAND, the rig or the device did not start.
#include "hil_tests/l1/bench_server.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/version.hpp"
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace
{

using Clock = std::chrono::steady_clock;
constexpr int poll_ms = 50;

struct Options {
    std::string serial = "AN500-0001", image;
    bool is_live = false;
    std::vector<std::string> command;
};

// --- the rig by itself ---

// Holds the measured values of a rig that runs in real time.
struct Meters {
    double motor_N = 0.0, torque_N_m = 0.0, way_m = 0.0;
    std::uint64_t milliseconds = 0, powered_ms = 0, stalls = 0;
    std::uint32_t overruns = 0;
    double edge_us = 0.0;
};

// Makes the hand push for 3 s, turn, and pull back for 2 s.
void move_hand(hil::Plant &plant)
{
    const std::uint64_t ms = plant.milliseconds() % 5000;
    hil::Plant::Track &track = plant.track(0);
    track.translation.move_hand(ms < 3000 ? 0.02 : -0.03);
    track.rotation.move_hand(ms < 2500 ? 2.0 : -2.0);
}

class LiveRig
{
  public:
    explicit LiveRig(const Options &options)
        : bench_(settings(),
                 {.image = options.image, .icount_shift = 0, .serial = options.serial, .debugger = {}})
    {
        bench_.plant().track(0).translation.set_hand(hil::Hand::spring);
    }

    std::string mailbox() { return bench_.emulator().memory_path() + ":0"; }

    // Runs the rig and the device in real time until `is_over` is true. If the machine was suspended, the rig
    // does not catch up on the lost time, because neither the rig nor the device has noticed the suspension.
    void run(const std::atomic<bool> &is_over)
    {
        Clock::time_point due = Clock::now();
        while (!is_over) {
            move_hand(bench_.plant());
            bench_.advance(1);
            note();
            due += std::chrono::milliseconds(1);
            const Clock::time_point now = Clock::now();
            if (now - due > std::chrono::milliseconds(20)) {
                meters_.stalls++;
                due = now;
            }
            std::this_thread::sleep_until(due);
        }
    }

    const Meters &meters() const { return meters_; }

  private:
    static hil::PlantSettings settings()
    {
        hil::PlantSettings settings;
        settings.translation_encoder.jitter_counts = 0.7;
        return settings;
    }

    void note()
    {
        hil::Plant &plant = bench_.plant();
        const double us =
            rig_read(&bench_.emulator().page().device.edge_counts) * crn::Emulator::count_ns * 1e-3;
        meters_.motor_N = std::max(meters_.motor_N, plant.motor_peak_N());
        meters_.torque_N_m = std::max(meters_.torque_N_m, plant.motor_torque_peak_N_m());
        meters_.way_m = std::max(meters_.way_m, plant.track(0).translation.tool());
        meters_.milliseconds = plant.milliseconds();
        meters_.powered_ms += plant.is_stage_on();
        meters_.overruns += us > 1000.0;
        meters_.edge_us = std::max(meters_.edge_us, us);
    }

    hil::EmulatedBench bench_;
    Meters meters_;
};

// --- the command ---

std::vector<std::string> filled_in(std::vector<std::string> command, const std::string &name,
                                   const std::string &value)
{
    for (std::string &word : command) {
        for (std::size_t at; (at = word.find(name)) != std::string::npos;)
            word.replace(at, name.size(), value);
    }
    return command;
}

pid_t start(const std::vector<std::string> &command)
{
    std::vector<char *> words;
    for (const std::string &word : command) words.push_back(const_cast<char *>(word.c_str()));
    words.push_back(nullptr);
    const pid_t child = fork();
    if (child != 0) return child;
    execvp(words[0], words.data());
    std::fprintf(stderr, "hil_rig: cannot run %s: %s\n", words[0], std::strerror(errno));
    _exit(127);
}

// Returns the exit code after the command has ended, and no value while the command runs.
std::optional<int> ended(pid_t child)
{
    int status = 0;
    if (waitpid(child, &status, WNOHANG) != child) return {};
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

int run_live(const Options &options)
{
    LiveRig rig(options);
    const pid_t child = start(filled_in(options.command, "{mailbox}", rig.mailbox()));
    std::atomic<bool> is_over = false;
    std::optional<int> code;
    std::thread watch([&] {
        while (!(code = ended(child))) std::this_thread::sleep_for(std::chrono::milliseconds(poll_ms));
        is_over = true;
    });
    rig.run(is_over);
    watch.join();
    const Meters &meters = rig.meters();
    std::printf("#- rig: %.1f s, %.1f s with power, motor at most %.2f N and %.2f mN m, tool at most %.1f mm "
                "in; longest tick "
                "%.0f us, %u over 1 ms; this machine stood still %llu times\n",
                static_cast<double>(meters.milliseconds) * 1e-3,
                static_cast<double>(meters.powered_ms) * 1e-3, meters.motor_N, meters.torque_N_m * 1e3,
                meters.way_m * 1e3, meters.edge_us, meters.overruns,
                static_cast<unsigned long long>(meters.stalls));
    return *code;
}

// --- the bench socket ---

int listen_at(const std::string &path)
{
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return -1;
    path.copy(address.sun_path, path.size());
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (listener < 0) return -1;
    if (bind(listener, reinterpret_cast<sockaddr *>(&address), sizeof address) == 0 &&
        listen(listener, 1) == 0)
        return listener;
    close(listener);
    return -1;
}

int run_served(const Options &options)
{
    crn::Emulator emulator(
        {.image = options.image, .icount_shift = 0, .serial = options.serial, .debugger = {}});
    const std::string socket_path =
        std::filesystem::path(emulator.memory_path()).replace_filename("bench").string();
    const int listener = listen_at(socket_path);
    if (listener < 0) {
        std::fprintf(stderr, "hil_rig: no socket at %s: %s\n", socket_path.c_str(), std::strerror(errno));
        return 1;
    }
    const pid_t child = start(filled_in(
        filled_in(options.command, "{mailbox}", emulator.memory_path() + ":0"), "{bench}", socket_path));
    std::optional<int> code;
    while (!(code = ended(child))) {
        pollfd wait = {listener, POLLIN, 0};
        if (poll(&wait, 1, poll_ms) <= 0) continue;
        const int connection = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
        if (connection < 0) continue;
        hil::serve_bench(emulator, connection);
        close(connection);
    }
    close(listener);
    return *code;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("A rig of numbers and emulation, for as long as a command runs beside it (docs/hil.md)");
    app.add_option("--serial", options.serial, "Of the device")->capture_default_str();
    app.add_option("--image", options.image, "Of the device; build/firmware has the one that ships");
    app.add_flag("--live", options.is_live, "The rig moves by itself, in real time");
    app.add_option("command", options.command,
                   "What to run; {mailbox} is the place of the USB tokens, {bench} the bench's socket")
        ->required();
    app.footer("Examples:\n  hil_rig --live -- hil_tests/l3/run_guest.py --mailbox {mailbox} -- "
               "build/bin/cournand rig "
               "monitor --seconds 5\n  hil_rig -- hil_tests/l3/run_guest.py --mailbox {mailbox} --channel "
               "{bench} -- "
               "build/bin/hil --level L3");
    app.set_version_flag("--version", crn::version_of("hil_rig"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return options.is_live ? run_live(options) : run_served(options);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hil_rig: %s\n", error.what());
        return 1;
    }
}
