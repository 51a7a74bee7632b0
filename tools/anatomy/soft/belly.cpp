/* Makes the shapes of the belly: cavity, kidneys, liver, spleen, psoas muscles, bowel and gas. */
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* The table gives the half-width, front and back of the belly's cavity at several heights, in millimetres. */
struct Level {
    double y, half_width, front, back;
};

const Level BELLY[] = {
    {-310, 36, 8, -62},   {-285, 48, 24, -74},  {-250, 78, 62, -70}, {-210, 112, 80, -58},
    {-160, 128, 90, -52}, {-110, 130, 94, -54}, {-50, 130, 92, -64}, {0, 126, 86, -76},
    {40, 122, 72, -84},   {80, 118, 64, -80},   {110, 112, 58, -74},
};
constexpr double FLOOR_MM = -305.0, TOP_MM = 105.0;

} // namespace

double belly_outline(const SoftShape &shape, const Vec3 &p)
{
    static const Spline width = course_over_height<Spline>(BELLY, &Level::half_width),
                        front = course_over_height<Spline>(BELLY, &Level::front),
                        back = course_over_height<Spline>(BELLY, &Level::back);
    const double y = std::clamp(p.y(), FLOOR_MM, TOP_MM);
    const double a = width.at(y), z_front = front.at(y), z_back = back.at(y), b = 0.5 * (z_front - z_back);
    const double outline = ellipsoid_distance({p.x(), 0.0, p.z() - 0.5 * (z_front + z_back)}, {a, 1e3, b});
    return smooth_max(outline - belly_growth_mm(shape, p), std::max(FLOOR_MM - p.y(), p.y() - TOP_MM), 12.0);
}

Box belly_bounds(const SoftShape &shape)
{
    const double grown_mm = 4.0 + std::max(0.0, shape.belly_mm);
    Box box;
    box.include(Vec3(-136, FLOOR_MM, -92), grown_mm);
    box.include(Vec3(136, TOP_MM, 98), grown_mm);
    return box;
}

Solid psoas()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        Part part(4.0);
        part.rod({side(s, 26, -4, -44), side(s, 34, -60, -40), side(s, 44, -120, -38), side(s, 56, -180, -32),
                  side(s, 66, -230, -8), side(s, 74, -290, 16)},
                 {8, 14, 18, 20, 18, 13});
        solid.add(part);
    }
    return solid;
}

namespace
{

struct KidneyPlace {
    Vec3 centre;
    Eigen::Matrix3d lean; // tilts the upper poles inwards and backwards
};

KidneyPlace kidney_place(double s)
{
    return {side(s, 77, s > 0 ? -38 : -52, -52),
            (Eigen::AngleAxisd(s * 0.22, Vec3::UnitZ()) * Eigen::AngleAxisd(0.2, Vec3::UnitX()))
                .toRotationMatrix()};
}

} // namespace

Solid kidney_nests()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        const KidneyPlace place = kidney_place(s);
        Part part(0.0);
        part.add<Ellipsoid>(place.centre, Vec3(37, 66, 33), place.lean);
        solid.add(part);
    }
    return solid;
}

Solid kidneys()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        const KidneyPlace place = kidney_place(s);
        Part part(0.0);
        part.add<Ellipsoid>(place.centre, Vec3(27, 57, 23), place.lean);
        // The kidney's hilum is a notch that is filled with fat and open towards the middle and the front.
        const Vec3 hilum = place.centre + place.lean * side(s, -31, 0, 8);
        part.cut<Ellipsoid>(hilum, Vec3(20, 19, 13), place.lean);
        solid.add(part);
    }
    return solid;
}

Solid liver()
{
    Part part(30.0);
    part.add<Ellipsoid>(Vec3(-66, 22, 2), Vec3(66, 66, 76));
    part.add<Ellipsoid>(Vec3(-84, -40, 14), Vec3(34, 52, 46)); // right lobe's edge
    part.add<Ellipsoid>(Vec3(0, 42, 34), Vec3(66, 30, 36));    // left lobe
    Solid solid;
    solid.add(part);
    return solid;
}

Solid spleen()
{
    const Eigen::Matrix3d lean = Eigen::AngleAxisd(-0.5, Vec3::UnitZ()).toRotationMatrix();
    Part part(0.0);
    part.add<Ellipsoid>(Vec3(98, 30, -46), Vec3(24, 50, 32), lean);
    Solid solid;
    solid.add(part);
    return solid;
}

Solid bladder(const SoftShape &shape)
{
    // It is nearly empty, as after a patient was asked to void, and lies on the floor of the pelvis behind
    // the symphysis. Its size differs from person to person.
    constexpr double FLOOR_OF_BLADDER_MM = -297.0;
    const double size = shape.bowel_seed == 0 ? 1.0 : 0.75 + 0.3 * (shape.bowel_seed % 101) / 100.0;
    const Vec3 half = size * Vec3(37, 20, 26);
    Part part(0.0);
    part.add<Ellipsoid>(Vec3(0, FLOOR_OF_BLADDER_MM + half.y(), 12), half);
    Solid solid;
    solid.add(part);
    return solid;
}

namespace
{

/* Adds a pouch of gas. The pocket of gas is a row of uneven balls along a curve, like the haustra of the
 * colon. */
void add_pouches(Part &part, const std::vector<Vec3> &course, double radius_mm, double wall_mm, uint32_t seed)
{
    uint32_t state = seed;
    auto random = [&state] { // xorshift gives the same numbers from 0 to 1 on every machine
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        return state / 4294967296.0;
    };
    const Curve curve = sample_curve(course, std::vector<double>(course.size(), radius_mm), 0.85 * radius_mm);
    for (const CurvePoint &point : curve) {
        const double r = radius_mm * (0.62 + 0.45 * random());
        const Vec3 shift = 0.35 * radius_mm * Vec3(random() - 0.5, random() - 0.5, random() - 0.5);
        const Vec3 half(r, r * (0.9 + 0.2 * random()), r);
        part.add<Ellipsoid>(point.position_mm + shift, half + Vec3::Constant(wall_mm));
    }
}

} // namespace

Solid bowel_gas(const SoftShape &shape, double wall_mm)
{
    const Vec3 wall = Vec3::Constant(wall_mm);
    Solid solid;
    auto pouch = [&](const std::vector<Vec3> &course, double radius_mm, uint32_t seed) {
        Part part(3.5);
        // Another person's pouches have other sizes: each 0.6 to 1.2 of the shipped man's.
        const std::uint32_t own =
            shape.bowel_seed == 0 ? seed : seed * 2654435761u ^ (shape.bowel_seed * 40503u + 1u);
        const double size = shape.bowel_seed == 0 ? 1.0 : 0.6 + 0.6 * (own >> 8 & 0xff) / 255.0;
        add_pouches(part, course, radius_mm * shape.gas * size, wall_mm, own | 1u);
        solid.add(part);
    };
    Part stomach(10.0);
    stomach.add<Ellipsoid>(Vec3(66, 36, 4), Vec3(31, 15, 27) + wall);
    stomach.add<Ellipsoid>(Vec3(48, 22, 26), Vec3(24, 12, 22) + wall);
    solid.add(stomach);
    pouch({{-112, 2, 38}, {-118, -22, 36}, {-106, -40, 52}}, 15, 11); // hepatic flexure
    pouch({{-78, -64, 70}, {-46, -82, 80}, {-20, -88, 84}}, 14, 23);  // transverse colon
    pouch({{24, -82, 82}, {58, -62, 72}, {84, -38, 58}}, 12, 5);
    pouch({{112, 4, 6}, {120, -18, 0}, {122, -34, -4}}, 14, 77);           // splenic flexure
    pouch({{-112, -150, 36}, {-116, -178, 40}, {-108, -206, 44}}, 19, 41); // caecum
    pouch({{120, -110, 10}, {124, -138, 14}}, 10, 97);                     // descending colon
    pouch({{66, -238, 58}, {42, -252, 62}, {22, -240, 60}}, 13, 131);      // sigmoid
    pouch({{0, -268, -52}, {3, -290, -46}}, 15, 151);                      // rectum
    pouch({{-24, -132, 78}, {-4, -142, 82}}, 8, 201);                      // small bowel
    pouch({{40, -168, 74}, {58, -162, 70}}, 8, 223);
    pouch({{-52, -226, 66}, {-38, -232, 70}}, 7, 239);
    return solid;
}

namespace
{

/* Adds the loops of the small bowel, which run back and forth in four rows. */
std::vector<Vec3> small_bowel_course()
{
    std::vector<Vec3> points;
    for (int row = 0; row < 4; row++)
        for (int step = 0; step < 5; step++) {
            const double across = (row % 2 ? 2 - step : step - 2) * 31.0;
            points.emplace_back(across, -112.0 - 31.0 * row + 9.0 * (step % 2),
                                38.0 + 26.0 * ((step + row) % 2));
        }
    return points;
}

} // namespace

namespace
{

/* Three stretches of the colon hold faeces, which a picture shows as a mottle of small bubbles of gas. */
struct Faeces {
    std::vector<Vec3> course;
    double reach_mm; // of the bubbles from the course
    std::uint32_t seed;
};

void add_bubbles(Part &part, const Faeces &faeces, std::uint32_t person)
{
    constexpr double APART_MM = 5.0, LEAST_MM = 1.8, MOST_MM = 4.6;
    constexpr int PER_PLACE = 6;
    std::uint32_t state = faeces.seed * 2654435761u ^ (person * 40503u + 1u);
    const auto random = [&state] {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) / 16777216.0;
    };
    const Curve curve = sample_curve(faeces.course, std::vector<double>(faeces.course.size(), 1.0), APART_MM);
    for (const CurvePoint &point : curve)
        for (int i = 0; i < PER_PLACE; i++) {
            const Vec3 way(2 * random() - 1, 2 * random() - 1, 2 * random() - 1);
            const double r = LEAST_MM + (MOST_MM - LEAST_MM) * random() * random();
            const Vec3 half(r, r * (0.7 + 0.5 * random()), r * (0.8 + 0.4 * random()));
            if (way.norm() < 1.0) part.add<Ellipsoid>(point.position_mm + (faeces.reach_mm - r) * way, half);
        }
}

} // namespace

Solid faeces_gas(const SoftShape &shape)
{
    const Faeces stretches[] = {
        {{{-110, -196, 43}, {-116, -172, 40}, {-115, -115, 32}, {-113, -70, 33}}, 14.5, 3},
        {{{119, -60, 1}, {120, -90, 4}, {120, -150, 18}, {112, -196, 29}}, 8.5, 7},
        {{{0, -272, -40}, {3, -290, -47}}, 8.5, 13},
    };
    Part part(0.0);
    for (const Faeces &faeces : stretches) add_bubbles(part, faeces, shape.bowel_seed);
    Solid solid;
    solid.add(part);
    return solid;
}

Solid bowel(const SoftShape &shape, double wall_mm)
{
    Solid solid = bowel_gas(shape, wall_mm);
    const auto tube = [&](const std::vector<Vec3> &course, double radius_mm) {
        Part part(3.0);
        part.rod(course, std::vector<double>(course.size(), radius_mm));
        solid.add(part);
    };
    tube({{-108, -206, 44}, {-116, -172, 40}, {-115, -115, 32}, {-113, -55, 34}, {-112, -8, 38}}, 18.0);
    tube({{-110, -26, 44}, {-78, -64, 68}, {-20, -86, 80}, {58, -62, 70}, {98, -24, 26}, {114, 0, 4}}, 15.0);
    tube({{118, -20, -2}, {120, -90, 4}, {120, -150, 18}, {108, -208, 32}}, 12.0);
    tube({{106, -212, 36},
          {76, -238, 52},
          {42, -250, 60},
          {12, -240, 46},
          {2, -254, 6},
          {0, -270, -38},
          {3, -292, -48}},
         12.0);
    tube(small_bowel_course(), 11.5);
    Part stomach(12.0);
    stomach.rod({{66, 40, -6}, {62, 8, 18}, {34, -18, 40}, {-4, -16, 40}}, {30, 26, 19, 11});
    solid.add(stomach);
    return solid;
}

} // namespace anatomy
