/* How the heart moves over one beat: a smooth map from the end of diastole to any phase, in the axes of the
 * left ventricle.
 *
 *     base  s = 1 and beyond: atria, roots of the great vessels      s = 0: apex
 *
 * What is modelled: the base goes to the apex, which hardly moves; walls go to the axis, inner ones further
 * than outer ones, so that they thicken; the base turns clockwise and the apex counter-clockwise as seen from
 * the apex. Length, radius and twist have courses of their own, so the centre towards which walls move is not
 * one place. Directions and sizes: Inv. Radiol. 1984 (91 % of wall motion is radial to one moving centre);
 * base descent 12 to 15 mm, twist 10 to 15 degrees, right coronary artery 20 to 30 mm: common figures,
 * assumed. Courses over time are assumed, and set so that measured volumes and rest periods
 * (heart_figures.hpp) are those of a man at 70 beats per minute. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

constexpr double BEAT_MS = 60000.0 / 70.0;
constexpr int BEAT_FRAMES = 24;

/* Axes of the left ventricle at the end of diastole. */
struct HeartAxes {
    Vec3 apex_mm;
    Vec3 up;       // unit, from the apex to the middle of the base
    Vec3 anterior; // unit, across: 0 degrees, the front of the septum
    Vec3 lateral;  // unit, across: 90 degrees, the free wall of the left ventricle
    double length_mm;

    /* A point by height (share of the length above the apex), and by its offset across. */
    double height(const Vec3 &point) const { return (point - apex_mm).dot(up) / length_mm; }
    Vec3 across(const Vec3 &point) const { return point - apex_mm - up * (point - apex_mm).dot(up); }
    /* From the axis at that height straight out at that angle. */
    Vec3 outward(double angle_deg) const;
    Vec3 on_axis(double height) const { return apex_mm + height * length_mm * up; }
};

const HeartAxes &heart_axes();

class HeartBeat
{
  public:
    HeartBeat();
    /* Where what rests at `point` at the end of diastole (and of expiration) is in each frame; frame k at k /
     * BEAT_FRAMES of BEAT_MS. */
    std::vector<Vec3> frames(const Vec3 &point) const;
    /* Where it is at the end of inspiration, at the end of diastole. */
    Vec3 inhaled(const Vec3 &point) const;
    /* Smallest ratio of a small volume in any frame to its volume at rest, on a grid through and around the
     * heart: above 0 nothing folds over, and what does not cross at rest does not cross later. */
    double least_volume_factor() const;

  private:
    struct Place { // what depends on the resting point alone
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
