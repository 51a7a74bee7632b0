/* Hip bones and upper femurs. Three dimensions are assumed as typical for a man: hip centres 172 mm apart,
 * a bi-iliac width of about 280 mm, and femoral heads of 48 mm. The anterior superior iliac spines and the
 * symphysis lie in one frontal plane, as in a standing man. */
#include "tools/anatomy/sheet.hpp"
#include "tools/anatomy/skeleton.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

const Vec3 HIP(86, -300, -12);

Vec3 mirrored(double s, const Vec3 &point)
{
    return {s * point.x(), point.y(), point.z()};
}

/* Adds the iliac wing. The iliac wing is a thin concave fan between the arcuate line and the thick crest. The
 * rows of grid points on the iliac wing go from the arcuate line to the crest. */
void add_ilium(Part &part, double s)
{
    constexpr size_t ACROSS = 121, ROWS = 37, ROD_STEP = 5;
    const std::vector<Vec3> crest = {{116, -270, 24}, {120, -252, 40}, {126, -232, 50},  {135, -206, 42},
                                     {141, -182, 26}, {138, -163, 2},  {124, -154, -26}, {98, -160, -54},
                                     {70, -180, -76}, {46, -208, -89}, {43, -230, -86}};
    const std::vector<Vec3> line = {{84, -282, 18},  {83, -268, 6},   {80, -255, -4},  {75, -245, -16},
                                    {68, -237, -30}, {60, -230, -44}, {53, -226, -56}, {48, -232, -68}};
    const auto rim = evenly_along(crest, ACROSS), base = evenly_along(line, ACROSS);
    std::vector<std::vector<SheetPoint>> rows(ROWS);
    for (size_t row = 0; row < ROWS; row++) {
        const double share = static_cast<double>(row) / (ROWS - 1), hollow = 4.0 * share * (1.0 - share);
        const double half_mm = 2.6 + 3.4 * std::exp(-4.5 * share); // thick at the line, thin in the middle
        for (size_t i = 0; i < ACROSS; i++) {
            const Vec3 point = base[i] + share * (rim[i] - base[i]) + hollow * Vec3(7, -2, -5);
            rows[row].push_back({mirrored(s, point), half_mm});
        }
    }
    part.add<Sheet>(rows).cortex_mm = 1.1;
    std::vector<Vec3> top, bottom;
    std::vector<double> top_radii, bottom_radii;
    for (size_t i = 0; i < ACROSS; i += ROD_STEP) {
        const double share = static_cast<double>(i) / (ACROSS - 1);
        top.push_back(rows.back()[i].position_mm);
        bottom.push_back(rows.front()[i].position_mm);
        top_radii.push_back(5.2 + 1.6 * std::cos(12.0 * share));
        bottom_radii.push_back(12.0 - 4.0 * share);
    }
    part.rod(top, top_radii, 1.1);
    part.rod(bottom, bottom_radii, 1.2);
    part.add<Ellipsoid>(mirrored(s, {50, -224, -70}), Vec3(7, 20, 16)).cortex_mm = 1.2;
}

void add_pubis_and_ischium(Part &part, double s)
{
    auto rod = [&](std::vector<Vec3> points, const std::vector<double> &radii) {
        for (Vec3 &point : points) point = mirrored(s, point);
        part.rod(points, radii, 1.15);
    };
    rod({{74, -284, 14}, {54, -292, 30}, {32, -303, 42}, {14, -311, 46}},
        {12, 8.5, 7.5, 8.5});                                           // superior ramus
    rod({{12, -310, 46}, {11, -326, 44}, {13, -338, 40}}, {8, 8.5, 7}); // body at the symphysis
    rod({{14, -338, 39}, {28, -353, 24}, {42, -366, 4}, {50, -368, -14}},
        {6.5, 5.2, 6, 10}); // inferior ramus
    rod({{53, -366, -22}, {60, -350, -32}, {70, -330, -36}, {76, -316, -32}}, {13, 13, 12, 14}); // ischium
    rod({{72, -318, -38}, {62, -310, -52}, {50, -310, -62}}, {9, 6, 3.5}); // ischial spine
    rod({{76, -306, -36}, {70, -276, -46}, {58, -250, -58}}, {12, 8, 9});  // back pillar and notch
}

/* Adds the hip socket (acetabulum), which holds the femoral head. The socket is a thick hollow ball that is
 * joined to the three hip bones and is open outwards, downwards and forwards. */
void add_socket(Part &part, double s)
{
    constexpr double CUP_MM = 26.2, BALL_MM = 31.5;
    const Vec3 centre = mirrored(s, HIP), opening = mirrored(s, Vec3(0.76, -0.58, 0.28)).normalized();
    part.add<Ellipsoid>(centre - 4.0 * opening, Vec3::Constant(BALL_MM)).cortex_mm = 1.2;
    part.cut<Tube>(sample_curve({centre, centre + 20.0 * opening, centre + 55.0 * opening},
                                {CUP_MM, CUP_MM, 42.0}, 4.0));
}

Part hip_bone(double s)
{
    Part part(5.0);
    add_ilium(part, s);
    add_pubis_and_ischium(part, s);
    add_socket(part, s);
    return part;
}

Part femur_part(double s)
{
    Part part(8.0);
    auto rod = [&](std::vector<Vec3> points, const std::vector<double> &radii, double cortex) -> Tube & {
        for (Vec3 &point : points) point = mirrored(s, point);
        return part.rod(points, radii, cortex);
    };
    part.add<Ellipsoid>(mirrored(s, HIP), Vec3::Constant(24.0)).cortex_mm = 1.0;
    rod({HIP, {104, -313, -12}, {128, -332, -14}}, {19, 15.5, 18}, 1.4);
    rod({{132, -332, -17}, {141, -318, -24}, {138, -308, -30}}, {17, 14, 8}, 1.1); // greater trochanter
    rod({{124, -350, -20}, {112, -360, -27}}, {14, 7.5}, 1.3);                     // lesser trochanter
    // The wall of the femur's shaft thickens downwards to more than a third of the shaft's radius.
    const std::vector<Vec3> axis = {{131, -334, -15}, {129, -362, -13}, {126, -395, -9}, {122, -450, -5}};
    std::vector<Vec3> canal = axis;
    for (Vec3 &point : canal) point = mirrored(s, point);
    rod(axis, {19, 16.5, 14.5, 14}, 2.0).marrow =
        std::make_shared<Tube>(sample_curve(canal, {17.5, 13.5, 9.0, 7.5}, 4.0));
    return part;
}

} // namespace

Solid pelvis_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) solid.add(hip_bone(s));
    solid.enlarge(shape.scale);
    return solid;
}

Solid femur_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) solid.add(femur_part(s));
    solid.enlarge(shape.scale);
    return solid;
}

} // namespace anatomy
