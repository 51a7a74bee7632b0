// Checks a mesh that a file reader returned: every index must refer to an existing vertex, and every
// coordinate must be a finite number.
#include "tools/mesh/fault.hpp"
#include "tools/mesh/files/mesh_file.hpp"
#include <cmath>
#include <string>

namespace crn::bake
{

void check_pieces(const std::vector<MeshPiece> &pieces, const std::string &file)
{
    std::size_t vertex = 0, face = 0; // counted through the file
    for (const MeshPiece &piece : pieces) {
        const std::string part = piece.name.empty() ? "" : " of part '" + piece.name + "'";
        for (const auto &v : piece.vertices) {
            if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]))
                throw Fault(file + ": vertex " + std::to_string(vertex) + part +
                            " is not a number or infinite: export the mesh again, or delete that vertex");
            ++vertex;
        }
        for (const auto &corners : piece.triangles) {
            for (const std::uint32_t corner : corners)
                if (corner >= piece.vertices.size())
                    throw Fault(file + ": face " + std::to_string(face) + part + " has vertex " +
                                std::to_string(corner) + ", but there are " +
                                std::to_string(piece.vertices.size()) +
                                " (numbered from 0): export the mesh again");
            ++face;
        }
    }
}

} // namespace crn::bake
