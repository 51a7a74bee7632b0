// Finds the instrument in a scan: its voxels, the order of these voxels, and the middle line through them
// (docs/ct.md, "The centreline").
#pragma once
#include "tools/lab/ct/scanner.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <optional>

namespace crn::ct
{

struct LineOptions {
    double threshold_HU = 0;                // of the instrument; 0: half of the brightest value
    std::optional<Eigen::Vector3d> seed_mm; // a place on the instrument; empty: the longest bright object
    std::optional<Eigen::Vector3d>
        mouth_mm; // determines which end is the tip; begin_at_mouth cuts the line there ...
    Eigen::Vector3d direction = Eigen::Vector3d::UnitY(); // ... across this direction
};

struct LinePoint {
    Eigen::Vector3d place_mm; // in the scene's axes
    double unsure_mm = 0;     // standard deviation across the line, as far as the fit can determine it
    double height_HU =
        0; // of the blurred instrument above its surroundings; beyond the scale where it is saturated
    std::string why; // the reason for the uncertainty; empty: none
};

struct InstrumentLine {
    std::vector<LinePoint> points; // from the introducer to the tip
    double threshold_HU = 0, blur_mm = 0,
           blur_slice_mm = 0; // as fitted: these blurs include the instrument's own width
    double around_HU = 0;
    std::vector<std::string> notes;
    std::vector<Eigen::Vector3d> places() const;
};

// Returns a volume in which the voxels of the instrument have the value 1. Throws Fault if the scan shows no
// instrument or more than one instrument.
Volume find_instrument(const Volume &volume, LineOptions &options);

// Returns the whole centreline of the instrument in the scan, including the part outside the introducer.
// Throws Fault if two instruments touch, or if the instrument is too short.
InstrumentLine trace_instrument(const Volume &volume, const Volume &mask, const LineOptions &options,
                                const Report &report);

// --- parts, for tests ---

// Returns points of the centreline at equal distances of about step_mm.
std::vector<Eigen::Vector3d> resampled(const std::vector<Eigen::Vector3d> &line, double step_mm);
// Returns the distance of a point from the centreline, and the arc length of the nearest point on the
// centreline.
struct LineDistance {
    double distance_mm, arc_mm;
};
LineDistance distance_from(const std::vector<Eigen::Vector3d> &line, const Eigen::Vector3d &place);

} // namespace crn::ct
