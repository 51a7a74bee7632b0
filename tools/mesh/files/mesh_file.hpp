// Reads a mesh file in three steps, because its content may be wrong or malicious. First, the numbers of
// vertices and faces that the file declares are compared with the file's size. Then the library assimp reads
// the file in a child process with limited memory and time (host/base/guarded_read.hpp). Finally, the
// functions of this header check every index and number that assimp returns.
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

// Holds one named part of a mesh file, in the file's axes and unit.
struct MeshPiece {
    std::string name;
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint64_t other = 0; // the number of faces that are points or lines
};

// Reads a mesh file and returns those of its parts that `parts` names ("name" or "begin*"); an empty list
// selects all parts. Throws a Fault that states the cause, the position in the file and the remedy.
std::vector<MeshPiece> read_mesh_file(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);
// Reads a mesh file like read_mesh_file, but in the calling process; the child process of read_mesh_file runs
// this function.
std::vector<MeshPiece> read_mesh_here(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts);

// Checks that the coordinates of every vertex are finite and that the corners of every triangle exist. Throws
// a Fault that names the file, the part, and the wrong vertex or face.
void check_pieces(const std::vector<MeshPiece> &pieces, const std::string &file);

// Holds the numbers of vertices and faces that a mesh file declares; a number is -1 if the file's format does
// not declare it.
struct Declared {
    std::int64_t vertices = -1, faces = -1;
};

// Each of the next functions reads a whole mesh file strictly. The strict reading checks that the declared
// counts fit the file's size, that indices name existing vertices, and that numbers can be parsed. Throws
// Fault. `folder` is the folder with the other files to which a .gltf file refers.
Declared check_ply(std::string_view bytes, const std::string &file);
// The library assimp takes line ends behind the header of a PLY file for a part of it, though they are the
// first bytes of binary data. In `changed`, the first byte is another one; `x` is the number that it belongs
// to. `changed` is empty for other files.
struct PlyStart {
    std::string changed;
    double x = 0;
};
PlyStart ply_start(std::string_view bytes, const std::string &file);
Declared check_stl(std::string_view bytes, const std::string &file);
Declared check_obj(std::string_view bytes, const std::string &file);
Declared check_gltf(std::string_view bytes, const std::string &file, const std::filesystem::path &folder);
// Chooses one of the checks above by the extension of the file's name, which must be in lower case.
Declared check_mesh_bytes(std::string_view bytes, const std::string &file, const std::string &ending,
                          const std::filesystem::path &folder);

} // namespace crn::bake
