#include "tools/anatomy/small/veins.hpp"

namespace anatomy
{

namespace
{

struct VeinMark {
    double height, angle_deg, diameter_mm;
};

/* Veins lie on the heart's surface, 1.5 mm farther out than arteries. */
SmallVessel heart_vein(const HeartTissue &heart, const std::string &name, const std::string &parent, Bed bed,
                       const std::vector<VeinMark> &marks)
{
    constexpr double STEP_MM = 4.0, LIFT_MM = -1.5;
    std::vector<Vec3> points;
    std::vector<double> radii_mm;
    for (const VeinMark &mark : marks) {
        points.push_back(heart.place(mark.height, mark.angle_deg, LIFT_MM, OUTER_LAYER).at);
        radii_mm.push_back(0.5 * mark.diameter_mm);
    }
    Curve curve = sample_curve(points, radii_mm, STEP_MM);
    for (CurvePoint &point : curve)
        point.position_mm = heart.onto({point.position_mm, LIFT_MM, OUTER_LAYER}).at;
    return {name, parent, bed, true, 0.0, curve};
}

} // namespace

std::vector<SmallVessel> coronary_veins(const HeartTissue &heart)
{
    return {heart_vein(heart, "coronary_sinus", "", Bed::left_coronary,
                       {{0.9, 236, 9}, {0.9, 222, 8}, {0.88, 205, 7}, {0.86, 188, 6}, {0.85, 172, 5.5}}),
            heart_vein(heart, "great_cardiac_vein", "coronary_sinus", Bed::left_coronary,
                       {{0.85, 172, 5},
                        {0.82, 150, 4.2},
                        {0.78, 128, 3.8},
                        {0.78, 104, 3.5},
                        {0.79, 84, 3.3},
                        {0.76, 66, 3},
                        {0.62, 48, 2.6},
                        {0.5, 28, 2.3},
                        {0.4, 12, 2},
                        {0.3, 1, 1.6},
                        {0.2, -6, 1.1}}),
            heart_vein(heart, "left_marginal_vein", "great_cardiac_vein", Bed::left_coronary,
                       {{0.78, 128, 2.4}, {0.6, 124, 2}, {0.45, 124, 1.6}, {0.3, 126, 1}}),
            heart_vein(heart, "posterior_vein", "coronary_sinus", Bed::left_coronary,
                       {{0.86, 188, 2.8}, {0.72, 178, 2.4}, {0.55, 172, 1.9}, {0.38, 168, 1.1}}),
            heart_vein(heart, "middle_cardiac_vein", "coronary_sinus", Bed::right_coronary,
                       {{0.9, 232, 3.5}, {0.76, 234, 3}, {0.6, 234, 2.6}, {0.45, 234, 2}, {0.25, 233, 1.2}})};
}

std::vector<SmallVessel> renal_veins()
{
    const auto vein = [](const char *name, const std::vector<Vec3> &points,
                         const std::vector<double> &radii_mm) {
        return SmallVessel{name, "", Bed::kidney, true, 0.0, sample_curve(points, radii_mm, 5.0)};
    };
    return {vein("right_renal_vein", {{-20, -38, -2}, {-34, -46, -14}, {-50, -51, -30}, {-62, -52, -42}},
                 {6, 5.5, 5, 3.5}),
            vein("left_renal_vein",
                 {{-14, -34, 4}, {2, -36, 13}, {20, -38, 10}, {38, -38, -10}, {54, -38, -30}, {63, -38, -42}},
                 {5.5, 5, 5.5, 5.5, 5, 3.5})};
}

} // namespace anatomy
