/* Skin, bowel gas and perirenal fat. */
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* Trunk outline by height: half-width, front and back. Values in millimetres. */
struct Level {
    double y, half_width, front, back;
};

const Level TRUNK[] = {
    {-470, 168, 78, -108},  {-400, 174, 88, -112},  {-340, 180, 96, -122},  {-290, 178, 100, -126},
    {-240, 170, 106, -116}, {-180, 158, 110, -108}, {-120, 150, 110, -107}, {-60, 152, 108, -114},
    {0, 158, 106, -123},    {60, 164, 108, -131},   {120, 170, 110, -136},  {170, 174, 106, -138},
    {215, 168, 92, -138},   {250, 142, 72, -132},   {280, 96, 52, -122},    {310, 66, 42, -108},
    {340, 60, 42, -98},     {400, 60, 44, -92},
};

double trunk_distance(const Vec3 &p)
{
    static const auto spline = [](double Level::*field) {
        std::vector<double> y, value;
        for (const Level &level : TRUNK) {
            y.push_back(level.y);
            value.push_back(level.*field);
        }
        return Spline(y, value);
    };
    static const Spline width = spline(&Level::half_width), front = spline(&Level::front),
                        back = spline(&Level::back);
    const double a = width.at(p.y()), z_front = front.at(p.y()), z_back = back.at(p.y());
    const double b = 0.5 * (z_front - z_back), z = p.z() - 0.5 * (z_front + z_back);
    // Superellipse: a trunk is squarer than an ellipse.
    constexpr double POWER = 2.5;
    const double u = std::abs(p.x()) / a, w = std::abs(z) / b;
    const double level = std::pow(std::pow(u, POWER) + std::pow(w, POWER), 1.0 / POWER);
    if (level < 1e-6) return -std::min(a, b);
    const double scale = std::pow(level, 1.0 - POWER);
    const double slope =
        std::hypot(scale * std::pow(u, POWER - 1.0) / a, scale * std::pow(w, POWER - 1.0) / b);
    return (level - 1.0) / slope;
}

} // namespace

Solid skin()
{
    constexpr double BOTTOM_MM = -430.0, TOP_MM = 352.0, RIM_MM = 6.0, SHOULDER_BLEND_MM = 45.0;
    Part shoulders(30.0);
    for (double s : {-1.0, 1.0}) {
        shoulders.add<Ellipsoid>(side(s, 150, 232, -55), Vec3(60, 56, 58));
        shoulders.rod({side(s, 172, 240, -52), side(s, 206, 300, -42), side(s, 226, 360, -30)}, {52, 47, 44});
    }
    Box where;
    where.include(Vec3(-290, BOTTOM_MM, -160), 0.0);
    where.include(Vec3(290, TOP_MM, 130), 0.0);
    Part part(0.0);
    part.add<Formula>(
        [shoulders](const Vec3 &p) {
            double inside = smooth_min(trunk_distance(p), shoulders.distance(p), SHOULDER_BLEND_MM);
            // The gap between the thighs.
            const double gap = std::hypot(p.x() * 1.6, std::max(0.0, p.y() + 400.0)) - 26.0;
            inside = smooth_max(inside, -gap, 20.0);
            return smooth_max(inside, std::max(BOTTOM_MM - p.y(), p.y() - TOP_MM), RIM_MM);
        },
        where);
    Solid solid;
    solid.add(part);
    return solid;
}

namespace
{

/* A pouch of gas: a row of uneven balls along a course, as the folds of the colon make it. */
void add_pouches(Part &part, const std::vector<Vec3> &course, double radius_mm, uint32_t seed)
{
    uint32_t state = seed;
    auto random = [&state] { // xorshift: the same on every machine; 0 to 1
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        return state / 4294967296.0;
    };
    const Curve curve = sample_curve(course, std::vector<double>(course.size(), radius_mm), 0.85 * radius_mm);
    for (const CurvePoint &point : curve) {
        const double r = radius_mm * (0.62 + 0.45 * random());
        const Vec3 shift = 0.35 * radius_mm * Vec3(random() - 0.5, random() - 0.5, random() - 0.5);
        part.add<Ellipsoid>(point.position_mm + shift, Vec3(r, r * (0.9 + 0.2 * random()), r));
    }
}

} // namespace

Solid bowel_gas()
{
    Solid solid;
    auto pouch = [&](const std::vector<Vec3> &course, double radius_mm, uint32_t seed) {
        Part part(3.5);
        add_pouches(part, course, radius_mm, seed);
        solid.add(part);
    };
    Part stomach(10.0);
    stomach.add<Ellipsoid>(Vec3(66, 36, 4), Vec3(31, 15, 27));
    stomach.add<Ellipsoid>(Vec3(48, 22, 26), Vec3(24, 12, 22));
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

Solid kidney_fat()
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        const Eigen::Matrix3d lean =
            (Eigen::AngleAxisd(s * 0.22, Vec3::UnitZ()) * Eigen::AngleAxisd(0.2, Vec3::UnitX()))
                .toRotationMatrix();
        const Vec3 centre = side(s, 77, s > 0 ? -38 : -52, -52);
        Part part(0.0);
        part.add<Ellipsoid>(centre, Vec3(35, 65, 31), lean);
        part.cut<Ellipsoid>(centre, Vec3(27, 57, 23), lean);
        solid.add(part);
    }
    return solid;
}

} // namespace anatomy
