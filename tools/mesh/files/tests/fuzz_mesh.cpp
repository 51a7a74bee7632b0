// This fuzz target reads arbitrary bytes as a mesh file. The target tests the strict checks of a mesh file
// that precede assimp, and the check of the mesh that assimp returns. The first byte selects the file format.
// The program tools/importers tests assimp itself, with whole sets of files in a child process.
#include "tools/mesh/fault.hpp"
#include "tools/mesh/files/mesh_file.hpp"
#include <algorithm>
#include <cstdlib>
#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

using namespace crn::bake;

const char *const endings[] = {".ply", ".stl", ".obj", ".gltf"};

const char *const texts[] = {
    "\0ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double "
    "z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "\0ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nelement face 1\n"
    "property list uchar uchar edges\nend_header\nA\2\1\1",
    "\1solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 "
    "0\nendloop\nendfacet\nendsolid a\n",
    "\2o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 \\\n3/1\nf -1 -2 -3\n",
    "\3{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"children\":[1]}"
    ",{}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}"
    "],"
    "\"buffers\":[{\"byteLength\":12,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAA\"}]}"};

// Builds vertices and triangles, which consist of three numbers each, from arbitrary bytes.
void offer_pieces(const std::uint8_t *bytes, std::size_t count)
{
    std::vector<MeshPiece> pieces(1 + count % 3);
    for (std::size_t at = 0; at + 13 <= count; at += 13) {
        MeshPiece &piece = pieces[bytes[at] % pieces.size()];
        if (bytes[at] & 64)
            std::memcpy(&piece.vertices.emplace_back(), bytes + at + 1, 12);
        else
            std::memcpy(&piece.triangles.emplace_back(), bytes + at + 1, 12);
    }
    try {
        check_pieces(pieces, "fuzz");
    } catch (const crn::Fault &) {
        return;
    }
    for (const MeshPiece &piece : pieces)
        for (const auto &triangle : piece.triangles)
            for (const std::uint32_t corner : triangle)
                if (corner >= piece.vertices.size()) std::abort();
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    if (count == 0) return 0;
    const std::vector<char> exact(bytes + 1,
                                  bytes + count); // an exact copy, so that a read past its end is detected
    try {
        const Declared declared =
            check_mesh_bytes({exact.data(), exact.size()}, "fuzz", endings[bytes[0] % 4], "/nonexistent");
        // A mesh file that is accepted cannot declare more vertices or faces than it has bytes.
        if (declared.vertices > static_cast<std::int64_t>(count) ||
            declared.faces > static_cast<std::int64_t>(count))
            std::abort();
    } catch (const crn::Fault &fault) {
        if (std::strncmp(fault.what(), "fuzz:", 5) != 0) std::abort();
    }
    offer_pieces(bytes + 1, count - 1);
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    if (index >= std::size(texts)) return 0;
    const std::size_t count = 1 + std::strlen(texts[index] + 1);
    if (count > capacity) return 0;
    std::memcpy(bytes, texts[index], count);
    return count;
}
