// Describes the balloon at one step, as the core reports it: by balls along the balloon's tool, and by
// directions that follow the balloon's axis without twist.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace crn
{

// Describes one of the balls. Between two balls of the balloon all values change linearly. Beyond the
// ends of the balloon its axis continues straight, and there is no balloon.
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
    // `across` is the first direction of the frame (the axes perpendicular to the balloon) at the previous
    // step. The frame of a step is turned as little as possible from that of the previous step, so that it
    // does not spin about the balloon.
    BalloonAxis(const BalloonPose &pose, const Eigen::Vector3d &across);
    bool is_known() const { return points_.size() >= 2; }

    struct Place {
        Eigen::Vector3d centre_mm, tangent, across,
            third; // tangent towards the hub; the three are orthonormal
        double radius_mm = 0.0, room_mm = std::numeric_limits<double>::infinity();
    };
    Place at(double arc_mm) const;
    // Returns the first direction of the frame at the first ball, which is needed for the next step.
    Eigen::Vector3d across() const
    {
        return points_.empty() ? Eigen::Vector3d::UnitX() : points_.front().across;
    }
    double first_arc_mm() const { return points_.front().arc_mm; }
    double last_arc_mm() const { return points_.back().arc_mm; }
    // Returns the arc length of the axis point nearest to a given position, and stores the distance; the
    // point never lies beyond the ends of the axis.
    double nearest_arc_mm(const Eigen::Vector3d &place_mm, double &distance_mm) const;

  private:
    struct Station {
        double arc_mm, radius_mm, room_mm;
        Eigen::Vector3d centre_mm, tangent, across;
    };
    std::vector<Station> points_;
};

} // namespace crn
