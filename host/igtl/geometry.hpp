// Converts places of the patient frame (docs/frames.md) to the RAS axes and millimetres of OpenIGTLink.
#pragma once
#include "host/igtl/frame.hpp"
#include "host/model/wire_frame.hpp"
#include "host/xray/paths/carm.hpp"
#include <optional>

namespace crn
{

// Converts a direction. The patient frame is (left, head, front), and RAS is (right, front, head).
Eigen::Vector3d ras_direction(const Eigen::Vector3d &direction);
// Converts a place in metres to millimetres.
Eigen::Vector3d ras_place_mm(const Eigen::Vector3d &place_m);

// Returns the frame of the tip at this arc length from the leading tip. Its origin is the tip, and its z axis
// points out of the tip. The smallest rotation that turns the direction to the head into this z axis gives
// the x and y axes, so they do not follow a turn of the tool about itself. The result is empty while the
// shape of the tools is not known.
std::optional<IgtlPose> tip_pose(const WireFrame &wire, double tip_arc_m);

// Returns the frame of the C-arm: the origin is the isocentre, x points to the right in the picture, y up in
// the picture, and z from the source to the detector.
IgtlPose carm_pose(const CArm &carm);

// Returns the place of a picture with this many pixels along each edge: it lies on the detector.
IgtlPicture picture_place(const CArm &carm, int size);

} // namespace crn
