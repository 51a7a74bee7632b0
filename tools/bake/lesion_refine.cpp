// Divides the triangles of the mesh where a lesion will move the wall.
#include "tools/bake/lesion.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace crn::bake
{
namespace
{

using Eigen::Vector3d;
using Edge = std::pair<std::uint32_t, std::uint32_t>; // lower corner first

constexpr double edge_min_mm = 0.25;
constexpr int rounds_max = 12; // each round halves the marked edges

double distance_mm(const Vector3d &a_mm, const Vector3d &b_mm, const Vector3d &place_mm) // from an edge
{
    const Vector3d step = b_mm - a_mm;
    const double share = std::clamp((place_mm - a_mm).dot(step) / step.squaredNorm(), 0.0, 1.0);
    return (place_mm - a_mm - share * step).norm();
}

class Divider
{
  public:
    Divider(Mesh &mesh, const VesselTree &tree) : mesh_(mesh)
    {
        for (const VesselLesion &lesion : tree.lesions) {
            const double throat_mm = tree.branches[lesion.branch].radii_m[tree.throat(lesion)] * 1e3;
            const double wanted_mm = std::min(lesion.length_m() * 1e3 / 20, 0.6 * throat_mm);
            places_.push_back({lesion, std::max(wanted_mm, edge_min_mm)});
            box_.extend(lesion_box_mm(lesion, lesion_near_radii));
        }
    }

    // Returns true if at least one edge was divided.
    bool round()
    {
        middles_.clear();
        for (const Triangle &t : mesh_.triangles)
            for (std::size_t k = 0; k < 3; ++k) mark(t[k], t[(k + 1) % 3]);
        if (middles_.empty()) return false;
        std::vector<Triangle> triangles;
        for (const Triangle &t : mesh_.triangles) divide(t, triangles);
        mesh_.triangles = std::move(triangles);
        return true;
    }

  private:
    static Edge edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

    // Returns the permitted length of an edge from a to b; it is infinite when no part of the edge is near a
    // lesion.
    double edge_max_mm(const Vector3d &a_mm, const Vector3d &b_mm) const
    {
        double most = std::numeric_limits<double>::infinity();
        for (const auto &[lesion, edge_mm] : places_)
            for (std::size_t i = 0; i < lesion.size(); ++i)
                if (distance_mm(a_mm, b_mm, lesion.healthy_points_m[i] * 1e3) <
                    lesion_near_radii * lesion.healthy_radii_m[i] * 1e3) {
                    most = std::min(most, edge_mm);
                    break;
                }
        return most;
    }

    void mark(std::uint32_t a, std::uint32_t b)
    {
        const Vector3d a_mm = mesh_.vertices_mm[a], b_mm = mesh_.vertices_mm[b];
        const double length_mm = (a_mm - b_mm).norm();
        if (length_mm <= edge_min_mm || middles_.count(edge(a, b))) return;
        Eigen::AlignedBox3d around(a_mm);
        if (!box_.intersects(around.extend(b_mm)) || length_mm <= edge_max_mm(a_mm, b_mm)) return;
        middles_[edge(a, b)] = static_cast<std::uint32_t>(mesh_.vertices_mm.size());
        mesh_.vertices_mm.push_back(0.5 * (a_mm + b_mm));
    }

    // Replaces a triangle by one to four triangles, depending on how many of its edges are divided.
    // Neighbouring triangles use the same midpoint of their common edge, so the surface stays closed.
    void divide(const Triangle &t, std::vector<Triangle> &out) const
    {
        std::array<std::int64_t, 3> middle; // of the edge that follows each corner; -1: not divided
        std::size_t count = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = middles_.find(edge(t[k], t[(k + 1) % 3]));
            middle[k] = found == middles_.end() ? -1 : static_cast<std::int64_t>(found->second);
            count += middle[k] >= 0;
        }
        if (count == 0) return out.push_back(t);
        // We number the triangle's corners so that its first edge is divided. If exactly two edges of the
        // triangle are divided, its last edge is the undivided one.
        std::size_t turn = 0;
        while (middle[turn] < 0 || (count == 2 && middle[(turn + 2) % 3] >= 0)) ++turn;
        const std::uint32_t a = t[turn], b = t[(turn + 1) % 3], c = t[(turn + 2) % 3];
        const auto ab = static_cast<std::uint32_t>(middle[turn]);
        if (count == 1) {
            out.push_back({a, ab, c});
            return out.push_back({ab, b, c});
        }
        const auto bc = static_cast<std::uint32_t>(middle[(turn + 1) % 3]);
        out.push_back({ab, b, bc});
        if (count == 2) {
            out.push_back({a, ab, bc});
            return out.push_back({a, bc, c});
        }
        const auto ca = static_cast<std::uint32_t>(middle[(turn + 2) % 3]);
        out.push_back({a, ab, ca});
        out.push_back({ab, bc, ca});
        out.push_back({ca, bc, c});
    }

    struct Place {
        const VesselLesion &lesion;
        double edge_mm; // the longest edge permitted there
    };

    Mesh &mesh_;
    std::vector<Place> places_;
    Eigen::AlignedBox3d box_;
    std::map<Edge, std::uint32_t> middles_;
};

} // namespace

void refine_lesions(Mesh &mesh, const VesselTree &tree)
{
    if (tree.lesions.empty()) return;
    Divider divider(mesh, tree);
    for (int round = 0; round < rounds_max && divider.round(); ++round) {
    }
}

} // namespace crn::bake
