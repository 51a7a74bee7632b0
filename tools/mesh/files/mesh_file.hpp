// A mesh file as plain data: what it declares is held against its size, assimp reads it in a child process
// with limits (host/base/guarded_read.hpp), and every index and number that comes back is checked here.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace crn::bake
{

constexpr std::size_t mesh_file_bytes_max = std::size_t{1} << 30;
constexpr std::size_t mesh_triangles_max = 4'000'000;
constexpr std::size_t mesh_vertices_max = 3 * mesh_triangles_max;
constexpr std::size_t mesh_pieces_max = 100'000; // parts as the file's nodes give them

// One named part of a file, in the file's axes and unit.
struct MeshPiece {
    std::string name;
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint64_t other = 0; // faces that are points or lines
};

// The parts that `parts` names ("name" or "begin*"; empty: all). Throws Fault: what, where, what to do.
std::vector<MeshPiece> read_mesh_file(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);
// The same in this process: what the child does.
std::vector<MeshPiece> read_mesh_here(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);

// Every vertex is finite, every triangle's corners are there. Throws Fault naming file, part, vertex or face.
void check_pieces(const std::vector<MeshPiece> &pieces, const std::string &file);

// What a file says of itself, as far as its format says it; -1: it does not.
struct Declared {
    std::int64_t vertices = -1, faces = -1;
};

// A strict reading of the whole file: counts fit its size, indices name vertices that are there, numbers are
// numbers. Throws Fault. `folder` is where a .gltf's other files are.
Declared check_ply(std::string_view bytes, const std::string &file);
Declared check_stl(std::string_view bytes, const std::string &file);
Declared check_obj(std::string_view bytes, const std::string &file);
Declared check_gltf(std::string_view bytes, const std::string &file, const std::filesystem::path &folder);
// By the ending of the name, in small letters.
Declared check_mesh_bytes(std::string_view bytes, const std::string &file, const std::string &ending,
                          const std::filesystem::path &folder);

} // namespace crn::bake
