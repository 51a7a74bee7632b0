// Finds the distal end of the introducer (the mouth) in scans, where a line begins.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

struct Mouth {
    Eigen::Vector3d place_mm,
        direction; // in the scene's axes; the direction is a unit vector into the vessel
};

// Cuts the line where it crosses the mouth's plane. Returns false, with a note, where the scan shows the
// instrument only in front of that plane. Throws Fault where the line passes elsewhere; `name` is the scan's,
// for messages.
bool begin_at_mouth(InstrumentLine &line, const Mouth &mouth, const std::string &name);

// A whole line of an instrument, with the inserted length that the case states.
struct InsertedLine {
    std::vector<Eigen::Vector3d> places; // from outside the vessel to the tip
    double inserted_mm;
    std::string name; // the name of the scan
};
// The mouth lies back from the tip along the line by the inserted length; for several depths we take the
// mean. Throws Fault where a scan shows less of the instrument than is inserted, or where the depths
// contradict each other.
Mouth find_mouth(const std::vector<InsertedLine> &lines);

// Checks that a line from the mouth to the tip is as long as the inserted length. Throws Fault otherwise: the
// spacing or the mouth is wrong.
void check_length(const InsertedLine &line);

// The straight continuation outside the vessel, where the introducer is.
std::vector<Eigen::Vector3d> behind_mouth(const LineOptions &options, const Eigen::Vector3d &begin_mm);

} // namespace crn::ct
