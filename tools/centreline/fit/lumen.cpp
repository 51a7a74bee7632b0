// Closes or remakes the mesh of a vessel, and distinguishes openings from walls.
#include "tools/centreline/fit/lumen.hpp"
#include "host/base/format.hpp"
#include "tools/bake/solid.hpp"

#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr double voxels_wanted = 3e5, voxel_min_mm = 0.15, voxel_max_mm = 1.0;

double chosen_voxel_mm(double wished_mm, const bake::Mesh &closed)
{
    if (wished_mm > 0) return wished_mm;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : closed.vertices_mm) box.extend(v);
    const double inside = std::abs(bake::volume_mm3(closed)) / voxels_wanted,
                 around = box.volume() / (0.8 * bake::solid_voxels_max);
    return std::clamp(std::cbrt(std::max(inside, around)), voxel_min_mm, voxel_max_mm);
}

// When an opening is capped, one vertex is appended to the list of the mesh's vertices, and a fan of
// triangles around this vertex closes the opening.
std::vector<Opening> openings_of(const bake::Mesh &capped, std::size_t own_vertices,
                                 std::size_t own_triangles)
{
    std::vector<Opening> openings;
    std::vector<std::size_t> rim;
    for (std::size_t v = own_vertices; v < capped.vertices_mm.size(); ++v)
        openings.push_back({capped.vertices_mm[v], 0});
    rim.assign(openings.size(), 0);
    for (std::size_t t = own_triangles; t < capped.triangles.size(); ++t) {
        const bake::Triangle &fan = capped.triangles[t];
        for (std::uint32_t centre : fan) {
            if (centre < own_vertices) continue;
            Opening &opening = openings[centre - own_vertices];
            for (std::uint32_t v : fan)
                if (v != centre) {
                    opening.radius_mm += (capped.vertices_mm[v] - opening.centre_mm).norm();
                    ++rim[centre - own_vertices];
                }
        }
    }
    for (std::size_t i = 0; i < openings.size(); ++i)
        openings[i].radius_mm /= static_cast<double>(std::max<std::size_t>(rim[i], 1));
    return openings;
}

} // namespace

Lumen::Lumen(bake::Mesh mesh, const LumenWish &wish, bake::Progress &progress)
{
    const bake::Mesh raw = mesh;
    bake::Mesh closed = std::move(mesh);
    bool is_remade = false;
    try {
        bake::check_closed(closed, wish.cap);
    } catch (const Fault &fault) {
        if (wish.cap != bake::Cap::any) throw;
        // A mesh that does not bound a body may do so after it has been remade from a level set.
        closed = raw;
        bake::cap_openings(closed, bake::Cap::any);
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d &v : closed.vertices_mm) box.extend(v);
        const double voxel_mm =
            wish.voxel_mm > 0 ? wish.voxel_mm : std::clamp(box.diagonal().norm() / 800, 0.2, 0.6);
        const double before_mm3 = std::abs(bake::volume_mm3(closed));
        progress.stage("making the surface anew", 0);
        bake::Mesh made;
        try {
            made = bake::offset_surface(closed, voxel_mm, 0);
        } catch (const Fault &) {
            throw fault; // the fault of the mesh says more than that of its level set
        }
        // If a hole of the mesh was not capped, the level set has no inside, and only a thin shell remains.
        if (bake::volume_mm3(made) < 0.5 * before_mm3) throw;
        notes_.push_back(std::string(fault.what()));
        const std::string text =
            formatted("made the surface anew from a level set of %.2f mm instead", voxel_mm);
        notes_.push_back(text);
        closed = std::move(made);
        is_remade = true;
    }
    notes_.insert(notes_.end(), closed.notes.begin(), closed.notes.end());
    wall_ = closed;
    if (!is_remade) {
        openings_ = openings_of(closed, raw.vertices_mm.size(), raw.triangles.size());
        wall_.triangles.resize(raw.triangles.size());
    }
    tree_ = std::make_unique<bake::TriangleTree>(wall_);
    if (!wish.with_voxels) return;
    progress.stage("measuring the inside", 0);
    voxels_ = std::make_unique<Voxels>(closed, chosen_voxel_mm(wish.voxel_mm, closed));
    // If an opening's radius is less than half the radius of the adjacent vessel, the opening is a crack in
    // the wall and not the end of a vessel.
    std::erase_if(openings_, [&](const Opening &opening) {
        long voxel = -1;
        for (double reach = 2 * voxels_->voxel_mm(); voxel < 0 && reach < 10; reach *= 2)
            voxel = voxels_->nearest(opening.centre_mm, reach);
        return voxel < 0 ||
               opening.radius_mm <
                   0.5 * voxels_->depth_mm(voxels_->middle_near(static_cast<std::size_t>(voxel)));
    });
    progress.finish();
}

double Lumen::radius_mm(const Eigen::Vector3d &p_mm, double bound_mm) const
{
    return std::abs(tree_->nearest(p_mm, bound_mm).distance_mm);
}

} // namespace crn::centreline
