/* The motion of the heart over one beat: a smooth map from the end of diastole to any phase, in the axes
 * of the left ventricle.
 *
 *     base  s = 1 and beyond: atria, roots of the great vessels      s = 0: apex
 *
 * The model has these parts. The base moves towards the apex, which hardly moves. Walls move towards the
 * axis, inner walls further than outer ones, so that they thicken. As seen from the apex, the base turns
 * clockwise and the apex counter-clockwise. Length, radius and twist have courses of their own, so the
 * centre towards which walls move is not one fixed place. Directions and sizes: Inv. Radiol. 1984 (91 % of
 * wall motion is radial to one moving centre); base descent 12 to 15 mm, twist 10 to 15 degrees, right
 * coronary artery 20 to 30 mm are common figures, assumed. Courses over time are assumed. They are set so
 * that measured volumes and rest periods (heart_figures.hpp) are those of a man at 70 beats per minute. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

constexpr double BEAT_MS = 60000.0 / 70.0;
constexpr int BEAT_FRAMES = 24;

/* The axes of the left ventricle at the end of diastole. */
struct HeartAxes {
    Vec3 apex_mm;
    Vec3 up;       // unit, from the apex to the middle of the base
    Vec3 anterior; // unit, across: 0 degrees, the front of the septum
    Vec3 lateral;  // unit, across: 90 degrees, the free wall of the left ventricle
    double length_mm;

    /* A point is described by its height (share of the length above the apex) and by its offset across. */
    double height(const Vec3 &point) const { return (point - apex_mm).dot(up) / length_mm; }
    Vec3 across(const Vec3 &point) const { return point - apex_mm - up * (point - apex_mm).dot(up); }
    /* Returns the direction from the axis straight out at that angle. */
    Vec3 outward(double angle_deg) const;
    Vec3 on_axis(double height) const { return apex_mm + height * length_mm * up; }
};

const HeartAxes &heart_axes();

class HeartBeat
{
  public:
    HeartBeat();
    /* The place in each frame of what rests at `point` at the end of diastole (and of expiration); frame k
     * is at k / BEAT_FRAMES of BEAT_MS. */
    std::vector<Vec3> frames(const Vec3 &point) const;
    /* Its place at the end of inspiration, at the end of diastole. */
    Vec3 inhaled(const Vec3 &point) const;
    /* Returns the smallest ratio of a small volume in any frame to its volume at rest, on a grid through and
     * around the heart. While it stays above 0 nothing folds over, and surfaces that do not cross at rest do
     * not cross later. */
    double least_volume_factor() const;

  private:
    struct Place { // values that depend on the resting point alone
        double height, inward, descent_mm, turn_rad, share;
        Vec3 point, across;
    };
    Place place(const Vec3 &point) const;
    Vec3 moved(const Place &here, double phase) const;

    Solid outline_, behind_;
    Distance left_ventricle_;
    Spline radial_, longitudinal_, twist_; // courses over the phase, 0 to 1
    Spline descent_, inward_, turn_deg_;   // profiles over the height
};

} // namespace anatomy
