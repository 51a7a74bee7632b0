// Describes the motion of a lumen by the lattice of firmware/core/motion.h, which is fitted to a sequence of
// meshes with equal triangles (docs/heart.md).
//
//   frames (the lumen's mesh at 24 moments)
//   ->  the frame from which the others are least far becomes the reference pose
//   ->  per keyframe: the displacement of each moved vertex back to that pose
//   ->  least squares on a trilinear lattice, smooth where there is no vertex, 0 at its boundary
//   ->  coefficients of the periodic spline in time  ->  int16  ->  measured by the core's own look-up
//
// The scene's text describes all parts in the pose of keyframe 0. With the fitted lattice, the moving parts
// are carried back to the reference pose.

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

// A sequence holds the positions of one set of points through the heart cycle; frame k shows the points at k
// / 24 of the cycle.
struct Sequence {
    std::vector<Eigen::Vector3d> reference_mm;
    std::vector<std::vector<Eigen::Vector3d>> moved_mm; // frames_count of them, or none
    std::vector<Eigen::Vector3d> inhaled_mm;            // frame 0 at the end of inspiration; empty: no breath

    // Resamples the frames in time. In the given frames, systole ends at frame `end_systole`; in the
    // resampled frames, it ends at frame 10.
    void retime(double end_systole);
};

struct Frames {
    Sequence lumen;
    std::vector<Triangle> triangles; // of the lumen
    Sequence guides; // other surfaces that the lattice moves, such as inner walls of the heart; empty: none
    std::size_t pose = 0; // the keyframe that is the reference pose
};

// Loads the files of the folders that the scene's text names, in the order of the file names, and resamples
// the frames to the 24 standard times. The reference pose is the keyframe that middle_pose() returns. `lumen`
// is the mesh of the scene's lumen, which must be checked and closed. Throws Fault if the number of files is
// wrong, if two files have different triangles, or if a vertex jumps between frames. Also throws Fault if the
// first frame differs from the scene's lumen; the message gives the file or the place of the difference.
Frames load_frames(const MotionText &text, const LumenText &lumen);

// Returns the keyframe whose longest displacement to any other keyframe is smallest. Displacements and their
// gradients are half as large when they are measured from the middle pose as when they are measured from one
// end of the motion.
std::size_t middle_pose(const Sequence &sequence);

struct Motion {
    crn_motion lattices{};
    std::vector<std::int16_t> rows, inhaled; // of the beat and of breath; empty: none
    const crn_motion *view();                // sets the pointers before it returns
    Eigen::Vector3d to_reference_mm(const Eigen::Vector3d &at_mm) const;
};

// The spacings of the lattices are the largest powers of two (in metres) that do not exceed the wanted
// spacings, and are stored in Q30. Throws Fault when the file format cannot hold a displacement, or when the
// motion would turn a part of the space inside out.
struct MotionSpacing {
    double beat_mm, breath_mm;
};
Motion fit_motion(const Frames &frames, const MotionSpacing &spacing, Progress &progress);

// The steepness is the difference of the displacements of two neighbouring nodes, divided by their distance.
// The core's arithmetic permits only a limited steepness (docs/heart.md).
struct Steepness {
    Worst heart, breath; // dimensionless shares, although the fields are called mm
};
constexpr double heart_steepness_max = 0.625, breath_steepness_max = 0.375;
Steepness steepness(const Motion &motion);
void refuse_steep(const Motion &motion); // throws Fault with the place where it is too steep

// Compares the surface of one frame with the lumen as the core moves it. The error of the moved lumen is |phi
// / |g||, evaluated at the vertices and at the middles of the triangles, where phi is the core's distance and
// g its gradient.
struct FrameError {
    double rms_mm = 0;
    Worst small; // where the reference lumen's radius is below small_vessel_mm
    Worst large;
    Worst along; // how far the wall's own points lie from their places in the frame; friction depends on it
};
constexpr double small_vessel_mm = 2.3;

// `left_out` marks vertices that the comparison skips, because a lesion makes the scene's lumen differ from
// the frames there. If `left_out` is empty, no vertex is skipped.
std::vector<FrameError> measure_motion(const crn_lumen *lumen, const crn_motion *motion, const Frames &frames,
                                       const std::vector<bool> &left_out = {});

} // namespace crn::bake
