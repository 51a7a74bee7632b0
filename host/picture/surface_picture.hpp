// Draws the walls around a lesion: the polygons of the lumen as glass, with calcium and balloon inside. The
// picture shows several moments side by side, each in a panel of its own.
#pragma once
#include "host/picture/picture.hpp"
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace crn
{

enum class SurfaceKind { wall, calcium, balloon };

struct SurfaceMesh {
    std::string name;
    SurfaceKind kind = SurfaceKind::wall;
    std::vector<Eigen::Vector3d> vertices_mm;
    std::vector<std::array<std::uint32_t, 3>> triangles; // anticlockwise from outside
};

struct SurfacePanel {
    double time_s = 0.0;
    std::vector<SurfaceMesh> meshes;
};

struct SurfaceView {
    Eigen::Vector3d right = Eigen::Vector3d::UnitX(),
                    up = Eigen::Vector3d::UnitY(); // unit vectors, at right angles
};

// Draws panels of size * size pixels, all of them at the same scale.
Image draw_surfaces(const std::vector<SurfacePanel> &panels, const SurfaceView &view, int size);

} // namespace crn
