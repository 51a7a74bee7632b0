/* Makes the skull with jaw and teeth. The size of the head is that of textbooks (183 x 141 mm over the vault,
 * 131 mm over the cheekbones, a man; a woman's 5 % less); all courses are assumed. */
#include "tools/anatomy/skeleton.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* The teeth are as dense as cortex: no marrow lies in a shape with a shell thicker than the shape. */
constexpr double SOLID_MM = 40.0;

/* The vault is an ellipsoid with a hollow for the brain: 6.5 mm thick, of which each table has 1.8 mm. */
const Vec3 VAULT(0, 489, -20), VAULT_HALF(70.5, 68, 91.5);
constexpr double VAULT_MM = 6.5, TABLE_MM = 1.8;

void add_base_and_face(Part &part)
{
    for (double s : {-1.0, 1.0}) {
        // Petrous ridges, the densest bone of the body, mastoids, and condyles on C1.
        part.rod({side(s, 62, 440, -28), side(s, 38, 438, -16), side(s, 14, 440, -2)}, {10, 9, 6}, 5.0);
        part.rod({side(s, 56, 432, -30), side(s, 52, 412, -26)}, {11, 6}, 1.2);
        part.rod({side(s, 18, 424, -40), side(s, 22, 421, -42)}, {7, 6}, 1.0);
        // Cheekbones with their arches, and the side walls of the face.
        part.rod({side(s, 22, 405, 62), side(s, 46, 416, 52), side(s, 60, 424, 30), side(s, 65, 430, 6),
                  side(s, 61, 432, -10)},
                 {9, 10, 5, 3.6, 4.5}, 1.2);
        part.rod({side(s, 46, 418, 50), side(s, 50, 440, 46), side(s, 46, 462, 52)}, {7, 5, 6}, 1.4);
        part.rod({side(s, 46, 462, 52), side(s, 30, 470, 66), side(s, 10, 462, 72)}, {6, 5.5, 5},
                 1.4);                                                                                // brow
        part.rod({side(s, 12, 458, 70), side(s, 13, 435, 68), side(s, 16, 408, 68)}, {5, 4, 6}, 1.0); // nose
        part.rod({side(s, 16, 424, 60), side(s, 40, 424, 50)}, {3.5, 4}, 1.0); // floor of the orbit
        part.plate(side(s, 46, 455, 40), side(s, 44, 425, 20), side(s, 34, 440, 2), 1.5, 0.6);
        part.plate(side(s, 18, 415, 8), side(s, 20, 440, 6), side(s, 20, 420, 26), 1.6, 0.7); // pterygoid
    }
    part.rod({{0, 424, -24}, {0, 436, -6}, {0, 446, 8}}, {11, 10, 9}, 1.2); // clivus and sphenoid
    part.rod({{0, 462, 72}, {0, 446, 80}, {0, 434, 86}}, {6, 4, 2.5}, 1.0); // nasal bones
    part.plate({0, 452, 66}, {0, 405, 66}, {0, 445, 10}, 1.0, 0.5);         // septum
    for (double s : {-1.0, 1.0})                                            // hard palate
        part.plate({0, 402, 70}, {0, 404, 26}, side(s, 22, 403, 30), 2.0, 0.8);
}

Part skull_part()
{
    Part part(4.0);
    part.add<Ellipsoid>(VAULT, VAULT_HALF).cortex_mm = TABLE_MM;
    add_base_and_face(part);
    part.cut<Ellipsoid>(VAULT + Vec3(0, 1, 0), VAULT_HALF - Vec3::Constant(VAULT_MM));
    part.removed.back()->cortex_mm = TABLE_MM;
    part.cut<Tube>(sample_curve({{0, 400, -52}, {0, 440, -44}}, {16, 16}, 6.0)); // foramen magnum
    part.cut<Ellipsoid>(Vec3(0, 471, 66), Vec3(20, 10, 5));                      // frontal sinus
    return part;
}

/* The curve of a row of teeth, from one side to the other. */
std::vector<Vec3> arch_curve(double y, double width, double front, double back)
{
    return {{-width, y, back},
            {-0.92 * width, y, 0.5 * (front + back)},
            {-0.5 * width, y, front - 4.0},
            {0, y, front},
            {0.5 * width, y, front - 4.0},
            {0.92 * width, y, 0.5 * (front + back)},
            {width, y, back}};
}

/* One row of teeth, with crowns that point down (-1) or up (+1) from the height y of their roots. */
Part teeth_part(double y, double width, double towards)
{
    constexpr double LENGTH_MM = 12.5;
    Part part(0.4);
    const Curve row = sample_curve(arch_curve(y, width, 78, 40), std::vector<double>(7, 1.0), 7.6);
    for (const CurvePoint &point : row) {
        const double molar = smooth_step(0.55, 0.8, std::abs(point.position_mm.x()) / width);
        const double radius_mm = 3.2 + 1.2 * molar;
        const Vec3 crown = point.position_mm + Vec3(0, towards * (LENGTH_MM - radius_mm + 3.2), 0);
        part.rod({point.position_mm, crown}, {0.8 * radius_mm, radius_mm}, SOLID_MM);
    }
    return part;
}

Part upper_jaw_part()
{
    Part part(3.0);
    part.add<Tube>(sample_curve(arch_curve(401, 25, 74, 34), std::vector<double>(7, 7.5), 4.0)).cortex_mm =
        1.1;
    return part;
}

/* The jaw: 62 mm from the angle up to its joint, 100 mm between the angles; its chin lies below the teeth. */
Part lower_jaw_part()
{
    Part part(4.0);
    part.rod({{-48, 374, 6},
              {-42, 366, 32},
              {-26, 360, 62},
              {0, 358, 74},
              {26, 360, 62},
              {42, 366, 32},
              {48, 374, 6}},
             {7, 8, 8.5, 9.5, 8.5, 8, 7}, 2.4);
    for (double s : {-1.0, 1.0}) {
        part.plate(side(s, 49, 374, 2), side(s, 46, 372, 32), side(s, 51, 418, 4), Vec3(4, 4, 3), 1.2);
        part.plate(side(s, 46, 372, 32), side(s, 49, 414, 24), side(s, 51, 418, 4), Vec3(4, 2.5, 3), 1.2);
        part.rod({side(s, 51, 412, 0), side(s, 51, 427, -3)}, {5, 6}, 1.2);
        part.rod({side(s, 49, 408, 24), side(s, 49, 422, 24)}, {4, 2.5}, 1.2);
    }
    return part;
}

} // namespace

Solid head_bones()
{
    Solid solid;
    solid.add(skull_part());
    solid.add(upper_jaw_part());
    solid.add(lower_jaw_part());
    solid.add(teeth_part(396, 26, -1));
    solid.add(teeth_part(363.5, 25, 1));
    return solid;
}

} // namespace anatomy
