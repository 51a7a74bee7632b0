#include "host/igtl/geometry.hpp"
#include "host/model/wire_place.hpp"

namespace crn
{

namespace
{

constexpr double mm_per_m = 1e3;
constexpr double tip_chord_m = 1e-3; // the tip's direction is that of its last millimetre

IgtlPose pose_of(const Eigen::Vector3d &x, const Eigen::Vector3d &y, const Eigen::Vector3d &z,
                 const Eigen::Vector3d &origin_m)
{
    IgtlPose pose = IgtlPose::Identity();
    pose.linear().col(0) = ras_direction(x);
    pose.linear().col(1) = ras_direction(y);
    pose.linear().col(2) = ras_direction(z);
    pose.translation() = ras_place_mm(origin_m);
    return pose;
}

} // namespace

Eigen::Vector3d ras_direction(const Eigen::Vector3d &direction)
{
    return {-direction.x(), direction.z(), direction.y()};
}

Eigen::Vector3d ras_place_mm(const Eigen::Vector3d &place_m)
{
    return ras_direction(place_m) * mm_per_m;
}

std::optional<IgtlPose> tip_pose(const WireFrame &wire, double tip_arc_m)
{
    if (wire.nodes.size() < 2) return {};
    const Eigen::Vector3d tip_m = line_place_m(wire, tip_arc_m);
    const Eigen::Vector3d out = tip_m - line_place_m(wire, tip_arc_m + tip_chord_m);
    if (!(out.norm() > 0.0)) return {};
    IgtlPose pose = IgtlPose::Identity();
    pose.linear() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ras_direction(out)).toRotationMatrix();
    pose.translation() = ras_place_mm(tip_m);
    return pose;
}

IgtlPose carm_pose(const CArm &carm)
{
    const View view = make_view(carm, 1);
    return pose_of(view.right, view.up, view.forward, carm.isocentre_m);
}

IgtlPicture picture_place(const CArm &carm, int size)
{
    const View view = make_view(carm, size);
    IgtlPicture picture;
    picture.size = size;
    picture.pixel_mm = view.pixel_m * mm_per_m;
    const Eigen::Vector3d centre_m = view.source_m + view.source_detector_m * view.forward;
    picture.pose = pose_of(view.right, -view.up, -view.forward, centre_m);
    return picture;
}

} // namespace crn
