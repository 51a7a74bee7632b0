// Evaluates the vessel in double precision. The code reads the same sparse field of B-spline coefficients as
// the core (the core's lumen.h specifies the layout), but independently of the core's arithmetic.
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

// Holds the field at a point. Neighbouring values differ exactly as the gradient states, but the gradient's
// length is not exactly 1. Second derivatives jump at the borders of voxels. Gradient and second derivatives
// are zero far from the wall.
struct LumenField {
    double distance_m = 0.0; // negative inside the lumen
    Vector gradient = Vector::Zero();
    Eigen::Matrix3d second_per_m = Eigen::Matrix3d::Zero();
};

// Holds the lumen and the place where the rod enters it. This object owns the bytes of its file, so it is
// neither copied nor moved.
class Vessel
{
  public:
    // Throws std::runtime_error that names the file, the fault and the remedy.
    explicit Vessel(const std::string &path);
    // Uses a lumen that belongs to another object, which must outlive this one.
    Vessel(const crn_lumen &lumen, const Vector &mouth_m, const Vector &direction);
    Vessel(const Vessel &) = delete;
    Vessel &operator=(const Vessel &) = delete;

    LumenSample sample(const Vector &position_m) const;
    const crn_lumen &lumen() const { return lumen_; }
    const Vector &mouth_m() const { return mouth_m_; }
    const Vector &direction() const { return direction_; }
    const std::string &name() const { return name_; }

    // Returns the corners of the lattice.
    Vector low_m() const;
    Vector high_m() const;

  private:
    std::vector<std::uint8_t> bytes_;
    crn_lumen lumen_{};
    Vector mouth_m_, direction_;
    std::string name_;
};

// Returns the field at a point: its value, and the normal from its gradient, computed from 27 coefficients.
// Far from every wall, the value is +-15.6 mm and the normal is zero.
LumenSample sample_lumen(const crn_lumen &lumen, const Vector &position_m);

LumenField lumen_field(const crn_lumen &lumen, const Vector &position_m);

} // namespace vcsim3
