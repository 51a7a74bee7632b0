#include "tools/anatomy/build.hpp"
#include "tools/anatomy/clutter.hpp"
#include "tools/anatomy/heart_sequence.hpp"
#include "tools/anatomy/skeleton.hpp"
#include "tools/anatomy/soft_bodies.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* GAP_MM is the smallest permitted distance between neighbouring bodies of the anatomy. GAP_MM is larger than
 * the sum of the errors that mesh simplification may cause on two facing surfaces. */
constexpr double GAP_MM = 0.9, SHELL_MM = 1.0;
/* The meshes of thin bones are simplified less than those of other bones. An X-ray picture along the iliac
 * wing, whose cortex is 2 mm thick, shows a patch of the surface as a streak if its direction is wrong by
 * 3 degrees. */
constexpr double BONE_ERROR_MM = 0.18, THIN_BONE_ERROR_MM = 0.1;
/* The inner surface of the cortex is uneven by GRAIN_MM, or by THIN_BONE_GRAIN_MM in thin bones, so that
 * bones look grainy in the X-ray picture. */
constexpr double GRAIN_MM = 0.12, THIN_BONE_GRAIN_MM = 0.05;

/* Returns a smooth function of the position that has the given wavelength and values between about -1 and 1.
 * The unevenness makes the surfaces of bones look natural, because real bone is not a perfect surface of
 * revolution. */
double unevenness(const Vec3 &p, double wavelength_mm)
{
    const Vec3 q = p * (6.283 / wavelength_mm);
    return std::sin(q.x() + 0.7 * q.y()) * std::sin(q.y() - 0.6 * q.z() + 1.3) *
           std::sin(q.z() + 0.5 * q.x() + 2.1);
}

// --- bones ---

struct BoneGroup {
    const char *name;
    Solid solid;
    double voxel_mm, error_mm, grain_mm;
    double density = 1.0; // of its spongy bone, in parts of that of a lumbar vertebra; 0: nominal
};

/* Returns the distance function of one group of bones. Every bone of the group stays at least GAP_MM away
 * from the bones in `before`. */
LocalDistance bone_distance(const Solid &bone, const Solid &before)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [own = bone.near(box, reach_mm + 1.0), other = before.near(box, GAP_MM + 0.1)](const Vec3 &p) {
            const double surface = own.distance(p) + 0.35 * unevenness(p, 17.0);
            return std::max(smooth_max(surface, beyond_cuts(p), 1.0), GAP_MM - other.distance(p));
        };
    };
}

LocalDistance marrow_distance(const Solid &bone, double grain_mm, const Solid &before)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [grain_mm, own = bone.near(box, reach_mm + 1.0),
                other = before.near(box, GAP_MM + SHELL_MM + 0.1)](const Vec3 &p) {
            const double surface =
                own.marrow_distance(p) + 0.35 * unevenness(p, 17.0) + grain_mm * (1.0 + unevenness(p, 6.1));
            return std::max(smooth_max(surface, beyond_cuts(p) + SHELL_MM, 1.0),
                            GAP_MM + SHELL_MM - other.distance(p));
        };
    };
}

void add_bone(std::vector<Body> &bodies, const BoneGroup &group, const Solid &before,
              const SkeletonShape &shape, double scale)
{
    const std::string name = group.name;
    const Box where = grown(group.solid.bounds, 2.0);
    // On a coarser grid, the marrow of a thin bone would reach out of its cortex.
    const double voxel_mm = group.voxel_mm * std::min(scale, 1.5);
    bodies.push_back({name,
                      "cortical_bone",
                      "flesh",
                      {where, bone_distance(group.solid, before), voxel_mm, group.error_mm}});
    bodies.push_back(
        {name + "_marrow",
         spongy_material(group.density, shape),
         name,
         {where, marrow_distance(group.solid, group.grain_mm, before), voxel_mm, group.error_mm}});
}

/* Adds the calcium of the costal cartilages, if there is any. Cartilage itself attenuates X-rays like the
 * muscle around it, so it is no body; the lungs and the heart leave its space free. */
void add_cartilages(std::vector<Body> &bodies, Solid &bones, const SkeletonShape &shape, double scale)
{
    const Solid calcium = cartilage_calcium(shape);
    if (!calcium.is_empty())
        bodies.push_back(
            {"cartilage_calcium",
             "cortical_bone",
             "flesh",
             {grown(calcium.bounds, 2.0), bone_distance(calcium, bones), 1.4 * std::min(scale, 1.2),
              BONE_ERROR_MM, 0.0, true}}); // a little calcium may be finer than the grid
    bones.add(costal_cartilages(shape));
}

} // namespace

MeshRequest lumen_request(const VesselTree &tree, const Fineness &fineness, const std::vector<Curve> &small)
{
    constexpr double CORONARY_VOXEL_MM = 0.45; // for the smallest radius, 0.6 mm
    constexpr double SMALL_FILLET_MM = 0.8;    // triangles would cross in a sharp groove
    const Solid lumen = tree_solid(tree, 0.0);
    const double voxel_mm = tree.coronary_count > 0 ? std::min(fineness.lumen_voxel_mm, CORONARY_VOXEL_MM)
                                                    : fineness.lumen_voxel_mm;
    MeshRequest request{grown(lumen.bounds, 2.0), local_distance(lumen), voxel_mm, 0.03};
    if (small.empty()) return request;
    Part arteries(SMALL_FILLET_MM);
    for (const Curve &curve : small) arteries.add<Tube>(curve);
    Solid solid;
    solid.add(arteries);
    request.bounds.include(grown(solid.bounds, 2.0));
    request.distance_in = [large = local_distance(lumen), thin = local_distance(solid)](const Box &box,
                                                                                        double reach_mm) {
        return [near_large = large(box, reach_mm + SMALL_FILLET_MM),
                near_thin = thin(box, reach_mm + SMALL_FILLET_MM)](const Vec3 &point) {
            return smooth_min(near_large(point), near_thin(point), SMALL_FILLET_MM);
        };
    };
    return request;
}

std::vector<Body> patient_bodies(const VesselTree &tree, const Fineness &fineness, const Person &person)
{
    // The vertices of each frame are rounded to a micrometre in the file. If the mesh had edges of about a
    // micrometre, rounding would turn some triangles over.
    constexpr double SHORTEST_MM = 0.02;
    const double scale = fineness.body_scale;
    const SkeletonShape shape = skeleton_shape(person);
    const SoftShape soft = soft_shape(person);
    const BoneGroup groups[] = {
        {"spine", spine_bones(shape), 1.6, BONE_ERROR_MM, GRAIN_MM},
        {"ribs", rib_bones(shape), 1.6, BONE_ERROR_MM, GRAIN_MM},
        {"pelvis", pelvis_bones(shape), 1.8, THIN_BONE_ERROR_MM, THIN_BONE_GRAIN_MM, 1.1},
        {"femurs", femur_bones(shape), 1.8, BONE_ERROR_MM, GRAIN_MM, 1.6},
        {"shoulders", shoulder_bones(shape), 1.8, THIN_BONE_ERROR_MM, THIN_BONE_GRAIN_MM},
        {"head", head_bones(), 1.8, THIN_BONE_ERROR_MM, THIN_BONE_GRAIN_MM, 0.0},
        {"forearms", forearm_bones(shape), 1.8, BONE_ERROR_MM, GRAIN_MM}};
    Solid bones;
    std::vector<Body> skeleton;
    for (const BoneGroup &group : groups) {
        add_bone(skeleton, group, bones, shape, scale);
        bones.add(group.solid);
    }
    Solid hard = bones;
    hard.add(cartilage_calcium(shape));
    const std::vector<Body> clutter = clutter_bodies(person.clutter, soft, hard, scale);
    add_cartilages(skeleton, bones, shape, scale);
    // Lungs, heart and layers leave space for metal as for bones.
    if (person.clutter.wires) bones.add(sternal_wires());
    if (person.clutter.pacemaker) bones.add(pacemaker());
    std::vector<Body> bodies = layer_bodies(soft, bones, scale);
    bodies.insert(bodies.end(), skeleton.begin(), skeleton.end());
    for (const Body &body : chest_bodies(soft, bones, tree, scale)) bodies.push_back(body);
    for (const Body &body : belly_bodies(soft, bones, tree, scale)) bodies.push_back(body);
    bodies.insert(bodies.end(), clutter.begin(), clutter.end());
    if (tree.coronary_count > 0)
        for (Body &body : bodies)
            if (moves_with_heart(body.name)) body.request.shortest_mm = SHORTEST_MM;
    return bodies;
}

std::vector<Body> phantom_bodies(const VesselTree &tree, const Fineness &fineness)
{
    constexpr double WALL_MM = 2.0, TANK_MM = 14.0, ERROR_MM = 0.08;
    const Solid wall = tree_solid(tree, WALL_MM), lumen = tree_solid(tree, 0.0);
    const Box outer = grown(wall.bounds, TANK_MM);
    const Distance tank = [outer](const Vec3 &p) {
        constexpr double ROUND_MM = 4.0;
        const Vec3 half = 0.5 * (outer.high - outer.low), centre = 0.5 * (outer.high + outer.low);
        const Vec3 offset = (p - centre).cwiseAbs() - half + Vec3::Constant(ROUND_MM);
        return offset.cwiseMax(0.0).norm() + std::min(0.0, offset.maxCoeff()) - ROUND_MM;
    };
    const double scale = fineness.body_scale;
    return {
        {"tank",
         "soft",
         "",
         {grown(outer, 4.0), [tank](const Box &, double) { return tank; }, 4.0 * scale, ERROR_MM}},
        {"wall", "silicone", "tank", {grown(wall.bounds, 2.0), local_distance(wall), 1.2 * scale, ERROR_MM}},
        {"fluid", "blood", "wall", {grown(lumen.bounds, 2.0), local_distance(lumen), 1.2 * scale, ERROR_MM}}};
}

} // namespace anatomy
