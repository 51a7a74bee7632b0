/* Makes courses of arteries on the surface of the shipped heart. A course is given by heights and angles
 * about the axis of the left ventricle (HeartAxes). */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <optional>

namespace anatomy
{

/* A station on the heart's surface. A diameter of 0 means that the diameter is interpolated between the
 * neighbouring marks. */
struct HeartMark {
    double height, angle_deg, diameter_mm;
    std::string name, source;
};

/* Follows a ray from the axis straight outwards, and returns the place slightly beyond the heart's
 * surface, because arteries lie half in their grooves. Returns nothing if the ray does not begin inside
 * the heart. */
std::optional<Vec3> on_heart(double height, double angle_deg);

/* Returns the stations of the course through at least two marks, with unnamed stations every few millimetres
 * between them. The first and the last mark must have a diameter, and no two neighbours may be at the same
 * place. Throws std::domain_error when the course leaves the heart. */
std::vector<Station> heart_course(const std::vector<HeartMark> &marks);

} // namespace anatomy
