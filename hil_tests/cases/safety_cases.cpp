// Tests safety: whatever fails while the motors push against a hand, the motors lose power in time, and the
// device reports the cause. These cases measure the force at the emulated actuator, behind the power stage;
// the meter shows the largest force within each millisecond.
#include "hil_tests/cases/conversation.hpp"

namespace hil
{

namespace
{

constexpr double force_safe_N = 0.02;      // less than the bearing's friction
constexpr double torque_safe_N_m = 0.0002; // likewise
constexpr int safe_ms = 5, silent_safe_ms = 50;
constexpr std::uint32_t warm_up_ms = 400;

// Runs a session in FREE_RUN in which the hand feels a force, so that a case can then make one part of the
// rig fail.
struct Running {
    explicit Running(Level &level) : bench(level.make({})), link(bench->pipe())
    {
        set_up(link);
        start_free_run(*bench, link);
        push_by_spring_hand(bench->plant());
        keep_running(link, warm_up_ms);
        check(bench->plant().is_stage_on(), "the motors have no power after %u ms", unsigned{warm_up_ms});
        check(bench->plant().motor_peak_N() > 2.0 * force_safe_N,
              "the motors hold %.3f N only: nothing to lose", bench->plant().motor_peak_N());
    }
    bool is_safe()
    {
        Plant &plant = bench->plant();
        return plant.motor_peak_N() <= force_safe_N && plant.motor_torque_peak_N_m() <= torque_safe_N_m;
    }
    // Returns the number of milliseconds until the motors no longer exert a force.
    int time_to_safe_ms(int limit_ms)
    {
        for (int ms = 1; ms <= limit_ms; ms++) {
            bench->advance(1);
            worst_N = std::max(worst_N, bench->plant().motor_peak_N());
            if (is_safe()) return ms;
        }
        return limit_ms + 1;
    }
    // Returns the cause that the device has stored for its state FAULT.
    std::uint16_t fault_code()
    {
        link.free_run(0);
        const crn_wire_status status = link.read_status();
        check(status.state == CRN_WIRE_STATE_FAULT, "the device is %s, not in FAULT",
              crn_wire_state_name(status.state));
        return status.fault_code;
    }
    // Checks that the motor power stays off until RESET, whatever the rig does afterwards.
    void check_latched()
    {
        for (int ms = 0; ms < 50; ms++) {
            bench->advance(1);
            check(!bench->plant().is_stage_on() && is_safe(), "power came back %d ms after the fault", ms);
        }
    }

    std::unique_ptr<Bench> bench;
    crn::Link link;
    double worst_N = 0.0;
};

struct Fault {
    const char *name;
    void (*inject)(Plant &plant);
    bool is_jump = false; // of an encoder
};

Plant::Track &track(Plant &plant)
{
    return plant.track(0);
}

const Fault sensor_faults[] = {
    {"translation encoder out of range",
     [](Plant &p) { track(p).translation_encoder.set_fault(SensorFault::range); }},
    {"translation encoder silent",
     [](Plant &p) { track(p).translation_encoder.set_fault(SensorFault::silent); }},
    {"translation encoder jumps 7 mm",
     [](Plant &p) { track(p).translation_encoder.set_fault(SensorFault::jump, 7000); }, true},
    {"rotation encoder out of range",
     [](Plant &p) { track(p).rotation_encoder.set_fault(SensorFault::range); }},
    {"rotation encoder jumps half a turn",
     [](Plant &p) { track(p).rotation_encoder.set_fault(SensorFault::jump, 32768); }, true},
    {"force sensor out of range", [](Plant &p) { track(p).force_fault = SensorFault::range; }},
    {"force sensor silent", [](Plant &p) { track(p).force_fault = SensorFault::silent; }},
    {"motor driver over its current", [](Plant &p) { track(p).is_over_current = true; }},
    {"actuator stuck on", [](Plant &p) { track(p).translation.set_motor_fault(MotorFault::stuck_on); }},
    {"emergency stop pressed", [](Plant &p) { p.emergency_stop = true; }},
    {"supply of the motors gone", [](Plant &p) { p.supply_good = false; }},
};

void every_fault_of_the_rig_is_safe_in_5_ms_and_latched(Level &level, const CaseOptions &options,
                                                        Report &report)
{
    int worst_ms = 0, faults = 0;
    std::vector<Fault> possible;
    for (const Fault &fault : sensor_faults)
        if (!fault.is_jump || level.has_jumping_encoders()) possible.push_back(fault);
    for (std::size_t i = 0; i < possible.size(); i += options.spread, faults++) {
        const Fault &fault = possible[i];
        Running session(level);
        fault.inject(session.bench->plant());
        const int ms = session.time_to_safe_ms(100);
        check(ms <= safe_ms, "%s: safe after %d ms, allowed %d", fault.name, ms, safe_ms);
        check(session.worst_N <= track(session.bench->plant()).translation.settings().motor_limit,
              "%s: the motor gave %.2f N", fault.name, session.worst_N);
        check(session.fault_code() != 0, "%s: FAULT without a cause", fault.name);
        session.check_latched();
        worst_ms = std::max(worst_ms, ms);
    }
    report.add(text("%d faults, safe after %d ms at most", faults, worst_ms));
}

// A debugger stops the processor. The power stage monitors the drive line without the processor, so the power
// ends while the processor is halted; the device detects the halt afterwards.
void a_frozen_processor_loses_power_in_5_ms_and_latches_a_fault(Level &level, const CaseOptions &options,
                                                                Report &report)
{
    Running session(level);
    Plant &plant = session.bench->plant();
    int off_ms = 0;
    session.bench->freeze(1, options.pause_s);
    for (off_ms = 1; plant.is_stage_on() && off_ms < 100; off_ms++) session.bench->freeze(1);
    check(off_ms <= CRN_PORT_DRIVE_HOLD_ms, "power went after %d ms, allowed %d", off_ms,
          int{CRN_PORT_DRIVE_HOLD_ms});
    session.bench->freeze(10000);
    check(session.is_safe(), "%.3f N at the motors of a frozen device", plant.motor_peak_N());
    session.bench->advance(2);
    check(!plant.is_stage_on(), "power came back by itself");
    const std::uint16_t code = session.fault_code();
    session.check_latched();
    report.add(text("power off after %d ms, then %s", off_ms, crn_wire_fault_name(code)));
}

// The supply voltage drops at an arbitrary moment of a session, and the processor restarts. After the restart
// the motors have no power and the device knows nothing of the old session; a new session gives the usual
// state hashes.
void a_brown_out_is_safe_and_a_new_session_starts_clean(Level &level, const CaseOptions &, Report &report)
{
    Running session(level);
    Plant &plant = session.bench->plant();
    session.bench->brown_out(20);
    check(!plant.is_stage_on() && session.is_safe(), "the motors have power after a brown-out");
    for (int ms = 0; ms < 50; ms++) {
        session.bench->advance(1);
        check(!plant.is_stage_on(), "power came back %d ms after a brown-out", ms);
    }
    bool is_told = false;
    try {
        session.link.read_status();
    } catch (const crn::LinkError &) {
        is_told = true;
    }
    check(is_told, "the host was not told that the device started again");
    crn::Link again(session.bench->pipe());
    set_up(again);
    check(again.read_status().state == CRN_WIRE_STATE_READY, "the device is not READY after a new HELLO");
    check_same(host_only_session(64, 16), lockstep_session(again, 64, 16),
               "host alone and after a brown-out");
    report.add("power off, INIT, same hashes again");
}

// If the host no longer sends anything, the motor forces must fade. The limit of 50 ms is the time from the
// host's last frame until the motor force is zero.
void a_silent_host_ends_the_forces_in_50_ms(Level &level, const CaseOptions &, Report &report)
{
    Running session(level);
    const int ms = session.time_to_safe_ms(400);
    check(ms <= silent_safe_ms, "no force %d ms after the last frame, allowed %d", ms, silent_safe_ms);
    report.add(text("no force after %d ms", ms));
}

constexpr Case safety_list[] = {
    {"every_fault_of_the_rig_is_safe_in_5_ms_and_latched",
     every_fault_of_the_rig_is_safe_in_5_ms_and_latched},
    {"a_frozen_processor_loses_power_in_5_ms_and_latches_a_fault",
     a_frozen_processor_loses_power_in_5_ms_and_latches_a_fault},
    {"a_brown_out_is_safe_and_a_new_session_starts_clean",
     a_brown_out_is_safe_and_a_new_session_starts_clean},
    {"a_silent_host_ends_the_forces_in_50_ms", a_silent_host_ends_the_forces_in_50_ms},
};

} // namespace

std::span<const Case> safety_cases()
{
    return safety_list;
}

} // namespace hil
