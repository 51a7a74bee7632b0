// Finds pairs of triangles in a mesh that cross: an edge of one triangle passes through the other triangle.
#include "tools/bake/fault.hpp"
#include "tools/bake/triangle_tree.hpp"

#include <algorithm>

namespace crn::bake
{
namespace
{

// Returns whether segment p-q passes through the interior of triangle a-b-c. Segments that only touch the
// triangle or lie in its plane do not count.
bool passes(const Eigen::Vector3d &p, const Eigen::Vector3d &q, const Eigen::Vector3d &a,
            const Eigen::Vector3d &b, const Eigen::Vector3d &c)
{
    const auto volume = [](const Eigen::Vector3d &o, const Eigen::Vector3d &x, const Eigen::Vector3d &y,
                           const Eigen::Vector3d &z) { return (x - o).dot((y - o).cross(z - o)); };
    const double above = volume(a, b, c, p), below = volume(a, b, c, q);
    const double tiny = 1e-9 * (b - a).cross(c - a).norm(); /* 1 pm above the plane */
    if (!((above > tiny && below < -tiny) || (above < -tiny && below > tiny))) return false;
    const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

bool cross(const Mesh &mesh, const Triangle &s, const Triangle &t)
{
    const auto corner = [&](const Triangle &x, int k) -> const Eigen::Vector3d & {
        return mesh.vertices_mm[x[k % 3]];
    };
    for (int k = 0; k < 3; ++k) {
        if (passes(corner(s, k), corner(s, k + 1), corner(t, 0), corner(t, 1), corner(t, 2))) return true;
        if (passes(corner(t, k), corner(t, k + 1), corner(s, 0), corner(s, 1), corner(s, 2))) return true;
    }
    return false;
}

bool share(const Triangle &s, const Triangle &t)
{
    return std::any_of(s.begin(), s.end(),
                       [&](std::uint32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); });
}

} // namespace

void check_crossing(const Mesh &mesh, Progress &progress)
{
    const TriangleTree tree(mesh);
    progress.stage("looking for crossing triangles in " + mesh.name, mesh.triangles.size());
    std::vector<std::uint32_t> near;
    std::size_t count = 0;
    std::uint32_t first = 0, second = 0;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (i % 1024 == 0) progress.step(i);
        Eigen::AlignedBox3d box;
        for (std::uint32_t v : mesh.triangles[i]) box.extend(mesh.vertices_mm[v]);
        tree.near(box, near);
        for (std::uint32_t j : near) {
            if (j <= i || share(mesh.triangles[i], mesh.triangles[j]) ||
                !cross(mesh, mesh.triangles[i], mesh.triangles[j]))
                continue;
            if (count++ == 0) {
                first = i;
                second = j;
            }
        }
    }
    progress.finish();
    if (count > 0)
        throw Fault(mesh.name + ": " + std::to_string(count) + " pairs of triangles cross, the first are " +
                    std::to_string(first) + " and " + std::to_string(second) + " at " +
                    place_text(mesh.vertices_mm[mesh.triangles[first][0]]) +
                    ": join the parts into one surface (\"boolean union\" or \"remesh\" in a mesh editor)");
}

} // namespace crn::bake
