// A test case checks one property of a device with its rig, by the same code at every test level (L0 to L3).
// A test case makes its own test bench. The case communicates with the device through host/link, and with the
// simulated rig through the class Plant. A test case fails by an exception whose text contains the measured
// value and the limit. The report contains the measurements of every test case.
#pragma once
#include "hil_tests/cases/bench.hpp"
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace hil
{

class Failure : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Holds the results of a test case, such as "power off after 5 ms", for the final table.
struct Report {
    std::string text;
    std::string hash;              // of the aorta session
    double worst_instructions = 0; // of a tick
    int cases = 1, passed = 1;     // for a command that ran several
    std::vector<std::string>
        rows; // for a command that printed a table like this program's: rows with figures
    void add(const std::string &figure) { text += (text.empty() ? "" : "; ") + figure; }
};

struct CaseOptions {
    double pause_s = 0.2;        // duration of a pause in wall-clock time
    std::uint32_t ticks = 400;   // of sessions in LOCKSTEP
    std::uint32_t free_ms = 600; // of sessions in FREE_RUN
    std::uint32_t spread = 1;    // runs one of this many faults of the rig, where time is short
};

struct Case {
    const char *name;
    void (*run)(Level &level, const CaseOptions &options, Report &report);
    bool needs_plant = true; // false: it also runs on a real rig, whose hands rest and whose sensors work
};

std::span<const Case> all_cases();

// The groups; all_cases() joins them.
std::span<const Case> session_cases();
std::span<const Case> exchange_cases();
std::span<const Case> pedal_cases();
std::span<const Case> safety_cases();
std::span<const Case> haptic_cases();
std::span<const Case> unplug_cases();

} // namespace hil
