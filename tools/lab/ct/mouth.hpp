// Finds the distal end of the introducer in scans (in the code: mouth), where a case's line begins.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

struct Mouth {
    Eigen::Vector3d place_mm,
        direction; // in the scene's axes; the direction is a unit vector into the vessel
};

// Cuts the line where it crosses the plane of the introducer's distal end. Returns false, and adds a note, if
// the scan shows the instrument only in front of that plane. Throws Fault if the line does not pass through
// the introducer's end; messages use the scan's `name`.
bool begin_at_mouth(InstrumentLine &line, const Mouth &mouth, const std::string &name);

// Holds the whole line of an instrument, with the inserted length that the case states.
struct InsertedLine {
    std::vector<Eigen::Vector3d> places; // from outside the vessel to the tip
    double inserted_mm;
    std::string name; // the name of the scan
};
// The introducer's end lies back from the tip along the line by the inserted length; for several depths we
// take the mean. Throws Fault if a scan shows less of the instrument than is inserted, or if the depths
// contradict each other.
Mouth find_mouth(const std::vector<InsertedLine> &lines);

// Checks that a line from the introducer's end to the tip is as long as the inserted length. Throws Fault if
// the line has another length, because then the spacing or the introducer's end is wrong.
void check_length(const InsertedLine &line);

// Returns the straight continuation of the line outside the vessel, inside the introducer.
std::vector<Eigen::Vector3d> behind_mouth(const LineOptions &options, const Eigen::Vector3d &begin_mm);

} // namespace crn::ct
