// Measures how the window performs on this machine: pictures per second, the delay from hand to picture, and
// how punctual the physics is. The measured times of the window are not part of a session's result.
#pragma once
#include "host/live/picture_thread.hpp"
#include "host/live/suite_state.hpp"
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

class SuiteTiming
{
  public:
    // Receives the contents of one drawing of the window, and the time at which this drawing was shown.
    void take(const SuiteState &state, const MonitorPicture *live, SuiteClock::time_point now);
    // Throws OutputError.
    void write(const std::string &path) const;

  private:
    SuiteClock::time_point begin_ = SuiteClock::now(), asked_{}, last_{};
    std::uint64_t screens_ = 0, first_pulses_ = 0, pulses_ = 0, left_out_ = 0;
    bool has_pulses_ = false;
    SuiteClock::time_point first_pulse_{}, last_pulse_{};
    PaceFigures pace_;
    struct Shown { // an input, and when its first picture was shown
        SuiteClock::time_point read, shown;
    };
    std::vector<Shown> inputs_;
};

} // namespace crn
