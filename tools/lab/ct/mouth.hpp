// Finds the distal end of the introducer (called "mouth" in the code) in scans; the centrelines of a case
// begin at this end.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

struct Mouth {
    Eigen::Vector3d place_mm,
        direction; // in the scene's axes; the direction is a unit vector into the vessel
};

// Cuts the centreline where it crosses the plane of the introducer's distal end. Returns false, and adds a
// note, if the scan shows only the part of the instrument that lies beyond this plane in the vessel. Throws
// Fault if the centreline does not pass through the introducer's end; the message names the scan as `name`.
bool begin_at_mouth(InstrumentLine &line, const Mouth &mouth, const std::string &name);

// Holds the whole centreline of an instrument, and the inserted length that the case states.
struct InsertedLine {
    std::vector<Eigen::Vector3d> places; // from outside the vessel to the tip
    double inserted_mm;
    std::string name; // the name of the scan
};
// The distance from the tip back along the centreline to the introducer's end is the inserted length. With
// several depths, the introducer's end is taken as the mean of the positions that the depths give. Throws
// Fault if the part of the instrument in a scan is shorter than the inserted length, or if the depths give
// contradictory positions.
Mouth find_mouth(const std::vector<InsertedLine> &lines);

// Checks that the length of a centreline, from the introducer's end to the tip, equals the inserted length.
// Throws Fault if the centreline has another length, because the spacing of the voxels or the introducer's
// end is then wrong.
void check_length(const InsertedLine &line);

// Returns the straight continuation of the centreline outside the vessel, inside the introducer.
std::vector<Eigen::Vector3d> behind_mouth(const LineOptions &options, const Eigen::Vector3d &begin_mm);

} // namespace crn::ct
