// A balloon as the core gives it at a picture: balls along its tool, and a frame that follows its axis
// without twist.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace crn
{

// One of the balls. Between two of them everything is linear; beyond the ends the axis continues straight and
// there is no balloon.
struct BalloonPoint {
    double arc_mm = 0.0; // of the tool, from its tip: ascending
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double radius_mm = 0.0;
    double room_mm = std::numeric_limits<double>::infinity(); // radius free of a surrounding wall or
                                                              // catheter; infinite: not known
};

struct BalloonPose {
    std::vector<BalloonPoint> points; // at least two, from the tip; points that are not finite are left out
};

class BalloonAxis
{
  public:
    // `across` is the direction of the frame's first axis in the previous picture; it is carried over, so
    // that nothing spins.
    BalloonAxis(const BalloonPose &pose, const Eigen::Vector3d &across);
    bool is_known() const { return points_.size() >= 2; }

    struct Place {
        Eigen::Vector3d centre_mm, tangent, across,
            third; // tangent towards the hub; the three are orthonormal
        double radius_mm = 0.0, room_mm = std::numeric_limits<double>::infinity();
    };
    Place at(double arc_mm) const;
    // Returns the frame's first axis at the first point, to be passed to the next picture.
    Eigen::Vector3d across() const
    {
        return points_.empty() ? Eigen::Vector3d::UnitX() : points_.front().across;
    }
    double first_arc_mm() const { return points_.front().arc_mm; }
    double last_arc_mm() const { return points_.back().arc_mm; }
    // Returns the arc of the axis point nearest to a place, and the distance to it; never beyond the ends.
    double nearest_arc_mm(const Eigen::Vector3d &place_mm, double &distance_mm) const;

  private:
    struct Station {
        double arc_mm, radius_mm, room_mm;
        Eigen::Vector3d centre_mm, tangent, across;
    };
    std::vector<Station> points_;
};

} // namespace crn
