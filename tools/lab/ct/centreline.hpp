// The instrument in a scan: which voxels, in which order, and where its middle line runs between them
// (docs/ct.md, "The centreline").
#pragma once
#include "tools/lab/ct/scanner.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <optional>

namespace crn::ct
{

struct LineOptions {
    double threshold_HU = 0;                // of the instrument; 0: half-way to the brightest
    std::optional<Eigen::Vector3d> seed_mm; // a place on the instrument; none: the longest bright thing
    std::optional<Eigen::Vector3d>
        mouth_mm; // tells which end is the tip; begin_at_mouth cuts the line there ...
    Eigen::Vector3d direction = Eigen::Vector3d::UnitY(); // ... across this
};

struct LinePoint {
    Eigen::Vector3d place_mm; // scene
    double unsure_mm = 0;     // standard deviation across the line, as far as the fit can tell
    double height_HU =
        0; // of the blurred instrument above what is around it, beyond the scale where it is saturated
    std::string why; // what makes it unsure; empty: nothing
};

struct InstrumentLine {
    std::vector<LinePoint> points; // from the mouth to the tip
    double threshold_HU = 0, blur_mm = 0,
           blur_slice_mm = 0; // as found: blurs with the instrument's own width
    double around_HU = 0;
    std::vector<std::string> notes;
    std::vector<Eigen::Vector3d> places() const;
};

// Voxels of the one instrument (1 inside). Throws Fault: no instrument, two instruments.
Volume find_instrument(const Volume &volume, LineOptions &options);

// The whole line in the scan, also behind the mouth. Throws Fault: two instruments that touch, one that is
// too short.
InstrumentLine trace_instrument(const Volume &volume, const Volume &mask, const LineOptions &options,
                                const Report &report);

// --- parts, for tests
// --------------------------------------------------------------------------------------------------- Points
// of a line at even distances of about step_mm.
std::vector<Eigen::Vector3d> resampled(const std::vector<Eigen::Vector3d> &line, double step_mm);
// Distance from a line, and from which place on it (arc length).
struct LineDistance {
    double distance_mm, arc_mm;
};
LineDistance distance_from(const std::vector<Eigen::Vector3d> &line, const Eigen::Vector3d &place);

} // namespace crn::ct
