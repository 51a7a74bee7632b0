// Divides the tree of vessels into cells, which are short segments with the blood in them. Each cell has a
// position, radius, length and volume, and the index of the upstream cell from which its blood comes.
//
//   FlowCells cells(tree);        // cells of a branch are consecutive; a cell comes after the one that feeds it
//   cells.reshape(opened);        // the same vessels after lesions have yielded: other radii, volumes and places
//   cells.place(moved);           // the same vessels elsewhere (a beating heart): radii and volumes stay
//   cells.nearest(tip_m);
#pragma once
#include "host/model/vessel_tree.hpp"
#include <cstddef>
#include <vector>

namespace crn
{

struct FlowCell {
    int branch = 0;
    int upstream = -1; // the cell that feeds it; -1: the inlet
    double radius_mm = 0.0, length_mm = 0.0, volume_ml = 0.0;
    double per_r4_mm3 = 0.0;         // integral of ds / r^4: in proportion to the resistance
    double healthy_per_r4_mm3 = 0.0; // the same without lesions
    // Mean flows out of the tree: into the bed behind the branch's end, into small vessels, and both
    // together; 0: nothing leaves here.
    double end_ml_s = 0.0, small_ml_s = 0.0, outlet_ml_s = 0.0;
    VesselBed bed = VesselBed::systemic;
    // Describes a position between two points of the cell's branch; a cell has three such positions, for its
    // middle and its two faces.
    struct Place {
        std::size_t point = 0;
        double share = 0.0;
    };
    Place middle, first, last;
};

// Describes the narrowest point of a lesion.
struct FlowThroat {
    std::size_t cell = 0,
                behind =
                    0; // the cell of the narrowest place, and the first cell of its branch behind the lesion
    double radius_mm = 0.0, healthy_radius_mm = 0.0;
};

class FlowCells
{
  public:
    FlowCells() = default;
    // `tree` has passed check_vessel_tree. The length of a cell is half of the vessel's radius, but at least
    // 1 mm and at most 3 mm. A branch begins at vessel_start_m. For an outlet whose flow is not given,
    // Murray's law computes the flow from the radius. The flow that is stated for a branch includes that of
    // the small vessels that leave it.
    explicit FlowCells(const VesselTree &tree);

    std::size_t size() const { return cells_.size(); }
    const FlowCell &operator[](std::size_t i) const { return cells_[i]; }
    // The next functions return the index of a branch's first cell, and the index after the branch's last
    // cell.
    std::size_t branch_begin(std::size_t branch) const { return branch_begin_[branch]; }
    std::size_t branch_count() const { return branch_begin_.empty() ? 0 : branch_begin_.size() - 1; }

    // Returns the cell that feeds what leaves the branch at this point.
    std::size_t cell_at_point(std::size_t branch, std::size_t point) const;

    const std::vector<FlowThroat> &throats() const { return throats_; } // one for each lesion

    // Replaces the points and radii inside the lesions of the tree by those of the opened tree. The new
    // points must be given for the same heart and breath phase as the tree that the constructor received. The
    // mean flow into the vascular beds does not change.
    void reshape(const VesselTree &opened);
    // Moves the points of the tree: `moved` must have the same numbers of branches, points and lesions as the
    // tree that the constructor received. Any other tree is ignored.
    void place(const VesselTree &moved);
    const Eigen::Vector3d &middle_m(std::size_t i) const { return middle_m_[i]; }
    Eigen::Vector3d first_face_m(std::size_t i) const { return at(i, cells_[i].first); }
    Eigen::Vector3d last_face_m(std::size_t i) const { return at(i, cells_[i].last); }

    // Finds the cell with the smallest power distance |p - m|^2 - r^2 from a point p, where m is the middle
    // and r the radius of the cell. Where vessels overlap, the found cell belongs to the vessel in which p
    // lies deeper.
    std::size_t nearest(const Eigen::Vector3d &place_m) const;
    // Finds the same cell, faster if it lies near the cell `guess`, such as that of the point before.
    std::size_t nearest(const Eigen::Vector3d &place_m, std::size_t guess) const;

  private:
    void cut(const VesselTree &tree, std::size_t branch, const VesselBranch &healthy);
    void feed_small_vessels(const VesselTree &tree);
    bool is_alike(const VesselTree &tree) const;
    FlowThroat throat_of(const VesselTree &tree, const VesselLesion &lesion) const;
    Eigen::Vector3d at(std::size_t cell, const FlowCell::Place &place) const;
    void find_middles();

    // Consecutive cells. All their balls lie within reach_m of the middle.
    struct Group {
        std::size_t begin, end;
        Eigen::Vector3d middle_m;
        double reach_m;
    };

    std::vector<FlowCell> cells_;
    std::vector<std::size_t> branch_begin_;
    std::vector<FlowThroat> throats_;
    std::vector<std::vector<Eigen::Vector3d>> points_m_; // of each branch, as of now
    std::vector<Eigen::Vector3d> middle_m_;
    std::vector<Group> groups_;
};

// Returns the mean flow out of a vessel of radius r by Murray's law: pi/4 500/s r^3, which gives a wall shear
// rate of 500/s.
double murray_flow_ml_s(double radius_mm);

} // namespace crn
