/* Computes the motion of the heart over one beat. A smooth map takes every point of the tissue at the end of
 * diastole to its position at any phase of the beat. The map uses coordinates about the axis of the left
 * ventricle. The height s along the ventricle's axis is 0 at the apex and 1 at the base; the atria and the
 * roots of the great vessels lie at s >= 1. The base moves towards the apex, and the apex hardly moves. Walls
 * move towards the axis. The inner surface of a wall moves further than its outer surface, so that the wall
 * thickens. As seen from the apex, the base turns clockwise and the apex counter-clockwise. The length,
 * radius and twist of the left ventricle follow different functions of time, so the walls do not move towards
 * one fixed point. One study (Investigative Radiology 1984) reports that 91 % of the motion of the
 * ventricle's wall points towards or away from one moving centre. Three commonly published figures are
 * assumed: the base descends by 12 to 15 mm, the twist is 10 to 15 degrees, and the right coronary artery
 * moves by 20 to 30 mm. The functions of time for length, radius and twist are also assumed. The functions of
 * time are chosen so that the chamber volumes and the periods of little motion, as measured by
 * heart_figures(), are typical of a man at 70 beats per minute. */
#pragma once
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

constexpr double BEAT_MS = 60000.0 / 70.0;
constexpr int BEAT_FRAMES = 24;

/* Holds the axes of the left ventricle at the end of diastole. */
struct HeartAxes {
    Vec3 apex_mm;
    Vec3 up;       // unit, from the apex to the middle of the base
    Vec3 anterior; // unit, across: 0 degrees, the front of the septum
    Vec3 lateral;  // unit, across: 90 degrees, the free wall of the left ventricle
    double length_mm;

    /* The function `height` returns a point's height above the apex as a fraction of the axis' length, and
     * `across` returns the point's offset from the axis. */
    double height(const Vec3 &point) const { return (point - apex_mm).dot(up) / length_mm; }
    Vec3 across(const Vec3 &point) const { return point - apex_mm - up * (point - apex_mm).dot(up); }
    /* Returns the unit vector that points straight outwards from the axis at the angle `angle_deg` about the
     * axis. */
    Vec3 outward(double angle_deg) const;
    Vec3 on_axis(double height) const { return apex_mm + height * length_mm * up; }
};

const HeartAxes &heart_axes();

class HeartBeat
{
  public:
    /* Prepares the map of the heart's motion. The part of `aorta` behind the heart does not move. */
    explicit HeartBeat(const Vessel &aorta);
    /* Returns the position in every frame of the tissue that is at `point` at the end of diastole and of
     * expiration. Frame k is at k / BEAT_FRAMES of BEAT_MS. */
    std::vector<Vec3> frames(const Vec3 &point) const;
    /* Takes the tissue that is at `point` after expiration, and returns its position after inspiration; both
     * positions are at the end of diastole. */
    Vec3 inhaled(const Vec3 &point) const;
    /* Returns the smallest ratio between the volume of a small piece of tissue in any frame and its volume at
     * the end of diastole. The pieces of tissue lie on a grid through and around the heart. If the smallest
     * ratio is above 0, the map of the heart's motion nowhere turns the tissue inside out. If the map folds
     * nowhere, surfaces that do not cross at the end of diastole do not cross in any frame. */
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
