// Computes planes through the phantom. The lumen's mesh is cut exactly, and the wall's outer outline is the
// curve at a given distance from the lumen.
#include "tools/lab/ct/scanner_parts.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{

constexpr double beside_mm = 1e-5; // keeps planes off the vertices of meshes with round numbers

// Returns the squared distance of p from a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
double distance_square(const Vector3d &p, const std::array<Vector3d, 3> &t)
{
    const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
    const Vector3d bp = p - t[1];
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
    const Vector3d cp = p - t[2];
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1])).squaredNorm();
    const double sum = va + vb + vc;
    return (ap - vb / sum * ab - vc / sum * ac).squaredNorm();
}

Vector2d flat(const Vector3d &p)
{
    return p.head<2>();
}

// Adds a rectangle as four edges, with its inside on their left.
void add_box(const Eigen::AlignedBox3d &box, double value, std::vector<Edge> &edges)
{
    const Vector2d low = flat(box.min()), high = flat(box.max());
    const Vector2d corner[4] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    for (int i = 0; i < 4; ++i) edges.push_back({corner[i], corner[(i + 1) % 4], value});
}

} // namespace

PhantomPlanes::PhantomPlanes(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                             const Eigen::AlignedBox3d &box_lps, const Vector3d &centre)
    : phantom_(phantom), box_(box_lps.min() - centre, box_lps.max() - centre)
{
    Eigen::AlignedBox3d all;
    for (const bake::Triangle &triangle : lumen.triangles) {
        std::array<Vector3d, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) {
            corners[i] = lps_from_scene(lumen.vertices_mm[triangle[i]]) - centre;
            all.extend(corners[i]);
        }
        const auto [low, high] = std::minmax({corners[0].z(), corners[1].z(), corners[2].z()});
        if (high < box_.min().z() - 6 || low > box_.max().z() + 6) continue;
        triangles_.push_back(corners);
    }
    const double margin = phantom.wall_mm + 3;
    const Eigen::AlignedBox3d wide(box_.min() - Vector3d(0, 0, 6), box_.max() + Vector3d(0, 0, 6));
    field_origin_ = (all.min() - Vector3d::Constant(margin)).cwiseMax(wide.min()).array().floor();
    const Vector3d end = (all.max() + Vector3d::Constant(margin)).cwiseMin(wide.max());
    for (std::size_t axis = 0; axis < 3; ++axis)
        field_size_[axis] =
            std::max(2, static_cast<int>(std::ceil(end[static_cast<Eigen::Index>(axis)] -
                                                   field_origin_[static_cast<Eigen::Index>(axis)])) +
                            1);
    at_height_.resize(static_cast<std::size_t>(field_size_[2]));
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
        const auto [low, high] =
            std::minmax({triangles_[i][0].z(), triangles_[i][1].z(), triangles_[i][2].z()});
        const int first = std::max(0, static_cast<int>(std::floor(low - field_origin_.z() - beside_mm))),
                  last = std::min(field_size_[2] - 1,
                                  static_cast<int>(std::floor(high - field_origin_.z() + beside_mm)));
        for (int k = first; k <= last; ++k) at_height_[static_cast<std::size_t>(k)].push_back(i);
    }
    measure_distance();
    mark_inside();
}

// Computes the distance field in the wall and slightly beyond. Each triangle lowers the stored distance at
// every grid point to which it is nearer than all earlier triangles.
void PhantomPlanes::measure_distance()
{
    const double reach = phantom_.wall_mm + 2;
    field_.assign(static_cast<std::size_t>(field_size_[0]) * static_cast<std::size_t>(field_size_[1]) *
                      static_cast<std::size_t>(field_size_[2]),
                  static_cast<float>(reach));
    for (const std::array<Vector3d, 3> &triangle : triangles_) {
        Eigen::AlignedBox3d near;
        for (const Vector3d &corner : triangle) near.extend(corner - field_origin_);
        int low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(0, static_cast<int>(std::ceil(near.min()[axis] - reach)));
            high[axis] = std::min(field_size_[static_cast<std::size_t>(axis)] - 1,
                                  static_cast<int>(std::floor(near.max()[axis] + reach)));
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    const double square = distance_square(field_origin_ + Vector3d(i, j, k), triangle);
                    float &here =
                        field_[static_cast<std::size_t>((k * field_size_[1] + j) * field_size_[0] + i)];
                    if (square < static_cast<double>(here * here))
                        here = static_cast<float>(std::sqrt(square));
                }
    }
}

// Each row of the grid crosses the outline of the cut lumen an even number of times, so the crossings
// separate inner from outer points.
void PhantomPlanes::mark_inside()
{
    std::vector<Edge> edges;
    std::vector<double> crossings;
    for (int k = 0; k < field_size_[2]; ++k) {
        edges.clear();
        cut_lumen(field_origin_.z() + k, 1, edges);
        for (int j = 0; j < field_size_[1]; ++j) {
            const double y = field_origin_.y() + j + beside_mm;
            crossings.clear();
            for (const Edge &edge : edges)
                if ((edge.a.y() > y) != (edge.b.y() > y))
                    crossings.push_back(edge.a.x() + (y - edge.a.y()) / (edge.b.y() - edge.a.y()) *
                                                         (edge.b.x() - edge.a.x()));
            std::sort(crossings.begin(), crossings.end());
            float *row = &field_[static_cast<std::size_t>((k * field_size_[1] + j) * field_size_[0])];
            for (std::size_t c = 0; c + 1 < crossings.size(); c += 2)
                for (int i = std::max(0, static_cast<int>(std::ceil(crossings[c] - field_origin_.x())));
                     i < field_size_[0] && field_origin_.x() + i < crossings[c + 1]; ++i)
                    row[i] = -row[i];
        }
    }
}

void PhantomPlanes::cut_lumen(double height_mm, double value, std::vector<Edge> &edges) const
{
    const double z = height_mm + beside_mm;
    const int slab = static_cast<int>(std::floor(z - field_origin_.z()));
    if (slab < 0 || slab >= field_size_[2]) return;
    for (const std::uint32_t index : at_height_[static_cast<std::size_t>(slab)]) {
        const std::array<Vector3d, 3> &t = triangles_[index];
        Vector2d ends[2];
        int found = 0;
        for (std::size_t i = 0; i < 3 && found < 2; ++i) {
            const Vector3d &p = t[i], &q = t[(i + 1) % 3];
            if ((p.z() > z) == (q.z() > z)) continue;
            ends[found++] = flat(p + (z - p.z()) / (q.z() - p.z()) * (q - p));
        }
        if (found < 2) continue;
        // An edge of the outline runs along z x n, and the lumen lies on the left of the edge.
        const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
        const Vector2d along(-normal.y(), normal.x());
        if (along.dot(ends[1] - ends[0]) < 0) std::swap(ends[0], ends[1]);
        edges.push_back({ends[0], ends[1], value});
    }
}

// Applies the method of marching squares to the distance in a plane; the outline is where the distance equals
// the wall's thickness.
void PhantomPlanes::outline_wall(double height_mm, double value, std::vector<Edge> &edges) const
{
    const double place = height_mm - field_origin_.z();
    const int low = std::clamp(static_cast<int>(std::floor(place)), 0, field_size_[2] - 2);
    const double share = std::clamp(place - low, 0.0, 1.0);
    const auto level = [&](int i, int j) {
        const auto at = [&](int k) {
            return static_cast<double>(
                field_[static_cast<std::size_t>((k * field_size_[1] + j) * field_size_[0] + i)]);
        };
        return phantom_.wall_mm - ((1 - share) * at(low) + share * at(low + 1)); // positive inside
    };
    for (int j = 0; j + 1 < field_size_[1]; ++j)
        for (int i = 0; i + 1 < field_size_[0]; ++i) {
            // The corners of a grid square are counted counter-clockwise. An edge of the outline enters the
            // square where the level falls below 0, and leaves it where the level rises above 0.
            const int di[4] = {0, 1, 1, 0}, dj[4] = {0, 0, 1, 1};
            double v[4];
            int inside = 0;
            for (int c = 0; c < 4; ++c) inside += (v[c] = level(i + di[c], j + dj[c])) > 0;
            if (inside == 0 || inside == 4) continue;
            Vector2d falls[2], rises[2];
            int fall_count = 0, rise_count = 0;
            for (int c = 0; c < 4; ++c) {
                const int d = (c + 1) % 4;
                if ((v[c] > 0) == (v[d] > 0)) continue;
                const double t = v[c] / (v[c] - v[d]);
                const Vector2d p = flat(field_origin_) +
                                   Vector2d(i + di[c] + t * (di[d] - di[c]), j + dj[c] + t * (dj[d] - dj[c]));
                (v[c] > 0 ? falls[fall_count++] : rises[rise_count++]) = p;
            }
            for (int e = 0; e < fall_count; ++e) edges.push_back({falls[e], rises[e], value});
        }
}

void PhantomPlanes::edges_at(double height_mm, std::vector<Edge> &edges) const
{
    edges.clear();
    add_box(box_, 1 + phantom_.gel_HU * 1e-3, edges);
    outline_wall(height_mm, (phantom_.silicone_HU - phantom_.gel_HU) * 1e-3, edges);
    cut_lumen(height_mm, (phantom_.fluid_HU - phantom_.silicone_HU) * 1e-3, edges);
}

Vector2d PhantomPlanes::middle_at(double height_mm) const
{
    std::vector<Edge> edges;
    cut_lumen(height_mm, 1, edges);
    Vector2d sum = Vector2d::Zero();
    double area = 0;
    for (const Edge &edge : edges) {
        const double part = edge.a.x() * edge.b.y() - edge.a.y() * edge.b.x();
        area += part / 2;
        sum += part / 6 * (edge.a + edge.b);
    }
    return area > 1 ? Vector2d(sum / area) : Vector2d::Zero();
}

// The chord of a ray is the sum of -t sign(ds) over all edges that the ray crosses, because it enters through
// edges below and leaves through edges above. Along an edge of the outline, the position t along the ray is a
// linear function of the ray's offset s. The mean of t over a detector bin is therefore t at the middle of
// the part of the bin that the edge covers.
void add_chords(const std::vector<Edge> &edges, const Rays &rays, double weight, std::vector<float> &sums)
{
    const double per_bin = 1 / rays.pitch_mm, half = 0.5 * rays.bins;
    for (const Edge &edge : edges) {
        const double value = weight * edge.value;
        for (int view = 0; view < rays.views; ++view) {
            const double c = rays.cosine[static_cast<std::size_t>(view)],
                         s = rays.sine[static_cast<std::size_t>(view)];
            double s0 = (c * edge.a.x() + s * edge.a.y()) * per_bin + half,
                   s1 = (c * edge.b.x() + s * edge.b.y()) * per_bin + half;
            double t0 = c * edge.a.y() - s * edge.a.x(), t1 = c * edge.b.y() - s * edge.b.x();
            double sign = -value;
            if (s0 > s1) {
                std::swap(s0, s1);
                std::swap(t0, t1);
                sign = value;
            }
            if (s1 - s0 < 1e-12) continue;
            const double slope = (t1 - t0) / (s1 - s0);
            float *row = &sums[static_cast<std::size_t>(view) * static_cast<std::size_t>(rays.bins)];
            const int first = std::max(0, static_cast<int>(s0)),
                      last = std::min(rays.bins - 1, static_cast<int>(s1));
            for (int bin = first; bin <= last; ++bin) {
                const double from = std::max(s0, static_cast<double>(bin)), to = std::min(s1, bin + 1.0);
                row[bin] += static_cast<float>(sign * (to - from) * (t0 + slope * (0.5 * (from + to) - s0)));
            }
        }
    }
}

} // namespace crn::ct
