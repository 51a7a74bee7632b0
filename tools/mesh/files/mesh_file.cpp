// Reads a mesh file with the library assimp in a child process, and checks the mesh that assimp returns.
#include "tools/mesh/files/mesh_file.hpp"
#include "host/base/guarded_read.hpp"
#include "tools/mesh/fault.hpp"

#include <algorithm>
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <cctype>
#include <cmath>
#include <fcntl.h>
#include <memory>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace crn::bake
{
namespace
{

// For each face in a file, assimp makes an object with its own list of corners, so assimp needs tens of times
// as many bytes as the file has.
constexpr double growth = 64;

std::string ending_of(const std::filesystem::path &file)
{
    std::string ending = file.extension().string();
    for (char &c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending;
}

void check_name_and_size(const std::filesystem::path &file)
{
    const std::string ending = ending_of(file);
    if (ending != ".stl" && ending != ".obj" && ending != ".ply" && ending != ".gltf" && ending != ".glb")
        throw Fault(file.string() +
                    ": is no .stl, .obj, .ply, .gltf or .glb file: export the mesh as one of these");
    std::error_code error;
    const auto bytes = std::filesystem::file_size(file, error);
    if (error) throw Fault(file.string() + ": cannot be read: " + error.message());
    if (!std::filesystem::is_regular_file(file, error))
        throw Fault(file.string() + ": cannot be read: is no file");
    if (bytes == 0) throw Fault(file.string() + ": is empty: export the mesh again");
    if (bytes > mesh_file_bytes_max)
        throw Fault(file.string() + ": " + std::to_string(bytes >> 20) + " MiB, over " +
                    std::to_string(mesh_file_bytes_max >> 20) +
                    " MiB: simplify the mesh, or give it in binary");
}

// Maps a file into memory for the lifetime of this object.
class Mapped
{
  public:
    explicit Mapped(const std::string &file)
    {
        const int handle = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
        struct stat info {
        };
        if (handle >= 0 && ::fstat(handle, &info) == 0 && info.st_size > 0) {
            count_ = static_cast<std::size_t>(info.st_size);
            begin_ = ::mmap(nullptr, count_, PROT_READ, MAP_PRIVATE, handle, 0);
        }
        if (handle >= 0) ::close(handle);
        if (begin_ == MAP_FAILED) throw Fault(file + ": cannot be read: check the file's permissions");
    }
    ~Mapped() { ::munmap(begin_, count_); }
    Mapped(const Mapped &) = delete;
    Mapped &operator=(const Mapped &) = delete;
    std::string_view bytes() const { return {static_cast<const char *>(begin_), count_}; }

  private:
    void *begin_ = MAP_FAILED;
    std::size_t count_ = 0;
};

// Holds one mesh of the file's node hierarchy, and the transformation from the mesh's coordinates to the
// file's coordinates.
struct Part {
    std::string name;
    const aiMesh *mesh;
    aiMatrix4x4 to_file;
};

void collect(const aiScene &scene, const aiNode &node, const aiMatrix4x4 &above, std::vector<Part> &parts)
{
    const aiMatrix4x4 here = above * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
        if (node.mMeshes[i] < scene.mNumMeshes)
            parts.push_back({node.mName.C_Str(), scene.mMeshes[node.mMeshes[i]], here});
    for (unsigned i = 0; i < node.mNumChildren; ++i) collect(scene, *node.mChildren[i], here, parts);
}

bool matches(const std::string &name, const std::string &wanted)
{
    if (wanted.back() != '*') return name == wanted;
    return name.compare(0, wanted.size() - 1, wanted, 0, wanted.size() - 1) == 0;
}

std::vector<Part> chosen(const std::vector<Part> &parts, const std::vector<std::string> &names,
                         const std::string &file)
{
    if (names.empty()) return parts;
    std::vector<Part> found;
    for (const std::string &wanted : names) {
        const std::size_t before = found.size();
        for (const Part &part : parts)
            if (matches(part.name, wanted)) found.push_back(part);
        if (found.size() > before) continue;
        std::string list;
        for (const Part &part : parts) list += (list.empty() ? "" : ", ") + part.name;
        throw Fault(file + ": has no part '" + wanted + "': its parts are " + list.substr(0, 4000));
    }
    return found;
}

// Checks the vertex indices of all faces before assimp uses these indices in later processing steps.
void check_faces(const aiScene &scene, const std::string &file)
{
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh &mesh = *scene.mMeshes[m];
        for (unsigned f = 0; f < mesh.mNumFaces; ++f)
            for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k)
                if (mesh.mFaces[f].mIndices[k] >= mesh.mNumVertices)
                    throw Fault(file + ": face " + std::to_string(f) + " of mesh " + std::to_string(m) +
                                " has vertex " + std::to_string(mesh.mFaces[f].mIndices[k]) +
                                ", but there are " + std::to_string(mesh.mNumVertices) +
                                " (numbered from 0): export the mesh again");
    }
}

// Checks that assimp has read as many faces and vertices as the file declares.
void check_declared(const aiScene &scene, const Declared &declared, const std::string &file)
{
    std::int64_t faces = 0, vertices = 0;
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh &mesh = *scene.mMeshes[m];
        // assimp represents the lines and points of an OBJ file as faces of fewer than three corners.
        faces += std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                               [](const aiFace &face) { return face.mNumIndices >= 3; });
        vertices += mesh.mNumVertices;
    }
    if ((declared.faces >= 0 && faces != declared.faces) ||
        (declared.vertices >= 0 && vertices < declared.vertices))
        throw Fault(
            file + ": cannot be read: it has " + std::to_string(declared.faces) + " faces" +
            (declared.vertices >= 0 ? " and " + std::to_string(declared.vertices) + " vertices" : "") +
            ", of which its reader understands " + std::to_string(faces) +
            (declared.vertices >= 0 ? " and " + std::to_string(vertices) : "") + ": export the mesh again");
}

MeshPiece piece_of(const Part &part)
{
    MeshPiece piece;
    piece.name = part.name;
    piece.vertices.reserve(part.mesh->mNumVertices);
    for (unsigned i = 0; i < part.mesh->mNumVertices; ++i) {
        const aiVector3D v = part.to_file * part.mesh->mVertices[i];
        piece.vertices.push_back({v.x, v.y, v.z});
    }
    piece.triangles.reserve(part.mesh->mNumFaces);
    for (unsigned i = 0; i < part.mesh->mNumFaces; ++i) {
        const aiFace &face = part.mesh->mFaces[i];
        if (face.mNumIndices == 3)
            piece.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
        else
            ++piece.other;
    }
    return piece;
}

void send(Outbox &out, const std::vector<MeshPiece> &pieces)
{
    out.value<std::uint64_t>(pieces.size());
    for (const MeshPiece &piece : pieces) {
        out.text(piece.name);
        out.list(piece.vertices);
        out.list(piece.triangles);
        out.value(piece.other);
    }
}

std::vector<MeshPiece> receive(Inbox &in)
{
    std::vector<MeshPiece> pieces(in.size(mesh_pieces_max));
    std::uint64_t vertices = 0, triangles = 0;
    for (MeshPiece &piece : pieces) {
        piece.name = in.text(1 << 16);
        piece.vertices = in.list<std::array<float, 3>>(mesh_vertices_max - vertices);
        piece.triangles = in.list<std::array<std::uint32_t, 3>>(mesh_triangles_max - triangles);
        piece.other = in.value<std::uint64_t>();
        vertices += piece.vertices.size(), triangles += piece.triangles.size();
    }
    return pieces;
}

} // namespace

std::vector<MeshPiece> read_mesh_here(const std::filesystem::path &path,
                                      const std::vector<std::string> &names)
{
    const std::string file = path.string();
    Declared declared;
    PlyStart start;
    {
        const Mapped mapped(file);
        declared = check_mesh_bytes(mapped.bytes(), file, ending_of(path), path.parent_path());
        if (ending_of(path) == ".ply") start = ply_start(mapped.bytes(), file);
    }
    if (declared.faces > static_cast<std::int64_t>(mesh_triangles_max))
        throw Fault(file + ": " + std::to_string(declared.faces) + " triangles, over " +
                    std::to_string(mesh_triangles_max) + ": simplify the mesh");
    Assimp::Importer importer;
    const std::string &changed = start.changed;
    const aiScene *scene = changed.empty()
                               ? importer.ReadFile(file, 0)
                               : importer.ReadFileFromMemory(changed.data(), changed.size(), 0, "ply");
    if (!scene) throw Fault(file + ": cannot be read as STL, OBJ, PLY or glTF: " + importer.GetErrorString());
    check_faces(*scene, file);
    check_declared(*scene, declared, file);
    // The code runs only those processing steps of assimp that change no vertex. This project's own code
    // merges equal vertices, so that every file format gives the same result.
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    if (!scene || !scene->mRootNode) throw Fault(file + ": cannot be made of triangles: export triangles");
    std::vector<Part> parts;
    collect(*scene, *scene->mRootNode, aiMatrix4x4(), parts);
    parts = chosen(parts, names, file);
    std::size_t triangles = 0, vertices = 0;
    for (const Part &part : parts) triangles += part.mesh->mNumFaces, vertices += part.mesh->mNumVertices;
    if (triangles > mesh_triangles_max || vertices > mesh_vertices_max || parts.size() > mesh_pieces_max)
        throw Fault(file + ": " + std::to_string(triangles) + " triangles, over " +
                    std::to_string(mesh_triangles_max) + ": simplify the mesh");
    std::vector<MeshPiece> pieces;
    for (const Part &part : parts) pieces.push_back(piece_of(part));
    if (!changed.empty() && !pieces.empty() && !pieces[0].vertices.empty())
        pieces[0].vertices[0][0] = static_cast<float>(start.x);
    return pieces;
}

std::vector<MeshPiece> read_mesh_file(const std::filesystem::path &file,
                                      const std::vector<std::string> &parts)
{
    check_name_and_size(file);
    std::vector<MeshPiece> pieces;
    try {
        const std::uint64_t bytes = regular_file_bytes(file.string(), mesh_file_bytes_max);
        read_apart(
            file.string(), read_limits(bytes, growth),
            [&](Outbox &out) { send(out, read_mesh_here(file, parts)); },
            [&](Inbox &in) { pieces = receive(in); });
    } catch (const GuardedReadError &error) {
        throw Fault(error.what());
    }
    check_pieces(pieces, file.string());
    return pieces;
}

} // namespace crn::bake
