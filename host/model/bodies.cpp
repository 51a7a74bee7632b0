// Checks the bodies that were read; the reader of body files is in bodies_file.cpp.
#include "host/model/bodies.hpp"

namespace crn
{
namespace
{

constexpr std::size_t triangles_max = 8'000'000;
constexpr std::int32_t coordinate_max_um = 2'000'000;

std::string describe(const Bodies &bodies, std::size_t index)
{
    return "body " + std::to_string(index) + " \"" + bodies.bodies[index].name + "\"";
}

bool parents_end(const Bodies &bodies, std::size_t index)
{
    int at = static_cast<int>(index);
    for (std::size_t steps = 0; steps <= bodies.bodies.size(); ++steps) {
        if (at < 0) return true;
        at = bodies.bodies[at].parent;
    }
    return false;
}

bool check_mesh(const Body &body, std::string &error)
{
    for (std::size_t i = 0; i < body.vertices_um.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            if (body.vertices_um[i][axis] < -coordinate_max_um ||
                body.vertices_um[i][axis] > coordinate_max_um) {
                error =
                    "vertex " + std::to_string(i) + " lies farther than 2 m from the origin; check the units";
                return false;
            }
    for (std::size_t i = 0; i < body.triangles.size(); ++i)
        for (std::uint32_t corner : body.triangles[i])
            if (corner >= body.vertices_um.size()) {
                error = "triangle " + std::to_string(i) + " names vertex " + std::to_string(corner) + " of " +
                        std::to_string(body.vertices_um.size()) + "; the file is damaged, make it again";
                return false;
            }
    return true;
}

} // namespace

bool check_bodies(const Bodies &bodies, std::string &error)
{
    std::size_t triangles = 0;
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const Body &body = bodies.bodies[i];
        if (body.parent < -1 || body.parent >= static_cast<int>(bodies.bodies.size())) {
            error = describe(bodies, i) + ": parent " + std::to_string(body.parent) + " does not exist (" +
                    std::to_string(bodies.bodies.size()) + " bodies, -1 for none)";
            return false;
        }
        triangles += body.triangles.size();
    }
    if (triangles > triangles_max) {
        error = std::to_string(triangles) + " triangles in all, more than " + std::to_string(triangles_max) +
                "; simplify the meshes";
        return false;
    }
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        std::string fault;
        if (!parents_end(bodies, i))
            fault = "its parents form a circle; give the outermost body the parent -1";
        if (fault.empty() && check_mesh(bodies.bodies[i], fault)) continue;
        error = describe(bodies, i) + ": " + fault;
        return false;
    }
    return true;
}

} // namespace crn
