// Implements the command cournand rig force. This file also implements the trial with powered motors, which
// the command cournand rig selftest uses as well.
#include "host/rig/rig.hpp"
#include <algorithm>
#include <cstdlib>

namespace crn
{

namespace
{

constexpr std::uint32_t round_ms = 10;          // forces fade when the host is silent for 30 ms
constexpr std::uint32_t coupling_N_per_m = 500; // half a millimetre for 250 mN
constexpr std::uint32_t inserted_um = 50000;

// Makes simulated straight tools of 300 mm length that fit into each other. The simulated tools lie in free
// space (without vessels), so only the friction of the sheath's valve holds them.
std::vector<crn_wire_instrument> straight_tools(unsigned count)
{
    static constexpr struct {
        std::uint32_t bend_nN_m2, outer_um, inner_um;
    } kinds[] = {{1000000, 400, 0}, {1000000, 800, 500}, {2000000, 1200, 900}};
    std::vector<crn_wire_instrument> tools;
    for (unsigned k = 0; k < count; k++) {
        crn_wire_instrument tool{};
        tool.lumen_friction_milli = k > 0 ? 50 : 0;
        tool.axial_stiffness_max_N = 5000;
        tool.element_tip_um = 2000;
        tool.element_shaft_um = 4000;
        tool.element_fine_um = 20000;
        tool.knots_count = 2;
        crn_wire_knot knot{};
        knot.bend_stiffness_nN_m2 = kinds[k].bend_nN_m2;
        knot.twist_stiffness_nN_m2 = kinds[k].bend_nN_m2 / 5 * 4;
        knot.mass_mg_per_m = 4000;
        knot.radius_outer_um = kinds[k].outer_um;
        knot.radius_inner_um = kinds[k].inner_um;
        knot.friction_kinetic_milli = 100;
        knot.friction_static_milli = 120;
        tool.knots[0] = tool.knots[1] = knot;
        tool.knots[1].arc_um = 300000;
        tools.push_back(tool);
    }
    return tools;
}

} // namespace

MotorTrial::MotorTrial(Link &link, unsigned track, unsigned force_mN, double damping_N_s_per_m)
    : link_(link), track_(track), before_(link.read_rig()), trial_(before_)
{
    if (track >= before_.tracks_count) throw LinkError("the rig has no track " + std::to_string(track + 1));
    for (std::uint16_t k = 0; k < trial_.tracks_count; k++) {
        crn_wire_track &one = trial_.tracks[k];
        one.coupling_N_per_m = one.coupling_uN_m_per_rad = 0;
        one.coupling_mN_s_per_m = one.coupling_nN_m_s_per_rad = 0;
    }
    crn_wire_track &driven = trial_.tracks[track];
    if (damping_N_s_per_m > 0.0)
        driven.damping_mN_s_per_m = static_cast<std::uint32_t>(damping_N_s_per_m * 1e3);
    if (driven.damping_mN_s_per_m < 2) {
        throw LinkError("the own damping of track " + std::to_string(track + 1) +
                        " is not known, so no safe spring can be chosen. Remedy: give --damping N s/m as "
                        "measured (docs/rig.md)");
    }
    // The stiffness of the virtual coupling obeys the device's passivity rule: stiffness x (half a tick + lag
    // of the motor) <= damping.
    const std::uint64_t stiffest =
        std::uint64_t{driven.damping_mN_s_per_m} * 1000 / (500 + driven.actuator_lag_us);
    driven.coupling_N_per_m = static_cast<std::uint32_t>(std::min<std::uint64_t>(coupling_N_per_m, stiffest));
    driven.seal_mN = std::min(force_mN, driven.force_limit_mN);
    driven.force_gain_milli = std::min<std::uint32_t>(driven.force_gain_milli, 1000);
    if (driven.force_gain_milli == 0) driven.force_gain_milli = 1000;
}

void MotorTrial::begin()
{
    is_changed_ = true;
    link_.set_rig(trial_);
    link_.load_scene({});
    link_.load_tools(straight_tools(track_ + 1));
    crn_wire_entry entry{};
    entry.direction_y_q30 = 1 << 30;
    entry.inserted_um_count = static_cast<std::uint16_t>(track_ + 1);
    for (unsigned k = 0; k <= track_; k++) entry.inserted_um[k] = inserted_um + 10000 * (track_ - k);
    link_.set_entry(entry);
    link_.use_free_run();
    link_.arm();
    link_.free_run(5); // the rig's lines are checked before the motors may be armed
    link_.arm_motors();
    link_.start();
}

const std::vector<crn_wire_live_tick> &MotorTrial::run()
{
    const crn_wire_status status = link_.read_status(); // also shows the device that its host is alive
    if (status.state != CRN_WIRE_STATE_RUNNING) {
        throw LinkError(std::string("the rig stopped: ") + crn_wire_fault_name(status.fault_code) + ": " +
                        crn_wire_fault_text(status.fault_code) +
                        ". Remedy: " + crn_wire_fault_remedy(status.fault_code));
    }
    link_.free_run(round_ms);
    return link_.live_ticks();
}

void MotorTrial::end()
{
    if (!is_changed_) return;
    is_changed_ = false;
    link_.reset(); // power off, READY
    link_.use_lockstep();
    link_.set_rig(before_);
}

MotorTrial::~MotorTrial()
{
    try {
        end();
    } catch (const std::exception &) {
        // If the device receives nothing for 50 ms, it removes the motor forces by itself, even if the
        // connection is broken.
    }
}

namespace
{

struct Peak {
    int asked_mN = 0, measured_mN = 0;
    std::uint32_t ticks = 0, powered = 0;
    void take(const crn_wire_live_tick &tick, unsigned track)
    {
        ticks++;
        powered += tick.flags >> 1 & 1;
        if (track < tick.state.tools_count)
            asked_mN = std::max(asked_mN, std::abs(tick.state.tools[track].motor_axial_mN));
        if (track < tick.force_measured_mN_count)
            measured_mN = std::max(measured_mN, std::abs(tick.force_measured_mN[track]));
    }
};

void show(const RigTalk &talk, const crn_wire_live_tick &tick, unsigned track, double seconds)
{
    std::fprintf(talk.out, "%s%6.1f s  hand %9d counts, asked %6d mN, measured %6d mN%s",
                 talk.is_terminal ? "\r" : "", seconds,
                 track < tick.input.hands_count ? tick.input.hands[track].translation_counts : 0,
                 track < tick.state.tools_count ? tick.state.tools[track].motor_axial_mN : 0,
                 track < tick.force_measured_mN_count ? tick.force_measured_mN[track] : 0,
                 talk.is_terminal ? "" : "\n");
    std::fflush(talk.out);
}

} // namespace

int rig_force(Link &link, const RigOptions &options, const RigTalk &talk)
{
    require_ready(link, options.reset);
    const unsigned track = options.track - 1;
    const double seconds = options.seconds > 0.0 ? options.seconds : 10.0;
    MotorTrial trial(link, track, options.force_mN, options.damping_N_s_per_m);
    const crn_wire_track limits = link.read_rig().tracks[track];
    std::fprintf(
        talk.out,
        "track %u: its motor will be powered for %.1f s. It resists a slow push by at most %u mN; the\n"
        "rig's own limits stay in force: %.3f N, %.3f N mm. It gives no force to a hand that rests.\n"
        "Ctrl-C ends it at once; so does the emergency stop.\n",
        options.track, seconds, options.force_mN, limits.force_limit_mN * 1e-3,
        limits.torque_limit_uN_m * 1e-3);
    if (!options.yes && talk.ask("Type yes to power the motor:") != "yes")
        throw RigStopped("not confirmed; no motor was powered");
    trial.begin();
    Peak peak;
    const auto rounds = static_cast<unsigned>(seconds * 1000.0 / round_ms);
    unsigned round = 0;
    for (; round < rounds && !talk.is_interrupted(); round++) {
        for (const crn_wire_live_tick &tick : trial.run()) {
            if (peak.ticks % 500 == 0) show(talk, tick, track, round * round_ms * 1e-3);
            peak.take(tick, track);
        }
    }
    trial.end();
    std::fprintf(talk.out, "%s%s after %u ticks, %u with power; largest force asked %d mN, measured %d mN\n",
                 talk.is_terminal ? "\n" : "", round < rounds ? "interrupted" : "done", unsigned{peak.ticks},
                 unsigned{peak.powered}, peak.asked_mN, peak.measured_mN);
    if (round < rounds)
        throw RigStopped("interrupted; the motor is off and the rig has its configuration back");
    return peak.powered > 0 ? 0 : 1;
}

} // namespace crn
