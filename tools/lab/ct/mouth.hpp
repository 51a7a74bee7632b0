// Where the inserter ends, in scans: there a line begins.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

struct Mouth {
    Eigen::Vector3d place_mm, direction; // scene; unit, into the vessel
};

// Lets the line begin where it crosses the mouth's plane; false where the scan shows it only in front of
// that, which is noted. Throws Fault where it lies elsewhere; `name` is the scan's, for messages.
bool begin_at_mouth(InstrumentLine &line, const Mouth &mouth, const std::string &name);

// A whole line, and how much of it the case says is inserted.
struct InsertedLine {
    std::vector<Eigen::Vector3d> places; // from outside to the tip
    double inserted_mm;
    std::string name; // the scan's
};
// The mouth is so far from the tip along the line as is inserted; of several depths, in the middle of what
// they say. Throws Fault where a scan does not show so much of the instrument, or where the depths contradict
// each other.
Mouth find_mouth(const std::vector<InsertedLine> &lines);

// That a line from the mouth to the tip is as long as what is inserted. Throws Fault where it is not: spacing
// or mouth are wrong.
void check_length(const InsertedLine &line);

// Straight on behind the mouth, where the inserter is.
std::vector<Eigen::Vector3d> behind_mouth(const LineOptions &options, const Eigen::Vector3d &begin_mm);

} // namespace crn::ct
