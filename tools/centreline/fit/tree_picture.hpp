// A vessel as glass with the tree's spheres in it: what `centreline show` writes and the editor shows.
#pragma once
#include "host/picture/canvas.hpp"
#include "tools/centreline/fit/points.hpp"
#include "tools/centreline/tree.hpp"

namespace crn::centreline
{

// Parallel view. Angles as of a C-arm turned about the patient: 0, 0 looks from the front (from +z), head
// (+y) up.
struct View {
    double turn_deg = 0; // about the head axis; above 0 the viewer walks to the patient's left
    double tilt_deg = 0; // above 0 the viewer rises towards the head
    Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();
    double pixels_per_mm = 1;
    int width = 768, height = 768;

    Eigen::Matrix3d axes() const; // rows: right, up, towards the viewer
    SheetPoint place(const Eigen::Vector3d &p_mm) const;
    Eigen::Vector3d ray_start_mm(double x, double y) const; // on the plane through the middle
};
// Everything of the mesh fits in, with a margin.
View view_of(const bake::Mesh &mesh, double turn_deg, double tilt_deg, int width, int height);

// How much wall a line of sight grazes, 0 to 1 per pixel. Kept by whoever draws one view many times.
std::vector<float> glass_of(const bake::Mesh &mesh, const View &view);

struct TreeDrawing {
    const bake::Mesh *wires = nullptr; // its edges, nearer ones darker
    const Tree *tree = nullptr;
    const std::vector<Point> *points = nullptr; // manual points, red
    int chosen = -1;                            // one of them, ringed
    bool with_names = false;                    // of all points; else only that of the chosen one
    bool with_scale = true;
};
Sheet draw_tree(const std::vector<float> &glass, const View &view, const TreeDrawing &drawing);

} // namespace crn::centreline
