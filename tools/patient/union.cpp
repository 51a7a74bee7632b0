#include "tools/patient/union.hpp"
#include "host/base/format.hpp"
#include "tools/bake/centreline.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/solid.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/mesh/pieces.hpp"
#include "tools/mesh/simplify.hpp"
#include "tools/patient/wall.hpp"

#include <algorithm>
#include <cmath>

namespace crn::patient
{
namespace
{

using Eigen::Vector3d;

constexpr double simplify_voxels = 0.1; // error of the simplified surface of a level set

Eigen::AlignedBox3d box_of(const bake::Mesh &mesh)
{
    Eigen::AlignedBox3d box;
    for (const Vector3d &v : mesh.vertices_mm) box.extend(v);
    return box;
}

void append(bake::Mesh &mesh, const bake::Mesh &other)
{
    const auto base = static_cast<std::uint32_t>(mesh.vertices_mm.size());
    mesh.vertices_mm.insert(mesh.vertices_mm.end(), other.vertices_mm.begin(), other.vertices_mm.end());
    for (const bake::Triangle &t : other.triangles)
        mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

// The connected pieces of a mesh, the largest first.
std::vector<bake::Mesh> separated(const bake::Mesh &mesh)
{
    const std::vector<std::uint32_t> piece = mesh::pieces_of(mesh.vertices_mm.size(), mesh.triangles);
    std::vector<std::size_t> number(piece.size(), SIZE_MAX);
    std::vector<bake::Mesh> pieces;
    for (const bake::Triangle &t : mesh.triangles) {
        std::size_t &n = number[piece[t[0]]];
        if (n == SIZE_MAX) {
            n = pieces.size();
            pieces.push_back({mesh.name, mesh.vertices_mm, {}, {}});
        }
        pieces[n].triangles.push_back(t);
    }
    for (bake::Mesh &one : pieces) mesh::drop_unused(one.vertices_mm, one.triangles);
    std::stable_sort(pieces.begin(), pieces.end(), [](const bake::Mesh &a, const bake::Mesh &b) {
        return std::abs(bake::volume_mm3(a)) > std::abs(bake::volume_mm3(b));
    });
    return pieces;
}

// Three times the volume over the area is a sphere's radius; twice, a tube's.
double tube_radius_mm(const bake::Mesh &closed)
{
    return 2 * std::abs(bake::volume_mm3(closed)) / std::max(1e-9, bake::area_mm2(closed));
}

// Closes the openings of a part piece by piece, so that rims of two pieces at one place are not confused.
bake::Mesh capped(const bake::Mesh &part)
{
    bake::Mesh whole;
    whole.name = part.name;
    for (bake::Mesh &piece : separated(part)) {
        const bake::Mesh raw = piece;
        try {
            bake::check_closed(piece, bake::Cap::any);
        } catch (const Fault &) { // the level set does not mind, but the volume's sign shall be right
            piece = raw;
            bake::cap_openings(piece, bake::Cap::any);
            if (bake::volume_mm3(piece) < 0)
                for (bake::Triangle &t : piece.triangles) std::swap(t[1], t[2]);
        }
        if (bake::volume_mm3(piece) < 0.1) continue; // a flake
        append(whole, piece);
    }
    return whole;
}

struct Lumens {
    std::vector<bake::Mesh> surfaces, closed; // of each part: as given, and capped
    std::vector<std::string> walls;           // names of the parts that are walls
    double thickness_mm = 0;
};

Lumens lumens_of(const std::vector<Part> &parts, const UnionWish &wish, bake::Progress &progress)
{
    Lumens lumens;
    progress.stage("looking for walls", parts.size());
    for (std::size_t p = 0; p < parts.size(); ++p) {
        bake::Mesh surface = parts[p].mesh;
        if (wish.walls != "lumen") {
            const std::optional<WallFound> found = lumen_of_wall(surface);
            if (!found && wish.walls == "wall")
                throw Fault(surface.name +
                            ": is no wall of two sheets, one in the other: leave out --walls wall");
            if (found) {
                surface = found->lumen;
                lumens.thickness_mm += found->thickness_mm;
                lumens.walls.push_back(parts[p].name);
            }
        }
        lumens.closed.push_back(capped(surface));
        if (lumens.closed.back().triangles.empty()) lumens.closed.back() = surface;
        lumens.surfaces.push_back(std::move(surface));
        progress.step(p + 1);
    }
    progress.finish();
    if (!lumens.walls.empty()) lumens.thickness_mm /= static_cast<double>(lumens.walls.size());
    return lumens;
}

// The surface as it is, if it bounds one solid.
std::optional<WholeLumen> as_given(const Lumens &lumens, bake::Progress &progress, std::string &why)
{
    if (lumens.surfaces.size() != 1) {
        why = formatted("%zu parts become one", lumens.surfaces.size());
        return std::nullopt;
    }
    WholeLumen whole;
    whole.surface = whole.closed = lumens.surfaces.front();
    try {
        bake::check_closed(whole.closed, bake::Cap::any);
        bake::check_crossing(whole.closed, progress);
    } catch (const Fault &fault) {
        if (bake::Progress::interrupted()) throw;
        why = fault.what();
        if (why.starts_with(whole.surface.name + ": ")) why.erase(0, whole.surface.name.size() + 2);
        return std::nullopt;
    }
    if (separated(whole.closed).size() > 1) {
        why = "the mesh is in several pieces";
        return std::nullopt;
    }
    whole.own = {whole.closed};
    return whole;
}

double voxel_for(const bake::Mesh &soup, const std::vector<bake::Mesh> &closed, const UnionWish &wish)
{
    if (wish.solid_mm > 0) return wish.solid_mm;
    double thinnest_mm = INFINITY;
    for (const bake::Mesh &part : closed) thinnest_mm = std::min(thinnest_mm, tube_radius_mm(part));
    const double least = std::cbrt(box_of(soup).volume() / (0.8 * bake::solid_voxels_max));
    return std::max(std::clamp(thinnest_mm / 4, 0.2, 0.6), least);
}

struct Deep {
    Vector3d place_mm;
    double radius_mm;
};

// Goes from a place on the wall inwards, to the middle of the vessel there. On the way to the middle the
// distance to the wall grows nearly as fast as the way; along the middle it does not grow.
Deep middle_from(const bake::TriangleTree &tree, const Vector3d &wall_mm, const Vector3d &inwards)
{
    constexpr double slope_min = 0.4, step_max_mm = 0.8, step_min_mm = 0.1;
    Deep best{wall_mm + 0.3 * inwards, 0};
    best.radius_mm = -tree.nearest(best.place_mm).distance_mm;
    for (double step_mm = step_max_mm; step_mm >= step_min_mm;) {
        Deep next = best;
        for (int n = 0; n < 27; ++n) {
            const Vector3d to(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            if (n == 13) continue;
            const Vector3d place_mm = best.place_mm + step_mm * to.normalized();
            const double radius_mm = -tree.nearest(place_mm).distance_mm;
            if (radius_mm > next.radius_mm) next = {place_mm, radius_mm};
        }
        if (next.radius_mm < best.radius_mm + slope_min * step_mm)
            step_mm /= 2;
        else
            best = next;
    }
    return best;
}

struct Gap {
    double mm = INFINITY;
    Vector3d from, to; // on the piece, and on the main one
};

Gap gap_between(const bake::Mesh &piece, const bake::TriangleTree &main, double most_mm)
{
    Gap gap;
    Eigen::AlignedBox3d near = box_of(main.mesh());
    near.min().array() -= most_mm;
    near.max().array() += most_mm;
    for (const Vector3d &v : piece.vertices_mm) {
        if (!near.contains(v)) continue;
        const bake::TriangleTree::Nearest nearest = main.nearest(v, std::min(gap.mm, most_mm) + 1e-6);
        if (std::abs(nearest.distance_mm) < gap.mm)
            gap = {std::abs(nearest.distance_mm), v, nearest.point_mm};
    }
    if (gap.mm > most_mm) gap.mm = INFINITY;
    return gap;
}

// A straight tube over a gap, a little thinner than the thinner vessel, from the middle of one to that of the
// other.
bake::Mesh bridge(const bake::TriangleTree &piece, const bake::TriangleTree &main, const Gap &gap,
                  double voxel_mm, bake::Progress &progress)
{
    Vector3d along = gap.to - gap.from;
    if (along.norm() < 1e-9) along = Vector3d::UnitY();
    along.normalize();
    const Deep here = middle_from(piece, gap.from, -along), there = middle_from(main, gap.to, along);
    const double radius_mm = std::max(2 * voxel_mm, 0.9 * std::min(here.radius_mm, there.radius_mm));
    bake::Curve line;
    line.spheres = {{here.place_mm, radius_mm}, {there.place_mm, radius_mm}};
    if ((here.place_mm - there.place_mm).norm() < 1e-3) line.spheres[1].centre_mm += Vector3d(0, voxel_mm, 0);
    return bake::surface_of({line}, std::min(voxel_mm, radius_mm / 3), progress);
}

std::size_t main_piece(const std::vector<bake::Mesh> &pieces, const UnionWish &wish)
{
    if (!wish.inlet_mm) return 0;
    std::size_t best = 0;
    double best_mm = INFINITY;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const double mm = bake::TriangleTree(pieces[p]).nearest(*wish.inlet_mm).distance_mm;
        if (mm < best_mm) best = p, best_mm = mm;
    }
    return best;
}

// Bridges every piece that lies near the main one, until none is left or none is near. Returns the main
// piece.
bake::Mesh bridged(bake::Mesh soup, double voxel_mm, const UnionWish &wish, Choices &choices,
                   bake::Progress &progress)
{
    std::vector<Vector3d> bridges;
    for (;;) {
        progress.stage("joining parts", 0);
        bake::Mesh solid = bake::offset_surface(soup, voxel_mm, 0);
        std::vector<bake::Mesh> pieces = separated(solid);
        std::swap(pieces[0], pieces[main_piece(pieces, wish)]);
        const bake::TriangleTree main(pieces[0]);
        const std::size_t before = bridges.size();
        for (std::size_t p = 1; p < pieces.size() && wish.bridge_mm > 0; ++p) {
            if (std::abs(bake::volume_mm3(pieces[p])) < 10 * std::pow(voxel_mm, 3)) continue;
            const Gap gap = gap_between(pieces[p], main, wish.bridge_mm);
            if (!std::isfinite(gap.mm)) continue;
            append(soup, bridge(bake::TriangleTree(pieces[p]), main, gap, voxel_mm, progress));
            bridges.push_back((gap.from + gap.to) / 2);
        }
        progress.finish();
        if (bridges.size() > before && bridges.size() < 200) continue;
        if (!bridges.empty()) {
            std::string places;
            for (std::size_t i = 0; i < bridges.size() && i < 4; ++i)
                places += (i ? ", " : "") + bake::place_text(bridges[i]);
            choices.add("bridges", std::to_string(bridges.size()),
                        formatted("gaps of at most %.1f mm are closed, at ", wish.bridge_mm) + places +
                            (bridges.size() > 4 ? " and more" : ""),
                        "--bridge-mm 0: none, or wider");
        }
        double left_mm3 = 0, largest_mm3 = 0;
        Vector3d largest_at = Vector3d::Zero();
        for (std::size_t p = 1; p < pieces.size(); ++p) {
            const double mm3 = std::abs(bake::volume_mm3(pieces[p]));
            left_mm3 += mm3;
            if (mm3 > largest_mm3) largest_mm3 = mm3, largest_at = box_of(pieces[p]).center();
        }
        if (pieces.size() > 1)
            choices.add(
                "left out", formatted("%zu pieces, %.2f ml", pieces.size() - 1, left_mm3 / 1000),
                formatted("they touch the largest piece (%.1f ml) nowhere; the largest of them is at %s",
                          std::abs(bake::volume_mm3(pieces[0])) / 1000, bake::place_text(largest_at).c_str()),
                "--bridge-mm, --inlet in the piece that is wanted");
        return pieces[0];
    }
}

} // namespace

WholeLumen whole_lumen(const std::vector<Part> &parts, const UnionWish &wish, Choices &choices,
                       bake::Progress &progress)
{
    Lumens lumens = lumens_of(parts, wish, progress);
    if (!lumens.walls.empty()) {
        std::string names;
        for (std::size_t n = 0; n < lumens.walls.size() && n < 4; ++n)
            names += (n ? ", " : "") + lumens.walls[n];
        if (lumens.walls.size() > 4) names += " and more";
        choices.add("walls", formatted("%zu of %zu parts", lumens.walls.size(), parts.size()),
                    formatted("two sheets %.1f mm apart, so the lumen is inside the inner one: ",
                              lumens.thickness_mm) +
                        names,
                    "--walls lumen");
    } else
        choices.add("walls", "none",
                    wish.walls == "lumen" ? "as stated" : "the mesh is the lumen's own surface",
                    "--walls wall");
    std::string why;
    if (std::optional<WholeLumen> whole = as_given(lumens, progress, why)) {
        for (const std::string &note : whole->closed.notes) choices.add("surface", note, "", "");
        return std::move(*whole);
    }
    WholeLumen whole;
    whole.is_remade = true;
    bake::Mesh soup;
    soup.name = parts.size() == 1 ? parts.front().mesh.name : "the parts together";
    for (const bake::Mesh &part : lumens.closed) append(soup, part);
    const double voxel_mm = voxel_for(soup, lumens.closed, wish);
    bake::Mesh made = bridged(soup, voxel_mm, wish, choices, progress);
    // Without all caps, a level set has no inside, and only a thin shell is left.
    double largest_mm3 = 0;
    for (const bake::Mesh &part : lumens.closed)
        largest_mm3 = std::max(largest_mm3, std::abs(bake::volume_mm3(part)));
    if (bake::volume_mm3(made) < 0.5 * largest_mm3)
        throw Fault(soup.name + ": no closed lumen comes of it (" + why +
                    "): close its holes in a mesh editor, or state a larger --solid-mm");
    made.name = soup.name;
    progress.stage("simplifying the surface", 0);
    const std::size_t before = made.triangles.size();
    bake::Mesh fewer = made;
    mesh::simplify(fewer.vertices_mm, fewer.triangles, simplify_voxels * voxel_mm);
    try {
        bake::check_closed(fewer, bake::Cap::none);
        bake::check_crossing(fewer, progress);
        made = std::move(fewer);
    } catch (const Fault &) { // all triangles are right, too
        if (bake::Progress::interrupted()) throw;
        bake::check_closed(made, bake::Cap::any);
    }
    choices.add("surface", formatted("made anew in voxels of %.2f mm", voxel_mm),
                why + formatted("; %zu triangles, simplified to %zu", before, made.triangles.size()),
                "--solid-mm");
    whole.surface = whole.closed = std::move(made);
    whole.own = std::move(lumens.closed);
    return whole;
}

} // namespace crn::patient
