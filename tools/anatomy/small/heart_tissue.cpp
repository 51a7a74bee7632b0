#include "tools/anatomy/small/heart_tissue.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/heart_course.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

using std::numbers::pi;
constexpr double LOW = 0.02, HIGH = 1.04, HEIGHT_STEP = 0.03, ANGLE_STEP_DEG = 6.0;
constexpr int HEIGHTS = 35, ANGLES = 60;

double wrapped(double angle_deg)
{
    return angle_deg - 360.0 * std::floor(angle_deg / 360.0);
}

/* Follows the ray from the axis outwards to where the distance passes 0. */
double cavity_radius_mm(const Distance &cavity, double height, double angle_deg)
{
    constexpr double FAR_MM = 60.0;
    const HeartAxes &axes = heart_axes();
    const Vec3 start = axes.on_axis(height), out = axes.outward(angle_deg);
    double inside = 0.0, outside = FAR_MM;
    if (cavity(start) > 0.0) return 0.0;
    for (int halving = 0; halving < 24; halving++) {
        const double middle = 0.5 * (inside + outside);
        (cavity(start + middle * out) < 0.0 ? inside : outside) = middle;
    }
    return outside;
}

} // namespace

HeartTissue::HeartTissue()
{
    const std::vector<Chamber> chambers = heart_chambers();
    const HeartAxes &axes = heart_axes();
    for (int h = 0; h < HEIGHTS; h++)
        for (int a = 0; a < ANGLES; a++) {
            const double height = LOW + HEIGHT_STEP * h, angle_deg = ANGLE_STEP_DEG * a;
            const std::optional<Vec3> surface = on_heart(height, angle_deg);
            outer_mm_.push_back(surface ? (*surface - axes.on_axis(height)).norm() : 1.0);
            cavity_mm_.push_back(cavity_radius_mm(chambers[0].distance, height, angle_deg));
        }
}

double HeartTissue::radius_mm(const std::vector<double> &table, double height, double angle_deg) const
{
    const double h = std::clamp((height - LOW) / HEIGHT_STEP, 0.0, HEIGHTS - 1.001),
                 a = std::min(wrapped(angle_deg) / ANGLE_STEP_DEG, ANGLES - 1e-6);
    const auto row = static_cast<size_t>(h), column = static_cast<size_t>(a);
    const double v = h - static_cast<double>(row), u = a - static_cast<double>(column);
    const auto at = [&](size_t r, size_t c) { return table[r * ANGLES + c % ANGLES]; };
    return (1 - v) * ((1 - u) * at(row, column) + u * at(row, column + 1)) +
           v * ((1 - u) * at(row + 1, column) + u * at(row + 1, column + 1));
}

TissuePlace HeartTissue::place(double height, double angle_deg, double depth_mm, int layer) const
{
    const HeartAxes &axes = heart_axes();
    const double held = std::clamp(height, LOW, HIGH);
    const double radius = layer == OUTER_LAYER
                              ? std::max(radius_mm(outer_mm_, held, angle_deg) - depth_mm, 1.0)
                              : radius_mm(cavity_mm_, held, angle_deg) + depth_mm;
    return {axes.on_axis(held) + radius * axes.outward(angle_deg), depth_mm, layer};
}

double HeartTissue::height(const Vec3 &at) const
{
    return heart_axes().height(at);
}

double HeartTissue::angle_deg(const Vec3 &at) const
{
    const HeartAxes &axes = heart_axes();
    const Vec3 across = axes.across(at);
    return wrapped(std::atan2(across.dot(axes.lateral), across.dot(axes.anterior)) * 180.0 / pi);
}

TissuePlace HeartTissue::onto(const TissuePlace &near) const
{
    return place(height(near.at), angle_deg(near.at), near.depth_mm, near.layer);
}

double HeartTissue::groove_deg(double height)
{
    static const MonotoneCubic groove({0.0, 0.2, 0.3, 0.4, 0.5, 0.62, 0.76, 1.0},
                                      {-25, 2, 9, 20, 36, 55, 61, 64});
    return groove.at(height);
}

/* The wall of the left ventricle is 10 mm thick, and that of the right one 2.5 mm. */
std::vector<TissuePlace> HeartTissue::scattered(double apart_mm, unsigned tries, std::uint64_t seed) const
{
    constexpr double WIDEST_MM = 55.0, OUTER_HIGH = 0.97, SEPTUM_HIGH = 0.85, SEPTUM_SHARE = 0.3;
    Chance chance(seed, 0);
    std::vector<TissuePlace> places;
    for (unsigned i = 0; i < tries; i++) {
        const bool is_septum = chance.uniform(0, 1) < SEPTUM_SHARE;
        const double height = chance.uniform(0.04, is_septum ? SEPTUM_HIGH : OUTER_HIGH),
                     angle_deg = chance.uniform(0, 360), at_depth = chance.uniform(0, 1);
        const double past_groove = wrapped(angle_deg - groove_deg(height)),
                     free_wall = wrapped(POSTERIOR_GROOVE_DEG - groove_deg(height));
        const bool is_left = past_groove < free_wall;
        if (is_septum && is_left) continue;
        const double depth_mm =
            is_septum ? 2.0 + 6.0 * at_depth : (is_left ? 0.8 + 8.0 * at_depth : 0.4 + 1.4 * at_depth);
        const TissuePlace there = place(height, angle_deg, depth_mm, is_septum ? SEPTUM_LAYER : OUTER_LAYER);
        const double radius = heart_axes().across(there.at).norm();
        if (chance.uniform(0, WIDEST_MM) > radius) continue;
        const bool is_free = std::none_of(places.begin(), places.end(), [&](const TissuePlace &other) {
            return (other.at - there.at).squaredNorm() < apart_mm * apart_mm;
        });
        if (is_free) places.push_back(there);
    }
    return places;
}

} // namespace anatomy
