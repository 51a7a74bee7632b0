#include "tools/anatomy/clutter.hpp"
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

constexpr double METAL_GAP_MM = 0.9, METAL_ERROR_MM = 0.05;

/* Metal keeps a gap to the bones. */
LocalDistance beside_bones(const Solid &metal, const Solid &bones)
{
    return [=](const Box &box, double reach_mm) -> Distance {
        return [own = metal.near(box, reach_mm), other = bones.near(box, METAL_GAP_MM + 0.1)](const Vec3 &p) {
            return std::max(own.distance(p), METAL_GAP_MM - other.distance(p));
        };
    };
}

Body metal_body(const char *name, const Solid &metal, const Solid &bones, double voxel_mm, double scale)
{
    return {name,
            "steel",
            "flesh",
            {grown(metal.bounds, 2.0), beside_bones(metal, bones), voxel_mm * std::min(scale, 1.2),
             METAL_ERROR_MM}};
}

/* The lead inside one chamber of the heart. Between its pieces lie the walls, which are bodies of their own.
 */
Body lead_in(const char *name, const char *chamber_name, const std::vector<Vec3> &course, double scale)
{
    constexpr double INSIDE_MM = 0.8, LEAD_RADIUS_MM = 1.0;
    Part part(0.0);
    part.rod(course, std::vector<double>(course.size(), LEAD_RADIUS_MM));
    Solid lead;
    lead.add(part);
    Distance room;
    for (const Chamber &chamber : heart_chambers())
        if (std::string(chamber.name) == chamber_name) room = chamber.distance;
    const LocalDistance distance = [=](const Box &box, double reach_mm) -> Distance {
        return [=, own = lead.near(box, reach_mm)](const Vec3 &p) {
            const double lead_mm = own.distance(p);
            return lead_mm > reach_mm ? lead_mm : std::max(lead_mm, room(p) + INSIDE_MM);
        };
    };
    return {name,
            "steel",
            chamber_name,
            {grown(lead.bounds, 2.0), distance, 0.8 * std::min(scale, 1.2), METAL_ERROR_MM}};
}

// --- on the skin ---

/* Returns the place on the skin in front of (x, y), seen from the front, or behind it (towards = -1). */
Vec3 on_skin(const Distance &outline, double x, double y, double towards)
{
    constexpr double START_MM = 260.0, STEP_MM = 0.8, ABOVE_MM = 2.4;
    for (double z = START_MM; z > 0.0; z -= std::max(STEP_MM, 0.4 * outline(Vec3(x, y, towards * z))))
        if (outline(Vec3(x, y, towards * z)) < ABOVE_MM) return {x, y, towards * z};
    return {x, y, 0.0};
}

/* A straight way over the skin between two places. */
std::vector<Vec3> over_skin(const Distance &outline, const Vec3 &from, const Vec3 &to)
{
    const int pieces = std::max(2, static_cast<int>((to - from).norm() / 18.0));
    std::vector<Vec3> course;
    for (int i = 0; i <= pieces; i++) {
        const Vec3 between = from + (to - from) * i / pieces;
        course.push_back(on_skin(outline, between.x(), between.y(), 1.0));
    }
    return course;
}

/* Five electrodes with their cables, which meet at a yoke on the left side of the belly. */
Solid leads(const Distance &outline)
{
    constexpr double CABLE_MM = 0.9, STUD_MM = 3.2, STUD_HALF_MM = 1.4;
    const Vec3 yoke(96, -70, 0),
        electrodes[] = {{-96, 212, 0}, {98, 214, 0}, {-92, 20, 0}, {100, 24, 0}, {72, 104, 0}};
    Solid solid;
    for (const Vec3 &electrode : electrodes) {
        Part part(0.4);
        const std::vector<Vec3> course = over_skin(outline, electrode, yoke);
        part.rod(course, std::vector<double>(course.size(), CABLE_MM));
        part.add<Ellipsoid>(course.front(), Vec3(STUD_MM, STUD_MM, STUD_HALF_MM));
        solid.add(part);
    }
    return solid;
}

Body lead_body(const Distance &outline, double scale)
{
    constexpr double CLEAR_MM = 0.5;
    const Solid solid = leads(outline);
    const LocalDistance distance = [=](const Box &box, double reach_mm) -> Distance {
        return [=, own = solid.near(box, reach_mm)](const Vec3 &p) {
            const double lead_mm = own.distance(p);
            return lead_mm > reach_mm ? lead_mm : std::max(lead_mm, CLEAR_MM - outline(p));
        };
    };
    return {"ecg_leads",
            "steel",
            "",
            {grown(solid.bounds, 2.0), distance, 0.9 * std::min(scale, 1.2), METAL_ERROR_MM}};
}

/* The table top below the back, with a rim along both edges. */
void add_table(std::vector<Body> &bodies, const Distance &outline, double scale)
{
    constexpr double HALF_WIDTH_MM = 210.0, HALF_THICK_MM = 4.0, HEAD_MM = 600.0, FOOT_MM = -430.0,
                     RAIL_MM = 5.0, MATTRESS_MM = 12.0;
    double back_mm = 0.0;
    for (double y = FOOT_MM + 20.0; y < HEAD_MM; y += 12.0)
        for (double x = -150.0; x <= 150.0; x += 25.0)
            back_mm = std::min(back_mm, on_skin(outline, x, y, -1.0).z());
    const double z = back_mm - MATTRESS_MM - HALF_THICK_MM;
    Box where;
    where.include(Vec3(-HALF_WIDTH_MM, FOOT_MM, z), HALF_THICK_MM + 2.0);
    where.include(Vec3(HALF_WIDTH_MM, HEAD_MM, z), HALF_THICK_MM + 2.0);
    const Distance slab = [=](const Vec3 &p) {
        constexpr double ROUND_MM = 2.0;
        const Vec3 half(HALF_WIDTH_MM, 0.5 * (HEAD_MM - FOOT_MM), HALF_THICK_MM),
            middle(0, 0.5 * (HEAD_MM + FOOT_MM), z);
        const Vec3 off = (p - middle).cwiseAbs() - half + Vec3::Constant(ROUND_MM);
        return off.cwiseMax(0.0).norm() + std::min(0.0, off.maxCoeff()) - ROUND_MM;
    };
    bodies.push_back(
        {"table_top",
         "polymer",
         "",
         {where, [slab](const Box &, double) { return slab; }, 3.0 * std::min(scale, 1.2), 0.1}});
    Part rails(0.0);
    for (double s : {-1.0, 1.0}) {
        const double x = HALF_WIDTH_MM + RAIL_MM + 2.0;
        rails.rod({side(s, x, FOOT_MM, z), side(s, x, HEAD_MM, z)}, {RAIL_MM, RAIL_MM});
    }
    Solid solid;
    solid.add(rails);
    bodies.push_back({"table_rails",
                      "polymer",
                      "",
                      {grown(solid.bounds, 2.0), local_distance(solid), 2.5 * std::min(scale, 1.2), 0.1}});
}

} // namespace

Solid sternal_wires()
{
    constexpr double WIRE_MM = 0.45, AROUND_MM = 2.2;
    constexpr int POINTS = 20;
    Solid solid;
    for (const double y : {234.0, 218.0, 184.0, 164.0, 144.0, 122.0}) {
        const SternumSection section = sternum_section(y);
        const double across = section.half_width_mm + AROUND_MM, deep = section.half_depth_mm + AROUND_MM;
        std::vector<Vec3> loop;
        for (int i = 0; i <= POINTS; i++) {
            const double angle = 2.0 * std::numbers::pi * i / POINTS;
            // The wire follows the flat front and back of the bone.
            const double c = std::cos(angle), s = std::sin(angle);
            loop.emplace_back(across * std::copysign(std::sqrt(std::abs(s)), s), y + 1.5 * c,
                              section.z_mm + deep * std::copysign(std::sqrt(std::abs(c)), c));
        }
        Part part(0.0);
        part.rod(loop, std::vector<double>(loop.size(), WIRE_MM));
        const Vec3 twist = loop.front();
        part.rod({twist, twist + Vec3(2, -3, 1), twist + Vec3(5, -7, 0.5)}, {0.8, 0.8, 0.6});
        solid.add(part);
    }
    return solid;
}

Solid pacemaker()
{
    constexpr double LEAD_RADIUS_MM = 1.0;
    Solid solid;
    Part can(0.0);
    can.add<Ellipsoid>(Vec3(92, 214, 44), Vec3(23, 20, 3.8),
                       Eigen::AngleAxisd(0.55, Vec3::UnitY()).toRotationMatrix());
    solid.add(can);
    Part lead(0.0);
    const std::vector<Vec3> course = {{84, 232, 48},  {78, 243, 40}, {62, 244, 28},
                                      {40, 243, 22},  {10, 238, 20}, {-20, 228, 15},
                                      {-29, 200, 11}, {-29, 170, 9}, {-29, 151, 9}};
    lead.rod(course, std::vector<double>(course.size(), LEAD_RADIUS_MM));
    solid.add(lead);
    return solid;
}

std::vector<Body> clutter_bodies(const Clutter &clutter, const SoftShape &shape, const Solid &bones,
                                 double scale)
{
    std::vector<Body> bodies;
    if (clutter.wires) bodies.push_back(metal_body("sternal_wires", sternal_wires(), bones, 0.55, scale));
    if (clutter.pacemaker) {
        bodies.push_back(metal_body("pacemaker", pacemaker(), bones, 0.8, scale));
        bodies.push_back(lead_in("pacing_lead_atrium", "right_atrium",
                                 {{-28, 138, 8}, {-25, 121, 5}, {-23, 109, 13}, {-22, 100, 22}}, scale));
        bodies.push_back(lead_in("pacing_lead_ventricle", "right_ventricle",
                                 {{-18, 96, 31}, {-6, 84, 41}, {10, 73, 46}, {24, 67, 50}, {34, 66, 51.5}},
                                 scale));
    }
    if (!clutter.leads && !clutter.table) return bodies;
    const Solid outline = skin(shape);
    const Distance skin_distance = [=](const Vec3 &p) {
        constexpr double OVER_BONES_MM = 7.0; // the skin covers every bone (layer_bodies)
        return std::min(outline.distance(p), bones.distance(p) - OVER_BONES_MM);
    };
    if (clutter.leads) bodies.push_back(lead_body(skin_distance, scale));
    if (clutter.table) add_table(bodies, skin_distance, scale);
    return bodies;
}

} // namespace anatomy
