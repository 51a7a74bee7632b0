// Implements the command cournand rig selftest, which checks every sensor, signal line and limit that the rig
// can report, and prints one line of text for each.
#include "host/rig/rig.hpp"
#include <cmath>
#include <cstdlib>

namespace crn
{

namespace
{

constexpr int rest_counts_max = 8; // limit for encoders of hands at rest, within 100 ms
constexpr int rest_force_max_mN = 200;

class Lines
{
  public:
    explicit Lines(const RigTalk &talk) : talk_(talk) {}
    void check(bool good, const std::string &what, const std::string &remedy)
    {
        (good ? passed_ : failed_)++;
        std::fprintf(talk_.out, "%s  %s%s%s\n", good ? "pass" : "FAIL", what.c_str(),
                     good ? "" : ". Remedy: ", good ? "" : remedy.c_str());
    }
    void note(const std::string &what) { std::fprintf(talk_.out, "  -   %s\n", what.c_str()); }
    int end()
    {
        std::fprintf(talk_.out, "%u passed, %u failed\n", passed_, failed_);
        return failed_ == 0 ? 0 : 1;
    }

  private:
    const RigTalk &talk_;
    unsigned passed_ = 0, failed_ = 0;
};

void check_device(Lines &lines, Link &link, const crn_wire_hello_reply &hello)
{
    const crn_wire_status status = link.read_status();
    lines.check(!serial_of(hello).empty(), "serial number " + serial_of(hello),
                "give the board a serial number");
    lines.check(hello.tick_us == 1000, "tick of " + std::to_string(hello.tick_us) + " us",
                "the tick is 1 ms");
    const std::string cause =
        status.fault_code == 0 ? "" : std::string(" after ") + crn_wire_fault_name(status.fault_code);
    lines.check(status.state != CRN_WIRE_STATE_FAULT, "state " + state_name(status.state) + cause,
                status.fault_code != 0 ? crn_wire_fault_remedy(status.fault_code) : "RESET");
    lines.check(status.tick_overruns == 0,
                std::to_string(status.tick_overruns) + " ticks too long, the longest " +
                    std::to_string(status.tick_us_max) + " us",
                "see the fault TICK_OVERRUN in docs/faults.md");
    lines.check(status.frames_bad == 0, std::to_string(status.frames_bad) + " damaged frames",
                "try another cable or port");
}

void check_sensor(Lines &lines, const std::string &what, unsigned status)
{
    if (status == 1) {
        lines.note(what + ": absent");
        return;
    }
    lines.check(status == 0, what + ": " + sensor_name(status), "check the sensor and its cable");
}

void check_track(Lines &lines, unsigned number, const crn_wire_track_sensors &first,
                 const crn_wire_track_sensors &later, const crn_wire_track &track)
{
    const std::string name = "track " + std::to_string(number) + " ";
    check_sensor(lines, name + "translation encoder", later.translation_sensor);
    check_sensor(lines, name + "rotation encoder", later.rotation_sensor);
    check_sensor(lines, name + "force sensor", later.force_sensor);
    const auto moved = [](std::int32_t a, std::int32_t b) {
        return std::abs(static_cast<double>(b) - static_cast<double>(a));
    };
    if (later.translation_sensor == 0) {
        const double counts = moved(first.translation_counts, later.translation_counts);
        lines.check(counts <= rest_counts_max,
                    name + "translation at rest: " + std::to_string(std::lround(counts)) +
                        " counts in 100 ms",
                    "take the hands off; else look for noise on the encoder's cable");
    }
    if (later.rotation_sensor == 0) {
        const double counts = moved(first.rotation_counts, later.rotation_counts);
        lines.check(counts <= rest_counts_max,
                    name + "rotation at rest: " + std::to_string(std::lround(counts)) + " counts in 100 ms",
                    "take the hands off; else look for noise on the encoder's cable");
    }
    if (later.force_sensor == 0) {
        lines.check(std::abs(later.force_mN) <= rest_force_max_mN,
                    name + "force at rest: " + std::to_string(later.force_mN) + " mN",
                    "take the hands off; else cournand rig calibrate --what force --track " +
                        std::to_string(number));
    }
    lines.check(later.over_current == 0, name + "motor driver: current within its limit",
                "check motor and cable for a short");
    lines.check(later.motor_axial_mN == 0 && later.motor_torque_uN_m == 0, name + "motor: no force ordered",
                "report it");
    lines.check(track.force_limit_mN > 0 && track.torque_limit_uN_m > 0,
                name + "limits: " + std::to_string(track.force_limit_mN) + " mN, " +
                    std::to_string(track.torque_limit_uN_m) + " uN m",
                "a limit of 0 was written; power the rig off and on");
}

// The test requests a force limit that is 1 mN larger than the present limit. The device must refuse the
// larger force limit and keep its present limit.
void check_limits_hold(Lines &lines, Link &link, const crn_wire_rig &rig)
{
    for (std::uint16_t k = 0; k < rig.tracks_count; k++) {
        crn_wire_rig higher = rig;
        higher.tracks[k].force_limit_mN++;
        bool is_refused = false;
        try {
            link.set_rig(higher);
            link.set_rig(rig);
        } catch (const LinkError &error) {
            is_refused = error.reject.code == CRN_REJECT_RIG_RANGE;
            if (error.reject.code == 0) throw;
        }
        lines.check(is_refused && link.read_rig().tracks[k].force_limit_mN == rig.tracks[k].force_limit_mN,
                    "track " + std::to_string(k + 1) + " force limit: the host cannot raise it",
                    "do not use the rig; report it with its firmware");
    }
}

void check_rig(Lines &lines, Link &link)
{
    const crn_wire_sensors first = link.read_sensors();
    if (!first.has_rig) {
        lines.check(false, "rig's electronics: none attached", "check the cable between board and rig");
        return;
    }
    link.free_run(100);
    const crn_wire_sensors later = link.read_sensors();
    const crn_wire_rig rig = link.read_rig();
    lines.check((later.lines & 1) == 0, "emergency stop: released", "release it");
    lines.check((later.lines & 2) != 0, "motors' supply: in its range", "check the supply");
    lines.check((later.lines & 4) == 0, "power stage: off",
                "cut the supply by hand; the power stage is broken");
    lines.note((later.lines & 8) != 0 ? "local unlock: closed, limits can be raised" : "local unlock: open");
    check_sensor(lines, "contrast syringe", later.syringe_sensor);
    check_sensor(lines, "inflator", later.inflator_sensor);
    for (std::uint16_t k = 0; k < later.tracks_count && k < first.tracks_count && k < rig.tracks_count; k++)
        check_track(lines, k + 1u, first.tracks[k], later.tracks[k], rig.tracks[k]);
    if ((later.lines & 8) != 0)
        lines.note("limits: not tried, since the local unlock permits higher ones");
    else if (link.read_status().state == CRN_WIRE_STATE_READY)
        check_limits_hold(lines, link, rig);
    else
        lines.note("limits: not tried, the rig is not in READY (--reset)");
}

void check_motor(Lines &lines, Link &link, const RigOptions &options, const RigTalk &talk)
{
    constexpr unsigned trial_mN = 300, rounds = 100, settle_ticks = 20;
    require_ready(link, options.reset);
    std::fprintf(
        talk.out,
        "track %u: its motor will be powered for a second. Take the hands off; it gives no force to a hand "
        "that rests.\n",
        options.track);
    if (!options.yes && talk.ask("Type yes to power the motor:") != "yes") {
        lines.note("motor: not confirmed, not powered");
        return;
    }
    MotorTrial trial(link, options.track - 1, trial_mN, options.damping_N_s_per_m);
    trial.begin();
    std::uint32_t ticks = 0, powered = 0;
    int largest_mN = 0;
    for (unsigned round = 0; round < rounds && !talk.is_interrupted(); round++) {
        for (const crn_wire_live_tick &tick : trial.run()) {
            if (ticks++ >= settle_ticks) powered += tick.flags >> 1 & 1;
            if (options.track <= tick.state.tools_count)
                largest_mN =
                    std::max(largest_mN, std::abs(tick.state.tools[options.track - 1].motor_axial_mN));
        }
    }
    trial.end();
    link.free_run(20);
    const std::string name = "track " + std::to_string(options.track) + " ";
    lines.check(ticks > settle_ticks && powered == ticks - settle_ticks,
                name + "motor: powered in " + std::to_string(powered) + " of " + std::to_string(ticks) +
                    " ticks",
                "see cournand rig log");
    lines.check(largest_mN <= static_cast<int>(trial_mN),
                name + "motor: at most " + std::to_string(largest_mN) + " mN asked at rest",
                "was it pushed? else check its encoder");
    lines.check((link.read_sensors().lines & 4) == 0, "power stage: off again 20 ms after the end",
                "cut the supply by hand; the power stage is broken");
}

} // namespace

int rig_selftest(Link &link, const crn_wire_hello_reply &hello, const RigOptions &options,
                 const RigTalk &talk)
{
    if (options.reset) require_ready(link, true);
    Lines lines(talk);
    check_device(lines, link, hello);
    check_rig(lines, link);
    if (options.motors)
        check_motor(lines, link, options, talk);
    else
        lines.note("motors: not powered (--motors)");
    const crn_wire_fault_log log = link.read_fault_log();
    for (std::uint16_t i = 0; i < log.entries_count; i++) {
        lines.note(std::string("since power-up: ") + crn_wire_fault_name(log.entries[i].code) + ", " +
                   std::to_string(log.entries[i].count) + " times (cournand rig log)");
    }
    return lines.end();
}

} // namespace crn
