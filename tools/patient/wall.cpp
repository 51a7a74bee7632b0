#include "tools/patient/wall.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/mesh/median.hpp"
#include "tools/mesh/pieces.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace crn::patient
{
namespace
{

using Eigen::Vector3d;

constexpr double wall_share_min = 0.25; // of the area; both sheets of a wall have about half each
constexpr double near_share_max = 0.3;  // a wall is thinner than this share of its lumen ...
constexpr double wall_mm_max = 6.0;     // ... and than this
constexpr double look_mm = 80.0;        // wider than any vessel
constexpr std::size_t sample_max = 4000;

struct Sight {
    double near_mm = INFINITY, far_mm = INFINITY;
    std::uint32_t near_triangle = UINT32_MAX;
};

// Goes along a line in steps that no triangle can be within, until one is met. Returns its distance, or
// infinity.
std::pair<double, std::uint32_t> meets(const bake::TriangleTree &tree, const Vector3d &from,
                                       const Vector3d &along)
{
    constexpr double begin_mm = 0.02, touch_mm = 0.005;
    double at = begin_mm;
    for (int step = 0; step < 200 && at < look_mm; ++step) {
        const bake::TriangleTree::Nearest nearest = tree.nearest(from + at * along);
        const double distance_mm = std::abs(nearest.distance_mm);
        if (distance_mm < touch_mm) return {at, nearest.triangle};
        at += distance_mm;
    }
    return {INFINITY, UINT32_MAX};
}

Sight sight_of(const bake::TriangleTree &tree, std::uint32_t number)
{
    const bake::Mesh &mesh = tree.mesh();
    const bake::Triangle &t = mesh.triangles[number];
    const Vector3d &a = mesh.vertices_mm[t[0]], &b = mesh.vertices_mm[t[1]], &c = mesh.vertices_mm[t[2]];
    const Vector3d cross = (b - a).cross(c - a);
    if (cross.norm() < 1e-12) return {};
    const Vector3d normal = cross.normalized(), middle = (a + b + c) / 3;
    const auto one = meets(tree, middle, normal), other = meets(tree, middle, -normal);
    const auto &near = one.first < other.first ? one : other;
    return {near.first, std::max(one.first, other.first), near.second};
}

bool may_be_inner(const Sight &sight)
{
    return std::isfinite(sight.far_mm) && sight.near_mm < wall_mm_max &&
           sight.near_mm < near_share_max * sight.far_mm;
}

double area_of(const bake::Mesh &mesh, std::uint32_t number)
{
    const bake::Triangle &t = mesh.triangles[number];
    const Vector3d &a = mesh.vertices_mm[t[0]];
    return (mesh.vertices_mm[t[1]] - a).cross(mesh.vertices_mm[t[2]] - a).norm() / 2;
}

// Looks from at most `most` triangles, evenly spread in the list. The others see nothing.
std::vector<Sight> sights_of(const bake::TriangleTree &tree, std::size_t most)
{
    const std::size_t count = tree.mesh().triangles.size();
    const std::size_t step = std::max<std::size_t>(1, count / most);
    std::vector<Sight> sights(count);
    tbb::parallel_for(std::size_t{0}, (count + step - 1) / step, [&](std::size_t n) {
        sights[n * step] = sight_of(tree, static_cast<std::uint32_t>(n * step));
    });
    return sights;
}

double inner_share(const bake::Mesh &mesh, const std::vector<Sight> &sights, std::size_t step)
{
    double inner = 0, all = 0;
    for (std::size_t i = 0; i < sights.size(); i += step) {
        const double area = area_of(mesh, static_cast<std::uint32_t>(i));
        all += area;
        if (may_be_inner(sights[i])) inner += area;
    }
    return all > 0 ? inner / all : 0;
}

using Neighbours = std::vector<std::vector<std::uint32_t>>;

Neighbours neighbours_of(const bake::Mesh &mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            edges[{std::min(a, b), std::max(a, b)}].push_back(t);
        }
    Neighbours neighbours(mesh.triangles.size());
    for (const auto &[edge, triangles] : edges)
        for (const std::uint32_t one : triangles)
            for (const std::uint32_t other : triangles)
                if (one != other) neighbours[one].push_back(other);
    return neighbours;
}

// The outer sheet of a bend also sees itself across the bend, but farther away than the inner sheet behind it
// sees the opposite wall.
std::vector<char> inner_triangles(const std::vector<Sight> &sights)
{
    std::vector<char> is_inner(sights.size(), 0);
    for (std::size_t i = 0; i < sights.size(); ++i) {
        if (!may_be_inner(sights[i])) continue;
        const Sight &behind = sights[sights[i].near_triangle];
        is_inner[i] = !(may_be_inner(behind) && behind.far_mm < sights[i].far_mm);
    }
    return is_inner;
}

// A triangle takes the side of most of its neighbourhood: single triangles at junctions see wrongly.
void smooth(std::vector<char> &is_inner, const Neighbours &neighbours)
{
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
        const std::vector<char> before = is_inner;
        for (std::size_t t = 0; t < before.size(); ++t) {
            int votes = before[t] ? 1 : -1;
            for (const std::uint32_t other : neighbours[t]) votes += before[other] ? 1 : -1;
            if (votes != 0) is_inner[t] = votes > 0;
        }
    }
}

// Keeps the connected sheets of inner triangles that have at least a tenth of the largest sheet's area.
void keep_sheets(const bake::Mesh &mesh, const Neighbours &neighbours, std::vector<char> &is_inner)
{
    constexpr double least_share = 0.1;
    std::vector<std::vector<std::uint32_t>> sheets;
    std::vector<double> areas;
    std::vector<char> is_seen(is_inner.size(), 0);
    for (std::uint32_t seed = 0; seed < is_inner.size(); ++seed) {
        if (!is_inner[seed] || is_seen[seed]) continue;
        std::vector<std::uint32_t> sheet{seed};
        is_seen[seed] = 1;
        double area = 0;
        for (std::size_t n = 0; n < sheet.size(); ++n) {
            area += area_of(mesh, sheet[n]);
            for (const std::uint32_t other : neighbours[sheet[n]])
                if (is_inner[other] && !is_seen[other]) is_seen[other] = 1, sheet.push_back(other);
        }
        sheets.push_back(std::move(sheet));
        areas.push_back(area);
    }
    const double largest = areas.empty() ? 0 : *std::max_element(areas.begin(), areas.end());
    for (std::size_t s = 0; s < sheets.size(); ++s)
        if (areas[s] < least_share * largest)
            for (const std::uint32_t t : sheets[s]) is_inner[t] = 0;
}

} // namespace

std::optional<WallFound> lumen_of_wall(const bake::Mesh &part)
{
    const bake::TriangleTree tree(part);
    const std::size_t count = part.triangles.size();
    const std::size_t step = std::max<std::size_t>(1, count / sample_max);
    std::vector<Sight> sights = sights_of(tree, sample_max);
    WallFound found;
    found.inner_share = inner_share(part, sights, step);
    if (found.inner_share < wall_share_min) return std::nullopt;
    if (step > 1) sights = sights_of(tree, count);
    const Neighbours neighbours = neighbours_of(part);
    std::vector<char> is_inner = inner_triangles(sights);
    smooth(is_inner, neighbours);
    keep_sheets(part, neighbours, is_inner);
    std::vector<double> thicknesses;
    found.lumen.name = part.name;
    found.lumen.vertices_mm = part.vertices_mm;
    for (std::uint32_t t = 0; t < count; ++t) {
        if (!is_inner[t]) continue;
        found.lumen.triangles.push_back(part.triangles[t]);
        if (std::isfinite(sights[t].near_mm)) thicknesses.push_back(sights[t].near_mm);
    }
    if (found.lumen.triangles.empty()) return std::nullopt;
    found.thickness_mm = mesh::median(std::move(thicknesses));
    mesh::drop_unused(found.lumen.vertices_mm, found.lumen.triangles);
    return found;
}

} // namespace crn::patient
