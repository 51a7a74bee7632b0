// A mesh file is read as plain data. First the file's declared counts are checked against its size. Then
// assimp reads the file in a child process with limits (host/base/guarded_read.hpp). Finally every index and
// number that assimp returns is checked here.
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

// Holds one named part of a file, in the file's axes and unit.
struct MeshPiece {
    std::string name;
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint64_t other = 0; // the number of faces that are points or lines
};

// Returns those parts of the file that `parts` names ("name" or "begin*"); an empty list selects all. Throws
// Fault with the cause, the place and the remedy.
std::vector<MeshPiece> read_mesh_file(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);
// Does the same work as read_mesh_file, but in the calling process; the child process runs this function.
std::vector<MeshPiece> read_mesh_here(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);

// Checks that every vertex is finite and that every triangle's corners exist. Throws Fault naming file, part,
// vertex or face.
void check_pieces(const std::vector<MeshPiece> &pieces, const std::string &file);

// Holds the counts that a file declares about itself; -1 if its format does not state them.
struct Declared {
    std::int64_t vertices = -1, faces = -1;
};

// Each check reads the whole file strictly: counts fit its size, indices name existing vertices, and numbers
// can be parsed. Throws Fault. `folder` holds the other files of a .gltf.
Declared check_ply(std::string_view bytes, const std::string &file);
Declared check_stl(std::string_view bytes, const std::string &file);
Declared check_obj(std::string_view bytes, const std::string &file);
Declared check_gltf(std::string_view bytes, const std::string &file, const std::filesystem::path &folder);
// Chooses the check by the extension of the name, which must be in lower case.
Declared check_mesh_bytes(std::string_view bytes, const std::string &file, const std::string &ending,
                          const std::filesystem::path &folder);

} // namespace crn::bake
