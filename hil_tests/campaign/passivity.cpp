#include "hil_tests/campaign/passivity.hpp"
#include "hil_tests/cases/haptic_bench.hpp"
#include "hil_tests/cases/tube_scene.h"
#include "host/session/device.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace hil
{

namespace
{

constexpr double speed_max_m_per_s = 0.25, cycle_span_N = 0.1, cycle_max_ms = 100.0;
constexpr double push_m_per_s = 0.08, way_m = 0.03;
constexpr std::uint32_t hold_ms = 600, released_ms = 600, talk_every_ms = 8;

const std::vector<std::uint8_t> &end_wall()
{
    static const std::vector<std::uint8_t> scene = [] {
        const hil_piece piece = {0.08, 0};
        std::vector<std::uint8_t> bytes(8u << 20);
        bytes.resize(hil_scene_of(&piece, 1, 0.001, 1, bytes.data(), bytes.size()));
        return bytes;
    }();
    return scene;
}

// Returns false if the device refused the settings because they break its passivity rule (docs/haptics.md).
bool set_up(Bench &bench, crn::Link &link, const PassivityTrial &trial)
{
    link.hello();
    bench.plant().local_unlock = true;
    bench.advance(2); // the sample with the change has reached the device
    crn_wire_rig rig = crn::host_rig();
    for (crn_wire_track &track : rig.tracks) {
        track.force_gain_milli = trial.gain_milli;
        track.damping_mN_s_per_m = trial.damping_mN_s_per_m;
        track.actuator_lag_us = trial.lag_us;
        track.coupling_N_per_m = trial.coupling_N_per_m;
    }
    try {
        link.set_rig(rig);
    } catch (const crn::LinkError &error) {
        if (error.reject.code != CRN_REJECT_RIG_RANGE) throw;
        return false;
    }
    const crn_wire_instrument wire = haptic_wire(1e-3);
    crn_wire_entry entry{};
    entry.direction_x_q30 = 1 << 30;
    entry.inserted_um_count = 1;
    entry.inserted_um[0] = 60000;
    link.load_scene(end_wall());
    link.load_tools({&wire, 1});
    link.set_entry(entry);
    start_free_run(bench, link);
    return true;
}

class HandSession
{
  public:
    HandSession(Bench &bench, crn::Link &link, PassivityOutcome &outcome)
        : bench_(bench), link_(link), outcome_(outcome)
    {
        axis().set_hand(Hand::spring);
    }
    void push()
    {
        axis().move_hand(push_m_per_s);
        pass(static_cast<std::uint32_t>(way_m / push_m_per_s * 1000), nullptr);
        axis().move_hand(0.0);
    }
    void hold()
    {
        CycleMeter meter(cycle_span_N);
        pass(hold_ms / 2, nullptr);
        pass(hold_ms / 2, &meter);
        judge(meter);
    }
    void release()
    {
        CycleMeter meter(cycle_span_N);
        axis().set_hand(Hand::none);
        is_released_ = true;
        pass(released_ms, &meter);
        judge(meter);
    }

  private:
    Axis &axis() { return bench_.plant().track(0).translation; }
    void judge(const CycleMeter &meter)
    {
        outcome_.cycle_ms = std::max(outcome_.cycle_ms, meter.longest_ms());
        if (meter.longest_ms() > cycle_max_ms)
            outcome_.cycle_N = std::max(outcome_.cycle_N, meter.largest_N());
    }
    void pass(std::uint32_t milliseconds, CycleMeter *meter)
    {
        for (std::uint32_t i = 0; i < milliseconds; i++) {
            if (ms_++ % talk_every_ms == 0) keep_talking(link_);
            bench_.advance(1);
            if (meter != nullptr) meter->take(axis().motor_force());
            // When a motor has lost its power, only the pushing hand moves the carriage; the carriage's speed
            // is then not recorded.
            if (bench_.plant().is_stage_on() || is_released_)
                outcome_.fastest_m_per_s = std::max(outcome_.fastest_m_per_s, std::abs(axis().tool_speed()));
            outcome_.largest_N = std::max(outcome_.largest_N, axis().motor_peak());
        }
    }

    Bench &bench_;
    crn::Link &link_;
    PassivityOutcome &outcome_;
    std::uint32_t ms_ = 0;
    bool is_released_ = false;
};

std::string failure_of(const PassivityOutcome &outcome)
{
    if (outcome.fastest_m_per_s > speed_max_m_per_s)
        return text("the carriage got %.3f m/s, allowed %.2f", outcome.fastest_m_per_s, speed_max_m_per_s);
    if (outcome.cycle_ms > cycle_max_ms)
        return text("+- %.3f N for %.0f ms, allowed %.2f N or %.0f ms", outcome.cycle_N, outcome.cycle_ms,
                    cycle_span_N / 2, cycle_max_ms);
    return {};
}

std::string line_of(const PassivityTrial &trial, const PassivityOutcome &outcome)
{
    return text("%u\t%u\t%u\t%u\t%s\t%s\t%.3f\t%.2f\t%.0f\t%s\t%s\n", unsigned{trial.gain_milli},
                unsigned{trial.coupling_N_per_m}, unsigned{trial.damping_mN_s_per_m}, unsigned{trial.lag_us},
                trial.is_firm ? "firm" : "loose", outcome.is_accepted ? "yes" : "no", outcome.fastest_m_per_s,
                outcome.largest_N, outcome.cycle_ms, outcome.fault, outcome.failure.c_str());
}

} // namespace

void CycleMeter::take(double force_N)
{
    constexpr int apart_ms = 150;
    ms_++;
    if (direction_ == 0) {
        low_N_ = high_N_ = force_N;
        direction_ = 1;
    }
    const bool rises = direction_ > 0;
    double &far_N = rises ? high_N_ : low_N_;
    if (rises ? force_N > far_N : force_N < far_N) far_N = force_N;
    if (std::abs(force_N - far_N) <= span_N_) return;
    // a reversal: back by more than the span
    if (first_turn_ms_ < 0 || ms_ - turn_ms_ > apart_ms) {
        first_turn_ms_ = ms_;
        turns_ = 0;
    }
    turn_ms_ = ms_;
    if (++turns_ >= 3) {
        longest_ms_ = std::max(longest_ms_, static_cast<double>(turn_ms_ - first_turn_ms_));
        largest_N_ = std::max(largest_N_, (high_N_ - low_N_) / 2);
    }
    direction_ = -direction_;
    (direction_ > 0 ? high_N_ : low_N_) = force_N;
}

std::vector<PassivityTrial> passivity_grid()
{
    std::vector<PassivityTrial> trials;
    for (const std::uint32_t gain : {500u, 1000u, 1500u, 2000u, 4000u})
        for (const std::uint32_t coupling : {200u, 400u, 800u, 1600u, 3200u})
            for (const std::uint32_t damping : {500u, 1000u, 1250u, 2000u, 5000u})
                for (const std::uint32_t lag : {0u, 500u, 2000u})
                    for (const bool is_firm : {false, true})
                        trials.push_back({gain, coupling, damping, lag, is_firm});
    return trials;
}

PassivityOutcome run_passivity(Level &level, const PassivityTrial &trial)
{
    PassivityOutcome outcome;
    const auto bench = level.make(haptic_plant(trial.is_firm ? 800 : 200, trial.is_firm ? 5 : 1));
    crn::Link link(bench->pipe());
    outcome.is_accepted = set_up(*bench, link, trial);
    if (!outcome.is_accepted) return outcome;
    HandSession session(*bench, link, outcome);
    session.push();
    session.hold();
    session.release();
    const crn_wire_status status = link.read_status();
    if (status.state != CRN_WIRE_STATE_RUNNING) outcome.fault = crn_wire_fault_name(status.fault_code);
    outcome.failure = failure_of(outcome);
    return outcome;
}

std::size_t run_passivity_grid(Level &level, std::size_t nth, const std::string &file)
{
    std::string lines =
        "gain_milli\tcoupling_N_per_m\tdamping_mN_s_per_m\tlag_us\thand\taccepted\tfastest_m_per_s\t"
        "largest_N\tcycle_ms\tstopped_by\tbroken\n";
    const std::vector<PassivityTrial> trials = passivity_grid();
    std::size_t count = 0, accepted = 0, broken = 0, stopped = 0;
    double fastest_m_per_s = 0.0;
    for (std::size_t i = 0; i < trials.size(); i += nth) {
        const PassivityOutcome outcome = run_passivity(level, trials[i]);
        const std::string line = line_of(trials[i], outcome);
        lines += line;
        count++;
        accepted += outcome.is_accepted;
        broken += !outcome.failure.empty();
        stopped += outcome.fault[0] != '\0';
        fastest_m_per_s = std::max(fastest_m_per_s, outcome.fastest_m_per_s);
        if (!outcome.failure.empty()) std::printf("BROKEN %s", line.c_str());
    }
    // Prints each total with its name on a line of its own, and adds the lines with the totals to the end of
    // the table. `make bars` reads these lines.
    char totals[256];
    std::snprintf(totals, sizeof totals,
                  "passivity.combinations\t%zu\npassivity.accepted\t%zu\npassivity.stopped\t%zu\n"
                  "passivity.fastest_m_per_s\t%.3f\npassivity.broken\t%zu\n",
                  count, accepted, stopped, fastest_m_per_s, broken);
    std::fputs(totals, stdout);
    lines += totals;
    if (file.empty()) return broken;
    const auto folder = std::filesystem::path(file).parent_path();
    if (!folder.empty()) std::filesystem::create_directories(folder);
    std::ofstream out(file);
    out << lines;
    if (!out.flush()) throw std::runtime_error(file + ": cannot be written");
    return broken;
}

} // namespace hil
