// A body's mesh is prepared before it is written: it is made solid, cut at neighbouring bodies, reduced to
// fewer triangles, and hollowed. The report of `bake` states how well the bodies fit into each other.
#pragma once
#include "tools/bake/container.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// The distance between two surfaces is measured from points of each surface (all vertices and evenly spread
// points) to the nearest point of the other surface.
struct Deviation {
    double mean_mm = 0, largest_mm = 0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero(); // of the largest deviation
    std::size_t points = 0;
};

Deviation deviation(const Mesh &one, const Mesh &other, std::size_t points_each);

// Reduces the number of triangles of a closed mesh by collapsing edges. The permitted error of the edge
// collapse is lowered until the measured deviation from the original mesh is within error_mm. Returns the
// measured deviation.
Deviation decimate(Mesh &mesh, double error_mm);

// Reads the mesh of a body from the file that the scene's text names, and closes its openings.
Mesh load_body(const BodyText &body);

// Reads the positions of a body's vertices after a full breath. `rest` is the mesh that load_body() returned.
// Throws Fault if the file holds other triangles than `rest`, or a vertex moves by more than 30 mm. A sharp
// fold of the surface may cross itself; a picture counts path lengths with their signs, so this does no harm.
std::vector<Eigen::Vector3d> load_inhaled(const BodyText &body, const Mesh &rest);

// Makes one body that the scene's text describes. `base` is the mesh that load_body() returned; marrow needs
// none. `made` holds the bodies that were made earlier, and the function adds one or two lines to `report`.
// Several threads may make different bodies at the same time.
Mesh form_body(const BodyText &body, Mesh base, const std::vector<BakedBody> &made, std::string &report);

// Returns one report line for each body that protrudes from the body around it, or enters a neighbouring
// body, by more than 0.3 mm. Where two bodies overlap, the X-ray picture shows the absorption of both
// materials. The comparison tests `samples` vertices of each body.
std::string nesting_report(const std::vector<BakedBody> &bodies, std::size_t samples);

// Returns the same lines for half a breath and for a full breath, where bodies that breathe are off by more
// than 1 mm. The report is empty if no body breathes.
std::string breath_report(const std::vector<BakedBody> &bodies, std::size_t samples);

} // namespace crn::bake
