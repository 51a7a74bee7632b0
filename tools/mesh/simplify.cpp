/* Simplifies a mesh by edge collapse; simplify.hpp states which properties of the mesh are guaranteed. */
#include "tools/mesh/simplify.hpp"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <boost/heap/d_ary_heap.hpp>
#include <cmath>

namespace crn::mesh
{

namespace
{

using Vec3 = Eigen::Vector3d;

/* The sum of the squared distances of a point x to several planes, weighted by area, is x'Ax + 2b'x + c. */
struct Quadric {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Vec3 b = Vec3::Zero();
    double c = 0.0, weight = 0.0;
    void add_plane(const Vec3 &normal, const Vec3 &point, double area)
    {
        const double offset = -normal.dot(point);
        a += area * normal * normal.transpose();
        b += area * offset * normal;
        c += area * offset * offset;
        weight += area;
    }
    void add(const Quadric &other)
    {
        a += other.a;
        b += other.b;
        c += other.c;
        weight += other.weight;
    }
    /* Returns the mean squared distance of a point from the planes, weighted by area. */
    double error(const Vec3 &point) const
    {
        return std::max(0.0, point.dot(a * point) + 2.0 * b.dot(point) + c) / weight;
    }
};

struct Candidate {
    double cost;
    uint32_t keep, drop, keep_version, drop_version;
    bool operator<(const Candidate &other) const
    {
        if (cost != other.cost) return cost > other.cost; // the queue's top is the cheapest
        return keep != other.keep ? keep > other.keep : drop > other.drop;
    }
};

class Simplifier
{
  public:
    Simplifier(std::vector<Vec3> &vertices_mm, std::vector<Triangle> &triangles, double error_mm);
    void run();
    void drop_short_edges(double length_mm);

  private:
    Vec3 best_point(uint32_t keep, uint32_t drop, double &cost) const;
    void offer(uint32_t one, uint32_t other);
    void offer_around(uint32_t vertex);
    bool keeps_a_manifold(uint32_t keep, uint32_t drop);
    bool may_collapse(uint32_t keep, uint32_t drop, const Vec3 &point);
    bool turns_a_triangle(uint32_t moving, uint32_t other, const Vec3 &point) const;
    void neighbours(uint32_t vertex, std::vector<uint32_t> &found) const;
    void collapse(uint32_t keep, uint32_t drop, const Vec3 &point);
    void compact();

    std::vector<Vec3> &vertices_;
    std::vector<Triangle> &triangles_;
    double limit_; // permitted squared error
    std::vector<Quadric> quadrics_;
    std::vector<std::vector<uint32_t>> triangles_of_;
    std::vector<uint32_t> version_;
    std::vector<bool> triangle_alive_;
    // The queue is far larger than the caches, so a heap with eight branches reads less memory than a binary
    // one.
    boost::heap::d_ary_heap<Candidate, boost::heap::arity<8>> queue_;
    std::vector<uint32_t> around_keep_, around_drop_, shared_; // kept between calls to avoid allocations
};

Simplifier::Simplifier(std::vector<Vec3> &vertices_mm, std::vector<Triangle> &triangles, double error_mm)
    : vertices_(vertices_mm), triangles_(triangles), limit_(error_mm * error_mm),
      quadrics_(vertices_mm.size()), triangles_of_(vertices_mm.size()), version_(vertices_mm.size(), 0),
      triangle_alive_(triangles.size(), true)
{
    for (uint32_t t = 0; t < triangles.size(); t++) {
        const auto &corner = triangles[t];
        const Vec3 &origin = vertices_mm[corner[0]];
        const Vec3 normal = (vertices_mm[corner[1]] - origin).cross(vertices_mm[corner[2]] - origin);
        const double area = 0.5 * normal.norm();
        for (uint32_t vertex : corner) {
            triangles_of_[vertex].push_back(t);
            if (area > 1e-9) quadrics_[vertex].add_plane(normal.normalized(), origin, area);
        }
    }
}

/* Returns the point with the least mean squared distance to the planes, or the middle of the edge if the
 * planes do not determine such a point. A small weight on the distance from the edge's middle makes the best
 * point unique where the surface is flat. */
Vec3 Simplifier::best_point(uint32_t keep, uint32_t drop, double &cost) const
{
    Quadric sum = quadrics_[keep];
    sum.add(quadrics_[drop]);
    const Vec3 middle = 0.5 * (vertices_[keep] + vertices_[drop]);
    const double pull = 1e-3 * sum.weight + 1e-12;
    const Eigen::Matrix3d system = sum.a + pull * Eigen::Matrix3d::Identity();
    const Vec3 right = pull * middle - sum.b;
    const Vec3 point = system.inverse() * right;
    cost = sum.weight > 0.0 ? sum.error(point) : 0.0;
    const double span = (vertices_[keep] - vertices_[drop]).norm();
    if ((point - middle).norm() <= span) return point;
    cost = sum.weight > 0.0 ? sum.error(middle) : 0.0;
    return middle;
}

void Simplifier::offer(uint32_t one, uint32_t other)
{
    const uint32_t keep = std::min(one, other), drop = std::max(one, other);
    double cost = 0.0;
    best_point(keep, drop, cost);
    // A small additional cost for the edge's length, far below the error limit, avoids long thin triangles.
    const double length = (vertices_[keep] - vertices_[drop]).squaredNorm();
    if (cost < limit_) queue_.push({cost + 1e-5 * length, keep, drop, version_[keep], version_[drop]});
}

void Simplifier::neighbours(uint32_t vertex, std::vector<uint32_t> &found) const
{
    // The surface is closed, and its triangles turn the same way: each neighbour follows the vertex in one
    // triangle.
    found.clear();
    for (uint32_t t : triangles_of_[vertex]) {
        const Triangle &corner = triangles_[t];
        found.push_back(corner[0] == vertex ? corner[1] : corner[1] == vertex ? corner[2] : corner[0]);
    }
}

void Simplifier::offer_around(uint32_t vertex)
{
    neighbours(vertex, around_keep_);
    for (uint32_t other : around_keep_) offer(vertex, other);
}

bool Simplifier::turns_a_triangle(uint32_t moving, uint32_t other, const Vec3 &point) const
{
    constexpr double COSINE_LEAST = 0.25, SLENDERNESS_LEAST = 0.08;
    for (uint32_t t : triangles_of_[moving]) {
        auto corner = triangles_[t];
        if (std::find(corner.begin(), corner.end(), other) != corner.end()) continue;
        while (corner[0] != moving) std::rotate(corner.begin(), corner.begin() + 1, corner.end());
        const Vec3 &b = vertices_[corner[1]], &c = vertices_[corner[2]];
        const Vec3 before = (b - vertices_[moving]).cross(c - vertices_[moving]);
        const Vec3 after = (b - point).cross(c - point);
        if (after.dot(before) < COSINE_LEAST * after.norm() * before.norm()) return true;
        const double longest =
            std::max({(b - point).squaredNorm(), (c - point).squaredNorm(), (b - c).squaredNorm()});
        if (after.norm() < SLENDERNESS_LEAST * longest) return true;
    }
    return false;
}

/* Checks the link condition for an edge of a closed surface: the two ends of the edge must share exactly two
 * neighbouring vertices. After the check of the link condition, around_keep_ and around_drop_ hold the
 * neighbours of the edge's two ends. */
bool Simplifier::keeps_a_manifold(uint32_t keep, uint32_t drop)
{
    neighbours(keep, around_keep_);
    neighbours(drop, around_drop_);
    shared_.clear();
    for (uint32_t vertex : around_keep_)
        if (std::find(around_drop_.begin(), around_drop_.end(), vertex) != around_drop_.end())
            shared_.push_back(vertex);
    if (shared_.size() != 2) return false;
    for (uint32_t vertex : shared_)
        if (triangles_of_[vertex].size() <= 3) return false;
    return true;
}

bool Simplifier::may_collapse(uint32_t keep, uint32_t drop, const Vec3 &point)
{
    constexpr size_t VALENCE_MOST = 14;
    return keeps_a_manifold(keep, drop) && around_keep_.size() + around_drop_.size() - 4 <= VALENCE_MOST &&
           !turns_a_triangle(keep, drop, point) && !turns_a_triangle(drop, keep, point);
}

void Simplifier::collapse(uint32_t keep, uint32_t drop, const Vec3 &point)
{
    vertices_[keep] = point;
    quadrics_[keep].add(quadrics_[drop]);
    for (uint32_t t : triangles_of_[drop]) {
        auto &corner = triangles_[t];
        const bool dies = std::find(corner.begin(), corner.end(), keep) != corner.end();
        if (!dies) {
            std::replace(corner.begin(), corner.end(), drop, keep);
            triangles_of_[keep].push_back(t);
            continue;
        }
        triangle_alive_[t] = false;
        for (uint32_t vertex : corner)
            if (vertex != drop) std::erase(triangles_of_[vertex], t);
    }
    triangles_of_[drop].clear();
    version_[keep]++;
    version_[drop]++;
}

void Simplifier::run()
{
    for (const auto &corner : triangles_)
        for (int i = 0; i < 3; i++)
            if (corner[i] < corner[(i + 1) % 3]) offer(corner[i], corner[(i + 1) % 3]);
    while (!queue_.empty()) {
        const Candidate next = queue_.top();
        queue_.pop();
        if (version_[next.keep] != next.keep_version || version_[next.drop] != next.drop_version) continue;
        double cost = 0.0;
        const Vec3 point = best_point(next.keep, next.drop, cost);
        if (!may_collapse(next.keep, next.drop, point)) continue;
        collapse(next.keep, next.drop, point);
        offer_around(next.keep);
    }
    compact();
}

void Simplifier::drop_short_edges(double length_mm)
{
    bool is_collapsed = false;
    for (bool is_changed = true; is_changed;) {
        is_changed = false;
        for (uint32_t t = 0; t < triangles_.size(); t++)
            for (int i = 0; i < 3 && triangle_alive_[t]; i++) {
                const uint32_t one = triangles_[t][i], other = triangles_[t][(i + 1) % 3];
                if ((vertices_[one] - vertices_[other]).norm() >= length_mm) continue;
                const uint32_t keep = std::min(one, other), drop = std::max(one, other);
                if (!keeps_a_manifold(keep, drop)) continue;
                collapse(keep, drop, vertices_[keep]);
                is_changed = is_collapsed = true;
            }
    }
    if (is_collapsed) compact();
}

void Simplifier::compact()
{
    std::vector<uint32_t> renamed(vertices_.size(), UINT32_MAX);
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (size_t t = 0; t < triangles_.size(); t++) {
        if (!triangle_alive_[t]) continue;
        Triangle corner = triangles_[t];
        for (uint32_t &vertex : corner) {
            if (renamed[vertex] == UINT32_MAX) {
                renamed[vertex] = static_cast<uint32_t>(vertices.size());
                vertices.push_back(vertices_[vertex]);
            }
            vertex = renamed[vertex];
        }
        triangles.push_back(corner);
    }
    vertices_ = std::move(vertices);
    triangles_ = std::move(triangles);
}

} // namespace

void simplify(std::vector<Vec3> &vertices_mm, std::vector<Triangle> &triangles, double error_mm)
{
    Simplifier(vertices_mm, triangles, error_mm).run();
}

void drop_short_edges(std::vector<Vec3> &vertices_mm, std::vector<Triangle> &triangles, double length_mm)
{
    Simplifier(vertices_mm, triangles, 0.0).drop_short_edges(length_mm);
}

} // namespace crn::mesh
