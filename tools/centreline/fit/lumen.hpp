// Holds the surface of the vessels in a form in which centrelines can be fitted. The stored surface is
// closed; the openings that the surface had before are stored separately. Callers can use the voxels inside
// the vessels, and can compute the exact distance from a point to the wall.
#pragma once
#include "tools/bake/triangle_tree.hpp"
#include "tools/centreline/fit/voxels.hpp"

#include <memory>

namespace crn::centreline
{

// An opening is a hole that the mesh had before it was closed, such as the cut end of a vessel. A centreline
// that ends at an opening extends up to the plane of this opening.
struct Opening {
    Eigen::Vector3d centre_mm;
    double radius_mm;
};

struct LumenWish {
    double voxel_mm = 0; // 0: some 300,000 voxels inside, of 0.15 to 1 mm
    bake::Cap cap = bake::Cap::any;
    bool with_voxels = true; // paths need voxels, distances do not
};

class Lumen
{
  public:
    // Makes a lumen from a mesh that was loaded from a file. If the mesh does not bound a body but has no
    // hole wider than a vessel, the constructor remakes it from a level set and adds a note. Throws a Fault
    // that states which part of the mesh must be repaired.
    Lumen(bake::Mesh mesh, const LumenWish &wish, bake::Progress &progress);
    Lumen(const Lumen &) = delete;
    Lumen &operator=(const Lumen &) = delete;

    // Returns the radius of the largest sphere around p that crosses no wall of the vessel; openings do not
    // count as walls. `bound_mm` is as in TriangleTree.
    double radius_mm(const Eigen::Vector3d &p_mm, double bound_mm = INFINITY) const;
    const Voxels &voxels() const { return *voxels_; } // only for a lumen made with voxels
    const std::vector<Opening> &openings() const { return openings_; }
    const bake::Mesh &wall() const { return wall_; } // without the caps
    const std::vector<std::string> &notes() const { return notes_; }

  private:
    bake::Mesh wall_;
    std::vector<Opening> openings_;
    std::vector<std::string> notes_;
    std::unique_ptr<bake::TriangleTree> tree_;
    std::unique_ptr<Voxels> voxels_;
};

} // namespace crn::centreline
