// How a lumen moves: the lattice of firmware/core/motion.h, fitted to a sequence of meshes with one topology
// (docs/heart.md).
//
//   frames (the lumen's mesh at 24 moments)  ->  one of them, from which the others are least far, becomes the reference pose
//   ->  per keyframe: at each moved vertex the way back to that pose  ->  least squares on a trilinear lattice, smooth where there
//   is no vertex, 0 at its boundary  ->  coefficients of the periodic spline in time  ->  int16  ->  measured by the core's own
//   look-up
//
// The scene is described at keyframe 0; what moves in it is taken to the reference pose by the lattice
// itself.

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

// One set of points through the cycle: frame k at k / 24 of it.
struct Sequence {
    std::vector<Eigen::Vector3d> reference_mm;
    std::vector<std::vector<Eigen::Vector3d>> moved_mm; // frames_count of them, or none
    std::vector<Eigen::Vector3d> inhaled_mm;            // frame 0 at the end of inspiration; empty: no breath

    // To frames of which number 10 is the end of systole, from frames in which that is number `end_systole`.
    void retime(double end_systole);
};

struct Frames {
    Sequence lumen;
    std::vector<Triangle> triangles; // of the lumen
    Sequence guides;      // other surfaces that the lattice moves: inner walls of the heart, say; empty: none
    std::size_t pose = 0; // the keyframe that is the reference pose
};

// The files of the text's folders, in the order of their names, retimed; the reference pose is middle_pose().
// `lumen` is the scene's, checked and closed. Throws Fault naming the file that has other triangles, a wrong
// number of files, the first place where the sequence jumps, or a first frame that is not the scene's lumen.
Frames load_frames(const MotionText &text, const LumenText &lumen);

// The keyframe from which the longest way to any other is shortest: half as far as from one end of the motion
// to the other, and half as steep.
std::size_t middle_pose(const Sequence &sequence);

struct Motion {
    crn_motion lattices{};
    std::vector<std::int16_t> rows, inhaled; // of the beat; of breath, empty: none
    const crn_motion *view();                // sets the pointers
    // Where in the reference pose a point of keyframe 0 lies.
    Eigen::Vector3d to_reference_mm(const Eigen::Vector3d &at_mm) const;
};

// Spacings: the largest powers of two of Q30 that are not above the wanted. Throws Fault when the frames move
// by more than the format holds or fold over.
struct MotionSpacing {
    double beat_mm, breath_mm;
};
Motion fit_motion(const Frames &frames, const MotionSpacing &spacing, Progress &progress);

// How much more one node moves than the next, as a share of their distance: what the core's arithmetic holds
// is limited (docs/heart.md).
struct Steepness {
    Worst heart, breath; // shares, for all that they are called mm
};
constexpr double heart_steepness_max = 0.625, breath_steepness_max = 0.375;
Steepness steepness(const Motion &motion);
void refuse_steep(const Motion &motion); // throws Fault with the place

// One frame's surface against the moved lumen, as the core sees it: |phi / |g|| at its vertices and the
// middles of its triangles.
struct FrameError {
    double rms_mm = 0;
    Worst small; // where the reference lumen's radius is below small_vessel_mm
    Worst large;
    Worst along; // how far the wall's own points are from where the frame has them: what friction sees
};
constexpr double small_vessel_mm = 2.3;

// `left_out`: vertices that are not looked at, where the scene's lumen is not the frames' (lesions); empty:
// none.
std::vector<FrameError> measure_motion(const crn_lumen *lumen, const crn_motion *motion, const Frames &frames,
                                       const std::vector<bool> &left_out = {});

} // namespace crn::bake
