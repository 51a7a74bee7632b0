// These tests check sessions in which the rig sets the pace and its encoders measure the hands (FREE_RUN,
// docs/rig.md). A recording contains the measured motion of the hands tick by tick. A LOCKSTEP replay of the
// recording gives the same state hashes, even if the cable was pulled during the session. When a rig stops,
// the session ends and reports the cause. The rig in these tests is the simulated rig of test level 0, with a
// hand that pushes against powered motors.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include "host/link/usb_devices.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

// Simulates a cable between the host and a test bench. The cable fails after a given number of reads; when
// the host opens the device again, the test creates a new cable.
class Cable final : public crn::Transport
{
  public:
    Cable(hil::Bench &bench, std::uint32_t &reads_left) : bench_(bench), reads_left_(reads_left)
    {
        std::uint8_t left_behind[4096];
        while (bench_.pipe().read(left_behind) > 0) {
        }
    }
    void write(std::span<const std::uint8_t> bytes) override
    {
        check();
        bench_.pipe().write(bytes);
    }
    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        if (reads_left_ > 0 && --reads_left_ == 0) is_gone_ = true;
        check();
        return bench_.pipe().read(bytes);
    }
    void pass_time_ms(std::uint32_t milliseconds) override { bench_.pipe().pass_time_ms(milliseconds); }

  private:
    void check() const
    {
        if (is_gone_) throw crn::DeviceLost("gone");
    }
    hil::Bench &bench_;
    std::uint32_t &reads_left_;
    bool is_gone_ = false;
};

struct Trial {
    explicit Trial(bool with_motors) : bench({})
    {
        choice.free_run = true;
        choice.powers_motors = with_motors;
        choice.opens = [this] {
            if (++opens > 1) bench.advance(away_ms); // the rig runs on without the host
            return std::make_unique<Cable>(bench, reads_left);
        };
        choice.return_limit_ms = 1000;
        crn::Link link(bench.pipe());
        hil::set_up(link); // the rig gets its couplings
        hil::push_by_spring_hand(bench.plant());
        bench.plant().track(0).translation.set_hand(hil::Hand::spring);
    }

    crn::RunResult run(double seconds, const std::function<void(crn::Device &)> &before = {})
    {
        const crn::SceneFile scene = crn::read_scene("");
        const std::vector<crn::Instrument> tools = {
            crn::read_instrument("shared/examples/instruments/j_wire.toml")};
        const crn_wire_entry entry = crn::entry_of(scene, 1, {});
        crn::Device device(scene, tools, entry, crn::host_rig(), choice);
        if (before) before(device);
        const crn::RecordingHeader header = device.recording_header("rig");
        crn::Recorder recorder(path, header);
        crn::Patient patient({}, tools);
        return crn::run_free_session(device, patient, {}, seconds, &recorder, nullptr, {});
    }

    // Replays every recorded tick on a separate device in the host's process.
    void check_replay(const crn::RunResult &result)
    {
        const crn::Recording recording = crn::read_recording(path);
        const crn::SceneFile scene = crn::read_scene("");
        for (double from_s : {0.0, result.figures.ticks * 0.7e-3}) {
            crn::Device device(scene, recording.header.tools, recording.header.entry, recording.header.rig);
            crn::ReplaySettings settings;
            settings.verifies = true;
            settings.from_s = from_s;
            const crn::ReplayResult replay =
                crn::replay_recording(device, recording, nullptr, nullptr, settings);
            if (replay.first_difference_tick) {
                fail_msg("from %.1f s: tick %u: %s", from_s, unsigned{*replay.first_difference_tick},
                         replay.difference.c_str());
            }
            assert_int_equal(replay.tick, result.figures.ticks);
            if (recording.is_complete) assert_true(replay.hash == result.hash);
        }
    }

    hil::SimBench bench;
    crn::DeviceChoice choice;
    std::uint32_t reads_left = 0, away_ms = 1500;
    int opens = 0;
    std::string path =
        (std::filesystem::temp_directory_path() / ("cournand_free_run_" + std::to_string(getpid()) + ".rec"))
            .string();
    ~Trial() { std::filesystem::remove(path); }
};

void what_hands_do_at_a_rig_replays_bit_for_bit(void **)
{
    for (bool with_motors : {false, true}) {
        Trial trial(with_motors);
        const crn::RunResult result = trial.run(2.0);
        if (!result.stopped_by.empty()) fail_msg("%s", result.stopped_by.c_str());
        assert_in_range(result.figures.ticks, 2000, 2060);
        assert_int_equal(result.powered_ticks > 0, with_motors);
        assert_true(result.pictures > 100);
        print_message("# %s: %.1f mm inserted, %u ticks with power\n", with_motors ? "motors" : "no motors",
                      result.figures.tools[0].inserted_m * 1e3, result.powered_ticks);
        assert_true(result.figures.tools[0].inserted_m > 0.03); // it began with 20 mm
        trial.check_replay(result);
    }
}

// The rig continues without the host for 1.5 s. After 1.5 s without contact, the host resumes the session
// from the last tick that the host has received.
void a_session_goes_on_after_an_unplug_and_replays_bit_for_bit(void **)
{
    for (std::uint32_t cut : {100u, 401u, 702u}) {
        Trial trial(true);
        const crn::RunResult result = trial.run(2.0, [&](crn::Device &) { trial.reads_left = cut; });
        if (!result.stopped_by.empty()) fail_msg("%s", result.stopped_by.c_str());
        print_message("# cut after %u reads: %u ticks, came back %u times\n", cut, result.figures.ticks,
                      result.resumes);
        assert_int_equal(result.resumes, 1);
        assert_int_equal(crn::read_recording(trial.path).resumes.size(), 1);
        assert_in_range(result.figures.ticks, 2000, 2060);
        trial.check_replay(result);
    }
}

// The host keeps the inputs of about free_run_kept_max ticks. If the host resumes a session that is longer
// than about free_run_kept_max ticks, the resumed session begins with a snapshot, which the recording
// contains.
void a_long_session_resumes_from_a_snapshot(void **)
{
    Trial trial(false);
    trial.bench.plant().track(0).translation.move_hand(0.01);
    const crn::RunResult result = trial.run(13.0, [&](crn::Device &) { trial.reads_left = 4700; });
    if (!result.stopped_by.empty()) fail_msg("%s", result.stopped_by.c_str());
    assert_int_equal(result.resumes, 1);
    assert_true(!crn::read_recording(trial.path).snapshots.empty());
    trial.check_replay(result);
}

void a_rig_that_stops_ends_the_session_with_the_cause(void **)
{
    Trial trial(true);
    crn::RunResult result = trial.run(2.0, [&](crn::Device &) { trial.bench.plant().emergency_stop = true; });
    print_message("# %s\n", result.stopped_by.c_str());
    assert_true(result.stopped_by.find("EMERGENCY_STOP") != std::string::npos);
    assert_true(result.stopped_by.find("Remedy: ") != std::string::npos);
    assert_true(result.figures.ticks < 2000);
    assert_int_equal(crn::read_recording(trial.path).ticks.size(), result.figures.ticks);
    if (result.figures.ticks > 0) trial.check_replay(result);
}

void motors_without_a_coupling_are_refused_with_a_remedy(void **)
{
    Trial trial(true);
    crn::Link link(trial.bench.pipe());
    link.hello();
    link.set_rig(crn::host_rig());
    try {
        trial.run(1.0);
    } catch (const crn::LinkError &error) {
        assert_true(std::string(error.what()).find("Remedy: ") != std::string::npos);
        return;
    }
    fail_msg("a rig without a coupling was powered");
}

// A tick of the J wire in free space takes more than 100,000 cycles. The device keeps LOCKSTEP for the
// set-up, and a session follows that is not led by the rig. Requirement: SR-27
void a_rig_too_slow_for_the_set_up_is_refused_with_figures_and_a_remedy(void **)
{
    Trial trial(false);
    trial.bench.set_tick_cycles(100000);
    std::string said;
    try {
        trial.run(1.0);
    } catch (const crn::LinkError &error) {
        said = error.what();
        assert_int_equal(error.reject.code, CRN_REJECT_TOO_SLOW);
    }
    print_message("# %s\n", said.c_str());
    assert_true(said.find("TOO_SLOW: ") != std::string::npos);
    assert_true(said.find(", 100000]. Remedy: ") != std::string::npos);
    crn::Link link(trial.bench.pipe());
    link.hello();
    assert_int_equal(link.read_status().state, CRN_WIRE_STATE_READY);
    assert_int_equal(link.read_rig().tracks[0].coupling_N_per_m, hil::plant_rig().tracks[0].coupling_N_per_m);
    trial.choice.free_run = false;
    const crn::SceneFile scene = crn::read_scene("");
    crn::Device device(scene, {crn::read_instrument("shared/examples/instruments/j_wire.toml")},
                       crn::entry_of(scene, 1, {}), crn::host_rig(), trial.choice);
    crn_wire_tick_input input{};
    input.hands_count = 1;
    assert_int_equal(device.step({&input, 1}, false).size(), 1);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(what_hands_do_at_a_rig_replays_bit_for_bit),
        cmocka_unit_test(a_session_goes_on_after_an_unplug_and_replays_bit_for_bit),
        cmocka_unit_test(a_long_session_resumes_from_a_snapshot),
        cmocka_unit_test(a_rig_that_stops_ends_the_session_with_the_cause),
        cmocka_unit_test(motors_without_a_coupling_are_refused_with_a_remedy),
        cmocka_unit_test(a_rig_too_slow_for_the_set_up_is_refused_with_figures_and_a_remedy),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
