// Measures the accuracy of the distance field that `bake` makes of a lumen. The program compares the distance
// field with exact distances. The function also compares the two functions that sample the distance field.
// The program also compares the contact depths of the core with those of the library libccd. All random
// numbers are generated from a seed, which the program prints.
#pragma once
#include "tools/bake/field.hpp"

namespace crn::bake
{

struct Worst {
    double mm = 0;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    void take(double value_mm, const Eigen::Vector3d &place)
    {
        if (value_mm < mm) return;
        mm = value_mm;
        place_mm = place;
    }
};

struct FieldError {
    std::size_t points = 0; // the number of points within error_band_mm of the wall
    double median_mm = 0, percent99_mm = 0, permille999_mm = 0;
    Worst largest;
};

// Returns the core's distance from a point to the lumen's wall; the result is positive outside and negative
// inside.
double contact_mm(const crn_lumen *lumen, const Eigen::Vector3d &p_mm);

// Compares the core's distance with the exact signed distance, at random points within error_band_mm of the
// wall.
FieldError measure_field(const crn_lumen *lumen, const TriangleTree &tree, std::size_t points,
                         std::uint64_t seed, Progress &progress);

struct Referee {
    std::size_t poses = 0, touching = 0;
    double radius_mm = 0, length_mm = 0;
    Worst disagreement;
};

// Tests random capsules whose axis lies in the lumen and whose radius reaches the wall. Compares the core's
// contact depth, the largest phi + r (signed distance of the axis plus radius) along the capsule's axis, with
// libccd's deepest penetration of the triangles around the capsule.
Referee measure_contact(const crn_lumen *lumen, const TriangleTree &tree, std::size_t poses,
                        std::uint64_t seed, Progress &progress);

// Returns the radius of the smallest ball that touches two opposite walls. The ball's two points of contact
// with the walls must be at least 120 degrees apart as seen from the ball's centre. The function tries up to
// `points` points of the surface.
Worst smallest_radius(const TriangleTree &tree, std::size_t points);

} // namespace crn::bake
