#include "tools/lab/ct/patient/vessels.hpp"
#include "host/base/format.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/centreline/fit/automatic.hpp"
#include "tools/lab/ct/measures.hpp"
#include "tools/lab/ct/patient/wall.hpp"
#include "tools/lab/ct/snake.hpp"
#include "tools/lab/ct/surface.hpp"
#include "tools/mesh/fault.hpp"
#include "tools/mesh/pieces.hpp"
#include "tools/mesh/simplify.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

constexpr double least_radius_mm = 0.1;

std::string structure_of(const centreline::Branch &branch, const LabelMap &labels)
{
    std::map<std::string, int> votes;
    for (const centreline::Sphere &sphere : branch.spheres) {
        const Vector3d voxel = labels.volume.voxel(sphere.centre_mm);
        const int i = static_cast<int>(std::lround(voxel.x())), j = static_cast<int>(std::lround(voxel.y())),
                  k = static_cast<int>(std::lround(voxel.z()));
        if (!labels.volume.holds(i, j, k)) continue;
        const auto found = labels.names.find(labels.label(labels.volume.at(i, j, k)));
        if (found != labels.names.end() && is_artery(found->second)) ++votes[found->second];
    }
    std::string best = "artery";
    int most = 0;
    for (const auto &[name, count] : votes)
        if (count > most) best = name, most = count;
    return best;
}

// The signed distance from the faces between voxels of the mask and others. signed_distance() is 0 in the
// middle of the mask's outermost voxels, half a voxel inside these faces; of the other voxels it is so half a
// voxel outside.
Volume border_distance(const Volume &mask)
{
    Volume others = mask;
    for (float &value : others.hu) value = value > 0 ? 0.0f : 1.0f;
    Volume distance = signed_distance(mask);
    const Volume back = signed_distance(others);
    for (std::size_t at = 0; at < distance.count(); ++at)
        distance.hu[at] = (distance.hu[at] - back.hu[at]) / 2;
    return distance;
}

} // namespace

Volume artery_level(const Volume &scan, const LabelMap &labels, const Contrast &contrast,
                    const Report &report)
{
    constexpr double least_HU = 150.0; // below it, noise hides the edges of the blood
    if (contrast.mean_HU >= least_HU) return wall_level(scan, labels, contrast, report);
    report("cut out arteries", 0);
    const Cut cut = cut_arteries(scan, labels);
    report("cut out arteries", 0.5);
    const Volume level = smoothed(in_cubes(border_distance(cut.mask), cube_of(scan)), 0.7);
    report("cut out arteries", 1);
    return level;
}

bake::Mesh lumen_of(const Volume &level)
{
    bake::Mesh mesh = surface_of(level, "lumen");
    mesh::drop_small_pieces(mesh.vertices_mm, mesh.triangles, 0, 0.5);
    if (mesh.triangles.empty())
        throw Fault(level.name +
                    ": no lumen remains of the label map's arteries: they are thinner than two voxels, or in "
                    "scattered pieces; segment again");
    return mesh;
}

Vector3d root_of(const LabelMap &labels)
{
    const Volume &grid = labels.volume;
    std::vector<unsigned char> kind(65536, 0);
    for (const auto &[number, name] : labels.names)
        kind[static_cast<std::size_t>(number)] = name == "aorta" ? 1 : name.find("heart") == 0 ? 2 : 0;
    const auto kind_at = [&](int i, int j, int k) {
        return kind[static_cast<std::size_t>(std::clamp(labels.label(grid.at(i, j, k)), 0, 65535))];
    };
    std::vector<Vector3d> touching, aorta;
    const int reach = 2;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = reach; j < grid.size[1] - reach; ++j)
            for (int i = reach; i < grid.size[0] - reach; ++i) {
                if (kind_at(i, j, k) != 1) continue;
                const Vector3d at = grid.scene({1.0 * i, 1.0 * j, 1.0 * k});
                aorta.push_back(at);
                const int above = std::min(k + 1, grid.size[2] - 1), below = std::max(k - 1, 0);
                const bool touches = kind_at(i + reach, j, k) == 2 || kind_at(i - reach, j, k) == 2 ||
                                     kind_at(i, j + reach, k) == 2 || kind_at(i, j - reach, k) == 2 ||
                                     kind_at(i, j, above) == 2 || kind_at(i, j, below) == 2;
                if (touches) touching.push_back(at);
            }
    if (touching.size() < 20) { // the foremost voxels of the aorta are those of its ascending part
        std::sort(aorta.begin(), aorta.end(),
                  [](const Vector3d &a, const Vector3d &b) { return a.z() > b.z(); });
        aorta.resize(std::max<std::size_t>(aorta.size() / 10, 1));
        return *std::min_element(aorta.begin(), aorta.end(),
                                 [](const Vector3d &a, const Vector3d &b) { return a.y() < b.y(); });
    }
    // The descending aorta touches the heart from behind, the ascending one comes out of its front part. Its
    // lowest part is the root.
    std::sort(touching.begin(), touching.end(),
              [](const Vector3d &a, const Vector3d &b) { return a.z() > b.z(); });
    touching.resize(touching.size() / 3 + 1);
    std::sort(touching.begin(), touching.end(),
              [](const Vector3d &a, const Vector3d &b) { return a.y() < b.y(); });
    touching.resize(touching.size() / 5 + 1);
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d &at : touching) sum += at;
    return sum / static_cast<double>(touching.size());
}

// Returns a place well inside the lumen near the given one: the deepest within the smallest distance of 4, 8
// or 16 mm in which any place is 3 mm from the wall.
static Vector3d inside_near(const bake::Mesh &lumen, const Vector3d &place_mm)
{
    constexpr double step_mm = 2.0, enough_mm = -3.0;
    const bake::TriangleTree wall(lumen);
    Vector3d best = place_mm;
    double least_mm = wall.nearest(place_mm).distance_mm;
    for (double reach_mm = 4.0; reach_mm <= 16.0 && least_mm > enough_mm; reach_mm *= 2.0)
        for (double x = -reach_mm; x <= reach_mm; x += step_mm)
            for (double y = -reach_mm; y <= reach_mm; y += step_mm)
                for (double z = -reach_mm; z <= reach_mm; z += step_mm) {
                    if (Vector3d(x, y, z).norm() > reach_mm) continue;
                    const Vector3d at = place_mm + Vector3d(x, y, z);
                    const double distance_mm = wall.nearest(at).distance_mm;
                    if (distance_mm < least_mm) best = at, least_mm = distance_mm;
                }
    return best;
}

// The distance of the wall from a place inside, along a direction.
static double wall_along(const bake::TriangleTree &wall, const Vector3d &from, const Vector3d &along,
                         double most_mm)
{
    double at_mm = 0;
    while (at_mm < most_mm) {
        const double clear_mm = -wall.nearest(from + at_mm * along).distance_mm;
        if (clear_mm < 0.02) break;
        at_mm += clear_mm;
    }
    return std::min(at_mm, most_mm);
}

// The radius of the circle with the area of the section. The largest inscribed sphere is smaller: it touches
// the nearest bump of the wall.
static double section_radius(const bake::TriangleTree &wall, const Vector3d &middle, const Vector3d &along,
                             double inscribed_mm)
{
    constexpr int rays = 12;
    const Vector3d right = along.unitOrthogonal(), up = along.cross(right);
    std::vector<double> edges;
    for (int ray = 0; ray < rays; ++ray) {
        const double angle = 2 * std::numbers::pi * ray / rays;
        edges.push_back(
            wall_along(wall, middle, std::cos(angle) * right + std::sin(angle) * up, 2 * inscribed_mm + 1));
    }
    const double most = 1.3 * median(edges); // beyond it, a ray looks into a branch
    double squares = 0;
    for (const double edge : edges) squares += std::min(edge, most) * std::min(edge, most);
    return std::max(std::sqrt(squares / rays), inscribed_mm);
}

static void widen_to_sections(const bake::Mesh &lumen, centreline::Tree &tree)
{
    const bake::TriangleTree wall(lumen);
    std::vector<std::size_t> first;
    for (std::size_t i = 0; i < tree.branches.size(); ++i)
        first.push_back(std::max<std::size_t>(centreline::first_own_sphere(tree, i), 1));
    for (std::size_t i = 0; i < tree.branches.size(); ++i) {
        std::vector<centreline::Sphere> &spheres = tree.branches[i].spheres;
        for (std::size_t n = first[i]; n + 1 < spheres.size(); ++n) {
            const Vector3d along = (spheres[n + 1].centre_mm - spheres[n - 1].centre_mm).normalized();
            spheres[n].radius_mm = section_radius(wall, spheres[n].centre_mm, along, spheres[n].radius_mm);
        }
    }
}

centreline::Tree tree_of(const bake::Mesh &lumen, const LabelMap &labels, const Vector3d &root_mm,
                         Findings &findings)
{
    bake::Progress progress;
    centreline::LumenWish voxels;
    voxels.voxel_mm = 0.6; // two across an artery of 1.2 mm
    const centreline::Lumen inside(lumen, voxels, progress);
    centreline::AutoWish wish;
    wish.inlet_mm = inside_near(lumen, root_mm);
    wish.shortest_mm = 5.0;
    std::vector<std::string> notes;
    centreline::Tree tree = centreline::fit_automatic(inside, wish, notes, progress);
    widen_to_sections(lumen, tree);
    // Where a line touches the wall of a thin vessel, its sphere has no radius, which `bake` would refuse.
    for (centreline::Branch &branch : tree.branches)
        for (centreline::Sphere &sphere : branch.spheres)
            sphere.radius_mm = std::max(sphere.radius_mm, least_radius_mm);
    double all_mm = 0.0;
    for (const centreline::Branch &branch : tree.branches) all_mm += centreline::length_mm(branch);
    if (all_mm < 30.0)
        throw Fault(formatted(
            "the arteries' tree is only %.0f mm long: the label map does not connect the aorta from the "
            "heart on; segment again, or mend the map",
            all_mm));
    std::map<std::string, int> used;
    for (centreline::Branch &branch : tree.branches) {
        const std::string name = structure_of(branch, labels);
        const int number = ++used[name];
        branch.name = number > 1 ? name + "_" + std::to_string(number) : name;
    }
    for (const std::string &note : notes) findings.facts.push_back("centrelines: " + note);
    return tree;
}

void name_branches(centreline::Tree &tree, const std::vector<Click> &clicks)
{
    std::map<std::size_t, std::string> given; // by branch
    for (const Click &click : clicks) {
        if (click.kind != ClickKind::name) continue;
        std::size_t nearest = 0;
        double least_mm = INFINITY;
        for (std::size_t i = 0; i < tree.branches.size(); ++i) {
            const centreline::LinePlace place = centreline::line_place(tree.branches[i], click.at_mm);
            const double outside_mm = place.distance_mm - place.radius_mm;
            if (outside_mm < least_mm) nearest = i, least_mm = outside_mm;
        }
        for (const auto &[branch, name] : given)
            if (branch != nearest && name == click.branch)
                throw Fault(click.where + ": 'branch': another branch is named '" + click.branch +
                            "' by an earlier click: choose another name");
        given[nearest] = click.branch;
    }
    for (const auto &[branch, name] : given) {
        for (centreline::Branch &other : tree.branches)
            if (other.name == name) other.name = tree.branches[branch].name;
        tree.branches[branch].name = name;
    }
}

void describe_branches(const centreline::Tree &tree, Findings &findings)
{
    for (const centreline::Branch &branch : tree.branches)
        findings.facts.push_back(formatted("branch %s: %.0f mm long, radius %.1f to %.1f mm",
                                           branch.name.c_str(), centreline::length_mm(branch),
                                           branch.spheres.front().radius_mm,
                                           branch.spheres.back().radius_mm));
}

} // namespace crn::ct
