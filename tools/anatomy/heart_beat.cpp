#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

/* Makes a spline over the phase of the heartbeat that repeats with every beat. Each knot of the spline has a
 * time in milliseconds and a value. */
Spline course(const std::vector<std::pair<double, double>> &knots)
{
    std::vector<double> phase, value;
    for (int beat = -1; beat <= 1; beat++)
        for (const auto &[ms, share] : knots) {
            phase.push_back(ms / BEAT_MS + beat);
            value.push_back(share);
        }
    return Spline(phase, value);
}

Spline profile(const std::vector<std::pair<double, double>> &knots)
{
    std::vector<double> height, value;
    for (const auto &[at, is] : knots) {
        height.push_back(at);
        value.push_back(is);
    }
    return Spline(height, value);
}

/* Returns the descending aorta, which begins at the end of the arch. The descending aorta lies behind the
 * heart and does not move. */
Solid descending_aorta(const Vessel &aorta)
{
    Curve curve = vessel_curve(aorta, 2.0);
    std::erase_if(
        curve, [](const CurvePoint &at) { return at.position_mm.z() > -30.0 || at.position_mm.y() < -20.0; });
    Part part(0.0);
    part.add<Tube>(curve);
    Solid solid;
    solid.add(part);
    return solid;
}

} // namespace

const HeartAxes &heart_axes()
{
    static const HeartAxes axes = [] {
        const Vec3 apex(78, 69, 48), base(4, 117, 2);
        HeartAxes made;
        made.apex_mm = apex;
        made.length_mm = (base - apex).norm();
        made.up = (base - apex) / made.length_mm;
        const Vec3 front(0, 0.35, 1);
        made.anterior = (front - made.up * front.dot(made.up)).normalized();
        made.lateral = made.up.cross(made.anterior);
        return made;
    }();
    return axes;
}

Vec3 HeartAxes::outward(double angle_deg) const
{
    const double angle = angle_deg * std::numbers::pi / 180.0;
    return std::cos(angle) * anterior + std::sin(angle) * lateral;
}

HeartBeat::HeartBeat(const Vessel &aorta)
    : outline_(heart_outline()), behind_(descending_aorta(aorta)),
      left_ventricle_(heart_chambers()[0].distance),
      radial_(course({{0, 0},       {45, 0.02},   {100, 0.12},  {150, 0.33},  {210, 0.61},  {270, 0.8},
                      {320, 0.885}, {352, 0.953}, {388, 1},     {424, 0.953}, {458, 0.838}, {492, 0.7},
                      {526, 0.525}, {562, 0.385}, {602, 0.285}, {642, 0.235}, {682, 0.2},   {722, 0.165},
                      {762, 0.115}, {802, 0.06},  {832, 0.02}})),
      longitudinal_(course(
          {{0, 0},       {45, 0.04},  {100, 0.18},  {150, 0.41},  {210, 0.68},  {270, 0.84}, {320, 0.905},
           {352, 0.955}, {386, 1},    {420, 0.952}, {454, 0.83},  {488, 0.685}, {522, 0.5},  {558, 0.365},
           {600, 0.275}, {642, 0.23}, {682, 0.196}, {722, 0.162}, {762, 0.113}, {802, 0.06}, {832, 0.02}})),
      twist_(course({{0, 0},
                     {60, 0.06},
                     {120, 0.27},
                     {200, 0.62},
                     {280, 0.89},
                     {340, 0.985},
                     {372, 1},
                     {410, 0.95},
                     {450, 0.8},
                     {490, 0.57},
                     {540, 0.33},
                     {600, 0.18},
                     {660, 0.13},
                     {720, 0.1},
                     {780, 0.06},
                     {825, 0.02}})),
      descent_(profile({{-0.4, 0},
                        {-0.1, 0},
                        {0, 0.01},
                        {0.2, 0.17},
                        {0.4, 0.37},
                        {0.6, 0.58},
                        {0.8, 0.8},
                        {0.95, 0.96},
                        {1.1, 1},
                        {1.3, 0.85},
                        {1.5, 0.55},
                        {1.7, 0.22},
                        {1.9, 0.03},
                        {2.1, 0},
                        {2.4, 0}})),
      inward_(profile({{-0.4, 0},
                       {-0.2, 0},
                       {0, 0.4},
                       {0.15, 0.85},
                       {0.3, 1},
                       {0.55, 1},
                       {0.8, 1},
                       {0.95, 0.8},
                       {1.1, 0.4},
                       {1.3, 0.1},
                       {1.5, 0},
                       {2, 0}})),
      turn_deg_(
          profile({{-0.4, 10}, {0, 10}, {0.5, 2.4}, {1, -5}, {1.3, -3.6}, {1.6, -1}, {1.8, 0}, {2.2, 0}}))
{
}

HeartBeat::Place HeartBeat::place(const Vec3 &point) const
{
    // The inner surface of the heart's wall moves further than the outer surface, and the right side of the
    // heart's base descends further than the left side. The free wall of the right ventricle moves further
    // than the other walls of the heart.
    constexpr double INNER = 0.34, OUTER = 0.12, RIGHT_OUTER = 0.33, WALL_MM = 10.0;
    constexpr double LEFT_DESCENT_MM = 14.0, RIGHT_DESCENT_MM = 22.0, RIGHT_AT_MM = 48.0, RIGHT_DEG = 300.0;
    constexpr double MOVES_WITHIN_MM = 3.0, RESTS_BEYOND_MM = 38.0, HELD_MM = 22.0;
    const HeartAxes &axes = heart_axes();
    Place place;
    place.point = point;
    place.height = axes.height(point);
    place.across = axes.across(point);
    const double height = std::clamp(place.height, -0.4, 2.0);
    const double depth = smooth_step(0.0, WALL_MM, left_ventricle_(point));
    const double right = smooth_step(0.0, RIGHT_AT_MM, place.across.dot(axes.outward(RIGHT_DEG)));
    const double outer = OUTER + (RIGHT_OUTER - OUTER) * right;
    place.inward = (INNER + (outer - INNER) * depth) * inward_.at(height);
    place.descent_mm = (LEFT_DESCENT_MM + (RIGHT_DESCENT_MM - LEFT_DESCENT_MM) * right) * descent_.at(height);
    place.turn_rad = turn_deg_.at(height) * std::numbers::pi / 180.0;
    place.share = (1.0 - smooth_step(MOVES_WITHIN_MM, RESTS_BEYOND_MM, outline_.distance(point))) *
                  smooth_step(0.0, HELD_MM, behind_.distance(point));
    return place;
}

Vec3 HeartBeat::moved(const Place &here, double phase) const
{
    const HeartAxes &axes = heart_axes();
    // A turn that a viewer at the apex sees as counter-clockwise is right-handed about the direction from
    // the base to the apex.
    const Eigen::AngleAxisd turn(here.turn_rad * twist_.at(phase), -axes.up);
    const Vec3 across = turn * here.across * (1.0 - here.inward * radial_.at(phase));
    const Vec3 way = across - here.across - axes.up * (here.descent_mm * longitudinal_.at(phase));
    return here.point + here.share * way;
}

std::vector<Vec3> HeartBeat::frames(const Vec3 &point) const
{
    const Place here = place(point);
    if (here.share <= 0.0) return std::vector<Vec3>(BEAT_FRAMES, point);
    std::vector<Vec3> places;
    for (int frame = 0; frame < BEAT_FRAMES; frame++)
        places.push_back(moved(here, static_cast<double>(frame) / BEAT_FRAMES));
    return places;
}

double HeartBeat::least_volume_factor() const
{
    constexpr double APART_MM = 9.0, STEP_MM = 0.5, AROUND_MM = 40.0;
    Box box = outline_.bounds;
    const Vec3 low = box.low, high = box.high;
    box.include(low, AROUND_MM);
    box.include(high, AROUND_MM);
    double least = 1.0;
    for (double x = box.low.x(); x < box.high.x(); x += APART_MM)
        for (double y = box.low.y(); y < box.high.y(); y += APART_MM)
            for (double z = box.low.z(); z < box.high.z(); z += APART_MM) {
                const Vec3 point(x, y, z);
                const std::vector<Vec3> here = frames(point);
                std::vector<Vec3> beside[3];
                for (int axis = 0; axis < 3; axis++)
                    beside[axis] = frames(point + STEP_MM * Vec3::Unit(axis));
                for (size_t k = 0; k < BEAT_FRAMES; k++) {
                    const Vec3 a = beside[0][k] - here[k], b = beside[1][k] - here[k],
                               c = beside[2][k] - here[k];
                    least = std::min(least, a.cross(b).dot(c) / (STEP_MM * STEP_MM * STEP_MM));
                }
            }
    return least;
}

Vec3 HeartBeat::inhaled(const Vec3 &point) const
{
    constexpr double FADES_MM = 70.0;
    const Vec3 way(0.0, -8.0, 1.5);
    const double share = 1.0 - smooth_step(0.0, FADES_MM, outline_.distance(point));
    return point + share * smooth_step(0.0, FADES_MM, behind_.distance(point)) * way;
}

} // namespace anatomy
