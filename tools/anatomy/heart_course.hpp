/* Computes the courses of arteries along the surface of the shipped heart. The course of an artery is a list
 * of points, each with a height along the axis of the left ventricle and an angle about this axis
 * (HeartAxes). */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <optional>

namespace anatomy
{

/* Describes a point on the heart's surface through which an artery passes. For a point with a diameter of 0,
 * the artery's diameter is interpolated between the neighbouring points. */
struct HeartMark {
    double height, angle_deg, diameter_mm;
    std::string name, source;
};

/* Follows a ray from the heart's axis straight outwards and returns a point slightly beyond the heart's
 * surface. The returned point lies outside the surface because only half of an artery's cross-section lies in
 * its groove in the heart. Returns std::nullopt if the ray does not begin inside the heart. */
std::optional<Vec3> on_heart(double height, double angle_deg);

/* Returns a centreline through at least two given points on the heart, with unnamed points every few
 * millimetres between them. The first and the last of the given points must have a diameter, and no two
 * neighbouring given points may be at the same position. Throws std::domain_error when the artery's course
 * leaves the heart. */
std::vector<Station> heart_course(const std::vector<HeartMark> &marks);

} // namespace anatomy
