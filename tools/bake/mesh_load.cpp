// Converts a mesh to the patient's coordinates, merges equal vertices, and writes the mesh. The file
// mesh_file.cpp reads meshes.
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/mesh/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace crn::bake
{
namespace
{

// Adds one part of the mesh file to the mesh, in the patient's coordinates.
void append(const MeshPiece &piece, const MeshText &text, Mesh &mesh)
{
    const double unit_mm = millimetres_per(text.placement.unit);
    const auto base = static_cast<std::uint32_t>(mesh.vertices_mm.size());
    for (const auto &v : piece.vertices)
        mesh.vertices_mm.push_back(text.placement.place({v[0], v[1], v[2]}, unit_mm));
    for (const auto &t : piece.triangles) mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

// Keeps only those connected pieces of the mesh that the scene's text selects.
void keep_pieces(Mesh &mesh, const MeshText &text)
{
    const std::vector<std::uint32_t> piece = mesh::pieces_of(mesh.vertices_mm.size(), mesh.triangles);
    std::vector<Eigen::AlignedBox3d> boxes(piece.size());
    for (std::uint32_t v = 0; v < piece.size(); ++v) boxes[piece[v]].extend(mesh.vertices_mm[v]);
    std::erase_if(mesh.triangles, [&](const Triangle &t) {
        const Eigen::AlignedBox3d &box = boxes[piece[t[0]]];
        return box.diagonal().norm() < text.pieces_min_mm ||
               (!text.pieces_mm.isEmpty() && !text.pieces_mm.contains(box.center()));
    });
    if (!mesh.triangles.empty()) return;
    std::string list;
    for (std::uint32_t v = 0; v < piece.size() && list.size() < 600; ++v)
        if (piece[v] == v) list += (list.empty() ? "" : ", ") + place_text(boxes[v].center());
    throw Fault(mesh.name + ": no piece is left by pieces_mm and pieces_min_mm: they lie at " + list);
}

} // namespace

std::string place_text(const Eigen::Vector3d &p_mm)
{
    const auto plain = [](double mm) { return std::abs(mm) < 0.05 ? 0.0 : mm; }; // avoids printing "-0.0"
    return formatted("(%.1f, %.1f, %.1f) mm", plain(p_mm.x()), plain(p_mm.y()), plain(p_mm.z()));
}

Mesh load_mesh(const MeshText &text)
{
    Mesh mesh;
    mesh.name = text.file.string();
    std::uint64_t other = 0;
    for (const MeshPiece &piece : read_mesh_file(text.file, text.parts)) {
        append(piece, text, mesh);
        other += piece.other;
    }
    if (other > 0) mesh.notes.push_back(std::to_string(other) + " points or lines left out");
    if (mesh.triangles.empty())
        throw Fault(mesh.name + ": holds no triangle: export the surface, not points or lines");
    check_extent(mesh, text.placement.unit);
    weld(mesh);
    if (!text.pieces_mm.isEmpty() || text.pieces_min_mm > 0) {
        keep_pieces(mesh, text);
        mesh::drop_unused(mesh.vertices_mm, mesh.triangles);
    }
    return mesh;
}

void check_extent(const Mesh &mesh, const std::string &unit)
{
    Eigen::Vector3d low = mesh.vertices_mm[0], high = low;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
    }
    const double extent_mm = (high - low).maxCoeff();
    const double reach_mm = std::max(high.cwiseAbs().maxCoeff(), low.cwiseAbs().maxCoeff());
    if (extent_mm < mesh_extent_min_mm || extent_mm > mesh_extent_max_mm) {
        std::string other;
        for (const char *guess : {"m", "cm", "mm", "um"}) {
            const double guessed_mm = extent_mm / millimetres_per(unit) * millimetres_per(guess);
            if (guessed_mm >= 20 && guessed_mm <= 2500)
                other += std::string(other.empty() ? "" : " or ") + "'" + guess + "'";
        }
        const std::string size = formatted("%.4g mm", extent_mm);
        throw Fault(mesh.name + ": is " + size + " long with unit '" + unit +
                    "', a patient's parts are 5 mm to 3 m: " +
                    (other.empty() ? "check unit and scale" : "did you mean unit " + other + "?"));
    }
    if (reach_mm > 1900)
        throw Fault(mesh.name + ": lies farther than 1.9 m from the origin: move it with offset_mm");
}

void weld(Mesh &mesh)
{
    std::vector<std::uint32_t> order(mesh.vertices_mm.size()), same(mesh.vertices_mm.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto &v = mesh.vertices_mm;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        for (int k = 0; k < 3; ++k)
            if (v[a][k] != v[b][k]) return v[a][k] < v[b][k];
        return a < b;
    });
    std::vector<std::uint32_t> first(mesh.vertices_mm.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && v[order[i]] == v[order[i - 1]] ? first[order[i - 1]] : order[i];
    std::vector<Eigen::Vector3d> kept;
    for (std::uint32_t i = 0; i < first.size(); ++i) {
        if (first[i] != i) continue;
        same[i] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(v[i]);
    }
    std::vector<Triangle> triangles;
    for (const Triangle &t : mesh.triangles) {
        const Triangle welded = {same[first[t[0]]], same[first[t[1]]], same[first[t[2]]]};
        if (welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0]) continue;
        triangles.push_back(welded);
    }
    const std::size_t dropped = mesh.triangles.size() - triangles.size();
    if (dropped > 0)
        mesh.notes.push_back(std::to_string(dropped) + " triangles with two equal corners left out");
    mesh.vertices_mm = std::move(kept);
    mesh.triangles = std::move(triangles);
    if (mesh.triangles.empty())
        throw Fault(mesh.name + ": every triangle has two equal corners: export it again");
}

void write_ply(const Mesh &mesh, const std::filesystem::path &file)
{
    std::ostringstream out;
    out << "ply\nformat binary_little_endian 1.0\ncomment unit mm, patient frame\nelement vertex "
        << mesh.vertices_mm.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << mesh.triangles.size()
        << "\nproperty list uchar uint vertex_indices\nend_header\n";
    for (const Eigen::Vector3d &v : mesh.vertices_mm) out.write(reinterpret_cast<const char *>(v.data()), 24);
    for (const Triangle &t : mesh.triangles) {
        out.put(3);
        out.write(reinterpret_cast<const char *>(t.data()), 12);
    }
    write_whole_file(file.string(), out.str());
}

} // namespace crn::bake
