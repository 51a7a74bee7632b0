#include "tools/lab/ct/surface.hpp"
#include "host/base/pending_file.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <unordered_map>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

// A cube is divided into six tetrahedra around its diagonal from corner 0 to corner 7 (bit 0: i, 1: j, 2: k).
// Neighbours share faces.
constexpr int tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                  {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
// Vertices keep this distance from the voxels' middles, so that no triangle has almost no area.
constexpr double nearest_share = 0.02;

class Marching
{
  public:
    explicit Marching(const Volume &level) : level_(level) {}

    bake::Mesh run()
    {
        // A layer of outside voxels around the volume closes the surface at the volume's border.
        for (int k = -1; k < level_.size[2]; ++k)
            for (int j = -1; j < level_.size[1]; ++j)
                for (int i = -1; i < level_.size[0]; ++i) cube(i, j, k);
        return std::move(mesh_);
    }

  private:
    struct Corner {
        int i, j, k;
        double value;
        std::uint64_t key;
    };

    double value(int i, int j, int k) const
    {
        if (!level_.holds(i, j, k)) return 1;
        const double here = static_cast<double>(level_.hu[level_.at(i, j, k)]);
        return here == 0 ? 1e-6 : here;
    }

    void cube(int i, int j, int k)
    {
        Corner corners[8];
        int inside = 0;
        for (int c = 0; c < 8; ++c) {
            const int x = i + (c & 1), y = j + (c >> 1 & 1), z = k + (c >> 2 & 1);
            corners[c] = {x, y, z, value(x, y, z), 0};
            inside += corners[c].value < 0;
        }
        if (inside == 0 || inside == 8) return;
        for (Corner &corner : corners)
            corner.key =
                (static_cast<std::uint64_t>(corner.k + 1) * static_cast<std::uint64_t>(level_.size[1] + 2) +
                 static_cast<std::uint64_t>(corner.j + 1)) *
                    static_cast<std::uint64_t>(level_.size[0] + 2) +
                static_cast<std::uint64_t>(corner.i + 1);
        for (const auto &t : tetrahedra)
            tetrahedron({&corners[t[0]], &corners[t[1]], &corners[t[2]], &corners[t[3]]});
    }

    void tetrahedron(std::array<const Corner *, 4> c)
    {
        std::stable_partition(c.begin(), c.end(), [](const Corner *corner) { return corner->value < 0; });
        const auto inside =
            std::count_if(c.begin(), c.end(), [](const Corner *corner) { return corner->value < 0; });
        if (inside == 0 || inside == 4) return;
        if (inside == 1) {
            triangle(on(c[0], c[1]), on(c[0], c[2]), on(c[0], c[3]), *c[0]);
        } else if (inside == 3) {
            triangle(on(c[0], c[3]), on(c[1], c[3]), on(c[2], c[3]), *c[0]);
        } else {
            const std::uint32_t a = on(c[0], c[2]), b = on(c[0], c[3]), d = on(c[1], c[2]),
                                e = on(c[1], c[3]);
            triangle(a, b, e, *c[0]);
            triangle(a, e, d, *c[0]);
        }
    }

    std::uint32_t on(const Corner *in, const Corner *out)
    {
        const std::uint64_t low = std::min(in->key, out->key), high = std::max(in->key, out->key);
        const auto [found, is_new] = vertices_.try_emplace(
            low << 32 | (high - low), static_cast<std::uint32_t>(mesh_.vertices_mm.size()));
        if (is_new) {
            const double share =
                std::clamp(in->value / (in->value - out->value), nearest_share, 1 - nearest_share);
            const Vector3d from(in->i, in->j, in->k), to(out->i, out->j, out->k);
            mesh_.vertices_mm.push_back(level_.scene(from + share * (to - from)));
        }
        return found->second;
    }

    // The corners are ordered so that the triangle's normal points away from a corner inside.
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Corner &in)
    {
        const Vector3d &p = mesh_.vertices_mm[a], &q = mesh_.vertices_mm[b], &r = mesh_.vertices_mm[c];
        const bool looks_in = (q - p).cross(r - p).dot(level_.scene(Vector3d(in.i, in.j, in.k)) - p) > 0;
        mesh_.triangles.push_back(looks_in ? bake::Triangle{a, c, b} : bake::Triangle{a, b, c});
    }

    const Volume &level_;
    bake::Mesh mesh_;
    std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
};

} // namespace

bake::Mesh surface_of(const Volume &level, const std::string &name)
{
    bake::Mesh mesh = Marching(level).run();
    mesh.name = name;
    return mesh;
}

void keep_large_pieces(bake::Mesh &mesh, double share)
{
    std::vector<std::uint32_t> parent(mesh.vertices_mm.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const bake::Triangle &t : mesh.triangles)
        for (std::size_t i = 1; i < 3; ++i) parent[root(t[i])] = root(t[0]);
    std::map<std::uint32_t, std::size_t> sizes;
    for (const bake::Triangle &t : mesh.triangles) ++sizes[root(t[0])];
    std::size_t largest = 0;
    for (const auto &[piece, size] : sizes) largest = std::max(largest, size);
    std::erase_if(mesh.triangles, [&](const bake::Triangle &t) {
        return static_cast<double>(sizes[root(t[0])]) < share * static_cast<double>(largest);
    });
    std::vector<std::uint32_t> index(mesh.vertices_mm.size(), ~0u);
    std::vector<Vector3d> kept;
    for (bake::Triangle &t : mesh.triangles)
        for (std::uint32_t &v : t) {
            if (index[v] == ~0u) {
                index[v] = static_cast<std::uint32_t>(kept.size());
                kept.push_back(mesh.vertices_mm[v]);
            }
            v = index[v];
        }
    mesh.vertices_mm = kept;
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
