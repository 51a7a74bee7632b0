// This test crashes the firmware of an emulated device in several ways, and checks the state of the device
// afterwards. In two tests a debugger causes a crash: a jump to an invalid address (a hard fault), or a loop
// that never ends. The motors must lose their power before the firmware prints any text, and the text on the
// console must show where the firmware failed. The watchdog restarts the device; after its next start the
// device reports the cause again and works.
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

extern "C" {
#include <cmocka.h>
}

namespace
{

constexpr std::uint32_t nowhere = 0x50000000; // no memory there
constexpr std::uint32_t spare = 0x003ff000;   // code memory behind the image
constexpr int hard_fault = 3, watchdog = 2;
constexpr int patience_s = 120;

// Implements the part of gdb's protocol that a test needs to stop a processor, to change its program counter
// and memory, and to resume it.
class Debugger
{
  public:
    explicit Debugger(const std::string &path) : path_(path) {}
    ~Debugger() { ::close(socket_); }

    // Connects to the emulator, which waits for this connection at its start.
    void release()
    {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        socket_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
        const timeval limit = {patience_s, 0};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        for (int i = 0; i < 100 * patience_s; i++, usleep(10000))
            if (::connect(socket_, reinterpret_cast<sockaddr *>(&address), sizeof address) == 0) break;
        say("c");
    }
    void stop()
    {
        send("\x03", 1);
        hear();
        ask("qXfer:features:read:target.xml:0,fff"); // registers have numbers from here on
    }
    std::string ask(const std::string &packet)
    {
        say(packet);
        return hear();
    }
    void set_program_counter(std::uint32_t address)
    {
        hil::check(ask("Pf=" + hex(address)) == "OK", "no new pc");
    }
    void write_code(std::uint32_t address, const char *bytes_hex)
    {
        char head[32];
        std::snprintf(head, sizeof head, "M%x,%zx:", address, std::strlen(bytes_hex) / 2);
        hil::check(ask(head + std::string(bytes_hex)) == "OK", "the memory cannot be written");
    }
    void go_on() { say("c"); }

  private:
    static std::string hex(std::uint32_t word) // little-endian
    {
        char text[9];
        std::snprintf(text, sizeof text, "%02x%02x%02x%02x", word & 255, word >> 8 & 255, word >> 16 & 255,
                      word >> 24);
        return text;
    }
    void send(const char *bytes, std::size_t count)
    {
        hil::check(::send(socket_, bytes, count, MSG_NOSIGNAL) == static_cast<ssize_t>(count),
                   "the emulator's debugger is gone");
    }
    void say(const std::string &packet)
    {
        unsigned sum = 0;
        for (const char letter : packet) sum += static_cast<unsigned char>(letter);
        char tail[8];
        std::snprintf(tail, sizeof tail, "#%02x", sum & 255);
        const std::string whole = "+$" + packet + tail; // and the received packet is acknowledged
        send(whole.data(), whole.size());
    }
    std::string hear()
    {
        std::string packet;
        bool is_in = false;
        for (char letter; ::recv(socket_, &letter, 1, 0) == 1;) {
            if (letter == '#') return packet;
            if (is_in) packet += letter;
            is_in = is_in || letter == '$';
        }
        throw hil::Failure("the emulator's debugger does not answer");
    }

    std::string path_;
    int socket_ = -1;
};

// Runs an emulated device that a debugger may crash.
class Patient
{
  public:
    explicit Patient(int icount_shift)
        : path_((std::filesystem::temp_directory_path() / ("cournand_crash_" + std::to_string(getpid())))
                    .string()),
          debugger(path_), helper_([this] { debugger.release(); }),
          bench(hil::PlantSettings{}, crn::EmulatorOptions{{}, icount_shift, {}, path_})
    {
        helper_.join();
    }
    ~Patient() { std::filesystem::remove(path_); }

    // Waits until the text `words` appears on the console.
    void expect_console(const char *words)
    {
        for (int i = 0; i < 100 * patience_s; i++, usleep(10000))
            if (bench.emulator().console().find(words) != std::string::npos) return;
        hil::check(false, "the console does not say '%s' but:\n%s", words,
                   bench.emulator().console().c_str());
    }
    void jump_to(std::uint32_t address)
    {
        debugger.stop();
        debugger.set_program_counter(address);
        debugger.go_on();
    }
    // Turns the processor's interrupts off and runs an endless loop, so that the device hangs. While its
    // interrupts are off, the processor cannot be in the handler of a millisecond when the watchdog acts. The
    // watchdog acts one minute after it was last reset, and a minute is a whole number of milliseconds. The
    // watchdog may therefore act just after a millisecond has begun, while the processor runs that
    // millisecond's handler.
    void hang()
    {
        debugger.stop();
        debugger.write_code(spare, "72b6fee7"); // cpsid i, b .
        debugger.set_program_counter(spare);
        debugger.go_on();
    }
    bool has_power()
    {
        const rig_outputs &outputs = bench.emulator().page().device.outputs;
        bool has = rig_read(&outputs.enable) != 0;
        for (int k = 0; k < RIG_TRACK_COUNT; k++)
            has = has || rig_read(&outputs.axial_mN[k]) != 0 || rig_read(&outputs.torque_uN_m[k]) != 0;
        return has;
    }
    void expect_new_start(std::uint32_t before)
    {
        for (int i = 0; i < 100 * patience_s && bench.emulator().boot_count() == before; i++) usleep(10000);
        hil::check(bench.emulator().boot_count() == before + 1,
                   "the watchdog does not start the device again");
    }

  private:
    std::string path_;

  public:
    Debugger debugger;

  private:
    std::thread helper_;

  public:
    hil::EmulatedBench bench;
};

// The macro fail_msg of cmocka leaves a failed test by a jump that runs no destructors. The tests therefore
// throw exceptions, and this function calls fail_msg after the destructors have run.
void guarded(void (*body)())
{
    std::string why;
    try {
        body();
    } catch (const std::exception &error) {
        why = error.what();
    }
    if (!why.empty()) fail_msg("%s", why.c_str());
}

// In this test the motors exert a force, and the emulated processor executes 1,000 instructions per us.
void power_goes_with_a_hard_fault()
{
    Patient patient(0);
    crn::Link link(patient.bench.pipe());
    hil::set_up(link);
    hil::start_free_run(patient.bench, link);
    hil::push_by_spring_hand(patient.bench.plant());
    hil::keep_running(link, 100);
    hil::check(patient.has_power() && patient.bench.plant().is_stage_on(), "no power before the fault");
    patient.jump_to(nowhere);
    patient.expect_console("power off");
    hil::check(!patient.has_power(), "the crashed device still asks for power");
    hil::Plant &plant = patient.bench.plant();
    crn_port_outputs outputs = patient.bench.outputs();
    outputs.enable = false; // as in the rig page
    plant.step(outputs);
    hil::check(!plant.is_stage_on(), "the power stage holds");
    patient.expect_console("fault: exception 3 at pc 0x50000000");
}

// In this test each instruction takes 1 us of emulated time. The test runs no millisecond handler and loads
// no scenes. The emulator therefore needs less than a second of real time for the minute after which the
// watchdog acts.
constexpr int slowest = 10;

void the_watchdog_starts_a_crashed_device_again_and_it_says_why()
{
    Patient patient(slowest);
    const std::uint32_t starts = patient.bench.emulator().boot_count();
    patient.jump_to(nowhere);
    patient.expect_new_start(starts);
    patient.expect_console("the last start ended by exception 3 at pc 0x50000000");
    const rig_crash &crash = patient.bench.emulator().page().device.crash;
    hil::check(crash.exception == hard_fault && crash.pc == nowhere, "exception %u at %08x is kept",
               unsigned{crash.exception}, unsigned{crash.pc});
    hil::check(!patient.has_power(), "power after a start");
}

void the_watchdog_ends_a_loop_and_the_host_is_told()
{
    Patient patient(slowest);
    const std::uint32_t starts = patient.bench.emulator().boot_count();
    patient.hang();
    patient.expect_console("watchdog: exception 2 at pc 0x003ff002");
    hil::check(!patient.has_power(), "the device that hung still asks for power");
    patient.expect_new_start(starts);
    patient.expect_console("the last start ended by exception 2 at pc 0x003ff002: watchdog");
    hil::check(patient.bench.emulator().page().device.crash.exception == watchdog, "another cause is kept");
    patient.bench.emulator().wait(
        [&] { return rig_read(&patient.bench.emulator().page().device.magic) == RIG_MAGIC; }, "the device");
    std::string first_error;
    try {
        crn::Link old(patient.bench.pipe());
        old.hello();
    } catch (const crn::LinkError &error) {
        first_error = error.what();
    }
    hil::check(first_error.find("started again") != std::string::npos, "the host is not told: '%s'",
               first_error.c_str());
    crn::Link link(patient.bench.pipe());
    hil::check(link.hello().accepted && link.read_status().state == CRN_WIRE_STATE_READY,
               "no new conversation");
}

void test_power(void **)
{
    guarded(power_goes_with_a_hard_fault);
}

void test_crash(void **)
{
    guarded(the_watchdog_starts_a_crashed_device_again_and_it_says_why);
}

void test_loop(void **)
{
    guarded(the_watchdog_ends_a_loop_and_the_host_is_told);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        {"power_goes_with_a_hard_fault", test_power, nullptr, nullptr, nullptr},
        {"the_watchdog_starts_a_crashed_device_again_and_it_says_why", test_crash, nullptr, nullptr, nullptr},
        {"the_watchdog_ends_a_loop_and_the_host_is_told", test_loop, nullptr, nullptr, nullptr},
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
