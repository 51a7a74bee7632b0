// A balloon as the core gives it at a picture: balls along its tool, and a frame that goes along its axis
// without twist.
#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace crn
{

// One of its balls. Between two of them everything is linear; beyond the ends the axis goes on straight and
// there is no balloon.
struct BalloonPoint {
    double arc_mm = 0.0; // of the tool, from its tip: ascending
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double radius_mm = 0.0;
    double room_mm = std::numeric_limits<double>::infinity(); // radius free of wall or catheter around;
                                                              // infinite: not known
};

struct BalloonPose {
    std::vector<BalloonPoint> points; // two at least, from the tip; what is not finite is left out
};

class BalloonAxis
{
  public:
    // `across` is where the frame's first axis lay in the picture before: it is carried on, so that nothing
    // spins.
    BalloonAxis(const BalloonPose &pose, const Eigen::Vector3d &across);
    bool is_known() const { return points_.size() >= 2; }

    struct Place {
        Eigen::Vector3d centre_mm, tangent, across,
            third; // tangent towards the hub; the three are orthonormal
        double radius_mm = 0.0, room_mm = std::numeric_limits<double>::infinity();
    };
    Place at(double arc_mm) const;
    // The frame's first axis at the first point: for the next picture.
    Eigen::Vector3d across() const
    {
        return points_.empty() ? Eigen::Vector3d::UnitX() : points_.front().across;
    }
    double first_arc_mm() const { return points_.front().arc_mm; }
    double last_arc_mm() const { return points_.back().arc_mm; }
    // Arc of the point of the axis nearest to a place, and how far it is; not beyond the ends.
    double nearest_arc_mm(const Eigen::Vector3d &place_mm, double &distance_mm) const;

  private:
    struct Station {
        double arc_mm, radius_mm, room_mm;
        Eigen::Vector3d centre_mm, tangent, across;
    };
    std::vector<Station> points_;
};

} // namespace crn
