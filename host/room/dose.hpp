// Measures the dose of a session as IEC 60601-2-43 requires: reference air kerma, kerma-area product and
// time, for each irradiation and in total.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/xray/run.hpp"
#include "host/xray/xray.hpp"
#include <cstdint>
#include <optional>
#include <vector>

namespace crn
{

// Holds the dose of one frame, or the sum over several frames.
struct Dose {
    std::uint32_t pulses = 0;
    double air_kerma_uGy = 0.0; // at the reference point, 15 cm from the isocentre toward the tube
    double kap_Gy_cm2 = 0.0;
    std::uint32_t beam_ticks = 0; // pedal down, ms
};

// One press of a pedal.
struct Irradiation {
    RunKind kind = RunKind::fluoro;
    int run = 0; // number of the run that was kept; 0: none
    std::uint32_t tick_begin = 0, tick_end = 0;
    double pulses_per_s = 0.0;
    CArm carm;                                                           // at its first pulse
    double tube_voltage_kV = 0.0, tube_current_mA = 0.0, pulse_ms = 0.0; // of its last pulse
    Dose dose;
};

// The room raises an alert when the reference air kerma reaches 2 Gy (the skin may redden) and 5 Gy (the
// patient needs a follow-up), as in ICRP 120.
inline constexpr double dose_alert_levels_Gy[] = {2.0, 5.0};
inline constexpr std::uint32_t fluoro_reminder_ticks = 300'000; // every five minutes of fluoroscopy

class DoseMeter
{
  public:
    void begin(const Irradiation &irradiation);
    // Adds the dose of one pulse to the current irradiation. `tick` is the tick of the pulse.
    void add(std::uint32_t tick, double air_kerma_uGy, double kap_Gy_cm2);
    void note_pulse(const CArm &carm, double tube_voltage_kV, double tube_current_mA, double pulse_ms);
    void end(std::uint32_t tick, int kept_as_run); // drops an irradiation without a pulse
    void pass_tick();                              // 1 ms with the pedal down
    void acknowledge();

    const std::vector<Irradiation> &irradiations() const { return irradiations_; }
    const Dose &total() const { return total_; }
    std::uint32_t fluoro_ticks() const { return fluoro_ticks_; } // pedal time of fluoroscopy only
    // kerma of the last pulse times its rate; 0 when the beam is off
    double kerma_rate_mGy_min() const { return kerma_rate_mGy_min_; }
    // Returns the highest alert that the user has not acknowledged, as an index into dose_alert_levels_Gy.
    std::optional<int> unseen_alert() const { return unseen_; }
    int alerts_passed() const { return alerts_passed_; }
    std::uint32_t fluoro_reminders() const { return fluoro_ticks_ / fluoro_reminder_ticks; }
    // Returns true if the user has not yet acknowledged the latest reminder of the fluoroscopy time.
    bool has_unseen_reminder() const { return fluoro_reminders() > reminders_seen_; }

    void archive(StateArchive &state);

  private:
    std::vector<Irradiation> irradiations_;
    bool is_on_ = false;
    Dose total_;
    std::uint32_t fluoro_ticks_ = 0, reminders_seen_ = 0;
    double kerma_rate_mGy_min_ = 0.0;
    int alerts_passed_ = 0;
    std::optional<int> unseen_;
};

} // namespace crn
