// Tests whether the force feedback is passive, with a simulated rig whose wire meets an end wall. The tests
// cover a grid of five quantities: force gain, coupling stiffness, declared damping, motor lag, and grip of
// the hand. The device refuses the settings that its passivity rule forbids. With every setting that the
// device accepts, the motors must not oscillate. In these tests the local unlock (a switch inside the rig
// that permits settings beyond the usual limits) is closed. With the local unlock closed, the device accepts
// false values of damping and lag, and only the passivity rule can refuse settings.
//
// In a trial, the hand pushes a stiff wire by 30 mm against the end of its tube, holds the wire still for 0.6
// s, and then releases the wire; the trial ends 0.6 s later. A trial fails if the carriage moved faster than
// 0.25 m/s, or if the motor's force oscillated by more than 50 mN for more than 100 ms. The limits of speed
// and oscillation apply from the moment at which the hand releases the wire. While the hand still holds the
// wire, the limits of speed and oscillation apply only in the second half of the hold, when the impact on the
// wall is over.
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
    const char *fault = ""; // the fault that stopped the device, if any
    std::string failure;    // empty: all held
};

// Measures for how long a force has oscillated by more than `span_N`. An oscillation continues as long as
// each reversal of the force comes within 150 ms after the previous reversal.
class CycleMeter
{
  public:
    explicit CycleMeter(double span_N) : span_N_(span_N) {}
    void take(double force_N);
    double longest_ms() const { return longest_ms_; }
    double largest_N() const { return largest_N_; } // half the span of the largest oscillation that counted

  private:
    double span_N_, low_N_ = 0.0, high_N_ = 0.0, longest_ms_ = 0.0, largest_N_ = 0.0;
    int direction_ = 0, ms_ = 0, turn_ms_ = 0, first_turn_ms_ = -1, turns_ = 0;
};

std::vector<PassivityTrial> passivity_grid();
PassivityOutcome run_passivity(Level &level, const PassivityTrial &trial);

// Runs every `nth` trial of the grid and prints four rows of results. Writes one line for each trial to
// `file`, unless `file` is empty. Returns the number of failed trials.
std::size_t run_passivity_grid(Level &level, std::size_t nth, const std::string &file);

} // namespace hil
