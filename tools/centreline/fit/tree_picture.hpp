// Draws a vessel as if it were made of glass, with the spheres of its tree inside. The command `centreline
// show` writes the picture of vessel and tree to a file, and the editor shows it in its window.
#pragma once
#include "host/picture/canvas.hpp"
#include "tools/centreline/fit/points.hpp"
#include "tools/centreline/tree.hpp"

namespace crn::centreline
{

// Describes a parallel projection whose direction is given by the angles of a C-arm around the patient. If
// both angles are 0, the view is from the front (from +z) with the head (+y) up.
struct View {
    double turn_deg = 0; // about the head axis; above 0 the viewer moves to the patient's left
    double tilt_deg = 0; // above 0 the viewer moves towards the head
    Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();
    double pixels_per_mm = 1;
    int width = 768, height = 768;

    Eigen::Matrix3d axes() const; // rows: right, up, towards the viewer
    SheetPoint place(const Eigen::Vector3d &p_mm) const;
    Eigen::Vector3d ray_start_mm(double x, double y) const; // on the plane through the middle
};
// Returns a view in which the whole mesh is visible, with a margin around it.
View view_of(const bake::Mesh &mesh, double turn_deg, double tilt_deg, int width, int height);

// Returns for each pixel the opacity of the drawn vessel, from 0 to 1. The opacity is large where the pixel's
// line of sight meets the vessel's wall at a grazing angle. A caller that draws the same view many times
// should store the returned opacities and use them again.
std::vector<float> glass_of(const bake::Mesh &mesh, const View &view);

struct TreeDrawing {
    const bake::Mesh *wires = nullptr; // its edges are drawn, nearer ones darker
    const Tree *tree = nullptr;
    const std::vector<Point> *points = nullptr; // points set by hand, red
    int chosen = -1;                            // one of them, ringed
    bool with_names = false;                    // names of all points; else only that of the chosen one
    bool with_scale = true;
};
Sheet draw_tree(const std::vector<float> &glass, const View &view, const TreeDrawing &drawing);

} // namespace crn::centreline
