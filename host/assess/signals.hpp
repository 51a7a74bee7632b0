// Computes the quantities that conditions use, such as the speed of a hand or tip, or how far a hand has
// pushed while its tip did not move.
#pragma once
#include "host/assess/session_log.hpp"
#include <array>
#include <vector>

namespace crn
{

struct ToolSignals {
    // One value per moment. Speeds are averaged over the last window_moments moments.
    std::vector<double> hand_mm_s, turn_deg_s; // of the hand, + into the patient and right-handed
    std::vector<double> tip_mm_s;              // of the tip, without the motion of heart and breath
    // Holds the distance that the hand has pushed, without pulling back, since the tip last moved by
    // tip_rests_mm.
    std::vector<double> fixed_mm;
};

class SessionSignals
{
  public:
    static constexpr std::size_t window_moments = 10; // 160 ms
    static constexpr double tip_rests_mm = 2.0;

    explicit SessionSignals(const SessionLog &log);
    const SessionLog &log() const { return log_; }
    const ToolSignals &tool(std::size_t k) const { return tools_[k]; }

  private:
    const SessionLog &log_;
    std::array<ToolSignals, CRN_WIRE_TOOL_MAX> tools_;
};

} // namespace crn
