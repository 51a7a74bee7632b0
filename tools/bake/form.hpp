// What is made of a body's mesh before it is written: solid, less its neighbours, decimated, hollowed; and
// how well the bodies lie in each other.
#pragma once
#include "tools/bake/container.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// How far two surfaces are apart, from points of each (all vertices and evenly spread ones) to the nearest
// point of the other.
struct Deviation {
    double mean_mm = 0, largest_mm = 0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero(); // of the largest
    std::size_t points = 0;
};

Deviation deviation(const Mesh &one, const Mesh &other, std::size_t points_each);

// Fewer triangles for a closed mesh, so that the measured deviation from what it was stays within error_mm:
// the limit of the edge collapse is lowered until it does. Returns what was measured.
Deviation decimate(Mesh &mesh, double error_mm);

// One body of the text, from file to mesh. `made` are the bodies before it. The report gets a line or two.
Mesh form_body(const BodyText &body, const std::vector<BakedBody> &made, std::string &report);

// A line for each body that leaves the one it lies in, or enters one beside it, by more than 0.3 mm: there
// the picture counts a material twice. `samples` vertices of each body are tried.
std::string nesting_report(const std::vector<BakedBody> &bodies, std::size_t samples);

} // namespace crn::bake
