#include "tools/patient/vtp_surface.hpp"
#include "host/base/guarded_read.hpp"
#include "host/base/number_text.hpp"
#include "host/base/text.hpp"
#include "tools/centreline/vtk_array.hpp"

#include <cctype>
#include <cmath>

namespace crn::patient
{
namespace
{

constexpr std::uint64_t file_bytes_max = std::uint64_t{256} << 20;

double attribute_of(const centreline::VtkFile &file, const pugi::xml_node &piece, const char *name,
                    double most)
{
    const double count = piece.attribute(name).as_double(-1);
    if (!(count >= 0 && count <= most && count == std::floor(count)))
        file.fail(std::string("Piece has ") + name + " = '" + piece.attribute(name).value() +
                  "': a whole number up to " + trimmed_text(most, 0) + " is needed");
    return count;
}

std::vector<double> polygon_array(const centreline::VtkFile &file, const pugi::xml_node &piece,
                                  const std::string &name, std::size_t count)
{
    for (const pugi::xml_node &array : piece.child("Polys"))
        if (array.attribute("Name").value() == name) return file.values(array, count);
    file.fail("has polygons without the array '" + name + "': export the file again");
}

std::size_t index_of(const centreline::VtkFile &file, double value, double low, double high)
{
    if (value >= low && value <= high && value == std::floor(value)) return static_cast<std::size_t>(value);
    file.fail("has the index " + trimmed_text(value, 3) + " in Polys, expected " + trimmed_text(low, 0) +
              " to " + trimmed_text(high, 0) + ": the file is damaged, export it again");
}

void add_piece(const centreline::VtkFile &file, const pugi::xml_node &piece, bake::MeshPiece &mesh)
{
    const double most = bake::mesh_vertices_max;
    const auto points = static_cast<std::size_t>(attribute_of(file, piece, "NumberOfPoints", most));
    const auto polygons = static_cast<std::size_t>(attribute_of(file, piece, "NumberOfPolys", most));
    if (piece.attribute("NumberOfStrips").as_double(0) > 0)
        file.fail("holds strips of triangles: triangulate the surface (vtkTriangleFilter) and save it again");
    if (points == 0 || polygons == 0) return;
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::vector<double> at = file.values(piece.child("Points").child("DataArray"), 3 * points);
    const std::vector<double> ends = polygon_array(file, piece, "offsets", polygons);
    const std::size_t corners = index_of(file, ends.back(), 0, 3.0 * bake::mesh_triangles_max);
    const std::vector<double> order = polygon_array(file, piece, "connectivity", corners);
    if (order.size() != corners || base + points > bake::mesh_vertices_max)
        file.fail("has too many points, or fewer corners than it states: export the file again");
    for (std::size_t p = 0; p < points; ++p)
        mesh.vertices.push_back({static_cast<float>(at[3 * p]), static_cast<float>(at[3 * p + 1]),
                                 static_cast<float>(at[3 * p + 2])});
    std::size_t begin = 0;
    for (std::size_t polygon = 0; polygon < polygons; ++polygon) {
        const std::size_t end =
            index_of(file, ends[polygon], static_cast<double>(begin), static_cast<double>(corners));
        const auto corner = [&](std::size_t k) {
            return base +
                   static_cast<std::uint32_t>(index_of(file, order[k], 0, static_cast<double>(points) - 1));
        };
        if (end - begin < 3) ++mesh.other;
        for (std::size_t k = begin + 2; k < end; ++k)
            mesh.triangles.push_back({corner(begin), corner(k - 1), corner(k)});
        begin = end;
        if (mesh.triangles.size() > bake::mesh_triangles_max)
            file.fail("has more than " + std::to_string(bake::mesh_triangles_max) +
                      " triangles: simplify the mesh");
    }
}

bake::MeshPiece parsed(const std::string &name)
{
    const centreline::VtkFile file(read_text_file(name), name);
    bake::MeshPiece mesh;
    for (const pugi::xml_node &piece : file.document().child("VTKFile").child("PolyData").children("Piece"))
        add_piece(file, piece, mesh);
    if (mesh.triangles.empty()) file.fail("holds no triangle: give the surface, not a centreline");
    return mesh;
}

} // namespace

bool is_vtp(const std::filesystem::path &file)
{
    std::string ending = file.extension().string();
    for (char &c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == ".vtp";
}

bake::MeshPiece read_vtp_surface(const std::filesystem::path &file)
{
    constexpr double growth = 64; // bytes of a parser's node per letter of XML
    const std::string name = file.string();
    bake::MeshPiece mesh;
    try {
        read_apart(
            name, read_limits(regular_file_bytes(name, file_bytes_max), growth),
            [&](Outbox &out) {
                const bake::MeshPiece read = parsed(name);
                out.list(read.vertices);
                out.list(read.triangles);
                out.value(read.other);
            },
            [&](Inbox &in) {
                mesh.vertices = in.list<std::array<float, 3>>(bake::mesh_vertices_max);
                mesh.triangles = in.list<std::array<std::uint32_t, 3>>(bake::mesh_triangles_max);
                mesh.other = in.value<std::uint64_t>();
            });
    } catch (const GuardedReadError &error) {
        throw Fault(error.what());
    }
    bake::check_pieces({mesh}, name);
    return mesh;
}

} // namespace crn::patient
