#include "tools/anatomy/varied/plausible.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

constexpr double POINTS_APART_MM = 2.0;            // between the measured points of a centreline
constexpr double NEAR_ORIGIN_MM = 25.0;            // two vessels may be close there: they have just parted
constexpr double APART_MM = 1.0, BEND_RADII = 1.5; // what a rule asks for
constexpr double ROUNDING = 0.01;

double to_bone_mm(const Curve &curve, const Solid &bones)
{
    double least_mm = 1e9;
    for (const CurvePoint &point : curve)
        least_mm = std::min(least_mm, bones.distance(point.position_mm) - point.radius_mm);
    return least_mm;
}

/* The circle goes through three points of a curve that are `reach` samples apart. */
double bend_radii(const Curve &curve)
{
    constexpr size_t REACH = 3;
    double least = 1e9;
    for (size_t i = REACH; i + REACH < curve.size(); ++i) {
        const Vec3 a = curve[i].position_mm - curve[i - REACH].position_mm,
                   b = curve[i + REACH].position_mm - curve[i].position_mm;
        const double cross = a.cross(b).norm();
        if (cross < 1e-9) continue;
        least = std::min(least, a.norm() * b.norm() * (a + b).norm() / (2 * cross) / curve[i].radius_mm);
    }
    return least;
}

/* The distance between a parent and its own branch is not measured, because a branch may leave its parent at
 * any angle.
 */
double apart_mm(const Vessel &one, const Curve &curve, const Vessel &other, const Curve &other_curve,
                double near_origin_mm)
{
    double least_mm = 1e9;
    if (one.parent == other.name || other.parent == one.name) return least_mm;
    const auto beyond = [&](const Vessel &vessel, const CurvePoint &point) {
        return vessel.parent.empty() || point.arc_mm > near_origin_mm;
    };
    for (const CurvePoint &a : curve) {
        if (!beyond(one, a)) continue;
        for (const CurvePoint &b : other_curve)
            if (beyond(other, b))
                least_mm =
                    std::min(least_mm, (a.position_mm - b.position_mm).norm() - a.radius_mm - b.radius_mm);
    }
    return least_mm;
}

} // namespace

Solid trunk_bones(const SkeletonShape &shape)
{
    // A person's lumen is the same with the arms in either place.
    SkeletonShape raised = shape, beside = shape;
    raised.arms = Arms::raised;
    beside.arms = Arms::beside;
    Solid solid;
    for (const Solid &one : {spine_bones(shape), rib_bones(shape), pelvis_bones(shape), femur_bones(shape),
                             shoulder_bones(raised), shoulder_bones(beside)})
        solid.add(one);
    return solid;
}

TreeSpaces spaces_of(const std::vector<Vessel> &vessels, const Solid &bones)
{
    TreeSpaces spaces;
    std::vector<Curve> curves;
    for (const Vessel &vessel : vessels) {
        curves.push_back(vessel_curve(vessel, POINTS_APART_MM));
        spaces.to_bone_mm.push_back(to_bone_mm(curves.back(), bones));
        spaces.bend_radii.push_back(bend_radii(curves.back()));
        std::vector<double> &row = spaces.apart_mm.emplace_back();
        const size_t i = curves.size() - 1;
        for (size_t j = 0; j < i; ++j)
            row.push_back(apart_mm(vessel, curves[i], vessels[j], curves[j], NEAR_ORIGIN_MM));
    }
    return spaces;
}

std::string broken_coronary_rule(const std::vector<Vessel> &vessels)
{
    constexpr double STEP_MM = 1.0, NEAR_FORK_MM = 9.0;
    std::vector<Curve> curves;
    for (const Vessel &vessel : vessels) curves.push_back(vessel_curve(vessel, STEP_MM));
    for (size_t i = 0; i < vessels.size(); ++i) {
        if (vessels[i].bed == Bed::body) continue;
        const char *name = vessels[i].name.c_str();
        const double bend = bend_radii(curves[i]);
        if (bend < BEND_RADII) return crn::formatted("%s: a bend of %.1f radii", name, bend);
        for (size_t j = 0; j < i; ++j) {
            const double apart = apart_mm(vessels[i], curves[i], vessels[j], curves[j], NEAR_FORK_MM);
            if (apart < APART_MM)
                return crn::formatted("%s: %.1f mm from %s", name, apart, vessels[j].name.c_str());
        }
    }
    return "";
}

std::string broken_rule(const std::vector<Vessel> &vessels, const TreeSpaces &usual, const Solid &bones)
{
    const TreeSpaces spaces = spaces_of(vessels, bones);
    const auto is_short = [](double value, double shipped, double wanted) {
        return value < std::min(shipped, wanted) - ROUNDING;
    };
    for (size_t i = 0; i < vessels.size(); ++i) {
        const char *name = vessels[i].name.c_str();
        if (is_short(spaces.to_bone_mm[i], usual.to_bone_mm[i], TO_BONE_MM))
            return crn::formatted("%s: %.1f mm from a bone", name, spaces.to_bone_mm[i]);
        if (is_short(spaces.bend_radii[i], usual.bend_radii[i], BEND_RADII))
            return crn::formatted("%s: a bend of %.1f radii", name, spaces.bend_radii[i]);
        for (size_t j = 0; j < i; ++j)
            if (is_short(spaces.apart_mm[i][j], usual.apart_mm[i][j], APART_MM))
                return crn::formatted("%s: %.1f mm from %s", name, spaces.apart_mm[i][j],
                                      vessels[j].name.c_str());
    }
    return "";
}

} // namespace anatomy
