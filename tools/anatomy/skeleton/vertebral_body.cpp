#include "tools/anatomy/skeleton/vertebral_body.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

VertebralBody::VertebralBody(const Vec3 &centre, const Eigen::Matrix3d &rotation,
                             const BodyMeasures &measures)
    : centre_(centre), inverse_(rotation.transpose()), measures_(measures)
{
    const double spur_mm = std::max(measures.right_spur_mm, measures.left_spur_mm);
    const Vec3 half(0.5 * std::max(measures.upper_width_mm, measures.lower_width_mm) + spur_mm,
                    0.5 * std::max(measures.front_height_mm, measures.back_height_mm) + 0.5 * spur_mm,
                    0.5 * measures.depth_mm + spur_mm);
    const Vec3 reach = rotation.cwiseAbs() * half;
    bounds.include(centre - reach, 0.0);
    bounds.include(centre + reach, 0.0);
}

double VertebralBody::distance(const Vec3 &point) const
{
    constexpr double WAIST = 0.10;       // the waist is 0.90 of the end plates (0.87 to 0.93)
    constexpr double RIM_ROUND_MM = 2.2; // assumed
    // The section is a part of an ellipse: its back is cut off where it is BACK of the width (assumed).
    constexpr double LONG = 0.62, SHIFT = 0.12, BACK_ROUND_MM = 5.0;
    const BodyMeasures &m = measures_;
    const Vec3 local = inverse_ * (point - centre_);
    const double ahead = std::clamp(local.z() / m.depth_mm + 0.5, 0.0, 1.0);
    const double half_height = 0.5 * (m.back_height_mm + ahead * (m.front_height_mm - m.back_height_mm));
    const double level = std::clamp(local.y() / half_height, -1.0, 1.0);
    const double girth = 1.0 - WAIST * (1.0 - level * level);
    const double width = m.lower_width_mm + 0.5 * (level + 1.0) * (m.upper_width_mm - m.lower_width_mm);

    const double aside = std::clamp(2.0 * local.x() / width, -1.0, 1.0);
    const double edge = smooth_step(0.72, 1.0, std::abs(level));
    const double spur = edge * std::abs(aside) * (aside < 0.0 ? m.right_spur_mm : m.left_spur_mm);

    const double half_width = 0.5 * girth * width + spur, half_depth = LONG * girth * m.depth_mm + 0.4 * spur;
    const double z = local.z() + SHIFT * girth * m.depth_mm;
    const double from_side = ellipsoid_distance({local.x(), z, 0.0}, {half_width, half_depth, half_width});
    const double middle = std::max(0.0, 1.0 - 4.0 * aside * aside);
    const double from_back = -local.z() - 0.5 * girth * m.depth_mm + m.notch_mm * middle;

    const double radial = std::hypot(local.x() / half_width, z / half_depth);
    const double hollow = m.hollow_mm * (1.0 - smooth_step(0.15, 0.95, radial));
    const double from_plate = std::abs(local.y()) - half_height + hollow;
    return smooth_max(smooth_max(from_side, from_back, BACK_ROUND_MM), from_plate, RIM_ROUND_MM);
}

} // namespace anatomy
