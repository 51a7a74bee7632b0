/* The hip bones. Common figures for a man: hip centres 172 mm apart, bi-iliac width 280 mm, pelvic height
 * 220 mm, subpubic angle 65 degrees (a woman: 88). All other measures are assumed. The anterior superior
 * iliac spines and the symphysis lie in one frontal plane, as in a standing man. */
#include "tools/anatomy/sheet.hpp"
#include "tools/anatomy/skeleton/levels.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* Builds the hip bone of one side; points are given for the left side of a man. */
struct HipBone {
    Part &part;
    double s;
    bool woman;

    /* A woman's pelvis is wider for her height, most of all between the ischial tuberosities. */
    Vec3 at(const Vec3 &p) const
    {
        constexpr double LOW_WIDER = 0.10;
        const double wider =
            woman ? WOMAN_PELVIS_WIDER + LOW_WIDER * smooth_step(0.0, 1.0, (-325.0 - p.y()) / 40.0) : 1.0;
        return {s * wider * p.x(), p.y(), p.z()};
    }
    std::vector<Vec3> all(std::vector<Vec3> points) const
    {
        for (Vec3 &point : points) point = at(point);
        return points;
    }
    void rod(const std::vector<Vec3> &points, const std::vector<double> &radii, double cortex_mm = 1.1) const
    {
        part.rod(all(points), radii, cortex_mm);
    }
    void band(const std::vector<Vec3> &points, const std::vector<double> &radii, const Vec3 &flat,
              double thinness) const
    {
        const Vec3 own(s * flat.x(), flat.y(), flat.z());
        part.add<Tube>(sample_curve(all(points), radii, 4.0), own, thinness).cortex_mm = 1.1;
    }
};

/* Adds the iliac wing: a thin concave fan between the arcuate line and the thick crest. The rows of grid
 * points on the iliac wing go from the arcuate line to the crest. */
void add_ilium(const HipBone &b)
{
    constexpr size_t ACROSS = 121, ROWS = 37, ROD_STEP = 5;
    const std::vector<Vec3> crest = {{113, -272, 22}, {119, -252, 40}, {127, -231, 50},  {137, -206, 42},
                                     {141, -182, 26}, {138, -163, 2},  {124, -154, -26}, {98, -160, -54},
                                     {70, -180, -76}, {48, -208, -89}, {45, -232, -88}};
    const std::vector<Vec3> line = {{86, -282, 16},  {84, -268, 5},   {81, -255, -5},  {76, -245, -17},
                                    {69, -237, -31}, {61, -231, -45}, {55, -228, -57}, {51, -234, -70}};
    const auto rim = evenly_along(crest, ACROSS), base = evenly_along(line, ACROSS);
    std::vector<std::vector<SheetPoint>> rows(ROWS);
    for (size_t row = 0; row < ROWS; row++) {
        const double share = static_cast<double>(row) / (ROWS - 1), hollow = 4.0 * share * (1.0 - share);
        // The wing is thick at the arcuate line, thin in the middle and thick again below the crest.
        const double half_mm = 2.3 + 4.2 * std::exp(-4.5 * share) + 2.6 * std::pow(share, 6.0);
        for (size_t i = 0; i < ACROSS; i++) {
            const double to_back = static_cast<double>(i) / (ACROSS - 1);
            const double thick = half_mm + 2.5 * smooth_step(0.75, 1.0, to_back);
            rows[row].push_back(
                {b.at(base[i] + share * (rim[i] - base[i]) + hollow * Vec3(7, -2, -5)), thick});
        }
    }
    b.part.add<Sheet>(rows).cortex_mm = 0.9;
    std::vector<Vec3> top, low;
    std::vector<double> top_radii, low_radii;
    for (size_t i = 0; i < ACROSS; i += ROD_STEP) {
        // The crest is thick at its front end, at the tubercle and at its back end.
        const double share = static_cast<double>(i) / (ACROSS - 1);
        top.push_back(rows.back()[i].position_mm);
        low.push_back(rows.front()[i].position_mm);
        top_radii.push_back(4.8 + 1.5 * std::cos(12.0 * share) + 2.0 * smooth_step(0.8, 1.0, share));
        low_radii.push_back(8.0 - 2.5 * share);
    }
    b.part.rod(top, top_radii, 1.0);
    b.part.rod(low, low_radii, 1.1);
    // The face towards the sacrum, and the back pillar above the sciatic notch.
    b.part.add<Ellipsoid>(b.at({53, -222, -72}), Vec3(7, 20, 15)).cortex_mm = 1.1;
    b.rod({{82, -292, -34}, {74, -268, -42}, {65, -248, -53}, {56, -238, -66}}, {13, 10, 9, 9});
    b.rod({{100, -276, 10}, {92, -282, 6}}, {9, 12}); // from the lower iliac spine to the socket
}

/* Pubis and ischium surround the obturator foramen, an oval of about 45 by 32 mm. */
void add_pubis_and_ischium(const HipBone &b)
{
    const Vec3 upright(0, 1, 0.25);
    b.band({{77, -286, 10}, {56, -293, 28}, {36, -301, 40}, {22, -306, 45}, {12, -309, 46}},
           {12.5, 9.2, 8.5, 9, 10}, upright, 0.85); // superior ramus
    // The body of the pubis is a plate beside the symphysis, which is 5 mm wide.
    const Vec3 thick(6.5, 6.0, 5.0);
    b.part.plate(b.at({8.5, -306, 46}), b.at({8.5, -337, 40}), b.at({24, -311, 41}), thick, 1.1);
    b.part.plate(b.at({8.5, -337, 40}), b.at({24, -311, 41}), b.at({22, -339, 34}), thick, 1.1);
    const Vec3 outwards(0.75, 0.55, 0.35);
    b.band({{14, -335, 38}, {26, -351, 22}, {39, -364, 4}, {48, -368, -14}}, {8.5, 8, 9, 11}, outwards,
           0.62); // the ramus of pubis and ischium
    b.part.add<Ellipsoid>(b.at({55, -360, -25}), Vec3(11.5, 19, 15)).cortex_mm = 1.1; // tuberosity
    b.rod({{57, -354, -27}, {66, -336, -33}, {76, -318, -34}}, {13, 12.5, 14});
    b.rod({{72, -312, -40}, {62, -313, -52}, {51, -316, -61}}, {9, 5.5, 2.8}); // ischial spine
    b.band({{78, -306, -36}, {72, -322, -44}, {66, -338, -42}}, {9, 8, 8}, upright, 0.7);
}

/* Adds the hip socket (acetabulum), which holds the femoral head. It faces outwards, downwards and, by 18
 * degrees, forwards (18.5 degrees in men, 21.3 in women by CT). Below, the notch opens
 * its rim. */
void add_socket(const HipBone &b)
{
    constexpr double CUP_MM = 26.4, BALL_MM = 30.0;
    const Vec3 centre = b.at(HIP_MM);
    const Vec3 opening = Vec3(b.s * 0.74, -0.62, b.woman ? 0.29 : 0.25).normalized(),
               down = Vec3(b.s * 0.12, -0.97, 0.2).normalized();
    b.part.add<Ellipsoid>(centre - 5.5 * opening, Vec3::Constant(BALL_MM)).cortex_mm = 1.2;
    b.part.add<Ellipsoid>(centre + Vec3(b.s * 1.0, 24.0, 0.0), Vec3(17, 10, 16)).cortex_mm = 1.2; // roof
    b.part.cut<Tube>(sample_curve({centre, centre + 20.0 * opening, centre + 55.0 * opening},
                                  {CUP_MM, CUP_MM, 42.0}, 4.0));
    b.part.cut<Tube>(sample_curve({centre + 20.0 * down, centre + 42.0 * down}, {13.0, 13.0}, 4.0));
}

} // namespace

Solid pelvis_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        Part part(5.0);
        const HipBone bone{part, s, shape.sex == Sex::woman};
        add_ilium(bone);
        add_pubis_and_ischium(bone);
        add_socket(bone);
        solid.add(part);
    }
    return solid;
}

} // namespace anatomy
