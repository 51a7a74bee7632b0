// Many sessions of one seed, in processes of their own, as many at a time as there are jobs: drawn, judged,
// shrunk when a bar breaks, and written row by row. Ctrl-C ends it; a later call goes on.
#pragma once
#include "hil_tests/soak/draw.hpp"
#include "hil_tests/soak/rows.hpp"
#include "hil_tests/soak/shrink.hpp"

namespace soak
{

struct CampaignSettings {
    std::uint64_t seed = 1;
    // It ends when both are reached, rows of former calls included; 0: that one does not matter.
    std::uint64_t sessions = 500, ticks = 20'000'000;
    double hours = 0; // of this call; 0: no end by the clock. With hours, sessions and ticks do not end it
    int jobs = 1;
    std::string folder = "out/soak";
    double trial_seconds_max = 900; // of the machine; what takes longer is broken
    DrawSettings draw;
    TrialSettings trial;
    ShrinkLimits shrink;
    bool shows_progress = true;
};

// One session by its number: judged in a process of its own, and shrunk into the folder when it broke.
// Nothing when it was interrupted.
std::optional<Row> judge_session(const Catalogue &catalogue, const CampaignSettings &settings,
                                 const DrawnSession &session);

// Throws std::runtime_error when nothing can be written.
void run_campaign(const Catalogue &catalogue, const CampaignSettings &settings, RowsFile &rows);

} // namespace soak
