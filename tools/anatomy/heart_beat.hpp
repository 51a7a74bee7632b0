/* The motion of the heart over one beat. It is a smooth map that gives, for every place at the end of
 * diastole, its place at any phase. The map uses the axes of the left ventricle. The height s is 0 at the
 * apex and 1 at the base; the atria and the roots of the great vessels lie at s = 1 and beyond. The base
 * moves towards the apex, and the apex hardly moves. Walls move towards the axis. Inner walls move further
 * than outer walls, so that walls thicken. As seen from the apex, the base turns clockwise and the apex
 * counter-clockwise. Length, radius and twist change over time by different functions, so the centre
 * towards which the walls move is not one fixed place. Inv. Radiol. 1984 reports that 91 % of the wall's
 * motion is radial to one moving centre. Three common figures are assumed: the base descends by 12 to 15
 * mm, the twist is 10 to 15 degrees, and the right coronary artery moves by 20 to 30 mm. The functions
 * over time are assumed, too. They are set so that the volumes and rest periods that heart_figures()
 * measures are those of a man at 70 beats per minute. */
#pragma once
#include "tools/anatomy/vessels.hpp"

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

    /* `height` is the share of the axis' length at which a point lies above the apex, and `across` is its
     * offset from the axis. */
    double height(const Vec3 &point) const { return (point - apex_mm).dot(up) / length_mm; }
    Vec3 across(const Vec3 &point) const { return point - apex_mm - up * (point - apex_mm).dot(up); }
    /* Returns the unit direction that points straight out from the axis at that angle. */
    Vec3 outward(double angle_deg) const;
    Vec3 on_axis(double height) const { return apex_mm + height * length_mm * up; }
};

const HeartAxes &heart_axes();

class HeartBeat
{
  public:
    /* The part of `aorta` behind the heart does not move. */
    explicit HeartBeat(const Vessel &aorta);
    /* Returns, for every frame, the place of the tissue that is at `point` at the end of diastole and of
     * expiration. Frame k is at k / BEAT_FRAMES of BEAT_MS. */
    std::vector<Vec3> frames(const Vec3 &point) const;
    /* Returns the place of the same tissue at the end of diastole and of inspiration. */
    Vec3 inhaled(const Vec3 &point) const;
    /* Returns the smallest ratio of a small volume in any frame to the same volume at rest. The volumes
     * lie on a grid through and around the heart. If the ratio is above 0, the map folds nowhere, and
     * surfaces that do not cross at rest do not cross in any frame. */
    double least_volume_factor() const;

  private:
    struct Place { // values that depend only on the point at rest
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
