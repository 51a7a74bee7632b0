// Session after session on one station, until it has lived for the wanted time. After every session the sums
// go into a file, so that a later call continues with the next session, on a station that is switched on
// anew.
#pragma once
#include "hil_tests/hours/memory.hpp"
#include "hil_tests/hours/play.hpp"
#include <functional>
#include <memory>

namespace hours
{

// The sums of all calls.
struct Sums {
    std::uint64_t simulated_ms = 0;
    std::uint64_t edges = 0, edges_done = 0, ticks = 0, live_ticks = 0, late_ticks = 0;
    std::uint64_t frames = 0, frames_missed = 0, reports = 0, reports_dropped = 0, reports_lost = 0;
    std::uint64_t overruns = 0, overruns_given = 0, us_wraps = 0, frame_wraps = 0, restarts = 0;
    std::uint64_t drift_us = 0; // the worst
    std::uint64_t sessions = 0, runs = 0, arms = 0, faults = 0, faults_unplanned = 0, repeated_ticks = 0,
                  broken = 0;
    std::int64_t leak_bytes = 0, leak_files = 0, growth_bytes = 0; // the worst of a call, since its warm-up
    std::uint64_t hash = 0;                                        // of the last session's end
    std::uint64_t calls = 0;
    std::uint64_t edge_us_max = 0, stack_free = 0, stack_growth = 0; // of a device that measures them
};

struct CampaignSettings {
    std::uint64_t seed = 1;
    double hours = 24.0;                           // of simulated time
    std::uint32_t seconds_max = 70;                // longest run of a session
    std::uint32_t long_every = 200, long_s = 4800; // one session in so many runs longer than the clock's wrap
    std::uint32_t warm_sessions = 24;              // afterwards the heap must not grow
    std::string path = "out/hours/host.tsv";
    std::string key; // of program, scenes and settings; other rows do not count
    bool shows_progress = true;
};

// Throws std::runtime_error, also if the file cannot be written.
Sums run_campaign(const soak::Catalogue &catalogue, const CampaignSettings &settings,
                  const std::function<std::unique_ptr<Station>(std::uint64_t begin_ms)> &make);

// The rows in the format of out/bench.tsv (docs/bench.md). `place` is "host" or "m7".
std::string bench_rows(const Sums &sums, const std::string &place);
// False if any figure breaks its promise; `why` receives a sentence for each.
bool is_kept(const Sums &sums, std::string &why);

// One edge in 5,000 may be late: the simulated processor makes one tick in 20,000 too long, and after it up
// to three more edges wait for the delay to be made up.
inline constexpr double late_share_max = 2e-4;
// An interrupt may come for the first time while the chain of calls is at its deepest: 32 bytes of registers,
// 4 of padding, and the handler's own words. What grows again and again soon exceeds this.
inline constexpr std::uint64_t stack_growth_max_bytes = 64;

} // namespace hours
