#include "tools/anatomy/small/beside_bones.hpp"
#include "tools/anatomy/skeleton.hpp"
#include <algorithm>

namespace anatomy
{

namespace
{

constexpr double CLEARANCE_MM = 1.5, NEARLY_MM = 0.5; // the least clearance is their difference

/* How far the wall must move away from the bones at a point. */
double lack_mm(const Solid &bones, const Vec3 &at, double radius_mm)
{
    return radius_mm + CLEARANCE_MM - bones.distance(at);
}

/* The direction in which the distance from the bones grows fastest. */
Vec3 away_from(const Solid &bones, const Vec3 &at)
{
    constexpr double REACH_MM = 0.5;
    Vec3 slope;
    for (int axis = 0; axis < 3; axis++)
        slope[axis] = bones.distance(at + REACH_MM * Vec3::Unit(axis)) -
                      bones.distance(at - REACH_MM * Vec3::Unit(axis));
    return slope.norm() > 1e-9 ? slope.normalized() : Vec3::UnitZ();
}

/* Each point moves as its neighbours do on average, so that the course stays smooth. */
void smooth(std::vector<Vec3> &moves)
{
    const std::vector<Vec3> before = moves;
    for (size_t i = 1; i < moves.size(); i++) {
        const Vec3 &next = before[std::min(i + 1, moves.size() - 1)];
        moves[i] = 0.25 * before[i - 1] + 0.5 * before[i] + 0.25 * next;
    }
}

} // namespace

Solid bones_beside(const SkeletonShape &shape)
{
    Solid bones;
    for (const Solid &group : {spine_bones(shape), rib_bones(shape), pelvis_bones(shape), femur_bones(shape),
                               shoulder_bones(shape), forearm_bones(shape), vertebral_discs(shape)})
        bones.add(group);
    return bones;
}

Vessel beside_bones(const Vessel &artery, const Solid &all_bones)
{
    constexpr int ROUNDS = 100, SMOOTH_ROUNDS = 80;
    constexpr double STEP_MM = 3.0, REACH_MM = 12.0;
    if (artery.name.find("vertebral") != std::string::npos) return artery;
    const Curve curve = vessel_curve(artery, STEP_MM);
    Box box;
    for (const CurvePoint &point : curve) box.include(point.position_mm, 0.0);
    const Solid bones = all_bones.near(box, REACH_MM);
    if (bones.is_empty()) return artery;
    if (std::all_of(curve.begin(), curve.end(), [&](const CurvePoint &point) {
            return lack_mm(bones, point.position_mm, point.radius_mm) <= 0.0;
        }))
        return artery;
    std::vector<Vec3> moves(curve.size(), Vec3::Zero());
    for (int round = 0; round < ROUNDS; round++) {
        double most_mm = 0.0;
        for (size_t i = 1; i < curve.size(); i++) {
            const Vec3 at = curve[i].position_mm + moves[i];
            const double lack = lack_mm(bones, at, curve[i].radius_mm);
            if (lack <= 0.0) continue;
            moves[i] += lack * away_from(bones, at);
            most_mm = std::max(most_mm, lack);
        }
        if (most_mm < NEARLY_MM) break;
        if (round < SMOOTH_ROUNDS) smooth(moves); // the last rounds only move out
    }
    Vessel bent = artery;
    bent.stations.clear();
    for (size_t i = 0; i < curve.size(); i++)
        bent.stations.push_back({curve[i].position_mm + moves[i], 2.0 * curve[i].radius_mm, "", ""});
    return bent;
}

} // namespace anatomy
