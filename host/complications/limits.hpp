// What a vessel bears, and what follows when it does not: the limits at which a wall is dissected or
// perforated, the size of such a wound, and its effect on the patient. docs/complications.md states the
// equations and sources; shared/examples/complications.toml states every limit with its source. A file of a
// user may state other limits:
//
//   ComplicationLimits limits = read_complications("mine.toml");
//   for (const RoomCommand &command : commands_of(limits)) patient.command(0, command);
//
// The commands are recorded, so that a replay has the same limits.
#pragma once
#include "host/room/command.hpp"
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace crn
{

struct ComplicationLimits {
    bool is_on = true; // false: vessels bear everything
    // A tool's tip pushes against the wall with a pressure: its force over the area of its front.
    double perforation_tip_kPa = 1430.0, dissection_tip_kPa = 477.0, tip_hold_ms = 96.0;
    // A balloon is too large: its free diameter at its pressure over the healthy vessel's diameter.
    double perforation_balloon_ratio = 1.3, dissection_balloon_ratio = 1.2, balloon_hold_ms = 480.0;
    // The hole: a tip leaves its own diameter, and a balloon the diameter at its limit and more beyond it.
    double balloon_hole_mm = 0.8, balloon_hole_mm_per_ratio = 2.0;
    double hole_open_pct = 25.0;                // share of its area that the tissue leaves open
    double crater_below_mm = 0.2, jet_mm = 1.0; // Ellis I below, III from this diameter on
    double seal_s = 600.0;                      // without pressure until a hole has closed
    double blush_mg_per_ml = 100.0;             // iodine in the tissue
    // The flap: its length behind a tip (that of the balloon otherwise), and the share of the diameter that
    // it takes at the limit and more beyond it, for a balloon up to the limit of a perforation.
    double flap_mm = 10.0, flap_narrowing_pct = 20.0;
    double tip_narrowing_pct = 40.0, balloon_narrowing_pct = 480.0; // per limit by which it is exceeded
    double pocket_fill_s = 1.0, pocket_empty_s = 60.0;
    // The pressure falls linearly between two amounts of lost blood, to the share that is left.
    double tamponade_begins_ml = 100.0, tamponade_full_ml = 250.0; // around the heart
    double shock_begins_ml = 750.0, shock_full_ml = 2000.0;        // anywhere
    double pressure_left_pct = 40.0;

    bool operator==(const ComplicationLimits &) const = default;
};

// Describes a limit: its key in files, and the numbers that it allows.
struct ComplicationLimit {
    const char *key;
    double ComplicationLimits::*value;
    double low, high;
};
std::span<const ComplicationLimit> complication_limits();

// Reads a file of limits (docs/complications.md); a limit that the file does not state is as it ships. Throws
// FileError: "FILE:LINE:COLUMN: place: what is wrong".
ComplicationLimits read_complications(const std::string &path);

// Returns the commands that set these limits; none for those that ship. A recording keeps thousandths.
std::vector<RoomCommand> commands_of(const ComplicationLimits &limits);
// Adopts the limit that such a command sets. Other commands are ignored.
void take_command(ComplicationLimits &limits, const RoomCommand &command);

// Returns what is wrong with the limits together, or an empty string.
std::string limits_fault(const ComplicationLimits &limits);

} // namespace crn
