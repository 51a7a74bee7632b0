// Computes the figures of a stent for the report: apposition, width, coverage, and how far the stent has
// stretched the vessel. The struts are also returned as lines with a radius, for the X-ray picture.
#pragma once
#include "host/stent/stent.hpp"
#include <string>
#include <vector>

namespace crn
{

inline constexpr double apposed_mm = 0.1; // a strut this near the wall counts as apposed

// Describes a strut that does not touch the wall, and the gap between strut and wall.
struct StentGap {
    int ring = 0;
    std::size_t strut = 0;    // of the lattice
    double gap_mm = 0.0;      // largest gap from its outside to the wall
    Eigen::Vector3d place_mm; // place of that gap
};

struct StentRing {
    Eigen::Vector3d centre_mm, axis; // towards the hub
    double along_mm = 0.0;           // from the first ring's middle, along the middles
    double diameter_mm = 0.0;        // inside: of the circle of equal area
    double diameter_min_mm = 0.0;    // narrowest, through the middle
    double area_mm2 = 0.0;           // inside
    bool is_opened = false;
};

struct StentFigures {
    std::size_t samples = 0; // samples on struts, five on each
    double apposed_share = 0.0;
    std::vector<StentGap>
        gaps; // by strut; where no wall is near one end of a strut, that end counts as far from any wall
    std::vector<StentRing> rings;
    double diameter_min_mm = 0.0, area_min_mm2 = 0.0; // of the rings
    double length_mm = 0.0;                           // from end to end, along the rings' middles
    double foreshortening = 0.0;                      // share of the crimped length
    std::size_t unopened_rings = 0;
    double bedded_share = 0.0; // of the crowns
};

// If `wall` is null, no strut counts as touching the wall (apposed).
StentFigures stent_figures(const Stent &stent, const StentWall *wall);

// Describes the position of a stent along a centreline, and the lengths of a lesion that the stent does not
// cover; positions are in mm along the centreline.
struct StentCoverage {
    double from_mm = 0.0, to_mm = 0.0;
    double missed_before_mm = 0.0, missed_behind_mm = 0.0; // of the lesion, at either end
    bool misses() const { return missed_before_mm > 0 || missed_behind_mm > 0; }
};
StentCoverage stent_coverage(const Stent &stent, std::span<const Eigen::Vector3d> centreline_mm,
                             double lesion_from_mm, double lesion_to_mm);
// Returns the coverage of a lesion in a moving vessel, in mm along the vessel's healthy branch from the
// branch's first point.
class VesselWall;
StentCoverage stent_coverage(const Stent &stent, const VesselWall &vessel, std::size_t lesion);

// Returns the largest overstretch of the vessel: a ring's outside diameter on a balloon, divided by the
// healthy vessel's diameter at the ring, minus 1. The overstretch is 0 for a stent that was never opened.
double stent_stretch(const Stent &stent, std::span<const Eigen::Vector3d> centreline_mm,
                     std::span<const double> healthy_radius_mm);

// Returns the length, in mm along the stents, over which an inner stent lies inside an outer stent.
double stent_overlap_mm(const Stent &inner, const StentSleeve &outer);

// A line of metal. Every ring of struts is one closed line through the middles of its struts, and every link
// is another line.
struct StentLine {
    std::vector<Eigen::Vector3d> points_mm;
    double radius_mm = 0.0; // of a round wire with the same amount of metal
};
std::vector<StentLine> stent_lines(const Stent &stent);

// Returns the balloon's two marker bands, one on each side of the crimped stent, as short pieces of the
// balloon's axis.
std::vector<StentLine> stent_markers(const StentDesign &design, double mount_arc_mm, const BalloonPose &pose);

std::string_view stent_stage_text(StentStage stage); // for displays and reports

} // namespace crn
