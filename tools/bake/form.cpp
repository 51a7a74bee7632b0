// Makes the bodies (organs, bones and vessels) of a scene, and measures how far they deviate from their
// meshes.
#include "tools/bake/form.hpp"
#include "host/base/format.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/solid.hpp"
#include "tools/mesh/simplify.hpp"
#include "tools/mesh/spread.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace crn::bake
{
namespace
{

// Returns all vertices of the mesh, and `count` further points that are spread evenly by area over its
// surface.
std::vector<Eigen::Vector3d> sample(const Mesh &mesh, std::size_t count)
{
    std::vector<Eigen::Vector3d> points = mesh.vertices_mm;
    std::vector<double> sums;
    for (const Triangle &t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices_mm[t[1]] - mesh.vertices_mm[t[0]];
        const double area = a.cross(mesh.vertices_mm[t[2]] - mesh.vertices_mm[t[0]]).norm();
        sums.push_back((sums.empty() ? 0 : sums.back()) + area);
    }
    for (std::size_t i = 1; i <= count; ++i) {
        const auto at = std::lower_bound(sums.begin(), sums.end(), mesh::spread(i, 2) * sums.back());
        const Triangle &t = mesh.triangles[std::min<std::size_t>(static_cast<std::size_t>(at - sums.begin()),
                                                                 sums.size() - 1)];
        double u = mesh::spread(i, 3), v = mesh::spread(i, 5);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Eigen::Vector3d &a = mesh.vertices_mm[t[0]];
        points.push_back(a + u * (mesh.vertices_mm[t[1]] - a) + v * (mesh.vertices_mm[t[2]] - a));
    }
    return points;
}

// `guess_mm` is a distance within which most points are expected; it only shortens the search.
void measure(const std::vector<Eigen::Vector3d> &points, const TriangleTree &tree, double guess_mm,
             Deviation &found)
{
    constexpr std::size_t chunk = 1024;
    std::vector<double> distances(points.size());
    tbb::parallel_for(std::size_t{0}, (points.size() + chunk - 1) / chunk, [&](std::size_t part) {
        const std::size_t end = std::min(points.size(), (part + 1) * chunk);
        for (std::size_t i = part * chunk; i < end; ++i)
            distances[i] = std::abs(tree.nearest(points[i], guess_mm).distance_mm);
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
        found.mean_mm += distances[i];
        ++found.points;
        if (distances[i] <= found.largest_mm) continue;
        found.largest_mm = distances[i];
        found.place_mm = points[i];
    }
}

Deviation deviation_between(const std::vector<Eigen::Vector3d> &of_one, const TriangleTree &one,
                            const Mesh &other, std::size_t points, double guess_mm)
{
    Deviation found;
    measure(of_one, TriangleTree(other), guess_mm, found);
    measure(sample(other, points), one, guess_mm, found);
    found.mean_mm /= static_cast<double>(found.points);
    return found;
}

const Mesh &mesh_of(const std::string &name, const std::vector<BakedBody> &made)
{
    return std::find_if(made.begin(), made.end(), [&](const BakedBody &b) { return b.name == name; })->mesh;
}

Mesh remade(const BodyText &body, const Mesh &mesh, const std::vector<BakedBody> &made)
{
    const FormText &form = body.form;
    if (form.solid_mm == 0) return mesh;
    Mesh solid = offset_surface(mesh, form.solid_mm, body.is_marrow ? -form.shell_mm : 0.0);
    if (solid.triangles.empty())
        throw Fault(mesh.name + ": body '" + body.inside +
                    "' is nowhere thicker than its shell: lower shell_mm");
    if (form.close_mm > 0) solid = closed_surface(solid, form.solid_mm, form.close_mm);
    if (!form.clip_mm.isEmpty()) solid = clipped(solid, form.clip_mm, form.solid_mm);
    if (form.less.empty()) return solid;
    std::vector<const Mesh *> taken;
    for (const BakedBody &other : made)
        if (std::find(form.less.begin(), form.less.end(), other.name) != form.less.end())
            taken.push_back(&other.mesh);
    return difference(solid, taken, form.solid_mm, form.gap_mm);
}

std::string form_report(const BodyText &body, const Mesh &before, const Mesh &after)
{
    if (body.form.solid_mm == 0 || body.is_marrow) return "";
    return formatted_line("solid             %s: %.1f -> %.1f cm3 in voxels of %.2f mm", body.name.c_str(),
                          volume_mm3(before) / 1000, volume_mm3(after) / 1000, body.form.solid_mm);
}

} // namespace

Deviation deviation(const Mesh &one, const Mesh &other, std::size_t points_each)
{
    return deviation_between(sample(one, points_each), TriangleTree(one), other, points_each, INFINITY);
}

Deviation decimate(Mesh &mesh, double error_mm)
{
    constexpr std::size_t points = 10000;
    constexpr int attempts_max = 8;
    constexpr double flat_share =
        0.05; // of the error is spent on this first pass; each attempt starts from its result
    const TriangleTree before(mesh);
    const std::vector<Eigen::Vector3d> samples = sample(mesh, points);
    Mesh flat = mesh;
    crn::mesh::simplify(flat.vertices_mm, flat.triangles, flat_share * error_mm);
    double limit_mm = 0.5 * error_mm;
    for (int attempt = 0; attempt < attempts_max; ++attempt) {
        Mesh fewer = flat;
        crn::mesh::simplify(fewer.vertices_mm, fewer.triangles, limit_mm);
        const Deviation found = deviation_between(samples, before, fewer, points, error_mm);
        if (found.largest_mm <= error_mm) {
            mesh = std::move(fewer);
            return found;
        }
        limit_mm *=
            std::clamp(0.9 * error_mm / found.largest_mm, 0.25, 0.75); // the next limit, by linear estimate
    }
    return {}; // no triangle could be removed
}

Mesh load_body(const BodyText &body)
{
    Mesh mesh = load_mesh(body.mesh);
    if (body.form.solid_mm > 0)
        cap_openings(mesh, body.mesh.cap);
    else
        check_closed(mesh, body.mesh.cap);
    return mesh;
}

std::vector<Eigen::Vector3d> load_inhaled(const BodyText &body, const Mesh &rest)
{
    constexpr double longest_mm = 30.0; // the body file holds displacements up to 32.7 mm
    BodyText text = body;
    text.mesh.file = body.inhaled;
    const Mesh mesh = load_body(text);
    if (mesh.triangles != rest.triangles || mesh.vertices_mm.size() != rest.vertices_mm.size())
        throw Fault(body.inhaled.string() + ": has other triangles than " + rest.name +
                    ": it must be the same mesh with its vertices moved");
    for (std::size_t i = 0; i < mesh.vertices_mm.size(); ++i) {
        const double way_mm = (mesh.vertices_mm[i] - rest.vertices_mm[i]).norm();
        if (way_mm > longest_mm)
            throw Fault(body.inhaled.string() + ": the vertex at " + place_text(rest.vertices_mm[i]) +
                        formatted(" moves by %.1f mm, more than %.0f", way_mm, longest_mm) +
                        ": is it placed and scaled as the mesh at rest is?");
    }
    return mesh.vertices_mm;
}

Mesh form_body(const BodyText &body, Mesh base, const std::vector<BakedBody> &made, std::string &report)
{
    if (body.is_marrow) base = mesh_of(body.inside, made);
    for (const std::string &note : base.notes) report += "note: " + base.name + ": " + note + "\n";
    Mesh mesh = remade(body, base, made);
    report += form_report(body, base, mesh);
    if (body.form.error_mm == 0) return mesh;
    const std::size_t before = mesh.triangles.size();
    const Deviation found = decimate(mesh, body.form.error_mm);
    report += formatted_line(
        "decimated         %s: %zu -> %zu triangles, off by %.3f mm on average, at most %.3f mm at %s "
        "(%zu points, allowed %.2f)",
        body.name.c_str(), before, mesh.triangles.size(), found.mean_mm, found.largest_mm,
        place_text(found.place_mm).c_str(), found.points, body.form.error_mm);
    return mesh;
}

namespace
{

struct Neighbour {
    const BakedBody &body;
    Eigen::AlignedBox3d box;
    std::unique_ptr<TriangleTree> tree; // made at its first use
};

// Tests about `samples` vertices of `mesh`, and returns the one that lies deepest on the wrong side of the
// surface `of`. The wrong side is the outside for sign +1, and the inside for sign -1.
Deviation worst(const Mesh &mesh, Neighbour &of, double sign, std::size_t samples)
{
    Deviation found;
    const std::size_t step = std::max<std::size_t>(1, mesh.vertices_mm.size() / samples);
    for (std::size_t i = 0; i < mesh.vertices_mm.size(); i += step) {
        const Eigen::Vector3d &p = mesh.vertices_mm[i];
        if (sign < 0 && !of.box.contains(p)) continue;
        if (!of.tree) of.tree = std::make_unique<TriangleTree>(of.body.mesh);
        if ((of.tree->winding(p) > 0) == (sign > 0)) continue;
        const double distance = std::abs(of.tree->nearest(p).distance_mm);
        if (distance <= found.largest_mm) continue;
        found.largest_mm = distance;
        found.place_mm = p;
    }
    return found;
}

} // namespace

// Returns the report's lines for all pairs of bodies that `is_asked` names. `when` begins each line's text.
static std::string pairs_report(const std::vector<BakedBody> &bodies, std::size_t samples,
                                double tolerated_mm, const std::string &when,
                                const std::function<bool(const BakedBody &, const BakedBody &)> &is_asked)
{
    std::vector<Neighbour> all;
    for (const BakedBody &body : bodies) {
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d &v : body.mesh.vertices_mm) box.extend(v);
        all.push_back({body, box, nullptr});
    }
    std::string report;
    for (std::size_t i = 0; i < bodies.size(); ++i)
        for (std::size_t k = 0; k < bodies.size(); ++k) {
            const bool is_parent = bodies[i].parent == static_cast<int>(k);
            if (i == k || !is_asked(bodies[i], bodies[k]) ||
                (!is_parent && (bodies[i].parent != bodies[k].parent || !all[i].box.intersects(all[k].box))))
                continue;
            const Deviation found = worst(bodies[i].mesh, all[k], is_parent ? 1 : -1, samples);
            if (found.largest_mm <= tolerated_mm) continue;
            report +=
                formatted_line("warning: %sbody '%s' reaches %.1f mm %s '%s' at %s: %s", when.c_str(),
                               bodies[i].name.c_str(), found.largest_mm, is_parent ? "out of" : "into",
                               bodies[k].name.c_str(), place_text(found.place_mm).c_str(),
                               is_parent ? "move it, or correct `inside`"
                                         : "move it, put one inside the other, or take one out by `less`");
        }
    return report;
}

std::string nesting_report(const std::vector<BakedBody> &bodies, std::size_t samples)
{
    constexpr double tolerated_mm = 0.3;
    return pairs_report(bodies, samples, tolerated_mm, "",
                        [](const BakedBody &, const BakedBody &) { return true; });
}

std::string breath_report(const std::vector<BakedBody> &bodies, std::size_t samples)
{
    constexpr double tolerated_mm = 1.0;
    const auto breathes = [](const BakedBody &body) { return !body.inhaled_mm.empty(); };
    if (std::none_of(bodies.begin(), bodies.end(), breathes)) return "";
    std::string report;
    for (const double depth : {0.5, 1.0}) {
        std::vector<BakedBody> moved = bodies;
        double longest_mm = 0;
        for (BakedBody &body : moved)
            for (std::size_t i = 0; i < body.inhaled_mm.size(); ++i) {
                const Eigen::Vector3d way_mm = body.inhaled_mm[i] - body.mesh.vertices_mm[i];
                longest_mm = std::max(longest_mm, way_mm.norm());
                body.mesh.vertices_mm[i] += depth * way_mm;
            }
        if (depth == 1.0)
            report += formatted_line("breath            moves %td bodies by at most %.1f mm",
                                     std::count_if(bodies.begin(), bodies.end(), breathes), longest_mm);
        report += pairs_report(
            moved, samples, tolerated_mm, depth == 1.0 ? "after a full breath, " : "after half a breath, ",
            [&](const BakedBody &a, const BakedBody &b) { return breathes(a) || breathes(b); });
    }
    return report;
}

} // namespace crn::bake
