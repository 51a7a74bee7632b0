#include "host/picture/surface_file.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/model/lesion_wall.hpp"
#include "host/model/scene_anatomy.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace crn
{
namespace
{

using Eigen::Vector3d;

constexpr double vessel_radii = 1.8; // places farther from the vessel's line belong to other vessels
constexpr std::uint32_t balloon_around = 24;
constexpr int panel_pixels = 480;

// Returns the point of the nested tools at an arc length from their leading tip, and the direction of the
// tools there.
bool place_at(const WireFrame &wire, double arc_m, Vector3d &place_m, Vector3d &along)
{
    for (std::size_t i = 0; i + 1 < wire.nodes.size(); ++i) {
        const WireNode &a = wire.nodes[i], &b = wire.nodes[i + 1];
        if (arc_m < a.arc_m || arc_m > b.arc_m || !(b.arc_m > a.arc_m)) continue;
        along = (b.position_m - a.position_m).normalized();
        place_m = a.position_m + (arc_m - a.arc_m) / (b.arc_m - a.arc_m) * (b.position_m - a.position_m);
        return true;
    }
    return false;
}

std::size_t lesion_called(const VesselTree &tree, const std::string &name)
{
    std::string names;
    for (std::size_t k = 0; k < tree.lesions.size(); ++k) {
        if (name.empty() || tree.lesions[k].name == name) return k;
        names += (names.empty() ? "" : ", ") + tree.lesions[k].name;
    }
    throw std::runtime_error(
        name.empty() ? "the scene has no lesion: bake one with a [[lesion]]"
                     : "--lesion: the scene has no '" + name + "'" +
                           (names.empty() ? "; it has none: bake one with a [[lesion]]" : ", but " + names));
}

} // namespace

SurfaceSink::SurfaceSink(const SurfaceSettings &settings, std::vector<std::uint32_t> ticks)
    : settings_(settings), ticks_(std::move(ticks))
{
    if (settings.bodies_path.empty())
        throw std::runtime_error("the scene has no .bodies file, which holds the walls");
    SceneAnatomy anatomy = read_scene_anatomy(settings.scene_path, settings.bodies_path);
    bodies_ = std::move(anatomy.bodies);
    motion_ = std::move(anatomy.motion);
    lesion_ = lesion_called(bodies_.vessels, settings.lesion);
    healthy_ = healthy_tree(bodies_.vessels);
    opened_.emplace(bodies_, LesionOpening(bodies_.vessels, anatomy.stations),
                    nullptr); // in the reference pose
    if (opened_->is_empty())
        throw std::runtime_error(
            settings.bodies_path +
            ": no body of blood has the lesion's vessel in it: give the scene's text one, such as "
            "[[body]] mesh = \"lumen\"");
}

SurfaceSink::~SurfaceSink() = default;

std::uint32_t SurfaceSink::next_tick() const
{
    return at_ < ticks_.size() ? ticks_[at_] : std::numeric_limits<std::uint32_t>::max();
}

// Returns true if a point is within the requested distance along the healthy vessel, and nearer to this
// vessel than to any other.
bool SurfaceSink::is_near(const Vector3d &place_m) const
{
    const VesselLesion &lesion = bodies_.vessels.lesions[lesion_];
    const VesselBranch &branch = healthy_.branches[lesion.branch];
    const VesselFoot foot = vessel_foot(branch, place_m);
    if (foot.radii > vessel_radii) return false;
    const auto arc_m = [&](std::size_t point, double share) {
        double sum_m = 0.0;
        for (std::size_t i = 0; i < point; ++i) sum_m += (branch.points_m[i + 1] - branch.points_m[i]).norm();
        return sum_m +
               (share > 0.0 ? share * (branch.points_m[point + 1] - branch.points_m[point]).norm() : 0.0);
    };
    const double here_m = arc_m(foot.point, foot.share), begin_m = arc_m(lesion.first_point, 0.0),
                 end_m = arc_m(lesion.first_point + lesion.size() - 1, 0.0);
    return here_m >= begin_m - settings_.around_mm * 1e-3 && here_m <= end_m + settings_.around_mm * 1e-3;
}

// Keeps the triangles whose three corners are near the lesion in the scene file, in which the vessels are at
// rest and the lesion is closed. All panels of the picture show the same triangles.
SurfaceMesh SurfaceSink::mesh_of(int body, std::span<const Eigen::Vector3i> vertices_um) const
{
    const Body &of = bodies_.bodies[static_cast<std::size_t>(body)];
    SurfaceMesh mesh;
    mesh.name = of.name;
    mesh.kind = of.material == "blood" ? SurfaceKind::wall : SurfaceKind::calcium;
    constexpr std::uint32_t unknown = 0xffffffff, far = 0xfffffffe, near = 0xfffffffd; // otherwise its number
    std::vector<std::uint32_t> number(of.vertices_um.size(), unknown);
    const auto is_kept = [&](std::uint32_t corner) {
        if (number[corner] == unknown)
            number[corner] = is_near(of.vertices_um[corner].cast<double>() * 1e-6) ? near : far;
        return number[corner] != far;
    };
    for (const auto &corners : of.triangles) {
        if (!std::all_of(corners.begin(), corners.end(), is_kept)) continue;
        std::array<std::uint32_t, 3> triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            std::uint32_t &own = number[corners[k]];
            if (own == near) {
                own = static_cast<std::uint32_t>(mesh.vertices_mm.size());
                mesh.vertices_mm.push_back(vertices_um[corners[k]].cast<double>() * 1e-3);
            }
            triangle[k] = own;
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

// Makes the balloon's surface by rotating the balloon's profile about the line through the centres of the
// balls that model the balloon.
SurfaceMesh SurfaceSink::balloon_of(const WireFrame &wire) const
{
    SurfaceMesh mesh;
    mesh.name = "balloon";
    mesh.kind = SurfaceKind::balloon;
    Vector3d across = Vector3d::UnitX();
    const MotionMoment moment{wire.heart_phase32, wire.breath_phase32};
    for (std::size_t j = 0; j < wire.balloon_radii_m.size(); ++j) {
        Vector3d place_m, along;
        const double arc_m = wire.balloon_arc_m + static_cast<double>(j) * wire.balloon_spacing_m;
        if (!place_at(wire, arc_m, place_m, along)) continue;
        if (mesh.vertices_mm.empty() && std::fabs(along.x()) > 0.9) across = Vector3d::UnitY();
        across = (across - across.dot(along) * along).normalized();
        const Vector3d third = along.cross(across);
        for (std::uint32_t k = 0; k < balloon_around; ++k) {
            const double angle = 2 * std::numbers::pi * k / balloon_around;
            const Vector3d there_m =
                place_m + wire.balloon_radii_m[j] * (std::cos(angle) * across + std::sin(angle) * third);
            mesh.vertices_mm.push_back((motion_ ? motion_->pull(there_m, moment) : there_m) * 1e3);
        }
    }
    const auto rings = static_cast<std::uint32_t>(mesh.vertices_mm.size()) / balloon_around;
    if (rings < 2) return {};
    const std::uint32_t last = (rings - 1) * balloon_around;
    for (std::uint32_t k = 0; k < balloon_around; ++k) {
        const std::uint32_t next = (k + 1) % balloon_around;
        for (std::uint32_t a = 0; a < last; a += balloon_around) {
            const std::uint32_t b = a + balloon_around;
            mesh.triangles.push_back({a + k, a + next, b + k});
            mesh.triangles.push_back({a + next, b + next, b + k});
        }
        if (k == 0 || next == 0) continue; // the flat ends
        mesh.triangles.push_back({0, next, k});
        mesh.triangles.push_back({last, last + k, last + next});
    }
    return mesh;
}

void SurfaceSink::frame(const SessionFrame &frame)
{
    if (at_ >= ticks_.size() || frame.wire.tick < ticks_[at_]) return;
    SurfacePanel panel;
    panel.time_s = frame.wire.tick * 1e-3;
    const std::vector<MovingBodies::Moved> &moved = opened_->at({}, frame.wire.lesions_open);
    for (const int body : opened_->bodies()) {
        const auto now = std::find_if(moved.begin(), moved.end(),
                                      [body](const MovingBodies::Moved &one) { return one.body == body; });
        panel.meshes.push_back(
            mesh_of(body, now != moved.end() ? now->vertices_um
                                             : bodies_.bodies[static_cast<std::size_t>(body)].vertices_um));
    }
    SurfaceMesh balloon = balloon_of(frame.wire);
    if (!balloon.triangles.empty()) panel.meshes.push_back(std::move(balloon));
    panels_.push_back(std::move(panel));
    while (at_ < ticks_.size() && ticks_[at_] <= frame.wire.tick) ++at_;
}

// Returns the direction of view from the side of the lesion, with the lesion's beginning at the top and its
// end at the bottom. Seen from the side of the lesion, the plaque and the open lumen lie side by side.
SurfaceView SurfaceSink::side_view() const
{
    const VesselLesion &lesion = bodies_.vessels.lesions[lesion_];
    const std::size_t throat = bodies_.vessels.throat(lesion);
    const Vector3d up = (lesion.healthy_points_m.front() - lesion.healthy_points_m.back()).normalized();
    Vector3d right = bodies_.vessels.branches[lesion.branch].points_m[throat] -
                     lesion.healthy_points_m[throat - lesion.first_point];
    right -= right.dot(up) * up;
    if (!(right.norm() > 20e-6)) right = up.unitOrthogonal(); // it is concentric
    return {right.normalized(), up};
}

void SurfaceSink::finish()
{
    std::string obj = "# Walls round a lesion, mm, patient frame: docs/lesions.md\n";
    std::size_t before = 1; // vertices of an OBJ file are numbered from 1
    for (const SurfacePanel &panel : panels_)
        for (const SurfaceMesh &mesh : panel.meshes) {
            obj += formatted("o t%07.3f_%s\n", panel.time_s, mesh.name.c_str());
            for (const Vector3d &v : mesh.vertices_mm)
                obj += formatted("v %.3f %.3f %.3f\n", v.x(), v.y(), v.z());
            for (const auto &corners : mesh.triangles) {
                obj += "f";
                for (const std::uint32_t corner : corners) obj += " " + std::to_string(before + corner);
                obj += "\n";
            }
            before += mesh.vertices_mm.size();
        }
    write_whole_file(settings_.output, obj);
    std::string error;
    if (!settings_.png.empty() &&
        !write_png(settings_.png, draw_surfaces(panels_, side_view(), panel_pixels), error))
        throw std::runtime_error(error);
}

} // namespace crn
