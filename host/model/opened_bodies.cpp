#include "host/model/opened_bodies.hpp"
#include "host/model/lesion_wall.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{
namespace
{

using Eigen::Vector3d;

Vector3d vertex_m(const Body &body, std::uint32_t index)
{
    return body.vertices_um[index].cast<double>() * 1e-6;
}

// Returns true if a point is inside a closed surface. The function sums the solid angle of the surface as
// seen from the point, as a fraction of the sphere: 1 means inside, 0 outside (Van Oosterom and Strackee
// 1983).
bool is_inside(const Body &body, const Vector3d &place_m)
{
    double sum = 0.0;
    for (const std::array<std::uint32_t, 3> &corners : body.triangles) {
        const Vector3d a = vertex_m(body, corners[0]) - place_m, b = vertex_m(body, corners[1]) - place_m,
                       c = vertex_m(body, corners[2]) - place_m;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return std::fabs(sum) > std::numbers::pi; // half of the sum over the whole sphere
}

// Returns true if part of the lesion's healthy centreline lies in the body (closed mesh); `bake` has narrowed
// each such body of blood.
bool runs_through(const Body &body, const VesselLesion &lesion)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3i &vertex_um : body.vertices_um) box.extend(vertex_um.cast<double>() * 1e-6);
    return std::any_of(
        lesion.healthy_points_m.begin(), lesion.healthy_points_m.end(),
        [&](const Vector3d &point_m) { return box.contains(point_m) && is_inside(body, point_m); });
}

} // namespace

OpenedBodies::OpenedBodies(const Bodies &bodies, const LesionOpening &opening, const Motion *motion)
    : opening_(opening)
{
    std::vector<LesionWall> walls;
    for (std::size_t k = 0; k < opening.lesion_count(); ++k) walls.emplace_back(bodies.vessels, k);
    for (std::size_t index = 0; index < bodies.bodies.size() && !walls.empty(); ++index) {
        const Body &body = bodies.bodies[index];
        Opened opened;
        opened.body = static_cast<int>(index);
        for (std::size_t k = 0; k < walls.size(); ++k) {
            const VesselLesion &lesion = bodies.vessels.lesions[k];
            const std::size_t before = opened.vertices.size();
            if (body.name == lesion.name + "_calcium")
                find_calcium(body, k, walls[k], opened);
            else if (body.material == "blood" && runs_through(body, lesion))
                find_wall(body, k, walls[k], opened);
            if (opened.vertices.size() > before) opened.lesions.push_back(k);
        }
        if (opened.vertices.empty()) continue;
        opened.narrow_um = opened.vertices_um = body.vertices_um;
        if (motion && body.moves) {
            std::vector<Vector3d> healthy_m;
            for (const Vertex &vertex : opened.vertices) healthy_m.push_back(vertex.healthy_m);
            opened.healthy.emplace(*motion, std::move(healthy_m));
        }
        opened_.push_back(std::move(opened));
    }
}

void OpenedBodies::find_wall(const Body &body, std::size_t lesion, const LesionWall &wall,
                             Opened &opened) const
{
    for (std::uint32_t i = 0; i < body.vertices_um.size(); ++i) {
        LesionWall::Healthy healthy;
        if (!wall.healthy_of(vertex_m(body, i), healthy)) continue;
        opened.vertices.push_back({i, opening_.place(lesion, healthy.arc_m), healthy.place_m});
    }
}

// Plaque keeps its volume. When a lumen widens from radius r to R, material at the distance d from the
// lumen's middle moves to sqrt(d^2 + R^2 - r^2), so that a ring of material keeps its area.
void OpenedBodies::find_calcium(const Body &body, std::size_t lesion, const LesionWall &wall,
                                Opened &opened) const
{
    for (std::uint32_t i = 0; i < body.vertices_um.size(); ++i) {
        const LesionFoot foot = wall.foot(vertex_m(body, i));
        const double healthy_m = foot.healthy_radius_m, narrow_m = foot.left * healthy_m;
        const Vector3d from_m = vertex_m(body, i) - foot.channel_m;
        const double squared = std::max(from_m.squaredNorm(), narrow_m * narrow_m);
        const double farther = std::sqrt(1 + (healthy_m * healthy_m - narrow_m * narrow_m) / squared);
        opened.vertices.push_back({i, opening_.place(lesion, foot.arc_m), foot.healthy_m + farther * from_m});
    }
}

std::size_t OpenedBodies::vertex_count() const
{
    std::size_t count = 0;
    for (const Opened &opened : opened_) count += opened.vertices.size();
    return count;
}

std::vector<int> OpenedBodies::bodies() const
{
    std::vector<int> bodies;
    for (const Opened &opened : opened_) bodies.push_back(opened.body);
    return bodies;
}

// Each vertex moves on a straight line from its narrowed to its healthy position, in every pose of the heart.
// Where two lesions meet, the displacements of the vertices are added.
void OpenedBodies::place(Opened &opened, std::span<const Eigen::Vector3i> narrow_um,
                         const MotionWeights &weights, std::span<const double> open)
{
    for (const Vertex &vertex : opened.vertices) opened.vertices_um[vertex.index] = narrow_um[vertex.index];
    for (std::size_t i = 0; i < opened.vertices.size(); ++i) {
        const Vertex &vertex = opened.vertices[i];
        const double share = LesionOpening::at(vertex.place, open);
        const Vector3d healthy_um =
            (opened.healthy ? opened.healthy->at(i, weights) : vertex.healthy_m) * 1e6;
        const Vector3d from_um = narrow_um[vertex.index].cast<double>();
        opened.vertices_um[vertex.index] +=
            (share * (healthy_um - from_um)).array().round().matrix().cast<int>();
    }
}

const std::vector<MovingBodies::Moved> &OpenedBodies::at(const MotionMoment &moment,
                                                         std::span<const double> open,
                                                         std::span<const MovingBodies::Moved> moved)
{
    at_.assign(moved.begin(), moved.end());
    for (Opened &opened : opened_) {
        const bool is_open = std::any_of(opened.lesions.begin(), opened.lesions.end(),
                                         [&](std::size_t k) { return opening_.is_open(k, open); });
        if (!is_open) continue;
        const auto beats = std::find_if(at_.begin(), at_.end(), [&](const MovingBodies::Moved &body) {
            return body.body == opened.body;
        });
        if (beats == at_.end()) {
            place(opened, opened.narrow_um, motion_weights(moment), open);
            at_.push_back({opened.body, opened.vertices_um});
            continue;
        }
        opened.vertices_um.assign(beats->vertices_um.begin(), beats->vertices_um.end());
        place(opened, beats->vertices_um, motion_weights(moment), open);
        beats->vertices_um = opened.vertices_um;
    }
    return at_;
}

} // namespace crn
