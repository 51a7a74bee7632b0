#include "tools/lab/ct/surface.hpp"
#include "host/base/pending_file.hpp"
#include "tools/mesh/level_set/level_set.hpp"
#include <Eigen/LU>
#include <utility>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

// Returns the value of the level set at a voxel. Everything beyond the volume's border counts as outside, so
// a surface that reaches the border is closed there. A level-set value of exactly 0 counts as outside.
double level_at(const Volume &level, const mesh::Cell &at)
{
    if (!level.holds(at[0], at[1], at[2])) return 1;
    const double here = static_cast<double>(level.hu[level.at(at[0], at[1], at[2])]);
    return here == 0 ? 1e-6 : here;
}

// Returns whether the surface crosses the block of voxels or its border.
bool is_crossed(const Volume &level, const mesh::Cell &low)
{
    int inside = 0;
    constexpr int edge = mesh::block_edge;
    for (int k = -1; k <= edge; ++k)
        for (int j = -1; j <= edge; ++j)
            for (int i = -1; i <= edge; ++i)
                inside += level_at(level, {low[0] + i, low[1] + j, low[2] + k}) < 0;
    return inside > 0 && inside < (edge + 2) * (edge + 2) * (edge + 2);
}

mesh::Block block_of(const Volume &level, const mesh::Cell &low)
{
    constexpr int edge = mesh::block_edge;
    mesh::Block block;
    for (int n = 0; n < static_cast<int>(block.size()); ++n)
        block[static_cast<std::size_t>(n)] =
            level_at(level, {low[0] + n % edge, low[1] + n / edge % edge, low[2] + n / edge / edge});
    return block;
}

} // namespace

bake::Mesh surface_of(const Volume &level, const std::string &name)
{
    constexpr int edge = mesh::block_edge;
    mesh::LevelSet set(1, 1); // in voxels, which need not be cubes
    // The blocks of voxels extend one voxel beyond the volume on each side.
    for (int k = -1; k * edge <= level.size[2]; ++k)
        for (int j = -1; j * edge <= level.size[1]; ++j)
            for (int i = -1; i * edge <= level.size[0]; ++i) {
                const mesh::Cell low = {edge * i, edge * j, edge * k};
                if (is_crossed(level, low)) set.set({i, j, k}, block_of(level, low));
            }
    set.fill_signs();
    const mesh::QuadSurface surface = set.surface();
    bake::Mesh mesh{name, surface.vertices, mesh::divided(surface), {}};
    mesh::separate_sheets(mesh.vertices_mm, mesh.triangles);
    for (Vector3d &vertex : mesh.vertices_mm) vertex = level.scene(vertex);
    if (level.scene_per_voxel().determinant() < 0) // the grid is left-handed
        for (bake::Triangle &t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

void write_surface(const bake::Mesh &mesh, const std::vector<float> &unsure_mm,
                   const std::filesystem::path &file)
{
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\ncomment by Cournand's ct, millimetres, +x left +y head +z "
        "front\nelement vertex " +
        std::to_string(mesh.vertices_mm.size()) +
        "\nproperty float x\nproperty float y\nproperty float z\nproperty float unsure_mm\nelement face " +
        std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
    for (std::size_t i = 0; i < mesh.vertices_mm.size(); ++i) {
        const float values[4] = {
            static_cast<float>(mesh.vertices_mm[i].x()), static_cast<float>(mesh.vertices_mm[i].y()),
            static_cast<float>(mesh.vertices_mm[i].z()), i < unsure_mm.size() ? unsure_mm[i] : 0.0f};
        bytes.append(reinterpret_cast<const char *>(values), sizeof values);
    }
    for (const bake::Triangle &triangle : mesh.triangles) {
        bytes += '\3';
        bytes.append(reinterpret_cast<const char *>(triangle.data()), sizeof triangle);
    }
    write_whole_file(file.string(), bytes);
}

} // namespace crn::ct
