// Tests the closed control loop of hand, rig, virtual coupling and simulated wire in the five contact
// situations of docs/haptics.md. The hand advances the wire, holds it, retracts it by half of the distance
// and holds it again. The test moves and holds the wire once with a loose grip and once with a firm grip. The
// force must not oscillate permanently (limit cycle) by more than 0.05 N, and the energy that the passivity
// observer computes must stay within its bound. The program firmware/tests/test_haptics.c runs the same tests
// with a simulated rig of its own, whereas the cases of this file test a complete device.
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/cases/haptic_bench.hpp"
#include "hil_tests/cases/tube_scene.h"
#include "host/session/device.hpp"
#include <cmath>

namespace hil
{

namespace
{

constexpr double cycle_max_N = 0.05;
constexpr double hand_speed = 0.08; // m/s
constexpr std::uint32_t hold_ms = 400, talk_every_ms = 8;

struct Situation {
    const char *name;
    double bend_N_m2; // of the wire
    std::vector<hil_piece> pieces;
    double radius_m;
    std::uint32_t inserted_um, seal_mN;
    double way_m;   // of the hand
    double force_N; // the least force that must have been felt
};

const Situation situations[] = {
    {"free", 1e-4, {}, 0, 50000, 0, 0.04, 0},
    {"sheath friction only", 1e-4, {}, 0, 50000, 300, 0.04, 0.25},
    {"along a wall in a bend", 1e-4, {{0.05, 0}, {0.06, 1.5}, {0.15, 0}}, 0.003, 52000, 0, 0.09, 0.1},
    {"tip against an end wall", 1e-3, {{0.08, 0}}, 0.001, 60000, 0, 0.03, 1.0},
    {"buckled in the aorta", 3e-5, {{0.20, 0}}, 0.012, 190000, 0, 0.03, 0.05},
};

struct Grip {
    double stiffness, damping; // N/m, N s/m
};
constexpr Grip grips[] = {{200, 1}, {800, 5}}; // loose, firm

// Returns rig settings with the stiffest axial coupling that the device accepts, and without a coupling for
// rotation.
crn_wire_rig rig_of(std::uint32_t seal_mN)
{
    crn_wire_rig rig = crn::host_rig();
    for (crn_wire_track &track : rig.tracks) {
        track.damping_mN_s_per_m = 1000;
        track.actuator_lag_us = 500;
        track.coupling_N_per_m = 800;
        track.coupling_mN_s_per_m = 200;
        track.seal_mN = seal_mN;
    }
    return rig;
}

class Trial
{
  public:
    Trial(Level &level, const Situation &situation, const Grip &grip)
        : bench_(level.make(haptic_plant(grip.stiffness, grip.damping))), link_(bench_->pipe())
    {
        std::vector<std::uint8_t> scene;
        if (!situation.pieces.empty()) {
            scene.resize(8u << 20);
            scene.resize(hil_scene_of(situation.pieces.data(),
                                      static_cast<std::uint32_t>(situation.pieces.size()), situation.radius_m,
                                      1, scene.data(), scene.size()));
        }
        const crn_wire_instrument wire = haptic_wire(situation.bend_N_m2);
        crn_wire_entry entry{};
        entry.direction_x_q30 = 1 << 30;
        entry.inserted_um_count = 1;
        entry.inserted_um[0] = situation.inserted_um;
        link_.hello();
        link_.load_scene(scene);
        link_.load_tools({&wire, 1});
        link_.set_entry(entry);
        link_.set_rig(rig_of(situation.seal_mN));
        start_free_run(*bench_, link_);
        axis().set_hand(Hand::spring);
    }

    void go(double way_m)
    {
        axis().move_hand(way_m < 0 ? -hand_speed : hand_speed);
        pass(static_cast<std::uint32_t>(std::abs(way_m) / hand_speed * 1000));
        axis().move_hand(0.0);
    }

    // Keeps the hand still for hold_ms milliseconds. Returns half of the difference between the largest and
    // the smallest force on the hand in the second half of the hold.
    double hold()
    {
        pass(hold_ms / 2);
        low_N_ = INFINITY, high_N_ = -INFINITY;
        pass(hold_ms / 2);
        return (high_N_ - low_N_) / 2;
    }

    crn_wire_status status() { return link_.read_status(); }
    double largest_N() const { return largest_N_; }

  private:
    Axis &axis() { return bench_->plant().track(0).translation; }
    void pass(std::uint32_t milliseconds)
    {
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            if (ms_++ % talk_every_ms == 0) keep_talking(link_);
            bench_->advance(1);
            const double force_N = axis().force_on_hand();
            low_N_ = std::min(low_N_, force_N);
            high_N_ = std::max(high_N_, force_N);
            largest_N_ = std::max(largest_N_, std::abs(force_N));
        }
    }

    std::unique_ptr<Bench> bench_;
    crn::Link link_;
    std::uint32_t ms_ = 0;
    double low_N_ = 0.0, high_N_ = 0.0, largest_N_ = 0.0;
};

void no_contact_situation_has_a_limit_cycle(Level &level, const CaseOptions &options, Report &report)
{
    double worst_N = 0.0;
    int trials = 0;
    for (std::size_t i = 0; i < std::size(situations) * std::size(grips); i += options.spread, trials++) {
        const Situation &situation = situations[i / std::size(grips)];
        const Grip &grip = grips[i % std::size(grips)];
        Trial trial(level, situation, grip);
        trial.go(situation.way_m);
        const double forth_N = trial.hold();
        trial.go(-situation.way_m / 2);
        const double back_N = trial.hold();
        const crn_wire_status status = trial.status();
        check(status.state == CRN_WIRE_STATE_RUNNING, "%s: ended by %s", situation.name,
              crn_wire_fault_name(status.fault_code));
        check(std::max(forth_N, back_N) <= cycle_max_N,
              "%s, hand of %.0f N/m: %.3f N forth, %.3f N back, allowed %.2f", situation.name, grip.stiffness,
              forth_N, back_N, cycle_max_N);
        check(trial.largest_N() >= situation.force_N, "%s: %.3f N felt at most, not %.2f", situation.name,
              trial.largest_N(), situation.force_N);
        check(status.passivity_ticks == 0, "%s: the passivity observer reduced the force in %u ticks",
              situation.name, unsigned{status.passivity_ticks});
        worst_N = std::max({worst_N, forth_N, back_N});
    }
    report.add(
        text("%d trials, cycle %.3f N at most, no force reduced by the passivity observer", trials, worst_N));
}

constexpr Case haptic_list[] = {
    {"no_contact_situation_has_a_limit_cycle", no_contact_situation_has_a_limit_cycle},
};

} // namespace

std::span<const Case> haptic_cases()
{
    return haptic_list;
}

} // namespace hil
