// Tests the commands of `cournand rig`: each must print what the device reports, write only settings that the
// user confirmed, and read these settings back. A command may power a motor only after the user has typed
// yes. A command that the user stops must leave the rig as the command found it. The functions for the HID
// interface must survive a rig that sends false reports.
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/port/sim/sim.h"
#include "host/link/usb_devices.hpp"
#include "host/rig/rig.hpp"
#include <hidapi/hidapi.h>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

// Simulates a rig whose sensor values the test sets.
class Rig final : public crn::Transport
{
  public:
    Rig() : sim(crn_sim_create(1 << 20)), inputs(crn_sim_healthy_inputs()) { sample(); }
    ~Rig() override { crn_sim_destroy(sim); }
    void write(std::span<const std::uint8_t> bytes) override
    {
        crn_sim_write(sim, bytes.data(), bytes.size());
    }
    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        return crn_sim_read(sim, bytes.data(), bytes.size());
    }
    void pass_time_ms(std::uint32_t milliseconds) override
    {
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            inputs.hands[0].translation_counts += push_counts_per_ms;
            if (powered_ms == stop_after_ms) inputs.emergency_stop = true;
            sample();
            const crn_sim_motors motors = crn_sim_read_motors(sim);
            largest_mN = std::max(largest_mN, std::abs(motors.axial_mN[0]));
            powered_ms += static_cast<unsigned>(motors.drive);
        }
    }
    void sample()
    {
        crn_sim_set_inputs(sim, &inputs);
        crn_sim_timer(sim, 1);
    }

    crn_sim *sim;
    crn_port_inputs inputs;
    std::int32_t push_counts_per_ms = 0, largest_mN = 0;
    unsigned powered_ms = 0, stop_after_ms = ~0u; // then the emergency stop is pressed
};

// A user with prepared answers. Before each answer of the simulated user, a function of the test may change
// something at the rig. `text` collects the output of the command.
struct User {
    std::deque<std::pair<std::string, std::function<void()>>> answers;
    bool is_interrupted = false;
    std::string text;
    char *buffer = nullptr;
    std::size_t bytes = 0;

    int run(const std::function<int(const crn::RigTalk &)> &command)
    {
        crn::RigTalk talk;
        talk.out = open_memstream(&buffer, &bytes);
        talk.is_interrupted = [this] { return is_interrupted; };
        talk.read_line = [this](std::string &line) {
            if (answers.empty()) return false;
            if (answers.front().second) answers.front().second();
            line = answers.front().first;
            answers.pop_front();
            return true;
        };
        int code = -1;
        std::string stopped;
        try {
            code = command(talk);
        } catch (const std::exception &error) {
            stopped = error.what();
        }
        std::fclose(talk.out);
        text = std::string(buffer, bytes) + stopped;
        std::free(buffer);
        return code;
    }
    void expect(const std::string &part) const
    {
        if (text.find(part) == std::string::npos) fail_msg("no '%s' in:\n%s", part.c_str(), text.c_str());
    }
};

struct Bench {
    Rig rig;
    crn::Link link{rig};
    crn_wire_hello_reply hello = link.hello();
    crn::RigOptions options;
    User user;
    int selftest()
    {
        return user.run(
            [&](const crn::RigTalk &talk) { return crn::rig_selftest(link, hello, options, talk); });
    }
    int calibrate()
    {
        return user.run([&](const crn::RigTalk &talk) { return crn::rig_calibrate(link, options, talk); });
    }
    int force()
    {
        return user.run([&](const crn::RigTalk &talk) { return crn::rig_force(link, options, talk); });
    }
};

// --- reading ---

void info_and_log_say_what_the_device_says(void **)
{
    Bench b;
    assert_int_equal(
        b.user.run([&](const crn::RigTalk &talk) { return crn::rig_info(b.link, b.hello, b.options, talk); }),
        0);
    for (const char *part : {"protocol 7.", "LOCKSTEP, FREE_RUN", "READY", "track 3", "8.000 N, 20.000 N mm"})
        b.user.expect(part);
    b.options.json = true;
    assert_int_equal(
        b.user.run([&](const crn::RigTalk &talk) { return crn::rig_info(b.link, b.hello, b.options, talk); }),
        0);
    b.user.expect("\"force_limit_mN\": 8000");
    b.user.run([&](const crn::RigTalk &talk) { return crn::rig_log(b.link, talk); });
    b.user.expect("no faults since power-up");
}

void selftest_passes_on_a_healthy_rig_and_powers_nothing(void **)
{
    Bench b;
    assert_int_equal(b.selftest(), 0);
    for (const char *part :
         {"pass  emergency stop", "pass  track 1 translation encoder: good",
          "pass  track 3 force at rest: 0 mN", "pass  track 2 force limit: the host cannot raise it",
          "motors: not powered", " 0 failed"})
        b.user.expect(part);
    assert_int_equal(b.rig.powered_ms, 0);
}

void selftest_names_each_thing_that_is_wrong(void **)
{
    const struct {
        std::function<void(crn_port_inputs &)> spoil;
        const char *line;
    } cases[] = {
        {[](crn_port_inputs &in) { in.tracks[1].translation_sensor = CRN_PORT_SENSOR_ERROR; },
         "FAIL  track 2 translation encoder: signal error"},
        {[](crn_port_inputs &in) { in.tracks[2].rotation_sensor = CRN_PORT_SENSOR_RANGE; },
         "FAIL  track 3 rotation encoder: out of its electrical range"},
        {[](crn_port_inputs &in) { in.tracks[0].force_sensor = CRN_PORT_SENSOR_ABSENT; },
         "track 1 force sensor: absent"},
        {[](crn_port_inputs &in) { in.tracks[0].force_raw = 700; }, "FAIL  track 1 force at rest: 700 mN"},
        {[](crn_port_inputs &in) { in.tracks[0].over_current = true; }, "FAIL  track 1 motor driver"},
        {[](crn_port_inputs &in) { in.emergency_stop = true; }, "FAIL  emergency stop"},
        {[](crn_port_inputs &in) { in.supply_good = false; }, "FAIL  motors' supply"},
        {[](crn_port_inputs &in) { in.syringe_sensor = CRN_PORT_SENSOR_ERROR; },
         "FAIL  contrast syringe: signal error"},
    };
    for (const auto &one : cases) {
        Bench b;
        one.spoil(b.rig.inputs);
        b.rig.sample();
        b.selftest();
        b.user.expect(one.line);
    }
    Bench moving;
    moving.rig.push_counts_per_ms = 3;
    assert_int_equal(moving.selftest(), 1);
    moving.user.expect("FAIL  track 1 translation at rest: 300 counts");
}

void selftest_powers_a_motor_after_a_typed_yes_only(void **)
{
    for (const char *answer : {"no", "", "y", "yes"}) {
        Bench b;
        b.options.motors = true;
        b.options.damping_N_s_per_m = 1.0;
        b.user.answers = {{answer, {}}};
        assert_int_equal(b.selftest(), 0);
        const bool is_yes = std::string(answer) == "yes";
        b.user.expect(is_yes ? "motor: powered in" : "not confirmed, not powered");
        assert_true((b.rig.powered_ms > 900) == is_yes);
        assert_int_equal(crn_sim_read_motors(b.rig.sim).drive, 0);
    }
}

// --- force ---

void force_resists_a_push_by_what_was_asked_and_gives_the_rig_back(void **)
{
    Bench b;
    b.options.yes = true;
    b.options.seconds = 2.0;
    b.options.force_mN = 300;
    b.options.damping_N_s_per_m = 1.0;
    b.rig.push_counts_per_ms = 20; // 20 mm/s
    const crn_wire_rig before = b.link.read_rig();
    assert_int_equal(b.force(), 0);
    b.user.expect("done after");
    b.user.expect("8.000 N, 20.000 N mm"); // the limits are shown
    assert_in_range(b.rig.largest_mN, 200, 330);
    const crn_wire_rig after = b.link.read_rig();
    assert_memory_equal(&before, &after, sizeof before);
    assert_int_equal(b.link.read_status().state, CRN_WIRE_STATE_READY);
    assert_int_equal(crn_sim_read_motors(b.rig.sim).drive, 0);
}

void force_gives_nothing_without_a_yes_and_ends_at_ctrl_c(void **)
{
    Bench b;
    b.options.damping_N_s_per_m = 1.0;
    b.user.answers = {{"yess", {}}};
    assert_int_equal(b.force(), -1);
    b.user.expect("no motor was powered");
    assert_int_equal(b.rig.powered_ms, 0);
    b.user.answers = {{"yes", [&] { b.user.is_interrupted = true; }}};
    assert_int_equal(b.force(), -1);
    b.user.expect("interrupted; the motor is off");
    assert_int_equal(crn_sim_read_motors(b.rig.sim).drive, 0);
    assert_int_equal(b.link.read_rig().tracks[0].coupling_N_per_m, 0);
    b.options.damping_N_s_per_m = 0.0;
    assert_int_equal(b.force(), -1);
    b.user.expect("--damping");
}

void a_fault_in_the_trial_is_told_and_logged(void **)
{
    Bench b;
    b.options.damping_N_s_per_m = 1.0;
    b.options.yes = true;
    b.rig.stop_after_ms = 200;
    assert_int_equal(b.force(), -1);
    b.user.expect("EMERGENCY_STOP: the emergency stop was pressed");
    b.user.expect("Remedy: release it");
    assert_int_equal(crn_sim_read_motors(b.rig.sim).drive, 0);
    b.user.run([&](const crn::RigTalk &talk) { return crn::rig_log(b.link, talk); });
    b.user.expect("EMERGENCY_STOP");
    b.user.expect("remedy: release it");
}

// --- calibration ---

// In the simulated calibration, 100 mm of motion give 4 000 counts in the opposite direction, and each of the
// tool's 2 turns gives 1 024 counts. The force sensor reads -120 counts without force, and 1 000 counts more
// with a weight of 100 g.
void script_motion(Bench &b)
{
    b.options.turns = 2.0;
    b.user.answers = {{"", {}},
                      {"", [&] { b.rig.inputs.hands[0].translation_counts -= 4000, b.rig.sample(); }},
                      {"", {}},
                      {"", [&] { b.rig.inputs.hands[0].rotation_counts += 2048, b.rig.sample(); }},
                      {"", [&] { b.rig.inputs.tracks[0].force_raw = -120, b.rig.sample(); }},
                      {"", [&] { b.rig.inputs.tracks[0].force_raw = 880, b.rig.sample(); }},
                      {"yes", [&] { b.rig.inputs.tracks[0].force_raw = -120; }}};
}

void calibration_is_measured_written_and_read_back(void **)
{
    Bench b;
    script_motion(b);
    assert_int_equal(b.calibrate(), 0);
    b.user.expect("written and read back");
    const crn_wire_track track = b.link.read_rig().tracks[0];
    assert_int_equal(track.translation_pm_per_count, 25000000);
    assert_int_equal(track.rotation_counts_per_turn, 1024);
    assert_int_equal(track.options, CRN_WIRE_OPTION_TRANSLATION_REVERSED);
    assert_int_equal(track.force_zero_counts, -120);
    assert_int_equal(track.force_uN_per_count, 981); // 0.980665 N / 1 000
}

void a_calibration_that_is_stopped_anywhere_changes_nothing(void **)
{
    for (std::size_t stop = 0; stop < 7; stop++) {
        Bench b;
        const crn_wire_rig before = b.link.read_rig();
        script_motion(b);
        b.user.answers.resize(stop);
        assert_int_equal(b.calibrate(), -1);
        b.user.expect("nothing was changed");
        const crn_wire_rig after = b.link.read_rig();
        assert_memory_equal(&before, &after, sizeof before);
    }
}

void a_motion_that_cannot_be_meant_is_refused(void **)
{
    Bench b;
    b.user.answers = {{"", {}}, {"", {}}};
    assert_int_equal(b.calibrate(), -1);
    b.user.expect("moved by 0 counts only");
    b.options.what = "force";
    b.user.answers = {{"", {}}, {"", [&] { b.rig.inputs.tracks[0].force_raw = -300; }}};
    assert_int_equal(b.calibrate(), -1);
    b.user.expect("swap its signal wires");
}

void a_calibration_is_saved_and_loaded(void **)
{
    const std::string path = "/tmp/cournand_test_rig_" + std::to_string(rand()) + ".json";
    Bench b;
    script_motion(b);
    b.options.save = path;
    assert_int_equal(b.calibrate(), 0);
    Bench fresh;
    fresh.options.load = path;
    fresh.options.yes = true;
    assert_int_equal(fresh.calibrate(), 0);
    assert_int_equal(fresh.link.read_rig().tracks[0].force_zero_counts, -120);
    assert_int_equal(fresh.calibrate(), 0);
    fresh.user.expect("has these values already");
    for (const char *text :
         {"", "{}", "[1]", "{\"tracks\": 3}", "{\"tracks\": [{}]}", "{\"tracks\": [1,2,3,4]}"}) {
        std::ofstream(path) << text;
        assert_int_equal(fresh.calibrate(), -1);
        fresh.user.expect(path);
    }
    std::remove(path.c_str());
}

// --- HID ---

struct FakeHid {
    std::deque<std::vector<unsigned char>> reports;
    std::vector<unsigned char> identity;
    crn_hid_limits limits{};
    bool is_gone = false, is_refusing = false, is_deaf = false, is_forbidden = false;
    unsigned rigs = 1, opens = 0;
    std::uint32_t tick = 0;
    std::uint8_t command = 0, result = 0;
};
FakeHid hid;

std::vector<unsigned char> state_report(std::uint32_t tick)
{
    std::vector<unsigned char> bytes(1 + CRN_HID_BYTES_state, CRN_HID_ID_state);
    crn_hid_state state{};
    state.tick = tick;
    state.state = CRN_WIRE_STATE_READY;
    state.command_number = hid.command;
    state.command_result = hid.result;
    state.tracks[1].translation_counts = -5;
    crn_wire_writer writer = crn_wire_writer_make(bytes.data() + 1, bytes.size() - 1);
    crn_hid_put_state(&writer, &state);
    return bytes;
}

crn::HidApi fake_api()
{
    hid = {};
    hid.identity.assign(1 + CRN_HID_BYTES_identity, CRN_HID_ID_identity);
    const crn_hid_identity identity = {3, 0, crn_wire_schema_hash(), crn_hid_report_hash(), 1};
    crn_wire_writer writer = crn_wire_writer_make(hid.identity.data() + 1, hid.identity.size() - 1);
    crn_hid_put_identity(&writer, &identity);
    crn::HidApi api;
    api.name = "fake";
    api.enumerate = [](unsigned short, unsigned short) {
        hid_device_info *list = nullptr;
        for (unsigned i = hid.rigs; i > 0; i--) {
            auto *one = new hid_device_info{};
            one->path = strdup(("/dev/hidraw" + std::to_string(i)).c_str());
            one->serial_number = wcsdup((L"RIG-000" + std::to_wstring(i)).c_str());
            one->next = list;
            list = one;
        }
        return list;
    };
    api.free_enumeration = [](hid_device_info *list) {
        while (list != nullptr) {
            hid_device_info *next = list->next;
            std::free(list->path);
            std::free(list->serial_number);
            delete list;
            list = next;
        }
    };
    api.open_path = [](const char *) -> hid_device_ * {
        if (hid.is_forbidden) return nullptr;
        hid.opens++;
        return reinterpret_cast<hid_device_ *>(&hid);
    };
    api.close = [](hid_device_ *) { hid.opens--; };
    api.read_timeout = [](hid_device_ *, unsigned char *bytes, std::size_t capacity, int) {
        if (hid.is_gone) return -1;
        if (hid.reports.empty() && !hid.is_deaf) hid.reports.push_back(state_report(++hid.tick));
        if (hid.reports.empty()) return 0;
        const std::vector<unsigned char> report = hid.reports.front();
        hid.reports.pop_front();
        std::copy_n(report.begin(), std::min(capacity, report.size()), bytes);
        return static_cast<int>(std::min(capacity, report.size()));
    };
    api.write = [](hid_device_ *, const unsigned char *bytes, std::size_t count) {
        if (hid.is_gone) return -1;
        hid.command = bytes[1];
        return static_cast<int>(count);
    };
    api.get_feature_report = [](hid_device_ *, unsigned char *bytes, std::size_t capacity) {
        if (bytes[0] == CRN_HID_ID_limits) {
            crn_wire_writer out = crn_wire_writer_make(bytes + 1, capacity - 1);
            crn_hid_put_limits(&out, &hid.limits);
            return 1 + CRN_HID_BYTES_limits;
        }
        std::copy(hid.identity.begin(), hid.identity.end(), bytes);
        return static_cast<int>(hid.identity.size());
    };
    api.send_feature_report = [](hid_device_ *, const unsigned char *bytes, std::size_t count) {
        if (hid.is_refusing) return -1;
        crn_hid_decode_limits(bytes + 1, count - 1, &hid.limits);
        return static_cast<int>(count);
    };
    api.error = [](hid_device_ *) -> const wchar_t * { return L"no such thing"; };
    return api;
}

void expect_hid_error(const std::function<void()> &action, const std::string &part)
{
    try {
        action();
    } catch (const crn::LinkError &error) {
        if (std::string(error.what()).find(part) == std::string::npos)
            fail_msg("'%s' does not hold '%s'", error.what(), part.c_str());
        return;
    }
    fail_msg("no error, expected '%s'", part.c_str());
}

void reports_are_decoded_commands_answered_and_limits_read_back(void **)
{
    const crn::HidApi api = fake_api();
    crn::HidRig rig(api, "");
    const auto state = rig.read_state(10);
    assert_true(state && state->tick == 1 && state->state == CRN_WIRE_STATE_READY);
    assert_int_equal(state->tracks[1].translation_counts, -5);
    assert_int_equal(rig.command(CRN_WIRE_ACTION_STOP, 0, 0).state, CRN_WIRE_STATE_READY);
    hid.result = CRN_REJECT_WRONG_STATE;
    expect_hid_error([&] { rig.command(CRN_WIRE_ACTION_START, 0, 0); }, "WRONG_STATE");
    crn_hid_limits limits{};
    limits.tracks[0].force_limit_mN = 1000;
    assert_int_equal(rig.write_limits(limits).tracks[0].force_limit_mN, 1000);
    hid.is_refusing = true;
    expect_hid_error([&] { rig.write_limits(limits); }, "refused to change its limits (no such thing)");
}

void a_lying_hid_rig_leaves_the_host_alive(void **)
{
    const crn::HidApi api = fake_api();
    {
        crn::HidRig rig(api, "");
        hid.is_deaf = true;
        hid.reports = {{},
                       {1},
                       std::vector<unsigned char>(10, 1),
                       std::vector<unsigned char>(64, 9),
                       std::vector<unsigned char>(200, 9)};
        for (int i = 0; i < 6; i++) assert_false(rig.read_state(0).has_value());
        assert_int_equal(rig.reports_bad(), 4);
        expect_hid_error([&] { rig.command(1, 0, 0, 20); }, "did not answer a command within 20 ms");
        hid.is_gone = true;
        expect_hid_error([&] { rig.read_state(10); }, "RIG-0001' is gone");
        expect_hid_error([&] { rig.command(1, 0, 0); }, "is gone");
    }
    assert_int_equal(hid.opens, 0);
    hid.identity[20]++; // the report hash
    expect_hid_error([&] { crn::HidRig(api, ""); }, "has other reports");
    hid.identity.resize(5);
    expect_hid_error([&] { crn::HidRig(api, ""); }, "does not have its form (5 bytes");
    hid.is_forbidden = true;
    expect_hid_error([&] { crn::HidRig(api, ""); }, "sudo make install-udev");
    hid.rigs = 2;
    expect_hid_error([&] { crn::HidRig(api, ""); }, "several rigs");
    expect_hid_error([&] { crn::HidRig(api, "RIG-0009"); }, "RIG-0002 at /dev/hidraw2");
    hid.rigs = 0;
    expect_hid_error([&] { crn::HidRig(api, ""); }, "no rig is on USB");
    assert_int_equal(hid.opens, 0);
}

void monitor_shows_counts_and_keeps_every_report(void **)
{
    const std::string path = "/tmp/cournand_test_rig_" + std::to_string(rand()) + ".csv";
    crn::RigOptions options;
    options.csv = path;
    std::uint32_t tick = 0;
    User user;
    const int code = user.run([&](const crn::RigTalk &talk) {
        return crn::rig_monitor(
            [&]() -> std::optional<crn_hid_state> {
                if (tick >= 1000) user.is_interrupted = true;
                crn_hid_state state{};
                state.tick = tick += tick == 500 ? 4 : 1; // three are lost
                state.state = CRN_WIRE_STATE_RUNNING;
                state.tracks[2].translation_counts = 77;
                return state;
            },
            options, talk);
    });
    assert_int_equal(code, 0);
    user.expect("998 reports");
    user.expect("3 ticks lost");
    user.expect("| 3: 77 0 counts");
    std::ifstream in(path);
    std::string line;
    unsigned lines = 0;
    while (std::getline(in, line)) lines++;
    assert_int_equal(lines, 999);
    std::remove(path.c_str());
}

void monitor_tells_silence_and_a_rig_that_went(void **)
{
    User user;
    const crn::RigOptions options;
    const auto silent = []() -> std::optional<crn_hid_state> { return std::nullopt; };
    assert_int_equal(
        user.run([&](const crn::RigTalk &talk) { return crn::rig_monitor(silent, options, talk); }), 1);
    const auto gone = []() -> std::optional<crn_hid_state> { throw crn::DeviceLost("gone"); };
    assert_int_equal(
        user.run([&](const crn::RigTalk &talk) { return crn::rig_monitor(gone, options, talk); }), 1);
    user.expect("0 reports");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(info_and_log_say_what_the_device_says),
        cmocka_unit_test(selftest_passes_on_a_healthy_rig_and_powers_nothing),
        cmocka_unit_test(selftest_names_each_thing_that_is_wrong),
        cmocka_unit_test(selftest_powers_a_motor_after_a_typed_yes_only),
        cmocka_unit_test(force_resists_a_push_by_what_was_asked_and_gives_the_rig_back),
        cmocka_unit_test(force_gives_nothing_without_a_yes_and_ends_at_ctrl_c),
        cmocka_unit_test(a_fault_in_the_trial_is_told_and_logged),
        cmocka_unit_test(calibration_is_measured_written_and_read_back),
        cmocka_unit_test(a_calibration_that_is_stopped_anywhere_changes_nothing),
        cmocka_unit_test(a_motion_that_cannot_be_meant_is_refused),
        cmocka_unit_test(a_calibration_is_saved_and_loaded),
        cmocka_unit_test(reports_are_decoded_commands_answered_and_limits_read_back),
        cmocka_unit_test(a_lying_hid_rig_leaves_the_host_alive),
        cmocka_unit_test(monitor_shows_counts_and_keeps_every_report),
        cmocka_unit_test(monitor_tells_silence_and_a_rig_that_went),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
