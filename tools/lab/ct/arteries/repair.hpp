// Mends arteries by clicks: cuts, bridges, and pieces that a click says are arteries.
#pragma once
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include <optional>

namespace crn::ct
{

// The balls that the cuts take out of the arteries.
std::vector<Ball> cuts_of(const std::vector<Click> &clicks);

// The disc at the first click into an artery, for scans without an aorta: its brightness is that of the
// blood. Empty without such a click, and where nothing there is as bright as blood with medium.
Stack clicked_start(const Volume &scan, const std::vector<Click> &clicks);

// The widest bright voxel near each click into an artery, or the nearest one if it is in a tube. Throws Fault
// where nothing there is bright.
std::vector<Source> sources_of(const Volume &scan, const Bright &bright, const std::vector<Click> &clicks);

// A tube between two vessels, as wide as they are.
struct Tube {
    Eigen::Vector3d from_mm, to_mm;
    double from_radius_mm, to_radius_mm;
    std::size_t to; // the voxel
};

// The tube of a bridge: from the artery nearest to the click to the nearest bright voxel on its other side.
// Throws Fault where one of them is missing.
Tube bridge_of(const Volume &scan, const Bright &bright, const Mask &artery, const Click &click);
void mark_tube(const Volume &scan, const Tube &tube, Mask &mask);

// Joins each clicked piece of the arteries by a tube to the nearest other one, unless it contains a voxel of
// `start`. The new voxels are marked in `tubes`, too.
void join_clicked(const Volume &scan, const Bright &bright, const std::vector<Click> &clicks,
                  const Mask &start, Mask &artery, Mask &tubes, Findings &findings);

// Takes away what is not connected with the voxels of `start`.
void keep_connected(const Volume &scan, const Mask &start, Mask &artery);

} // namespace crn::ct
