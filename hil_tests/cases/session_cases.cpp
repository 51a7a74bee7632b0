// Tests that a session gives equal state hashes wherever the device runs, and that pauses do not change the
// hashes.
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include <chrono>
#include <cmath>

namespace hil
{

namespace
{

// Runs a LOCKSTEP session on the device of this test level and on the host's own device, and compares the
// state hashes of every tick and the final hash.
void lockstep_gives_the_hash_of_the_host_alone(Level &level, const CaseOptions &options, Report &report)
{
    const auto bench = level.make({});
    crn::Link link(bench->pipe());
    set_up(link);
    const Ending here = lockstep_session(link, options.ticks, 16);
    check_same(host_only_session(options.ticks, 64), here, "host alone and this level");
    report.add(
        text("%u ticks, hash %016llx", unsigned{here.tick}, static_cast<unsigned long long>(here.hash)));
}

// The processor is halted between two steps of a session, as under a debugger, while the rig's time goes on.
void a_pause_in_lockstep_changes_nothing(Level &level, const CaseOptions &options, Report &report)
{
    const auto bench = level.make({});
    crn::Link link(bench->pipe());
    set_up(link);
    const std::uint32_t ticks = std::min<std::uint32_t>(options.ticks, 96);
    int pauses = 0;
    const Ending paused = lockstep_session(link, ticks, 8, [&](std::uint32_t tick) {
        if (tick % 32 != 0) return;
        bench->freeze(10000, pauses++ == 0 ? options.pause_s : 0.0);
        bench->advance(1);
    });
    check_same(host_only_session(ticks, 8), paused, "without and with pauses");
    report.add(text("%d pauses of 10 s of the rig, the first %.1f s of ours", pauses, options.pause_s));
}

// Runs a FREE_RUN session with hand, rig, device and motors twice: at this test level and at level 0.
// Compares the motor forces, the motion of the tool and the state hashes.
void a_free_run_closes_the_loop_as_at_level_0(Level &level, const CaseOptions &options, Report &report)
{
    Ending endings[2];
    double places_m[2], peaks_N[2] = {0.0, 0.0};
    SimLevel reference;
    for (int i = 0; i < 2; i++) {
        PlantSettings settings;
        settings.translation_encoder.jitter_counts = 0.7;
        const auto bench = (i == 0 ? static_cast<Level &>(reference) : level).make(settings);
        crn::Link link(bench->pipe());
        set_up(link);
        start_free_run(*bench, link);
        push_by_spring_hand(bench->plant());
        for (std::uint32_t ms = 0; ms < options.free_ms; ms += 8) {
            keep_running(link, 8, &endings[i]);
            peaks_N[i] = std::max(peaks_N[i], bench->plant().motor_peak_N());
        }
        places_m[i] = bench->plant().track(0).translation.tool();
        check(bench->plant().is_stage_on(), "the motors lost power within the session");
        check(link.read_status().state == CRN_WIRE_STATE_RUNNING, "the session ended by itself");
    }
    check_same(endings[0], endings[1], "level 0 and this level");
    check(places_m[0] == places_m[1] && peaks_N[0] == peaks_N[1], "the tool is at %.9f m and %.9f m",
          places_m[0], places_m[1]);
    check(peaks_N[1] > 0.05 && peaks_N[1] <= 8.0, "the motors gave %.3f N at most, not 0.05 to 8 N",
          peaks_N[1]);
    report.add(text("%u ms, tool at %.1f mm, motor %.2f N at most", unsigned{options.free_ms},
                    places_m[1] * 1e3, peaks_N[1]));
}

// Every change at the rig's pedals, syringe and inflator must appear in the recorded inputs of the next
// ticks.
void pedals_syringe_and_inflator_reach_the_host(Level &level, const CaseOptions &, Report &report)
{
    const auto bench = level.make({});
    crn::Link link(bench->pipe());
    set_up(link);
    start_free_run(*bench, link);
    constexpr std::uint32_t xray = CRN_WIRE_BUTTON_XRAY, cine = CRN_WIRE_BUTTON_CINE;
    int changes = 0;
    for (const std::uint32_t pressed : {xray, xray | cine, cine, 0u}) {
        Plant &plant = bench->plant();
        plant.buttons = pressed;
        plant.syringe_counts += 700 + 100 * changes;
        plant.inflator_raw = 900 * ++changes; // within the 41 bar that the board measures
        keep_running(link, 8);
        link.free_run(16); // keeps the ticks of this call; a batch of them need not come within 8 ms
        check(!link.live_ticks().empty(), "no tick within 16 ms");
        const crn_wire_tick_input &input = link.live_ticks().back().input;
        check(input.buttons == pressed, "pedals %u, not %u", unsigned{input.buttons}, unsigned{pressed});
        check(input.syringe_counts == plant.syringe_counts, "syringe %d, not %d", int{input.syringe_counts},
              int{plant.syringe_counts});
        check(input.inflator_raw == plant.inflator_raw, "inflator %d, not %d", int{input.inflator_raw},
              int{plant.inflator_raw});
    }
    report.add(text("%d levels of two pedals, syringe and inflator", changes));
}

// When a tool slips on its roller, the encoder measures the motion of the roller, the session continues, and
// the hand feels at most the friction force between roller and tool.
void a_roller_that_slips_is_no_fault(Level &level, const CaseOptions &, Report &report)
{
    PlantSettings settings;
    settings.translation.grip_limit = 0.3;
    settings.rotation_encoder.jitter_counts = settings.translation_encoder.jitter_counts = 0.7;
    const auto bench = level.make(settings);
    crn::Link link(bench->pipe());
    set_up(link);
    start_free_run(*bench, link);
    push_by_spring_hand(bench->plant());
    double most_N = 0.0;
    for (std::uint32_t ms = 0; ms < 600; ms += 8) {
        keep_running(link, 8);
        most_N = std::max(most_N, std::abs(bench->plant().track(0).translation.force_on_hand()));
    }
    const Axis &axis = bench->plant().track(0).translation;
    const double slipped_m = axis.tool() - axis.roller();
    check(slipped_m > 1e-3, "the tool slipped by %.3f mm only", slipped_m * 1e3);
    check(link.read_status().state == CRN_WIRE_STATE_RUNNING, "the session ended: %s",
          crn_wire_fault_name(link.read_status().fault_code));
    check(most_N < 0.6, "the hand got %.3f N over a grip of 0.3 N", most_N);
    report.add(text("slipped by %.1f mm, %.2f N at most", slipped_m * 1e3, most_N));
}

// Requests and answers alternate for a second of wall-clock time, and no answer may be missing.
void every_question_is_answered(Level &level, const CaseOptions &, Report &report)
{
    using Clock = std::chrono::steady_clock;
    const auto bench = level.make({});
    crn::Link link(bench->pipe());
    link.hello();
    const crn_wire_status before = link.read_status();
    const Clock::time_point begin = Clock::now();
    int count = 0;
    while (Clock::now() - begin < std::chrono::seconds(1)) {
        link.read_status();
        count++;
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    const crn_wire_status after = link.read_status();
    check(after.frames_bad == before.frames_bad && after.sequence_gaps == before.sequence_gaps &&
              after.transmit_dropped == before.transmit_dropped,
          "of %d questions %u came broken, %u not at all, %u answers were not sent", count,
          unsigned{after.frames_bad - before.frames_bad},
          unsigned{after.sequence_gaps - before.sequence_gaps},
          unsigned{after.transmit_dropped - before.transmit_dropped});
    report.add(text("%.0f round trips/s of the whole link", count / seconds));
}

constexpr Case session_list[] = {
    {"lockstep_gives_the_hash_of_the_host_alone", lockstep_gives_the_hash_of_the_host_alone, false},
    {"every_question_is_answered", every_question_is_answered, false},
    {"a_pause_in_lockstep_changes_nothing", a_pause_in_lockstep_changes_nothing},
    {"a_free_run_closes_the_loop_as_at_level_0", a_free_run_closes_the_loop_as_at_level_0},
    {"pedals_syringe_and_inflator_reach_the_host", pedals_syringe_and_inflator_reach_the_host},
    {"a_roller_that_slips_is_no_fault", a_roller_that_slips_is_no_fault},
};

} // namespace

std::span<const Case> session_cases()
{
    return session_list;
}

} // namespace hil
