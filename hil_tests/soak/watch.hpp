// Observes a session while it runs. The class Watch compares every tick with the bars, which are the limits
// that docs/soak.md sets.
#pragma once
#include "hil_tests/soak/trial.hpp"
#include "host/patient/patient.hpp"
#include "host/script/session.hpp"
#include "host/session/frame_sink.hpp"
#include <stdexcept>

namespace soak
{

// Ends a session from within.
struct Enough {
    std::string broken, text; // as in Verdict; empty: the session is long enough
    std::uint32_t tick = 0;
};

class Watch final : public crn::FrameSink
{
  public:
    // The function `log` reads the device's fault log.
    Watch(const TrialSettings &settings, const crn::PatientContrast &contrast,
          std::function<crn_wire_fault_log()> log);

    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state) override;
    std::uint32_t next_tick() const override;
    void frame(const crn::SessionFrame &frame) override;

    // Reads the device's present log. Throws Enough if the log contains a fault that must not occur in any
    // session.
    void look_at_faults(std::uint32_t tick);
    // The caller calls the following function when the session is over. The function checks that the injected
    // iodine equals the iodine in the vessels plus the iodine that has left the vessels. Throws Enough.
    void balance_iodine(std::uint32_t tick) const;
    const Verdict &worst() const { return worst_; }

  private:
    void hold(const char *bar, double value, double most, const char *unit, std::uint32_t tick) const;

    const TrialSettings &settings_;
    const crn::PatientContrast &contrast_;
    std::function<crn_wire_fault_log()> log_;
    Verdict worst_;
    std::uint32_t fault_bits_ = 0, seen_tick_ = 0;
    std::uint32_t news_tick_ = UINT32_MAX; // the tick at which the log is read for a new fault
};

} // namespace soak
