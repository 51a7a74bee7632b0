// Measures how accurate the field of a baked lumen is (see measure.hpp).
#include "tools/bake/measure.hpp"
#include "tools/bake/fault.hpp"

#include <ccd/ccd.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace crn::bake
{
namespace
{

using Random = std::mt19937_64;

// Returns evenly distributed random numbers that are equal on every machine, unlike the numbers of
// std::uniform_real_distribution.
double uniform(Random &random, double from, double to)
{
    return from + (to - from) * std::ldexp(static_cast<double>(random() >> 11), -53);
}

Eigen::Vector3d in_ball(Random &random, double radius)
{
    for (;;) {
        const Eigen::Vector3d p(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
        if (p.squaredNorm() <= 1 && p.squaredNorm() > 1e-12) return p * radius;
    }
}

// Selects random points of the surface, evenly distributed by area.
class SurfacePoints
{
  public:
    explicit SurfacePoints(const Mesh &mesh) : mesh_(mesh)
    {
        double sum = 0;
        for (const Triangle &t : mesh.triangles) {
            const Eigen::Vector3d a = mesh.vertices_mm[t[1]] - mesh.vertices_mm[t[0]];
            sum += a.cross(mesh.vertices_mm[t[2]] - mesh.vertices_mm[t[0]]).norm();
            area_until_.push_back(sum);
        }
    }
    Eigen::Vector3d draw(Random &random, std::uint32_t &triangle) const
    {
        const double at = uniform(random, 0, area_until_.back());
        const auto found = std::lower_bound(area_until_.begin(), area_until_.end(), at);
        triangle = static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(
            found - area_until_.begin(), static_cast<std::ptrdiff_t>(area_until_.size()) - 1));
        double u = uniform(random, 0, 1), v = uniform(random, 0, 1);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Triangle &t = mesh_.triangles[triangle];
        const Eigen::Vector3d &a = mesh_.vertices_mm[t[0]];
        return a + u * (mesh_.vertices_mm[t[1]] - a) + v * (mesh_.vertices_mm[t[2]] - a);
    }

  private:
    const Mesh &mesh_;
    std::vector<double> area_until_;
};

// --- libccd: the capsule and a triangle as support functions, in mm relative to the capsule's centre ---
struct CcdCapsule {
    Eigen::Vector3d half_axis;
    double radius;
};
struct CcdTriangle {
    Eigen::Vector3d corners[3];
};

Eigen::Vector3d from_ccd(const ccd_vec3_t *v)
{
    return {v->v[0], v->v[1], v->v[2]};
}

void capsule_support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const auto *capsule = static_cast<const CcdCapsule *>(object);
    const Eigen::Vector3d d = from_ccd(direction);
    const double length = d.norm();
    Eigen::Vector3d p =
        d.dot(capsule->half_axis) >= 0 ? capsule->half_axis : Eigen::Vector3d(-capsule->half_axis);
    if (length > 0) p += d * (capsule->radius / length);
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

void triangle_support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const auto *triangle = static_cast<const CcdTriangle *>(object);
    const Eigen::Vector3d d = from_ccd(direction);
    int best = 0;
    for (int k = 1; k < 3; ++k)
        if (d.dot(triangle->corners[k]) > d.dot(triangle->corners[best])) best = k;
    const Eigen::Vector3d &p = triangle->corners[best];
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

void capsule_centre(const void *, ccd_vec3_t *out)
{
    ccdVec3Set(out, 0, 0, 0);
}

void triangle_centre(const void *object, ccd_vec3_t *out)
{
    const auto *triangle = static_cast<const CcdTriangle *>(object);
    const Eigen::Vector3d p = (triangle->corners[0] + triangle->corners[1] + triangle->corners[2]) / 3;
    ccdVec3Set(out, p.x(), p.y(), p.z());
}

// Returns how deep the capsule penetrates one triangle, or 0 if the capsule does not touch the triangle.
double ccd_depth(const CcdCapsule &capsule, const CcdTriangle &triangle)
{
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = capsule_support;
    ccd.support2 = triangle_support;
    ccd.center1 = capsule_centre;
    ccd.center2 = triangle_centre;
    ccd.max_iterations = 200;
    ccd.epa_tolerance = 1e-4;
    ccd.mpr_tolerance = 1e-5;
    ccd_real_t depth = 0;
    ccd_vec3_t direction, position;
    return ccdGJKPenetration(&capsule, &triangle, &ccd, &depth, &direction, &position) == 0 ? depth : 0;
}

struct Pose {
    Eigen::Vector3d centre, half_axis;
};

double referee_depth(const TriangleTree &tree, const Pose &pose, double radius)
{
    std::vector<std::uint32_t> near;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(radius);
    tree.near(
        {pose.centre - pose.half_axis.cwiseAbs() - margin, pose.centre + pose.half_axis.cwiseAbs() + margin},
        near);
    double deepest = 0;
    for (std::uint32_t i : near) {
        CcdTriangle triangle;
        for (int k = 0; k < 3; ++k)
            triangle.corners[k] = tree.mesh().vertices_mm[tree.mesh().triangles[i][k]] - pose.centre;
        deepest = std::max(deepest, ccd_depth({pose.half_axis, radius}, triangle));
    }
    return deepest;
}

// The core tests points and not whole capsules, so we test 33 points along the capsule's axis.
double core_depth(const crn_lumen *lumen, const Pose &pose, double radius)
{
    double deepest = -INFINITY;
    for (int i = -16; i <= 16; ++i)
        deepest = std::max(deepest, contact_mm(lumen, pose.centre + pose.half_axis * (i / 16.0)) + radius);
    return deepest;
}

// Selects a random capsule near a random point of the wall. The capsule's axis must lie in the lumen, and the
// capsule's radius must reach the wall. Returns false when the axis of the random capsule leaves the lumen or
// its surface does not reach the wall.
bool draw_pose(const TriangleTree &tree, const SurfacePoints &surface, double radius, double length,
               Random &random, Pose &pose)
{
    std::uint32_t triangle = 0;
    const Eigen::Vector3d wall = surface.draw(random, triangle);
    pose.centre = wall + in_ball(random, radius);
    pose.half_axis = in_ball(random, 1).normalized() * (length / 2);
    constexpr double clearance = 0.05; // the axis must not cross a triangle, or depth would have two meanings
    for (int i = -4; i <= 4; ++i)
        if (tree.nearest(pose.centre + pose.half_axis * (i / 4.0)).distance_mm > -clearance) return false;
    return true;
}

// Returns the radius of the largest ball that touches the wall at p from inside and has no wall inside it.
// The ball's centre lies on the inward normal at p. The radius of the ball is reduced step by step (shrinking
// balls: Ma, Bae & Choi 2012). Returns `limit` if the ball touches the wall at p only, or if no wall is near
// the ball's point opposite to p.
double ball_radius(const TriangleTree &tree, const Eigen::Vector3d &p, const Eigen::Vector3d &inward,
                   double limit)
{
    constexpr double facet_slack = 0.03; // flat triangles reach into a ball that fits the curved wall
    double radius = limit;
    for (int round = 0; round < 30; ++round) {
        const auto hit = tree.nearest(p + inward * radius);
        const Eigen::Vector3d to = hit.point_mm - p;
        if (std::abs(hit.distance_mm) > radius * (1 - facet_slack) || to.dot(inward) <= 1e-9) break;
        radius = to.squaredNorm() / (2 * to.dot(inward));
    }
    if (radius >= limit) return limit;
    // A ball in a dent of the surface touches the wall only near p. We recognise a dent by the fact that no
    // wall is near the point of the ball opposite to p.
    return std::abs(tree.nearest(p + inward * (2 * radius)).distance_mm) > 0.3 * radius ? limit : radius;
}

} // namespace

double contact_mm(const crn_lumen *lumen, const Eigen::Vector3d &p)
{
    const crn_vec3 q = to_q30(p);
    return crn_lumen_contact(lumen, &q).distance_m_q30 * mm_per_q30;
}

FieldError measure_field(const crn_lumen *lumen, const TriangleTree &tree, std::size_t points,
                         std::uint64_t seed, Progress &progress)
{
    Random random(seed);
    const SurfacePoints surface(tree.mesh());
    FieldError error;
    std::vector<double> errors;
    progress.stage("field error", points);
    while (errors.size() < points) {
        if (errors.size() % 4096 == 0) progress.step(errors.size());
        std::uint32_t triangle = 0;
        const Eigen::Vector3d wall = surface.draw(random, triangle);
        const Eigen::Vector3d p = wall + in_ball(random, error_band_mm);
        const double exact = tree.nearest(p).distance_mm;
        const crn_vec3 q = to_q30(p);
        const double core = crn_lumen_contact(lumen, &q).distance_m_q30 * mm_per_q30;
        errors.push_back(std::abs(core - exact));
        error.largest.take(errors.back(), p);
    }
    progress.finish();
    std::sort(errors.begin(), errors.end());
    error.points = errors.size();
    error.median_mm = errors[errors.size() / 2];
    error.percent99_mm = errors[errors.size() * 99 / 100];
    error.permille999_mm = errors[errors.size() * 999 / 1000];
    return error;
}

Referee measure_contact(const crn_lumen *lumen, const TriangleTree &tree, std::size_t poses,
                        std::uint64_t seed, Progress &progress)
{
    constexpr std::size_t draws_max =
        400; // attempts per pose: a lumen narrower than the capsule gives no pose
    constexpr std::size_t chunk = 512;
    Random random(seed);
    const SurfacePoints surface(tree.mesh());
    Referee referee;
    referee.radius_mm = 0.835; // that of a 5 F catheter
    referee.length_mm = 2;
    std::vector<Pose> drawn;
    for (std::size_t draws = 0; drawn.size() < poses && draws < poses * draws_max; ++draws) {
        Pose pose;
        if (draw_pose(tree, surface, referee.radius_mm, referee.length_mm, random, pose))
            drawn.push_back(pose);
    }
    referee.poses = drawn.size();
    progress.stage("libccd referee", poses);
    std::vector<double> core(drawn.size()), judged(drawn.size());
    for (std::size_t first = 0; first < drawn.size(); first += chunk) {
        progress.step(first);
        tbb::parallel_for(first, std::min(first + chunk, drawn.size()), [&](std::size_t i) {
            core[i] = std::max(0.0, core_depth(lumen, drawn[i], referee.radius_mm));
            judged[i] = referee_depth(tree, drawn[i], referee.radius_mm);
        });
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        referee.touching += judged[i] > 0;
        referee.disagreement.take(std::abs(core[i] - judged[i]), drawn[i].centre);
    }
    progress.finish();
    return referee;
}

Worst smallest_radius(const TriangleTree &tree, std::size_t points)
{
    const Mesh &mesh = tree.mesh();
    const std::size_t stride = std::max<std::size_t>(1, mesh.triangles.size() / points);
    Worst smallest;
    smallest.mm = 60;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += stride) {
        const Triangle &t = mesh.triangles[i];
        const Eigen::Vector3d &a = mesh.vertices_mm[t[0]], &b = mesh.vertices_mm[t[1]],
                              &c = mesh.vertices_mm[t[2]];
        const Eigen::Vector3d p = (a + b + c) / 3, inward = -(b - a).cross(c - a).normalized();
        const double radius = ball_radius(tree, p, inward, smallest.mm);
        if (radius < smallest.mm) {
            smallest.mm = radius;
            smallest.place_mm = p + inward * radius;
        }
    }
    return smallest;
}

} // namespace crn::bake
