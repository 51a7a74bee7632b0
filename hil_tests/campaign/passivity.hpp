// Gain, coupling, stated damping and lag, and the hand, one against the other over the rig's model at an end
// wall: the device refuses what its rule says, and whatever it takes must be quiet. Nobody is at the rig who
// would say that damping or lag are stated falsely: the local unlock is closed, so that the rule of passivity
// alone refuses.
//
// A trial pushes a stiff wire by 30 mm against the end of its tube, holds it for 0.6 s, and lets go of it for
// 0.6 s. Broken is one in which the carriage got faster than 0.25 m/s, or the motor's force went forth and
// back by more than 50 mN for more than 100 ms: from the moment of the release on; before, in the second half
// of the hold, when the blow of the wall is over.
#pragma once
#include "hil_tests/cases/conversation.hpp"
#include <vector>

namespace hil
{

struct PassivityTrial {
    std::uint32_t gain_milli, coupling_N_per_m, damping_mN_s_per_m, lag_us;
    bool is_firm; // the hand
};

struct PassivityOutcome {
    bool is_accepted = false;
    double fastest_m_per_s = 0.0, largest_N = 0.0, cycle_ms = 0.0, cycle_N = 0.0;
    const char *fault = ""; // that stopped the device, if any
    std::string failure;    // empty: all held
};

// How long a force has gone forth and back by more than `span_N`, each turn within 150 ms of the last.
class CycleMeter
{
  public:
    explicit CycleMeter(double span_N) : span_N_(span_N) {}
    void take(double force_N);
    double longest_ms() const { return longest_ms_; }
    double largest_N() const { return largest_N_; } // half the span of the largest swing that counted

  private:
    double span_N_, low_N_ = 0.0, high_N_ = 0.0, longest_ms_ = 0.0, largest_N_ = 0.0;
    int direction_ = 0, ms_ = 0, turn_ms_ = 0, first_turn_ms_ = -1, turns_ = 0;
};

std::vector<PassivityTrial> passivity_grid();
PassivityOutcome run_passivity(Level &level, const PassivityTrial &trial);

// Every `nth` trial of the grid; prints the four rows, writes one line each to `file` unless it is empty. The
// number that broke.
std::size_t run_passivity_grid(Level &level, std::size_t nth, const std::string &file);

} // namespace hil
