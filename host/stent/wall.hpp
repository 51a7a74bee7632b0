// Represents the wall on which a stent lies, a closed mesh of triangles around the blood. The vertices of the
// wall's mesh move from step to step, and each triangle keeps its three vertices.
//
//   StentWall wall(triangles, vertex_count);
//   wall.move(vertices_um);                        every picture: that of the motion (host/model/motion.hpp)
//   WallFoot foot = wall.walk(place, foot);        nearest place of the wall, searched from the previous one
//   place = wall.place(foot);                      where the wall has carried it
//
// A foot is a point that moves with the wall. A foot is described by a triangle, a point in the triangle's
// plane, and a height above the plane towards the blood. Lengths in mm.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

using WallTriangle = std::array<std::uint32_t, 3>; // counter-clockwise seen from outside the blood

struct WallFoot {
    std::int32_t triangle = -1; // -1: none
    double u = 0.0, v = 0.0;    // shares of its second and third corner; outside of 0 .. 1 beyond an edge
    double height_mm = 0.0;     // height over its plane, towards the blood; below 0 behind the wall
    double distance_mm =
        0.0; // distance to the nearest place of the wall at the time of the search; below 0 behind the wall
    bool is_known() const { return triangle >= 0; }
};

class StentWall
{
  public:
    // The constructor leaves out triangles with vertices that do not exist.
    StentWall(std::span<const WallTriangle> triangles, std::size_t vertex_count);
    // Moves the wall to new positions of its vertices. If `vertices_um` has another number of vertices than
    // the wall, the wall does not move.
    void move(std::span<const Eigen::Vector3i> vertices_um);
    bool is_placed() const { return is_placed_; } // has been given its vertices

    std::size_t triangle_count() const { return triangles_.size(); }
    const WallTriangle &triangle(std::size_t i) const { return triangles_[i]; }
    const Eigen::Vector3d &corner_mm(std::size_t triangle, std::size_t k) const
    {
        return vertices_mm_[triangles_[triangle][k]];
    }
    Eigen::Vector3d
    normal(std::size_t triangle) const; // unit, away from the blood; 0 for a triangle without area

    // place() returns the present position of a foot (a point that moves with the wall); on_plane() returns
    // the position in the plane of the foot's triangle, without the height above it.
    Eigen::Vector3d place(const WallFoot &foot) const;
    Eigen::Vector3d on_plane(const WallFoot &foot) const;

    // Walks from the triangle `from` to neighbouring triangles as long as each step reduces the distance to
    // `place_mm`, and returns the nearest point found on the wall.
    WallFoot walk(const Eigen::Vector3d &place_mm, std::int32_t from) const;
    // Returns the point on the triangles `among` that is nearest to `place_mm`; if no such point is within
    // `reach_mm`, the returned foot has no triangle.
    WallFoot nearest(const Eigen::Vector3d &place_mm, std::span<const std::uint32_t> among,
                     double reach_mm) const;
    // Returns, in ascending order, the triangles of a patch: those that are nearer than `reach_mm` to any of
    // the given points.
    std::vector<std::uint32_t> near(std::span<const Eigen::Vector3d> places_mm, double reach_mm) const;

  private:
    struct Closest {
        double squared = 0.0;
        bool is_inside = false; // not on an edge
    };
    Closest closest(const Eigen::Vector3d &place_mm, std::size_t triangle) const;
    WallFoot foot(const Eigen::Vector3d &place_mm, std::size_t triangle, const Closest &at) const;

    std::vector<WallTriangle> triangles_;
    std::vector<Eigen::Vector3d> vertices_mm_;
    std::vector<std::uint32_t> fan_begin_, fan_; // triangles around each vertex
    bool is_placed_ = false;
};

// Finds those triangles of a patch of the wall that may touch a given box. A grid divides the space into
// cells, and each cell lists the triangles whose bounding boxes reach into it.
class WallGrid
{
  public:
    void build(const StentWall &wall, std::span<const std::uint32_t> patch, const Eigen::Vector3d &low_mm,
               const Eigen::Vector3d &high_mm);
    // Appends to `found` each triangle that may touch the box once, by its index in the patch.
    void query(const Eigen::Vector3d &low_mm, const Eigen::Vector3d &high_mm,
               std::vector<std::uint32_t> &found);

  private:
    std::array<int, 3> cell_of(const Eigen::Vector3d &place_mm) const;
    struct Box {
        Eigen::Vector3f low, high;
        std::uint32_t index;
    };
    Eigen::Vector3d low_mm_ = Eigen::Vector3d::Zero();
    std::array<int, 3> count_{};
    std::vector<Box> boxes_;
    std::vector<std::uint32_t> begin_, items_, seen_;
    std::uint32_t round_ = 0;
};

} // namespace crn
