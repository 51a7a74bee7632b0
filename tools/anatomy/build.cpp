#include "tools/anatomy/build.hpp"
#include "tools/anatomy/organs.hpp"
#include "tools/anatomy/skeleton.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* Least distance kept between neighbouring bodies, above what simplification may move both. */
constexpr double GAP_MM = 0.9, SHELL_MM = 1.0;
constexpr double BONE_ERROR_MM = 0.16, SOFT_ERROR_MM = 0.3;

/* The patient ends here; bones end a little inside the skin's cuts. Positive outside. */
constexpr double BONE_BOTTOM_MM = -422.0, BONE_TOP_MM = 344.0;

double beyond_cuts(const Vec3 &p)
{
    return std::max(BONE_BOTTOM_MM - p.y(), p.y() - BONE_TOP_MM);
}

Box grown(Box box, double margin_mm)
{
    box.low -= Vec3::Constant(margin_mm);
    box.high += Vec3::Constant(margin_mm);
    return box;
}

/* Smooth unevenness between about -1 and 1 with the given wavelength: bone is not turned on a lathe. */
double unevenness(const Vec3 &p, double wavelength_mm)
{
    const Vec3 q = p * (6.283 / wavelength_mm);
    return std::sin(q.x() + 0.7 * q.y()) * std::sin(q.y() - 0.6 * q.z() + 1.3) *
           std::sin(q.z() + 0.5 * q.x() + 2.1);
}

LocalDistance local(const Solid &solid)
{
    return [solid](const Box &box, double reach_mm) -> Distance {
        return [near = solid.near(box, reach_mm)](const Vec3 &p) { return near.distance(p); };
    };
}

// --- bones ------------------------------------------------------------------------------------------------------

struct BoneGroup {
    const char *name;
    Solid solid;
    double voxel_mm;
};

/* Bone of one group; it keeps its gap to the groups before it. */
LocalDistance bone_distance(const Solid &bone, const Solid &before)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [own = bone.near(box, reach_mm + 1.0), other = before.near(box, GAP_MM + 0.1)](const Vec3 &p) {
            const double surface = own.distance(p) + 0.35 * unevenness(p, 17.0);
            return std::max(smooth_max(surface, beyond_cuts(p), 1.0), GAP_MM - other.distance(p));
        };
    };
}

LocalDistance marrow_distance(const Solid &bone, const Solid &before)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [own = bone.near(box, reach_mm + 1.0),
                other = before.near(box, GAP_MM + SHELL_MM + 0.1)](const Vec3 &p) {
            const double surface =
                own.marrow_distance(p) + 0.35 * unevenness(p, 17.0) + 0.12 * (1.0 + unevenness(p, 6.1));
            return std::max(smooth_max(surface, beyond_cuts(p) + SHELL_MM, 1.0),
                            GAP_MM + SHELL_MM - other.distance(p));
        };
    };
}

void add_bone(std::vector<Body> &bodies, const BoneGroup &group, const Solid &before, double scale)
{
    const std::string name = group.name;
    const Box where = grown(group.solid.bounds, 2.0);
    const double voxel_mm = group.voxel_mm * scale;
    bodies.push_back({name,
                      "cortical_bone",
                      "skin",
                      {where, bone_distance(group.solid, before), voxel_mm, BONE_ERROR_MM}});
    bodies.push_back({name + "_marrow",
                      "trabecular_bone",
                      name,
                      {where, marrow_distance(group.solid, before), voxel_mm, BONE_ERROR_MM}});
}

// --- soft bodies ------------------------------------------------------------------------------------------------

/* The skin passes every bone with some flesh between. */
Body skin_body(const Solid &bones, double scale)
{
    const Solid outline = skin();
    const LocalDistance distance = [=](const Box &box, double reach_mm) -> Distance {
        constexpr double FLESH_MM = 5.0, BLEND_MM = 8.0;
        return [outline, near = bones.near(box, reach_mm + FLESH_MM + BLEND_MM)](const Vec3 &p) {
            const double own = outline.distance(p);
            if (own < -2.0 * FLESH_MM - BLEND_MM) return own;
            return smooth_min(own, std::max(near.distance(p), beyond_cuts(p)) - FLESH_MM, BLEND_MM);
        };
    };
    return {"skin", "soft", "", {grown(outline.bounds, 12.0), distance, 4.0 * scale, SOFT_ERROR_MM}};
}

/* One lung: its cavity less everything else in the chest. */
LocalDistance lung_distance(double sign, const Solid &bones)
{
    const Solid middle = mediastinum(), air = airway(), aorta_wall = tree_solid(aorta_tree(), 2.0);
    const Distance cavity = lung_cavity(sign);
    return [=](const Box &box, double reach_mm) -> Distance {
        constexpr double PLEURA_MM = 2.0;
        const double reach = reach_mm + PLEURA_MM + 1.0;
        return [=, heart = middle.near(box, reach), trachea = air.near(box, reach),
                aorta = aorta_wall.near(box, reach), bone = bones.near(box, reach)](const Vec3 &p) {
            double taken = std::min(trachea.distance(p), aorta.distance(p));
            taken = std::min(heart.distance(p), std::min(taken, bone.distance(p)) - PLEURA_MM);
            return smooth_max(cavity(p), -taken, 1.5);
        };
    };
}

/* Adds lungs with their vessels; they give way to bones, aorta, airway and mediastinum. */
void add_lungs(std::vector<Body> &bodies, const Solid &bones, double scale)
{
    for (double s : {-1.0, 1.0}) {
        const std::string name = s < 0 ? "lung_right" : "lung_left";
        const LocalDistance lung = lung_distance(s, bones);
        const Solid tree = lung_vessels(s, lung(lung_bounds(s), 20.0));
        const LocalDistance vessels = [=](const Box &box, double reach_mm) -> Distance {
            constexpr double INSIDE_MM = 1.3;
            return [own = tree.near(box, reach_mm), around = lung(box, reach_mm + INSIDE_MM)](const Vec3 &p) {
                const double distance = own.distance(p);
                return distance > 1e3 ? distance : std::max(distance, around(p) + INSIDE_MM);
            };
        };
        bodies.push_back(
            {name, "lung", "skin", {grown(lung_bounds(s), 4.0), lung, 2.2 * scale, SOFT_ERROR_MM}});
        bodies.push_back(
            {name + "_vessels", "blood", name, {grown(tree.bounds, 2.0), vessels, 1.2 * scale, 0.2}});
    }
}

/* Soft body that keeps clear of the bones. */
Body clear_of_bones(const char *name, const char *material, const Solid &solid, const Solid &bones,
                    double voxel_mm)
{
    const LocalDistance distance = [=](const Box &box, double reach_mm) -> Distance {
        constexpr double CLEAR_MM = 2.0;
        return [own = solid.near(box, reach_mm), bone = bones.near(box, reach_mm + CLEAR_MM)](const Vec3 &p) {
            return smooth_max(own.distance(p), CLEAR_MM - bone.distance(p), 1.0);
        };
    };
    return {name, material, "skin", {grown(solid.bounds, 3.0), distance, voxel_mm, SOFT_ERROR_MM}};
}

} // namespace

MeshRequest lumen_request(const VesselTree &tree, const Fineness &fineness)
{
    const Solid lumen = tree_solid(tree, 0.0);
    return {grown(lumen.bounds, 2.0), local(lumen), fineness.lumen_voxel_mm, 0.03};
}

std::vector<Body> patient_bodies(const Fineness &fineness)
{
    const double scale = fineness.body_scale;
    const BoneGroup groups[] = {{"spine", spine_bones(), 1.6},
                                {"ribs", rib_bones(), 1.6},
                                {"pelvis", pelvis_bones(), 1.8},
                                {"femurs", femur_bones(), 1.8},
                                {"shoulders", shoulder_bones(), 1.8}};
    Solid bones;
    std::vector<Body> bodies(1);
    for (const BoneGroup &group : groups) {
        add_bone(bodies, group, bones, scale);
        bones.add(group.solid);
    }
    bodies[0] = skin_body(bones, scale);
    add_lungs(bodies, bones, scale);
    bodies.push_back(clear_of_bones("heart", "blood", heart_blood(), bones, 2.2 * scale));
    bodies.push_back(clear_of_bones("airway", "air", airway(), bones, 1.5 * scale));
    bodies.push_back(clear_of_bones("bowel_gas", "air", bowel_gas(), bones, 2.0 * scale));
    bodies.push_back(clear_of_bones("kidney_fat", "adipose", kidney_fat(), bones, 2.2 * scale));
    return bodies;
}

/* A wall of silicone around the vessels in a tank of water, filled with a fluid like blood. */
std::vector<Body> phantom_bodies(const Fineness &fineness)
{
    constexpr double WALL_MM = 2.0, TANK_MM = 14.0, ERROR_MM = 0.08;
    const VesselTree tree = phantom_tree();
    const Solid wall = tree_solid(tree, WALL_MM), lumen = tree_solid(tree, 0.0);
    const Box outer = grown(wall.bounds, TANK_MM);
    const Distance tank = [outer](const Vec3 &p) {
        constexpr double ROUND_MM = 4.0;
        const Vec3 half = 0.5 * (outer.high - outer.low), centre = 0.5 * (outer.high + outer.low);
        const Vec3 offset = (p - centre).cwiseAbs() - half + Vec3::Constant(ROUND_MM);
        return offset.cwiseMax(0.0).norm() + std::min(0.0, offset.maxCoeff()) - ROUND_MM;
    };
    const double scale = fineness.body_scale;
    return {{"tank",
             "soft",
             "",
             {grown(outer, 4.0), [tank](const Box &, double) { return tank; }, 4.0 * scale, ERROR_MM}},
            {"wall", "silicone", "tank", {grown(wall.bounds, 2.0), local(wall), 1.2 * scale, ERROR_MM}},
            {"fluid", "blood", "wall", {grown(lumen.bounds, 2.0), local(lumen), 1.2 * scale, ERROR_MM}}};
}

} // namespace anatomy
