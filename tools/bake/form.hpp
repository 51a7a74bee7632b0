// The steps that a body's mesh goes through before it is written: made solid, reduced by its neighbours,
// decimated, hollowed. A report states how well the bodies fit into each other.
#pragma once
#include "tools/bake/container.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// The distance between two surfaces, from points of each (all vertices and evenly spread ones) to the nearest
// point of the other.
struct Deviation {
    double mean_mm = 0, largest_mm = 0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero(); // of the largest deviation
    std::size_t points = 0;
};

Deviation deviation(const Mesh &one, const Mesh &other, std::size_t points_each);

// Reduces the triangles of a closed mesh so that its measured deviation from the original stays within
// error_mm. The limit of the edge collapse is lowered until it does. Returns the measured deviation.
Deviation decimate(Mesh &mesh, double error_mm);

// Makes one body of the text from its file. `made` holds the bodies before it. The report gets a line or two.
Mesh form_body(const BodyText &body, const std::vector<BakedBody> &made, std::string &report);

// One line for each body that leaves the body it lies in, or enters one beside it, by more than 0.3 mm; there
// the picture counts a material twice. `samples` vertices of each body are tried.
std::string nesting_report(const std::vector<BakedBody> &bodies, std::size_t samples);

} // namespace crn::bake
