// Makes lumens from exact distance functions in closed form, and computes the core's sparse field from these
// functions in memory. The computed field equals the field that the program `bake` would make. This code does
// not use `bake`, so that a validation case depends on the core alone.
#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <vector>

struct crn_lumen;

namespace crn::validate
{

using Eigen::Vector3d;

// A Distance function returns the signed distance to the wall in metres, negative inside; the slope of this
// distance never exceeds 1.
using Distance = std::function<double(const Vector3d &)>;

// Describes a path in closed form, as straight pieces and arcs in one or several planes.
class Path
{
  public:
    Path(const Vector3d &start, const Vector3d &direction, const Vector3d &normal);
    Path &straight(double length_m);
    Path &bend(double radius_m, double angle_rad); // towards the normal
    Path &roll(double angle_rad);                  // turns the normal about the direction

    double distance(const Vector3d &point_m) const; // to the path
    Vector3d at(double arc_m) const;                // the last piece continues beyond the end
    Vector3d end() const { return at_; }
    Vector3d end_direction() const { return direction_; }
    double length() const { return length_m_; }
    // Returns the smallest box around the path.
    Vector3d low() const { return low_; }
    Vector3d high() const { return high_; }

  private:
    struct Piece {
        Vector3d from, direction, normal;
        double length_m, radius_m; // radius 0: straight
        Vector3d point(double arc_m) const;
        double distance(const Vector3d &point_m) const;
    };
    std::vector<Piece> pieces_;
    Vector3d at_, direction_, normal_, low_, high_;
    double length_m_ = 0;
    void add(const Piece &piece);
};

class LumenField
{
  public:
    // Makes the core's field from the function `distance` within the box; the refinement levels 0, 1 and 2
    // have voxels of 1, 0.5 and 0.25 mm.
    LumenField(const Distance &distance, const Vector3d &low, const Vector3d &high, unsigned level);
    ~LumenField();
    LumenField(LumenField &&) noexcept;
    const crn_lumen *lumen() const;

  private:
    struct Storage;
    std::unique_ptr<Storage> storage_;
};

// Makes a tube of constant radius around a path; the tube ends in hemispheres, or a plane across its end
// closes it.
LumenField tube_field(const Path &path, double radius_m, unsigned level, bool flat_end = false);

} // namespace crn::validate
