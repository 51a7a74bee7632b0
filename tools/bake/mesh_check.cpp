// Decides whether a mesh is the boundary of a solid: examines its edges, caps its openings, and makes its
// triangles point outwards.
#include "host/base/format.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace crn::bake
{
namespace
{

// A Side is one edge of one triangle: it holds the edge's vertices `low` and `high`, and whether the triangle
// runs from low to high.
struct Side {
    std::uint32_t low, high, triangle;
    bool forward;
};

std::vector<Side> sides_of(const Mesh &mesh)
{
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), i, a < b});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side &a, const Side &b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    return sides;
}

// Calls use(begin, end) once for every edge of the mesh; begin and end delimit the part of the list `sides`
// that belongs to this edge.
template <typename Use> void for_each_edge(const std::vector<Side> &sides, Use use)
{
    for (std::size_t i = 0, end; i < sides.size(); i = end) {
        for (end = i;
             end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high;)
            ++end;
        use(i, end);
    }
}

std::string edge_text(const Mesh &mesh, const Side &side)
{
    return "edge " + place_text(mesh.vertices_mm[side.low]) + " - " +
           place_text(mesh.vertices_mm[side.high]) + " of triangle " + std::to_string(side.triangle);
}

void check_manifold(const Mesh &mesh, const std::vector<Side> &sides)
{
    std::size_t count = 0, first = 0, most = 0, open = 0;
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
        open += end - begin == 1;
        if (end - begin <= 2) return;
        if (count++ == 0) {
            first = begin;
            most = end - begin;
        }
    });
    if (count > 0)
        throw Fault(mesh.name + ": " + std::to_string(count) + " non-manifold edges, the first, " +
                    edge_text(mesh, sides[first]) + ", lies in " + std::to_string(most) + " triangles" +
                    (open ? ", and " + std::to_string(open) + " open edges" : "") +
                    ": remove double and inner faces (\"make manifold\" in a mesh editor)");
}

// Reverses triangles so that neighbouring triangles have the same orientation. Returns the number of reversed
// triangles; throws Fault for a one-sided surface.
std::size_t agree(Mesh &mesh, const std::vector<Side> &sides)
{
    struct SharedSide {
        std::uint32_t triangle;
        bool same_sense;
    };
    std::vector<std::vector<SharedSide>> neighbours(mesh.triangles.size());
    bool all_agree = true;
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
        if (end - begin != 2) return;
        const Side &a = sides[begin], &b = sides[begin + 1];
        all_agree = all_agree && a.forward != b.forward;
        neighbours[a.triangle].push_back({b.triangle, a.forward == b.forward});
        neighbours[b.triangle].push_back({a.triangle, a.forward == b.forward});
    });
    if (all_agree) return 0;
    std::vector<signed char> turned(mesh.triangles.size(), -1);
    std::vector<std::uint32_t> front;
    for (std::uint32_t seed = 0; seed < turned.size(); ++seed) {
        if (turned[seed] >= 0) continue;
        turned[seed] = 0;
        front.push_back(seed);
        while (!front.empty()) {
            const std::uint32_t at = front.back();
            front.pop_back();
            for (const SharedSide &n : neighbours[at]) {
                const signed char wanted =
                    static_cast<signed char>(n.same_sense ? 1 - turned[at] : turned[at]);
                if (turned[n.triangle] < 0) {
                    turned[n.triangle] = wanted;
                    front.push_back(n.triangle);
                } else if (turned[n.triangle] != wanted) {
                    throw Fault(mesh.name + ": the surface is one-sided (a Moebius strip) near triangle " +
                                std::to_string(n.triangle) + " at " +
                                place_text(mesh.vertices_mm[mesh.triangles[n.triangle][0]]) +
                                ": repair it in a mesh editor");
                }
            }
        }
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < turned.size(); ++i) {
        if (turned[i] != 1) continue;
        std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
        ++count;
    }
    return count;
}

// An opening is stored as the list of its corners, in the corner order of a polygon that would close the
// opening.
using Loop = std::vector<std::uint32_t>;

std::vector<Loop> openings(const std::vector<Side> &sides)
{
    std::multimap<std::uint32_t, std::uint32_t>
        next; // against the direction of the triangle beside the opening
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
        if (end - begin != 1) return;
        const Side &side = sides[begin];
        next.emplace(side.forward ? side.high : side.low, side.forward ? side.low : side.high);
    });
    std::vector<Loop> loops;
    while (!next.empty()) {
        Loop loop{next.begin()->first};
        for (auto at = next.begin(); at != next.end(); at = next.find(loop.back())) {
            const std::uint32_t corner = at->second;
            next.erase(at);
            if (corner == loop.front()) break;
            loop.push_back(corner);
        }
        loops.push_back(loop);
    }
    return loops;
}

struct Opening {
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double across_mm = 0, unevenness_mm = 0;
};

Opening describe(const Mesh &mesh, const Loop &loop)
{
    Opening opening;
    for (std::uint32_t v : loop) opening.centre_mm += mesh.vertices_mm[v] / static_cast<double>(loop.size());
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Eigen::Vector3d a = mesh.vertices_mm[loop[i]] - opening.centre_mm;
        normal += a.cross(mesh.vertices_mm[loop[(i + 1) % loop.size()]] - opening.centre_mm);
        opening.across_mm = std::max(opening.across_mm, 2 * a.norm());
    }
    if (normal.norm() > 0) normal.normalize();
    for (std::uint32_t v : loop)
        opening.unevenness_mm =
            std::max(opening.unevenness_mm, std::abs(normal.dot(mesh.vertices_mm[v] - opening.centre_mm)));
    return opening;
}

std::string opening_text(const Opening &opening, std::size_t edges)
{
    const std::string text = formatted(" (%zu edges, %.1f mm across)", edges, opening.across_mm);
    return place_text(opening.centre_mm) + text;
}

void cap_opening(Mesh &mesh, const Loop &loop, const Opening &opening)
{
    const auto centre = static_cast<std::uint32_t>(mesh.vertices_mm.size());
    mesh.vertices_mm.push_back(opening.centre_mm);
    for (std::size_t i = 0; i < loop.size(); ++i)
        mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], centre});
}

void close_openings(Mesh &mesh, const std::vector<Loop> &loops, Cap cap)
{
    constexpr std::size_t named_max = 6;
    std::string list;
    for (std::size_t i = 0; i < loops.size() && i < named_max; ++i)
        list += (i ? ", " : "") + opening_text(describe(mesh, loops[i]), loops[i].size());
    if (loops.size() > named_max) list += " and " + std::to_string(loops.size() - named_max) + " more";
    if (cap == Cap::none)
        throw Fault(mesh.name + ": open, with " + std::to_string(loops.size()) + " openings at " + list +
                    ": set cap = true if they are flat vessel ends, cap = \"any\" for every other shape, or "
                    "close them in a mesh editor");
    double widest_mm = 0;
    for (const Loop &loop : loops) {
        const Opening opening = describe(mesh, loop);
        // An opening counts as flat if its corners deviate from a plane by at most 5 % of its width. Openings
        // that scanner software has cut into vessels are flat.
        const bool is_flat = loop.size() >= 3 && opening.unevenness_mm <= 0.05 * opening.across_mm;
        if (!is_flat && cap == Cap::flat)
            throw Fault(mesh.name + ": the opening at " + opening_text(opening, loop.size()) +
                        " is not flat, so cap = true cannot close it: set cap = \"any\" to close it by a fan "
                        "of triangles about its middle, or close it in a mesh editor");
        cap_opening(mesh, loop, opening);
        widest_mm = std::max(widest_mm, opening.across_mm);
        if (loops.size() <= named_max)
            mesh.notes.push_back("capped the opening at " + opening_text(opening, loop.size()));
    }
    if (loops.size() > named_max) {
        const std::string text =
            formatted("capped %zu openings, the widest %.1f mm across", loops.size(), widest_mm);
        mesh.notes.push_back(text);
    }
}

} // namespace

double volume_mm3(const Mesh &mesh)
{
    double sum = 0;
    const Eigen::Vector3d origin = mesh.vertices_mm[0];
    for (const Triangle &t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices_mm[t[0]] - origin, b = mesh.vertices_mm[t[1]] - origin;
        sum += a.dot(b.cross(mesh.vertices_mm[t[2]] - origin));
    }
    return sum / 6;
}

double area_mm2(const Mesh &mesh)
{
    double sum = 0;
    for (const Triangle &t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices_mm[t[1]] - mesh.vertices_mm[t[0]];
        sum += a.cross(mesh.vertices_mm[t[2]] - mesh.vertices_mm[t[0]]).norm() / 2;
    }
    return sum;
}

void check_closed(Mesh &mesh, Cap cap)
{
    std::vector<Side> sides = sides_of(mesh);
    check_manifold(mesh, sides);
    if (const std::size_t turned = agree(mesh, sides)) {
        mesh.notes.push_back(std::to_string(turned) + " triangles turned to agree with their neighbours");
        sides = sides_of(mesh);
    }
    const std::vector<Loop> loops = openings(sides);
    if (!loops.empty()) {
        close_openings(mesh, loops, cap);
        check_manifold(mesh, sides_of(mesh));
    }
    const double volume = volume_mm3(mesh);
    if (volume < 0) {
        for (Triangle &t : mesh.triangles) std::swap(t[1], t[2]);
        mesh.notes.push_back("was inside out: turned");
    }
    if (std::abs(volume) < 1e-6 * area_mm2(mesh))
        throw Fault(mesh.name + ": encloses nothing, it is a flat or doubled sheet: export a closed surface");
}

void cap_openings(Mesh &mesh, Cap cap)
{
    const std::vector<Loop> loops = openings(sides_of(mesh));
    if (!loops.empty()) close_openings(mesh, loops, cap);
}

} // namespace crn::bake
