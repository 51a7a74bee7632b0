// Computes exact distances and winding numbers of a closed triangle mesh. Gives the signed distance to the
// mesh, and lists the triangles near a box. The sign of the distance comes from angle-weighted normals of the
// nearest feature (Baerentzen & Aanaes 2005). Every approximation that the program `bake` makes is compared
// with the exact geometry of the mesh.
#pragma once
#include "tools/bake/mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace crn::bake
{

class TriangleTree
{
  public:
    explicit TriangleTree(const Mesh &mesh); // the mesh must outlive the tree

    struct Nearest {
        double distance_mm; // negative inside
        Eigen::Vector3d point_mm;
        std::uint32_t triangle;
    };
    // `bound_mm` is an upper bound of the distance, which shortens the search for the nearest triangle; it is
    // infinite if no bound is known.
    Nearest nearest(const Eigen::Vector3d &p_mm, double bound_mm = INFINITY) const;

    // Returns the winding number of the surface around a point, which is 1 inside the surface and 0 outside.
    // The winding number is found by counting how often a ray from the point crosses the surface. The winding
    // number is right even where a thin sheet is folded over at its edge. The function nearest() gives a
    // wrong sign of the distance wherever the fold of a thin sheet is the nearest part of the surface.
    int winding(const Eigen::Vector3d &p_mm) const;

    // Lists the triangles whose bounding box overlaps the given box.
    void near(const Eigen::AlignedBox3d &box, std::vector<std::uint32_t> &triangles) const;

    const Mesh &mesh() const { return mesh_; }

  private:
    struct Node {
        Eigen::AlignedBox3d box;
        std::uint32_t first,
            count; // leaf: triangles order_[first ...]; inner: count 0, children first, first + 1
    };
    struct Hit {
        double square;
        Eigen::Vector3d point;
        std::uint32_t triangle;
        int feature; // 0-2 corner, 3-5 edge from corner (feature - 3), 6 face
    };
    void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);
    Hit search(const Eigen::Vector3d &p_mm, double limit_square) const;
    int crossing(std::uint32_t triangle, const Eigen::Vector3d &p_mm) const;
    Hit closest_on(std::uint32_t triangle, const Eigen::Vector3d &p_mm) const;

    const Mesh &mesh_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
    std::vector<Eigen::Vector3d> centres_;
    std::vector<Eigen::Vector3d> face_normals_, corner_normals_;
    std::vector<std::array<Eigen::Vector3d, 3>> edge_normals_;
};

} // namespace crn::bake
