// The tree consists of bounding boxes around triangles. The triangles of a box are split into two equal
// halves along the longest axis of the box around their centres.
#include "tools/bake/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace crn::bake
{
namespace
{

constexpr std::uint32_t leaf_triangles = 4;

double angle_between(const Eigen::Vector3d &a, const Eigen::Vector3d &b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

} // namespace

TriangleTree::TriangleTree(const Mesh &mesh) : mesh_(mesh)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0u);
    centres_.resize(count);
    face_normals_.resize(count);
    edge_normals_.resize(count);
    corner_normals_.assign(mesh.vertices_mm.size(), Eigen::Vector3d::Zero());
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges; // (low, high) and 3 * triangle + edge
    for (std::uint32_t i = 0; i < count; ++i) {
        const Triangle &t = mesh.triangles[i];
        const Eigen::Vector3d &a = mesh.vertices_mm[t[0]], &b = mesh.vertices_mm[t[1]],
                              &c = mesh.vertices_mm[t[2]];
        centres_[i] = (a + b + c) / 3;
        face_normals_[i] = (b - a).cross(c - a).normalized();
        corner_normals_[t[0]] += face_normals_[i] * angle_between(b - a, c - a);
        corner_normals_[t[1]] += face_normals_[i] * angle_between(c - b, a - b);
        corner_normals_[t[2]] += face_normals_[i] * angle_between(a - c, b - c);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint64_t p = t[k], q = t[(k + 1) % 3];
            edges.emplace_back(std::min(p, q) << 32 | std::max(p, q), 3 * i + k);
        }
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0, end; i < edges.size(); i = end) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (end = i; end < edges.size() && edges[end].first == edges[i].first; ++end)
            sum += face_normals_[edges[end].second / 3];
        for (std::size_t k = i; k < end; ++k) edge_normals_[edges[k].second / 3][edges[k].second % 3] = sum;
    }
    nodes_.reserve(count);
    nodes_.emplace_back();
    build(0, 0, count);
}

void TriangleTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t count)
{
    Eigen::AlignedBox3d box, centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        for (std::uint32_t v : mesh_.triangles[order_[i]]) box.extend(mesh_.vertices_mm[v]);
        centres.extend(centres_[order_[i]]);
    }
    nodes_[node] = {box, first, count};
    if (count <= leaf_triangles) return;
    int axis = 0;
    centres.sizes().maxCoeff(&axis);
    const std::uint32_t half = count / 2;
    std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                     [&](std::uint32_t a, std::uint32_t b) { return centres_[a][axis] < centres_[b][axis]; });
    const auto children = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    nodes_.emplace_back();
    nodes_[node].first = children;
    nodes_[node].count = 0;
    build(children, first, half);
    build(children + 1, first + half, count - half);
}

// Returns the point of a triangle that is closest to a given point. The function distinguishes the regions of
// corners, edges and interior (Ericson, Real-Time Collision Detection, 5.1.5).
TriangleTree::Hit TriangleTree::closest_on(std::uint32_t triangle, const Eigen::Vector3d &p) const
{
    const Triangle &t = mesh_.triangles[triangle];
    const Eigen::Vector3d &a = mesh_.vertices_mm[t[0]], &b = mesh_.vertices_mm[t[1]],
                          &c = mesh_.vertices_mm[t[2]];
    const auto hit = [&](const Eigen::Vector3d &q, int feature) {
        return Hit{(p - q).squaredNorm(), q, triangle, feature};
    };
    const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
                 d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return hit(a, 0);
    if (d3 >= 0 && d4 <= d3) return hit(b, 1);
    if (d6 >= 0 && d5 <= d6) return hit(c, 2);
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return hit(a + ab * (d1 / (d1 - d3)), 3);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return hit(a + ac * (d2 / (d2 - d6)), 5);
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return hit(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), 4);
    const double sum = 1 / (va + vb + vc);
    return hit(a + ab * (vb * sum) + ac * (vc * sum), 6);
}

TriangleTree::Hit TriangleTree::search(const Eigen::Vector3d &p, double limit_square) const
{
    Hit best{limit_square, p, UINT32_MAX, 6};
    std::array<std::pair<std::uint32_t, double>, 128> stack;
    std::size_t depth = 0;
    stack[depth++] = {0, nodes_[0].box.squaredExteriorDistance(p)};
    while (depth > 0) {
        const auto [index, square] = stack[--depth];
        if (square >= best.square) continue;
        const Node &node = nodes_[index];
        if (node.count > 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                const Hit hit = closest_on(order_[i], p);
                if (hit.square < best.square) best = hit;
            }
            continue;
        }
        const double left = nodes_[node.first].box.squaredExteriorDistance(p);
        const double right = nodes_[node.first + 1].box.squaredExteriorDistance(p);
        // The child box nearer to the point is pushed onto the stack last, so that it is visited first.
        stack[depth++] = left < right ? std::pair{node.first + 1, right} : std::pair{node.first, left};
        stack[depth++] = left < right ? std::pair{node.first, left} : std::pair{node.first + 1, right};
    }
    return best;
}

TriangleTree::Nearest TriangleTree::nearest(const Eigen::Vector3d &p_mm, double bound_mm) const
{
    Hit hit = search(p_mm, bound_mm * bound_mm);
    if (hit.triangle == UINT32_MAX) hit = search(p_mm, INFINITY); // no triangle lies within the bound
    const Triangle &t = mesh_.triangles[hit.triangle];
    const Eigen::Vector3d &normal = hit.feature == 6   ? face_normals_[hit.triangle]
                                    : hit.feature >= 3 ? edge_normals_[hit.triangle][hit.feature - 3]
                                                       : corner_normals_[t[hit.feature]];
    const double distance = std::sqrt(hit.square);
    return {normal.dot(p_mm - hit.point) < 0 ? -distance : distance, hit.point, hit.triangle};
}

// Returns +1 if the ray from p along +z leaves the body through the triangle, -1 if it enters, and 0 if it
// misses the triangle. If the ray passes through an edge or corner that several triangles share, only one of
// these triangles counts the crossing. The crossing test uses half-open intervals and treats an edge
// identically in both of its triangles, so that no crossing is missed or counted twice.
int TriangleTree::crossing(std::uint32_t triangle, const Eigen::Vector3d &p) const
{
    const Triangle &t = mesh_.triangles[triangle];
    bool covers = false;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t low = std::min(t[k], t[(k + 1) % 3]), high = std::max(t[k], t[(k + 1) % 3]);
        const Eigen::Vector3d &a = mesh_.vertices_mm[low], &b = mesh_.vertices_mm[high];
        if ((a.y() > p.y()) == (b.y() > p.y())) continue;
        if (p.x() < a.x() + (b.x() - a.x()) * ((p.y() - a.y()) / (b.y() - a.y()))) covers = !covers;
    }
    const Eigen::Vector3d &normal = face_normals_[triangle];
    if (!covers || normal.z() == 0) return 0;
    const double above = normal.dot(mesh_.vertices_mm[t[0]] - p) / normal.z();
    return above <= 0 ? 0 : normal.z() > 0 ? 1 : -1;
}

int TriangleTree::winding(const Eigen::Vector3d &p_mm) const
{
    std::vector<std::uint32_t> triangles;
    near({p_mm, Eigen::Vector3d(p_mm.x(), p_mm.y(), std::max(p_mm.z(), nodes_[0].box.max().z()))}, triangles);
    int sum = 0;
    for (std::uint32_t triangle : triangles) sum += crossing(triangle, p_mm);
    return sum;
}

void TriangleTree::near(const Eigen::AlignedBox3d &box, std::vector<std::uint32_t> &triangles) const
{
    triangles.clear();
    std::array<std::uint32_t, 128> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const Node &node = nodes_[stack[--depth]];
        if (!node.box.intersects(box)) continue;
        if (node.count == 0) {
            stack[depth++] = node.first;
            stack[depth++] = node.first + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            Eigen::AlignedBox3d own;
            for (std::uint32_t v : mesh_.triangles[order_[i]]) own.extend(mesh_.vertices_mm[v]);
            if (own.intersects(box)) triangles.push_back(order_[i]);
        }
    }
}

} // namespace crn::bake
