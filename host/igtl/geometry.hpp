// Converts positions in the patient frame (docs/frames.md) to the RAS axes and millimetres of OpenIGTLink.
#pragma once
#include "host/igtl/frame.hpp"
#include "host/model/wire_frame.hpp"
#include "host/xray/paths/carm.hpp"
#include <optional>

namespace crn
{

// Converts a direction. The patient frame is (left, head, front), and RAS is (right, front, head).
Eigen::Vector3d ras_direction(const Eigen::Vector3d &direction);
// Converts a position in metres to millimetres.
Eigen::Vector3d ras_place_mm(const Eigen::Vector3d &place_m);

// Returns the coordinate frame of the tip at this arc length from the leading tip. The origin of the frame is
// the tip, and its z axis points out of the tip. The x and y axes result from the smallest rotation that
// turns the head direction into this z axis, so they do not follow a turn of the tool about its own axis. The
// function returns nothing if the shape of the tools is not known yet.
std::optional<IgtlPose> tip_pose(const WireFrame &wire, double tip_arc_m);

// Returns the coordinate frame of the C-arm: its origin is the isocentre, x points to the right in the
// picture, y upwards in the picture, and z from the source to the detector.
IgtlPose carm_pose(const CArm &carm);

// Returns the position and size, on the detector, of a picture with this many pixels along each edge.
IgtlPicture picture_place(const CArm &carm, int size);

} // namespace crn
