/* Makes the bones of forearms and hands; all courses are assumed. */
#include "tools/anatomy/skeleton.hpp"

namespace anatomy
{

namespace
{

/* The raised forearms lie over the head. */
Solid raised_forearms()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        Part ulna(2.0), radius(2.0);
        ulna.is_exact_inside = radius.is_exact_inside = true; // the marrow of the shafts lies deep
        ulna.rod({side(s, 300, 553, 2), side(s, 296, 545, 8), side(s, 268, 588, 10), side(s, 218, 652, 16),
                  side(s, 168, 712, 24)},
                 {8, 10, 7, 6, 5.5}, 3.0);
        radius.rod({side(s, 283, 548, 28), side(s, 262, 582, 32), side(s, 212, 650, 36),
                    side(s, 172, 700, 38), side(s, 158, 718, 38)},
                   {9, 6.5, 7, 8, 11}, 2.6);
        solid.add(ulna);
        solid.add(radius);
        Part wrist(0.5);
        for (int row = 0; row < 2; row++)
            for (int k = 0; k < 4; k++)
                wrist
                    .add<Ellipsoid>(
                        side(s, 164 - 10.5 * row - 9.5 * k + 12, 728 + 11 * row - 5.5 * k + 8, 36),
                        Vec3(5.6, 5.6, 6.5))
                    .cortex_mm = 1.0;
        solid.add(wrist);
        for (int k = 0; k < 4; k++) { // metacarpals and fingers, close together
            Part finger(0.5);
            const Vec3 root = side(s, 154 - 9.0 * k, 748 - 4.5 * k, 38), along = side(s, -0.63, 0.77, 0.06);
            finger.rod({root, root + 30 * along, root + 56 * along}, {5, 3.6, 5}, 1.6);
            solid.add(finger);
        }
    }
    return solid;
}

/* Beside the body, the palms lie on the table. The fingers end where the body ends. */
Solid lowered_forearms()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        Part ulna(2.0), radius(2.0), wrist(0.5);
        ulna.is_exact_inside = radius.is_exact_inside = true;
        ulna.rod({side(s, 249, -64, -80), side(s, 248, -84, -74), side(s, 251, -140, -66),
                  side(s, 256, -230, -54), side(s, 260, -318, -44)},
                 {8, 10, 7, 6, 5.5}, 3.0);
        radius.rod({side(s, 266, -91, -56), side(s, 268, -112, -54), side(s, 273, -180, -48),
                    side(s, 276, -270, -40), side(s, 276, -322, -38)},
                   {9, 6.5, 7, 8, 11}, 2.6);
        solid.add(ulna);
        solid.add(radius);
        for (int row = 0; row < 2; row++)
            for (int k = 0; k < 4; k++)
                wrist.add<Ellipsoid>(side(s, 254 + 9.5 * k, -339 - 11 * row, -39), Vec3(5.2, 5.6, 6.5))
                    .cortex_mm = 1.0;
        solid.add(wrist);
        for (int k = 0; k < 4; k++) { // metacarpals and fingers, close together
            Part finger(0.5);
            const Vec3 root = side(s, 252 + 11.0 * k, -361, -38), along = side(s, 0.03, -1.0, 0.02);
            finger.rod({root, root + 30 * along, root + 50 * along}, {5, 3.6, 5}, 1.6);
            solid.add(finger);
        }
    }
    return solid;
}

} // namespace

Solid forearm_bones(const SkeletonShape &shape)
{
    return shape.arms == Arms::raised ? raised_forearms() : lowered_forearms();
}

} // namespace anatomy
