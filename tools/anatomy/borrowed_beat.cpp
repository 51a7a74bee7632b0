#include "tools/anatomy/borrowed_beat.hpp"
#include "host/base/format.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr double SCALE_MIN = 0.6, SCALE_MAX = 1.6, RESIDUAL_MAX_MM = 20.0, FLATTEST = 0.03;

using Places = std::array<Vec3, 3>;

Places places_of(const HeartLandmarks &heart)
{
    return {heart.left_ostium_mm, heart.right_ostium_mm, heart.apex_mm};
}

Eigen::Matrix3d columns(const Places &places)
{
    Eigen::Matrix3d all;
    for (int k = 0; k < 3; k++) all.col(k) = places[static_cast<size_t>(k)];
    return all;
}

std::filesystem::path frame_file(const std::filesystem::path &folder, const std::string &name, int frame)
{
    return folder / crn::formatted("%s_%02d.ply", name.c_str(), frame);
}

} // namespace

namespace
{

/* Returns the first point of an artery's centreline that lies outside of the aorta. The centreline of an
 * artery begins inside the aorta. */
Vec3 ostium(const Vessel &artery, const Curve &aorta)
{
    for (const CurvePoint &point : vessel_curve(artery, 0.5)) {
        const auto nearest = std::min_element(aorta.begin(), aorta.end(), [&](const auto &a, const auto &b) {
            return (a.position_mm - point.position_mm).squaredNorm() <
                   (b.position_mm - point.position_mm).squaredNorm();
        });
        if ((nearest->position_mm - point.position_mm).norm() > nearest->radius_mm) return point.position_mm;
    }
    throw std::logic_error(artery.name + " does not leave the aorta");
}

} // namespace

HeartLandmarks shipped_landmarks()
{
    HeartLandmarks heart;
    heart.apex_mm = heart_axes().apex_mm;
    const VesselTree tree = shipped_vessels("heart");
    const Curve aorta = vessel_curve(tree.vessels.front(), 0.5);
    for (const Vessel &vessel : coronary_arteries(tree)) {
        if (vessel.name == "LM") heart.left_ostium_mm = ostium(vessel, aorta);
        if (vessel.name == "RCA") heart.right_ostium_mm = ostium(vessel, aorta);
    }
    return heart;
}

HeartPlacement place_heart(const HeartLandmarks &other)
{
    const Places from = places_of(other), to = places_of(shipped_landmarks());
    const Vec3 across = from[1] - from[0], down = from[2] - from[0];
    if (across.cross(down).norm() <= FLATTEST * down.squaredNorm())
        throw std::invalid_argument("left ostium, right ostium and apex lie on one line: look at --left, "
                                    "--right and --apex (x, y and z in mm)");
    const Eigen::Matrix4d found = Eigen::umeyama(columns(from), columns(to), true);
    HeartPlacement placement;
    placement.scale = found.block<3, 1>(0, 0).norm();
    placement.rotation = found.block<3, 3>(0, 0) / placement.scale;
    placement.shift_mm = found.block<3, 1>(0, 3);
    if (placement.scale < SCALE_MIN || placement.scale > SCALE_MAX)
        throw std::invalid_argument(crn::formatted(
            "this heart would be %.2f times as large as the shipped one, beyond %.1f to %.1f: look at "
            "--left, --right and --apex, in mm",
            1.0 / placement.scale, 1.0 / SCALE_MAX, 1.0 / SCALE_MIN));
    static const char *const names[3] = {"--left", "--right", "--apex"};
    for (size_t k = 0; k < 3; k++) {
        placement.residual_mm[k] = (placement.from_shipped(to[k]) - from[k]).norm();
        if (placement.residual_mm[k] > RESIDUAL_MAX_MM)
            throw std::invalid_argument(crn::formatted(
                "%s is %.0f mm off where a heart like the shipped one has it, more than %.0f: is it right?",
                names[k], placement.residual_mm[k], RESIDUAL_MAX_MM));
    }
    return placement;
}

double write_borrowed_beat(const std::filesystem::path &folder, const std::string &name, const Mesh &rest,
                           const HeartPlacement &placement)
{
    const HeartBeat beat(shipped_vessels("heart").vessels.front());
    std::vector<std::vector<Vec3>> frames_mm(BEAT_FRAMES);
    std::vector<Vec3> inhaled_mm;
    double longest_mm = 0.0;
    for (const Vec3 &vertex : rest.vertices_mm) {
        const Vec3 there = placement.to_shipped(vertex);
        const std::vector<Vec3> places = beat.frames(there);
        for (size_t frame = 0; frame < BEAT_FRAMES; frame++) {
            frames_mm[frame].push_back(vertex + placement.from_shipped(places[frame]) -
                                       placement.from_shipped(there));
            longest_mm = std::max(longest_mm, (frames_mm[frame].back() - vertex).norm());
        }
        inhaled_mm.push_back(vertex + placement.rotation.transpose() * (beat.inhaled(there) - there));
    }
    std::filesystem::create_directories(folder);
    const std::string comment = "the shipped heart's beat, borrowed, millimetres";
    for (int frame = 0; frame < BEAT_FRAMES; frame++)
        write_ply(frame_file(folder, name, frame), {frames_mm[static_cast<size_t>(frame)], rest.triangles},
                  comment);
    write_ply(folder.string() + "_inhaled.ply", {inhaled_mm, rest.triangles}, comment);
    return longest_mm;
}

} // namespace anatomy
