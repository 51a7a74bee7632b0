// Evaluates the distance field of the vessel in double precision. This code reads the same sparse field of
// B-spline coefficients as the core (the core's lumen.h specifies the layout), but does not use the core's
// arithmetic.
#pragma once
#include "tools/lab/vcsim3/rod.hpp"
extern "C" {
#include "firmware/core/lumen.h"
}
#include <cstdint>
#include <string>
#include <vector>

namespace vcsim3
{

struct LumenSample {
    double distance_m = 0.0;        // negative inside the lumen
    Vector inward = Vector::Zero(); // unit normal; zero far from the wall
};

// Holds the value and derivatives of the distance field at a point. The gradient is the exact derivative of
// the field's value, but the length of the gradient is not exactly 1. The second derivatives of the field are
// discontinuous at the borders of voxels. The gradient and second derivatives are zero far from the wall.
struct LumenField {
    double distance_m = 0.0; // negative inside the lumen
    Vector gradient = Vector::Zero();
    Eigen::Matrix3d second_per_m = Eigen::Matrix3d::Zero();
};

// Holds the lumen of a scene, and the position at which the rod enters the lumen. The lumen object owns the
// bytes of the scene file, so it cannot be copied or moved.
class Vessel
{
  public:
    // Throws std::runtime_error, whose message names the file, the fault and the remedy.
    explicit Vessel(const std::string &path);
    // Uses a lumen that belongs to another object, which must outlive this object.
    Vessel(const crn_lumen &lumen, const Vector &mouth_m, const Vector &direction);
    Vessel(const Vessel &) = delete;
    Vessel &operator=(const Vessel &) = delete;

    LumenSample sample(const Vector &position_m) const;
    const crn_lumen &lumen() const { return lumen_; }
    const Vector &mouth_m() const { return mouth_m_; }
    const Vector &direction() const { return direction_; }
    const std::string &name() const { return name_; }

    // Returns two opposite corners of the lattice on which the field is stored.
    Vector low_m() const;
    Vector high_m() const;

  private:
    std::vector<std::uint8_t> bytes_;
    crn_lumen lumen_{};
    Vector mouth_m_, direction_;
    std::string name_;
};

// Returns the value of the field at a point, and the normal of the wall from the field's gradient; both are
// computed from 27 coefficients. Far from every wall, the value of the field is +-15.6 mm and the normal is
// zero.
LumenSample sample_lumen(const crn_lumen &lumen, const Vector &position_m);

LumenField lumen_field(const crn_lumen &lumen, const Vector &position_m);

} // namespace vcsim3
