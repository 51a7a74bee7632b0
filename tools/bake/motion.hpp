// How a lumen moves: the lattice of firmware/core/motion.h, fitted to a sequence of meshes with one topology
// (docs/heart.md).
//
//   frames (the lumen's mesh at 24 moments)
//   ->  the frame from which the others are least far becomes the reference pose
//   ->  per keyframe: the displacement of each moved vertex back to that pose
//   ->  least squares on a trilinear lattice, smooth where there is no vertex, 0 at its boundary
//   ->  coefficients of the periodic spline in time  ->  int16  ->  measured by the core's own look-up
//
// The scene is described at keyframe 0. The lattice itself carries its moving parts to the reference pose.

#pragma once
#include "tools/bake/field.hpp"
#include "tools/bake/measure.hpp"
#include "tools/bake/mesh.hpp"

#include <vector>
extern "C" {
#include "firmware/core/motion.h"
}

namespace crn::bake
{

constexpr std::size_t frames_count = CRN_MOTION_KEYFRAMES;

// One set of points through the cycle: frame k is at k / 24 of it.
struct Sequence {
    std::vector<Eigen::Vector3d> reference_mm;
    std::vector<std::vector<Eigen::Vector3d>> moved_mm; // frames_count of them, or none
    std::vector<Eigen::Vector3d> inhaled_mm;            // frame 0 at the end of inspiration; empty: no breath

    // Resamples frames in which `end_systole` is the end of systole, so that it becomes frame 10.
    void retime(double end_systole);
};

struct Frames {
    Sequence lumen;
    std::vector<Triangle> triangles; // of the lumen
    Sequence guides; // other surfaces that the lattice moves, such as inner walls of the heart; empty: none
    std::size_t pose = 0; // the keyframe that is the reference pose
};

// Loads the files of the text's folders in the order of their names and retimes them; the reference pose is
// middle_pose(). `lumen` is that of the scene, checked and closed. Throws Fault naming a file with other
// triangles, a wrong number of files, the first place where the sequence jumps, or a first frame that differs
// from the scene's lumen.
Frames load_frames(const MotionText &text, const LumenText &lumen);

// The keyframe whose longest displacement to any other is shortest. The motion from it is half as long, and
// half as steep, as from one end of the motion to the other.
std::size_t middle_pose(const Sequence &sequence);

struct Motion {
    crn_motion lattices{};
    std::vector<std::int16_t> rows, inhaled; // of the beat and of breath; empty: none
    const crn_motion *view();                // sets the pointers before it returns
    Eigen::Vector3d to_reference_mm(const Eigen::Vector3d &at_mm) const;
};

// The lattices take the largest spacings, powers of two of Q30, that do not exceed the wanted ones. Throws
// Fault when the frames move by more than the format holds or fold over.
struct MotionSpacing {
    double beat_mm, breath_mm;
};
Motion fit_motion(const Frames &frames, const MotionSpacing &spacing, Progress &progress);

// The difference in displacement between neighbouring nodes as a share of their distance. The core's
// arithmetic holds a limited range (docs/heart.md).
struct Steepness {
    Worst heart, breath; // dimensionless shares, although the fields are called mm
};
constexpr double heart_steepness_max = 0.625, breath_steepness_max = 0.375;
Steepness steepness(const Motion &motion);
void refuse_steep(const Motion &motion); // throws Fault with the place where it is too steep

// One frame's surface against the moved lumen, as the core computes it: |phi / |g|| at the vertices and at
// the middles of the triangles.
struct FrameError {
    double rms_mm = 0;
    Worst small; // where the reference lumen's radius is below small_vessel_mm
    Worst large;
    Worst along; // how far the wall's own points lie from their places in the frame; friction depends on it
};
constexpr double small_vessel_mm = 2.3;

// `left_out` marks vertices that are skipped because the scene's lumen differs there from the frames
// (lesions); empty: none.
std::vector<FrameError> measure_motion(const crn_lumen *lumen, const crn_motion *motion, const Frames &frames,
                                       const std::vector<bool> &left_out = {});

} // namespace crn::bake
