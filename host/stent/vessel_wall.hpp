// Makes a wall for stents from a stretch of a vessel: a tube of fine triangles around a branch of the vessel
// tree. The tube is narrow at lesions of the branch that no balloon has opened, and the tube moves with the
// heart.
//
//   VesselWall vessel(tree, branch, 5, 45, motion);      mm along the branch
//   vessel.move(moment, opened);                         every picture
//   stent.step({&vessel.wall(), ...});
//
// The meshes of bodies are too coarse to be walls for stents: each flat facet lies up to a tenth of a
// millimetre inside the wall of a coronary artery. Gaps between strut and wall of a tenth of a millimetre
// decide whether a strut counts as apposed. The vessel tree contains the radius of every inscribed sphere to
// within some micrometres, and also the position of the healthy vessel. The tube has no openings where side
// branches leave the vessel.
#pragma once
#include "host/model/motion.hpp"
#include "host/model/vessel_tree.hpp"
#include "host/stent/wall.hpp"
#include <Eigen/Core>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crn
{

class VesselWall
{
  public:
    // The tube of triangles never begins before the ostium of the branch. `motion` may be null; in this case
    // the tube stays at rest. Throws std::invalid_argument, with the reason, if the branch does not contain
    // the stretch from `from_mm` to `to_mm`.
    VesselWall(const VesselTree &tree, std::size_t branch, double from_mm, double to_mm,
               const Motion *motion);

    // `opened` contains a list of values for each lesion of the tree; the values state how far the lesion is
    // open. The values of `opened` belong to evenly spaced points from the lesion's beginning to its end,
    // such as the core's stations. A list in `opened` with only one value applies to the whole lesion. The
    // value 0 means as narrow as in the scene file, 1 as wide as the healthy vessel, and above 1
    // overstretched. Lesions without a list in `opened`, or with an empty list, are as narrow as in the scene
    // file.
    void move(const MotionMoment &moment, std::span<const std::vector<double>> opened = {});

    const StentWall &wall() const { return wall_; }
    // The next functions return the present centreline of a part of the vessel, and its radii, at every row
    // of vertices of the wall.
    std::span<const Eigen::Vector3d> line_mm() const { return line_mm_; }
    std::span<const double> radius_mm() const { return radius_mm_; }
    std::span<const double> healthy_radius_mm() const { return healthy_radius_mm_; }
    // Returns the position of a row of vertices along the healthy branch, in mm from the branch's first
    // point.
    double along_mm(std::size_t row) const { return rows_[row].along_mm; }
    // Sets the distance between the first and the last point for which `opened` has values; the middle
    // between these two points is the middle of the lesion.
    void set_places(std::size_t lesion, double span_mm);
    // Holds the beginning and end of a lesion on the wall's part of the vessel; the range is empty if the
    // branch has no lesion with that number.
    struct Stretch {
        double from_mm = 0.0, to_mm = 0.0;
        bool is_empty() const { return !(to_mm > from_mm); }
    };
    Stretch lesion_mm(std::size_t lesion) const
    {
        return lesion < lesions_.size() ? lesions_[lesion] : Stretch{};
    }
    // Returns the beginning and end of the part of the vessel along which `opened` has values for the lesion
    // with this number.
    Stretch places_mm(std::size_t lesion) const
    {
        return lesion < places_.size() ? places_[lesion] : Stretch{};
    }
    // The next functions return the radius in the scene file and the healthy radius at a position along the
    // branch. Beyond an end of this part of the vessel, the functions return the radius at that end.
    double narrow_radius_mm(double along_mm) const;
    double healthy_radius_mm(double along_mm) const;
    // Holds the position along the branch that is nearest to a point of the patient, and the distance of that
    // point from the centreline.
    struct Foot {
        double along_mm = 0.0, off_mm = 0.0;
    };
    Foot foot_of(const Eigen::Vector3d &place_mm) const;
    double along_of(const Eigen::Vector3d &place_mm) const { return foot_of(place_mm).along_mm; }
    // Returns the present radius of the vessel, with its lesions as far open as they are now.
    double radius_at_mm(double along_mm) const;

  private:
    struct Row { // of the tube, in the reference pose
        Eigen::Vector3d narrow_m, healthy_m;
        double narrow_radius_m, healthy_radius_m;
        double along_mm;       // the healthy branch
        std::ptrdiff_t lesion; // -1: none
    };
    std::pair<std::size_t, double> row_at(double along_mm) const;
    double opened_at(std::size_t row, std::span<const std::vector<double>> opened) const;
    static std::vector<Row> rows_of(const VesselTree &tree, std::size_t branch, double from_mm, double to_mm);
    void add_points(const std::vector<Row> &rows, const Motion *motion);
    static std::vector<WallTriangle> triangles_of(std::size_t rows);
    Eigen::Vector3d at_m(std::size_t point, std::size_t row, double share,
                         const MotionWeights &weights) const;

    std::vector<Row> rows_;
    std::vector<Stretch> lesions_, places_;             // of the tree
    std::vector<Eigen::Vector3d> narrow_m_, healthy_m_; // of every vertex, then of every row's middle
    std::optional<MovingPoints> narrow_ways_, healthy_ways_;
    StentWall wall_;
    std::vector<Eigen::Vector3i> vertices_um_;
    std::vector<Eigen::Vector3d> line_mm_;
    std::vector<double> radius_mm_, healthy_radius_mm_;
};

} // namespace crn
