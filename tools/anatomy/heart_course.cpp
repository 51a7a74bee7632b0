#include "tools/anatomy/heart_course.hpp"
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <stdexcept>

namespace anatomy
{

namespace
{

Vec3 place_of(double height, double angle_deg)
{
    const std::optional<Vec3> place = on_heart(height, angle_deg);
    if (!place) throw std::domain_error("the course leaves the heart's surface between two stations");
    return *place;
}

} // namespace

std::optional<Vec3> on_heart(double height, double angle_deg)
{
    constexpr double LIFT_MM = 0.5, FAR_MM = 90.0, STEP_MM = 0.5;
    static const Solid heart = heart_outline();
    const HeartAxes &axes = heart_axes();
    const Vec3 start = axes.on_axis(height), out = axes.outward(angle_deg);
    double inside = 0.0, outside = STEP_MM;
    if (heart.distance(start) >= LIFT_MM) return std::nullopt;
    while (heart.distance(start + outside * out) < LIFT_MM && outside < FAR_MM) {
        inside = outside;
        outside += STEP_MM;
    }
    for (int halving = 0; halving < 20; halving++) {
        const double middle = 0.5 * (inside + outside);
        (heart.distance(start + middle * out) < LIFT_MM ? inside : outside) = middle;
    }
    return start + outside * out;
}

std::vector<Station> heart_course(const std::vector<HeartMark> &marks)
{
    constexpr double APART_MM = 4.0;
    std::vector<double> arc, height, angle, arc_known, diameter;
    std::vector<Vec3> places;
    for (const HeartMark &mark : marks) {
        places.push_back(place_of(mark.height, mark.angle_deg));
        arc.push_back(arc.empty() ? 0.0 : arc.back() + (places.back() - places[places.size() - 2]).norm());
        height.push_back(mark.height);
        angle.push_back(mark.angle_deg);
        if (mark.diameter_mm <= 0.0) continue;
        arc_known.push_back(arc.back());
        diameter.push_back(mark.diameter_mm);
    }
    const Spline height_at(arc, height), angle_at(arc, angle);
    const MonotoneCubic diameter_at(arc_known, diameter);
    std::vector<Station> stations;
    for (size_t i = 0; i < marks.size(); i++) {
        stations.push_back({places[i], diameter_at.at(arc[i]), marks[i].name, marks[i].source});
        if (i + 1 == marks.size()) break;
        const int pieces = std::max(1, static_cast<int>((arc[i + 1] - arc[i]) / APART_MM));
        for (int k = 1; k < pieces; k++) {
            const double at = arc[i] + (arc[i + 1] - arc[i]) * k / pieces;
            stations.push_back({place_of(height_at.at(at), angle_at.at(at)), diameter_at.at(at), "", ""});
        }
    }
    return stations;
}

} // namespace anatomy
