// A vessel's surface made ready for fitting: closed, with its openings known, its inside as voxels and its
// wall as an exact distance.
#pragma once
#include "tools/bake/triangle_tree.hpp"
#include "tools/centreline/fit/voxels.hpp"

#include <memory>

namespace crn::centreline
{

// Where the mesh was open: a vessel's end, through which a line goes on to the very plane.
struct Opening {
    Eigen::Vector3d centre_mm;
    double radius_mm;
};

struct LumenWish {
    double voxel_mm = 0; // 0: some 300,000 inside, from 0.15 to 1 mm
    bake::Cap cap = bake::Cap::any;
    bool with_voxels = true; // ways need them, distances do not
};

class Lumen
{
  public:
    // Takes a mesh as it was loaded. What is not the boundary of a body, but has no hole wider than a vessel,
    // is made anew from a level set (noted). Throws Fault that names what to mend.
    Lumen(bake::Mesh mesh, const LumenWish &wish, bake::Progress &progress);
    Lumen(const Lumen &) = delete;
    Lumen &operator=(const Lumen &) = delete;

    // Radius of the largest sphere about p that crosses no wall; openings are no wall. `bound_mm` as in
    // TriangleTree.
    double radius_mm(const Eigen::Vector3d &p_mm, double bound_mm = INFINITY) const;
    const Voxels &voxels() const { return *voxels_; } // of a lumen made with them
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
