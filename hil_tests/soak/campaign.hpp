// This header runs many sessions of one seed in separate processes, `jobs` of them at a time. Sessions are
// drawn, judged, shrunk when a bar breaks, and written to a file row by row. Ctrl-C ends the campaign; a
// later call continues it.
#pragma once
#include "hil_tests/soak/draw.hpp"
#include "hil_tests/soak/rows.hpp"
#include "hil_tests/soak/shrink.hpp"

namespace soak
{

struct CampaignSettings {
    std::uint64_t seed = 1;
    // The campaign ends when both limits are reached, where rows of former calls count; a limit of 0 does not
    // apply.
    std::uint64_t sessions = 500, ticks = 20'000'000;
    // This is the limit of this call by the clock; 0 means no limit. With such a limit, the numbers of
    // sessions and ticks do not end the campaign.
    double hours = 0;
    int jobs = 1;
    std::string folder = "out/soak";
    double trial_seconds_max = 900; // of wall-clock time; a session that takes longer is broken
    DrawSettings draw;
    TrialSettings trial;
    ShrinkLimits shrink;
    bool shows_progress = true;
};

// Judges one session in a separate process, and writes its shrunk form into the folder when a bar broke.
// Returns nothing when the call was interrupted.
std::optional<Row> judge_session(const Catalogue &catalogue, const CampaignSettings &settings,
                                 const DrawnSession &session);

// Throws std::runtime_error when a file cannot be written.
void run_campaign(const Catalogue &catalogue, const CampaignSettings &settings, RowsFile &rows);

} // namespace soak
