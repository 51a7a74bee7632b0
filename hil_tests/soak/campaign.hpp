// Runs many random sessions of one seed in separate processes, `jobs` of them at a time. Every session is
// made at random and judged by limits, which docs/soak.md calls bars. The result of every session becomes one
// row of a file. If a session exceeds a limit, the campaign also shortens the session to the part that causes
// this. Ctrl-C ends the campaign; a later call continues it.
#pragma once
#include "hil_tests/soak/draw.hpp"
#include "hil_tests/soak/rows.hpp"
#include "hil_tests/soak/shrink.hpp"

namespace soak
{

struct CampaignSettings {
    std::uint64_t seed = 1;
    // The campaign ends when the file of results has at least `sessions` sessions and `ticks` ticks,
    // including those of earlier calls. If `sessions` or `ticks` is 0, only the other of these two numbers
    // ends the campaign.
    std::uint64_t sessions = 500, ticks = 20'000'000;
    // `hours` is the wall-clock time in hours after which this call ends; 0 means no time limit. With a time
    // limit, the numbers of sessions and ticks do not end the campaign.
    double hours = 0;
    int jobs = 1;
    std::string folder = "out/soak";
    double trial_seconds_max = 900; // of wall-clock time; a session that takes longer is broken
    DrawSettings draw;
    TrialSettings trial;
    ShrinkLimits shrink;
    bool shows_progress = true;
};

// Judges one session in a separate process. If a limit is exceeded, the function also shortens the session
// and writes its short form into the folder. Returns nothing if the user interrupted the call.
std::optional<Row> judge_session(const Catalogue &catalogue, const CampaignSettings &settings,
                                 const DrawnSession &session);

// Throws std::runtime_error if a file cannot be written.
void run_campaign(const Catalogue &catalogue, const CampaignSettings &settings, RowsFile &rows);

} // namespace soak
