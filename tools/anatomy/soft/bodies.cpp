#include "tools/anatomy/soft/lung_vessels.hpp"
#include "tools/anatomy/soft_bodies.hpp"
#include "tools/anatomy/wall_calcium.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

constexpr double SOFT_ERROR_MM = 0.3;

/* Returns the voxel size for the mesh of a body that nearly touches the body around it. The returned voxel
 * size stays fine even if the user chooses a coarse anatomy, so that the mesh of the inner body stays inside
 * the outer one. */
double tight_mm(double voxel_mm, double scale)
{
    return voxel_mm * std::min(scale, 1.2);
}

// --- layers ---

/* Returns the distance to the outer surface of the skin. The skin covers every bone, and some flesh lies
 * between bone and skin. */
LocalDistance outline_distance(const SoftShape &shape, const Solid &bones)
{
    const Solid outline = skin(shape);
    return [=](const Box &box, double reach_mm) -> Distance {
        constexpr double FLESH_MM = 7.0, BLEND_MM = 8.0;
        return [outline, reach_mm, near = bones.near(box, reach_mm + FLESH_MM + BLEND_MM)](const Vec3 &p) {
            const double own = outline.distance(p);
            if (own < -std::max(reach_mm, FLESH_MM + BLEND_MM)) return own; // bones only make it deeper
            return smooth_min(own, std::max(near.distance(p), beyond_cuts(p)) - FLESH_MM, BLEND_MM);
        };
    };
}

/* Returns the distance to the part of the trunk that lies deeper than `depth_mm` below the outer surface of
 * the skin. Where a bone comes near the skin, this part of the trunk still covers the bone. */
LocalDistance layer_distance(const SoftShape &shape, const Solid &bones, double least_mm,
                             double (*depth_mm)(const SoftShape &, const Vec3 &))
{
    return [=, outline = outline_distance(shape, bones)](const Box &box, double reach_mm) -> Distance {
        constexpr double COVER_MM = 2.5, BLEND_MM = 4.0;
        const double deepest_mm = 10.0 + 20.0 * std::max(1.0, shape.fat);
        return [=, near = bones.near(box, reach_mm + COVER_MM + BLEND_MM),
                own = outline(box, reach_mm + deepest_mm)](const Vec3 &p) {
            const double skin_mm = own(p), kept_mm = skin_mm + depth_mm(shape, p);
            if (kept_mm < -std::max(reach_mm, 3.0 * COVER_MM + BLEND_MM)) return kept_mm;
            const double covered = std::max(near.distance(p), beyond_cuts(p)) - COVER_MM;
            return std::max(skin_mm + least_mm, smooth_min(kept_mm, covered, BLEND_MM));
        };
    };
}

double skin_depth_mm(const SoftShape &, const Vec3 &)
{
    return 2.4;
}

} // namespace

std::vector<Body> layer_bodies(const SoftShape &shape, const Solid &bones, double scale)
{
    const Box where = grown(skin(shape).bounds, 12.0);
    const LocalDistance flesh = layer_distance(shape, bones, 4.2, flesh_depth_mm);
    std::vector<Body> bodies = {
        {"skin", "soft", "", {where, outline_distance(shape, bones), tight_mm(4.5, scale), SOFT_ERROR_MM}},
        {"fat",
         "adipose",
         "skin",
         {where, layer_distance(shape, bones, 2.4, skin_depth_mm), tight_mm(4.0, scale), SOFT_ERROR_MM}},
        {"flesh", "muscle", "fat", {where, flesh, tight_mm(4.0, scale), SOFT_ERROR_MM}},
    };
    const Solid glands = breast_glands(shape);
    if (glands.is_empty()) return bodies;
    const LocalDistance outline = outline_distance(shape, bones);
    const LocalDistance gland = [=](const Box &box, double reach_mm) -> Distance {
        constexpr double UNDER_SKIN_MM = 5.0, TO_FLESH_MM = 8.0;
        return [=, own = glands.near(box, reach_mm), around = outline(box, reach_mm + UNDER_SKIN_MM),
                muscle = flesh(box, reach_mm + TO_FLESH_MM)](const Vec3 &p) {
            const double kept = smooth_max(own.distance(p), around(p) + UNDER_SKIN_MM, 4.0);
            return smooth_max(kept, TO_FLESH_MM - muscle(p), 4.0);
        };
    };
    bodies.push_back(
        {"breast_glands", "soft", "fat", {grown(glands.bounds, 3.0), gland, 3.0 * scale, SOFT_ERROR_MM}});
    return bodies;
}

// --- chest ---

namespace
{

/* Returns the distance to one lung, which is the chest cavity on its side minus everything else in the
 * chest. */
LocalDistance lung_distance(double sign, const SpineBend &bend, const Solid &bones, const Solid &aorta_wall,
                            const Solid &coronaries)
{
    const Solid middle = mediastinum(bend), air = airway();
    const Distance cavity = lung_cavity(sign, bend);
    return [=](const Box &box, double reach_mm) -> Distance {
        constexpr double PLEURA_MM = 2.0, ADVENTITIA_MM = 1.0;
        const double reach = reach_mm + PLEURA_MM + 1.0;
        return [=, heart = middle.near(box, reach), trachea = air.near(box, reach),
                aorta = aorta_wall.near(box, reach), bone = bones.near(box, reach),
                coronary = coronaries.near(box, reach)](const Vec3 &p) {
            double taken = std::min(trachea.distance(p), aorta.distance(p));
            taken = std::min(taken, coronary.distance(p) - ADVENTITIA_MM + PLEURA_MM);
            taken = std::min(heart.distance(p), std::min(taken, bone.distance(p)) - PLEURA_MM);
            return smooth_max(cavity(p), -taken, 1.5);
        };
    };
}

/* Adds the lungs with their vessels. Bones, aorta, airway and mediastinum are cut out of the lungs. */
void add_lungs(std::vector<Body> &bodies, const SpineBend &bend, const Solid &bones, const Solid &aorta_wall,
               const Solid &coronaries, double scale)
{
    for (double s : {-1.0, 1.0}) {
        const std::string name = s < 0 ? "lung_right" : "lung_left";
        const LocalDistance lung = lung_distance(s, bend, bones, aorta_wall, coronaries);
        const Box where = lung_bounds(s, bend);
        const auto space = std::make_shared<const LungSpace>(lung, where);
        const LungSide which = s < 0 ? LungSide::right : LungSide::left;
        const std::vector<LungTree> trees = {lung_arteries(which, *space, where),
                                             lung_veins(which, *space, where)};
        const Solid tree = wide_lung_vessels(trees);
        const LocalDistance vessels = [=](const Box &box, double reach_mm) -> Distance {
            constexpr double INSIDE_MM = 1.3;
            return [own = tree.near(box, reach_mm), around = lung(box, reach_mm + INSIDE_MM)](const Vec3 &p) {
                const double distance = own.distance(p);
                return distance > 1e3 ? distance : std::max(distance, around(p) + INSIDE_MM);
            };
        };
        bodies.push_back({name, "lung", "flesh", {grown(where, 4.0), lung, 2.2 * scale, SOFT_ERROR_MM}});
        MeshRequest request{grown(tree.bounds, 2.0), vessels, 1.2 * scale, 0.2};
        request.more = [=] { return narrow_lung_vessels(trees, *space); };
        bodies.push_back({name + "_vessels", "blood", name, request});
    }
}

/* Returns the distance to that part of a shape that is at least `clear_mm` away from the solid `other`. */
LocalDistance clear_of(const LocalDistance &shape, const Solid &other, double clear_mm)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [=, own = shape(box, reach_mm + 1.0), near = other.near(box, reach_mm + clear_mm)](
                   const Vec3 &p) { return smooth_max(own(p), clear_mm - near.distance(p), 1.0); };
    };
}

LocalDistance clear_of_bones(const Solid &solid, const Solid &bones)
{
    constexpr double CLEAR_MM = 2.0;
    return clear_of(local_distance(solid), bones, CLEAR_MM);
}

/* Adds the heart muscle, which fills the heart's outline, and inside it the blood of the four chambers. */
void add_heart(std::vector<Body> &bodies, const Solid &bones, const Solid &vessels, double scale)
{
    constexpr double VESSEL_WALL_MM = 0.6;
    const Solid outline = heart_outline();
    const LocalDistance muscle = clear_of(clear_of_bones(outline, bones), vessels, VESSEL_WALL_MM);
    bodies.push_back(
        {"heart", "muscle", "flesh", {grown(outline.bounds, 3.0), muscle, 2.4 * scale, SOFT_ERROR_MM}});
    for (const Chamber &chamber : heart_chambers()) {
        const LocalDistance inside = [=](const Box &box, double reach_mm) -> Distance {
            constexpr double WALL_MM = 2.0; // the thinnest wall, that of the atria
            return [own = chamber.distance, around = muscle(box, reach_mm + WALL_MM)](const Vec3 &p) {
                return smooth_max(own(p), around(p) + WALL_MM, 1.0);
            };
        };
        bodies.push_back(
            {chamber.name, "blood", "heart", {chamber.bounds, inside, 2.4 * scale, SOFT_ERROR_MM}});
    }
}

/* Holds the root of the aorta and the coronary arteries of the left and the right side. The root of the aorta
 * and the coronary arteries are empty if the tree has no coronary arteries. */
struct HeartVessels {
    Solid root, left, right;

    Solid all() const
    {
        Solid solid = root;
        solid.add(left);
        solid.add(right);
        return solid;
    }
};

HeartVessels heart_vessels(const VesselTree &tree)
{
    constexpr double ROOT_LENGTH_MM = 52.0;
    if (tree.coronary_count == 0) return {};
    std::vector<Vessel> left, right;
    for (const Vessel &artery : coronary_arteries(tree))
        (artery.bed == Bed::right_coronary ? right : left).push_back(artery);
    Curve root = vessel_curve(tree.vessels.front(), 1.0);
    std::erase_if(root, [](const CurvePoint &point) { return point.arc_mm > ROOT_LENGTH_MM; });
    Part part(0.0);
    part.add<Tube>(root);
    HeartVessels vessels{{},
                         vessels_solid(left, 0.0, tree.coronary_fillet_mm),
                         vessels_solid(right, 0.0, tree.coronary_fillet_mm)};
    vessels.root.add(part);
    return vessels;
}

void add_heart_vessels(std::vector<Body> &bodies, const HeartVessels &vessels, double scale)
{
    constexpr double APART_MM = 0.5, CORONARY_ERROR_MM = 0.05;
    bodies.push_back({"aortic_root",
                      "blood",
                      "flesh",
                      {grown(vessels.root.bounds, 2.0), local_distance(vessels.root), 1.5 * scale, 0.1}});
    for (const auto &[name, solid] :
         {std::pair{"coronaries_left", vessels.left}, {"coronaries_right", vessels.right}})
        bodies.push_back({name,
                          "blood",
                          "flesh",
                          {grown(solid.bounds, 2.0), clear_of(local_distance(solid), vessels.root, APART_MM),
                           tight_mm(0.5, scale), CORONARY_ERROR_MM}});
}

} // namespace

std::vector<Body> chest_bodies(const SoftShape &shape, const Solid &bones, const VesselTree &tree,
                               double scale)
{
    constexpr double AORTA_WALL_MM = 2.0;
    std::vector<Body> bodies;
    const HeartVessels vessels = heart_vessels(tree);
    const Solid taken = vessels.all();
    add_lungs(bodies, shape.bend, bones, vessels_solid(body_vessels(tree), AORTA_WALL_MM, tree.fillet_mm),
              taken, scale);
    add_heart(bodies, bones, taken, scale);
    if (!taken.is_empty()) add_heart_vessels(bodies, vessels, scale);
    const Solid air = airway();
    bodies.push_back({"airway",
                      "air",
                      "flesh",
                      {grown(air.bounds, 3.0), clear_of_bones(air, bones), 1.5 * scale, SOFT_ERROR_MM}});
    return bodies;
}

// --- belly ---

namespace
{

constexpr double DIAPHRAGM_MM = 4.0, ORGAN_GAP_MM = 1.5;

/* Returns the distance to the belly's cavity, in which fat surrounds the organs. The cavity is the belly's
 * outline minus the diaphragm, heart, bones and psoas muscles. */
LocalDistance belly_distance(const SoftShape &shape, const Solid &bones)
{
    const Solid heart = mediastinum(shape.bend), loins = psoas(), nests = kidney_nests();
    const Distance right = lung_cavity(-1.0, shape.bend), left = lung_cavity(1.0, shape.bend);
    const Solid outline = skin(shape);
    return [=](const Box &box, double reach_mm) -> Distance {
        constexpr double CLEAR_MM = 3.0, BLEND_MM = 6.0, WALL_MM = 3.0;
        const double reach = reach_mm + DIAPHRAGM_MM + BLEND_MM;
        return [=, bone = bones.near(box, reach), middle = heart.near(box, reach),
                flank = loins.near(box, reach), nest = nests.near(box, reach)](const Vec3 &p) {
            const double room = smooth_min(belly_outline(shape, p), nest.distance(p), BLEND_MM);
            const double chest = std::min({right(p), left(p), middle.distance(p)});
            double taken = std::min(chest - DIAPHRAGM_MM, bone.distance(p) - CLEAR_MM);
            taken = std::min(taken, flank.distance(p));
            const double kept = smooth_max(room, -taken, 2.0);
            if (kept > 3.0 * BLEND_MM) return kept; // far outside, where the wall does not matter
            return std::max(kept, outline.distance(p) + flesh_depth_mm(shape, p) + WALL_MM);
        };
    };
}

/* Returns the distance to an organ of the belly. The organ is the part of `shape` inside the belly that keeps
 * a gap to the organs in `before`, so `shape` may be larger than the organ. */
LocalDistance organ_distance(const Solid &shape, const LocalDistance &belly, const Solid &before,
                             double inset_mm)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        const double gap = ORGAN_GAP_MM + inset_mm;
        return [=, own = shape.near(box, reach_mm + 1.0), other = before.near(box, reach_mm + gap),
                room = belly(box, reach_mm + gap)](const Vec3 &p) {
            const double kept = smooth_max(own.distance(p), gap - other.distance(p), 1.0);
            return smooth_max(kept, room(p) + gap, 1.0);
        };
    };
}

/* Adds the plaques in the wall of vessels inside the belly's fat, or those outside of it, where they are
 * clear of bones and organs. */
void add_plaques(std::vector<Body> &bodies, const std::vector<Plaque> &plaques, const Solid &organs,
                 const LocalDistance &belly, bool is_in_belly, double scale)
{
    constexpr double CLEAR_MM = 1.2, MIDDLE_MM = 2.5;
    const auto beyond = [=](double room_mm) { return is_in_belly ? room_mm : -room_mm; };
    std::vector<Plaque> kept;
    for (const Plaque &plaque : plaques) {
        Box here;
        here.include(plaque.centre_mm, 1.0);
        if (beyond(belly(here, 10.0)(plaque.centre_mm)) < -MIDDLE_MM &&
            organs.distance(plaque.centre_mm) > MIDDLE_MM)
            kept.push_back(plaque);
    }
    if (kept.empty()) return;
    const Solid solid = plaque_solid(kept);
    const LocalDistance distance = [=](const Box &box, double reach_mm) -> Distance {
        return [=, own = solid.near(box, reach_mm), other = organs.near(box, reach_mm + CLEAR_MM),
                room = belly(box, reach_mm + CLEAR_MM)](const Vec3 &p) {
            const double plaque = own.distance(p);
            if (plaque > reach_mm) return plaque;
            return std::max({plaque, CLEAR_MM - other.distance(p), beyond(room(p)) + CLEAR_MM});
        };
    };
    bodies.push_back({is_in_belly ? "calcium_belly" : "calcium_chest",
                      "cortical_bone",
                      is_in_belly ? "belly_fat" : "flesh",
                      {grown(solid.bounds, 2.0), distance, 0.7 * std::min(scale, 1.3), 0.06, 0.0, true}});
}

} // namespace

std::vector<Body> belly_bodies(const SoftShape &shape, const Solid &bones, const VesselTree &tree,
                               double scale)
{
    const LocalDistance belly = belly_distance(shape, bones);
    std::vector<Body> bodies = {
        {"belly_fat", "adipose", "flesh", {belly_bounds(shape), belly, tight_mm(3.4, scale), SOFT_ERROR_MM}}};
    Solid before;
    const auto add = [&](const char *name, const char *material, const char *inside, const Solid &organ,
                         double voxel_mm, double inset_mm) {
        bodies.push_back({name,
                          material,
                          inside,
                          {grown(organ.bounds, 3.0), organ_distance(organ, belly, before, inset_mm),
                           tight_mm(voxel_mm, scale), SOFT_ERROR_MM}});
    };
    const Solid kidney_pair = kidneys(), liver_shape = liver(), spleen_shape = spleen();
    add("kidneys", "muscle", "belly_fat", kidney_pair, 2.6, 0.0);
    before.add(kidney_pair);
    add("liver", "muscle", "belly_fat", liver_shape, 3.4, 0.0);
    before.add(liver_shape);
    add("spleen", "muscle", "belly_fat", spleen_shape, 3.0, 0.0);
    before.add(spleen_shape);
    const Solid bladder_shape = bladder(shape);
    add("bladder", "soft", "belly_fat", bladder_shape, 2.6, 0.0);
    before.add(bladder_shape);
    constexpr double WALL_MM = 2.5; // thickness of the bowel's wall around its gas
    const Solid bowels = bowel(shape, WALL_MM);
    add("bowel", "soft", "belly_fat", bowels, 3.0, 0.0);
    add("bowel_gas", "air", "bowel", bowel_gas(shape, 0.0), 2.0, WALL_MM - 0.5);
    constexpr double BUBBLES_APART_MM = 1.2;
    const Solid faeces = faeces_gas(shape);
    bodies.push_back({"faeces_gas",
                      "air",
                      "bowel",
                      {grown(faeces.bounds, 2.0),
                       clear_of(organ_distance(faeces, belly, before, WALL_MM - 0.5), bowel_gas(shape, 0.0),
                                BUBBLES_APART_MM),
                       tight_mm(1.3, scale), 0.12}});
    const std::vector<Plaque> plaques = wall_plaques(tree, shape);
    before.add(bowels);
    before.add(bones);
    add_plaques(bodies, plaques, before, belly, true, scale);
    before.add(heart_outline());
    before.add(airway());
    add_plaques(bodies, plaques, before, belly, false, scale);
    return bodies;
}

} // namespace anatomy
