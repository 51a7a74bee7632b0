/* Makes the coronary arteries of the shipped heart at the end of diastole, right dominant. Their courses run
 * in the grooves between its chambers; they are given by height and angle about the left ventricle's axis
 * (heart_beat.hpp) and projected onto the heart's surface. Names and numbers of branches are the usual
 * ones. The courses are assumed; they come from no angiogram. */
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/organs.hpp"
#include "tools/anatomy/vessels.hpp"
#include <algorithm>

namespace anatomy
{

namespace
{

const char *DODGE = "Dodge 1992, Circulation 86:232 (60 men, right dominance)";
const char *BETWEEN = "assumed: between its neighbours";
const char *BRANCH = "assumed: usual size of this branch";

/* A point of a course on the heart's surface; a point without a diameter only defines the course. */
struct Mark {
    double height, angle_deg, diameter_mm;
    const char *name, *source;
};

/* Returns the place where the ray straight out from the axis leaves the heart, plus a small distance:
 * arteries lie half in their grooves. */
Vec3 on_heart(const Solid &heart, double height, double angle_deg)
{
    constexpr double LIFT_MM = 0.5, FAR_MM = 90.0, STEP_MM = 0.5;
    const HeartAxes &axes = heart_axes();
    const Vec3 start = axes.on_axis(height), out = axes.outward(angle_deg);
    double inside = 0.0, outside = STEP_MM;
    while (heart.distance(start + outside * out) < LIFT_MM && outside < FAR_MM) {
        inside = outside;
        outside += STEP_MM;
    }
    for (int halving = 0; halving < 20; halving++) {
        const double middle = 0.5 * (inside + outside);
        (heart.distance(start + middle * out) < LIFT_MM ? inside : outside) = middle;
    }
    return start + outside * out;
}

/* Returns the artery that begins with the given stations, if any, and then follows the marks. It touches the
 * surface every few millimetres. */
Vessel artery(const char *name, std::vector<Station> stations, const std::vector<Mark> &marks)
{
    constexpr double APART_MM = 4.0;
    static const Solid heart = heart_outline();
    std::vector<double> arc = {0.0}, height, angle, arc_known, diameter;
    Vec3 last = on_heart(heart, marks[0].height, marks[0].angle_deg);
    for (size_t i = 0; i < marks.size(); i++) {
        const Vec3 here = on_heart(heart, marks[i].height, marks[i].angle_deg);
        if (i > 0) arc.push_back(arc.back() + (here - last).norm());
        last = here;
        height.push_back(marks[i].height);
        angle.push_back(marks[i].angle_deg);
        if (marks[i].diameter_mm <= 0.0) continue;
        arc_known.push_back(arc.back());
        diameter.push_back(marks[i].diameter_mm);
    }
    const Spline height_at(arc, height), angle_at(arc, angle);
    const MonotoneCubic diameter_at(arc_known, diameter);
    for (size_t i = 0; i < marks.size(); i++) {
        const Mark &mark = marks[i];
        stations.push_back(
            {on_heart(heart, mark.height, mark.angle_deg), diameter_at.at(arc[i]), mark.name, mark.source});
        if (i + 1 == marks.size()) break;
        const int pieces = std::max(1, static_cast<int>((arc[i + 1] - arc[i]) / APART_MM));
        for (int k = 1; k < pieces; k++) {
            const double at = arc[i] + (arc[i + 1] - arc[i]) * k / pieces;
            stations.push_back(
                {on_heart(heart, height_at.at(at), angle_at.at(at)), diameter_at.at(at), "", ""});
        }
    }
    return {name, stations};
}

} // namespace

namespace
{

/* Mean flows at rest out of the ends, assumed: the LAD with its diagonals carries 56 ml/min (40 to 80 are
 * usual), the left main 92. */
double resting_flow_ml_min(const std::string &artery)
{
    const std::pair<const char *, double> flows[] = {{"LAD", 28}, {"D1", 16},  {"D2", 12},
                                                     {"LCX", 8},  {"OM1", 16}, {"OM2", 12},
                                                     {"AM", 8},   {"PDA", 24}, {"PL", 22}};
    for (const auto &[name, flow_ml_min] : flows)
        if (artery == name) return flow_ml_min;
    return 0;
}

std::vector<Vessel> left_courses()
{
    const Vec3 fork(29, 138.5, 14.5); // where the left main artery divides
    const Station at_fork = {fork, 3.8, "", ""};
    return {
        {"LM",
         {{{6, 151, 18}, 4.8, "", ""},
          {{17, 148, 14.5}, 4.6, "", ""},
          {{24, 143.5, 13.5}, 4.5, "left main", DODGE},
          {fork, 4.2, "", ""}}},
        artery("LAD", {at_fork},
               {{.76, 61, 3.7, "proximal LAD", DODGE},
                {.62, 55, 0, "", ""},
                {.5, 36, 2.9, "middle LAD", BETWEEN},
                {.4, 20, 0, "", ""},
                {.3, 9, 0, "", ""},
                {.2, 2, 1.9, "distal LAD", DODGE},
                {.1, -8, 0, "", ""},
                {.03, -25, 1.3, "", ""}}),
        artery("D1", {},
               {{.60, 54, 2.2, "", ""},
                {.5, 62, 2.0, "first diagonal", BRANCH},
                {.36, 70, 0, "", ""},
                {.22, 76, 1.3, "", ""}}),
        artery("D2", {},
               {{.42, 22, 2.0, "", ""},
                {.32, 34, 1.8, "second diagonal", BRANCH},
                {.2, 46, 0, "", ""},
                {.11, 55, 1.2, "", ""}}),
        artery("LCX", {at_fork},
               {{.79, 76, 3.4, "proximal LCX", DODGE},
                {.755, 92, 0, "", ""},
                {.71, 112, 2.8, "middle LCX", BETWEEN},
                {.72, 132, 0, "", ""},
                {.77, 150, 0, "", ""},
                {.83, 168, 1.5, "", ""}}),
        artery("OM1", {},
               {{.72, 106, 2.5, "", ""},
                {.6, 110, 2.3, "first marginal", BRANCH},
                {.45, 113, 0, "", ""},
                {.28, 118, 1.4, "", ""}}),
        artery("OM2", {},
               {{.735, 138, 2.1, "", ""},
                {.62, 142, 1.9, "second marginal", BRANCH},
                {.47, 146, 0, "", ""},
                {.3, 150, 1.3, "", ""}}),
    };
}

std::vector<Vessel> right_courses()
{
    return {
        artery("RCA",
               {{{0, 151, 22}, 4.2, "", ""}, {{-6, 149.5, 32}, 4.0, "", ""}, {{-9, 143, 39}, 3.95, "", ""}},
               {{.96, 345, 3.9, "proximal RCA", DODGE},
                {1.0, 322, 0, "", ""},
                {.99, 302, 3.5, "middle RCA", BETWEEN},
                {.93, 283, 0, "", ""},
                {.86, 264, 3.2, "distal RCA", BETWEEN},
                {.82, 247, 0, "", ""},
                {.87, 231, 2.7, "", ""}}),
        artery("AM", {},
               {{.96, 292, 1.9, "", ""},
                {.8, 300, 1.7, "acute marginal", BRANCH},
                {.62, 305, 0, "", ""},
                {.45, 312, 1.2, "", ""}}),
        artery("PDA", {},
               {{.87, 231, 2.4, "", ""},
                {.76, 228, 2.1, "posterior descending", BRANCH},
                {.6, 228, 0, "", ""},
                {.45, 228, 0, "", ""},
                {.28, 228, 1.3, "", ""}}),
        artery("PL", {},
               {{.87, 231, 2.3, "", ""},
                {.84, 216, 2.0, "posterolateral", BRANCH},
                {.74, 205, 0, "", ""},
                {.58, 198, 1.3, "", ""}}),
    };
}

} // namespace

bool is_right_coronary(const std::string &name)
{
    return name == "RCA" || name == "AM" || name == "PDA" || name == "PL";
}

std::vector<Vessel> coronary_arteries()
{
    std::vector<Vessel> arteries = left_courses();
    for (const Vessel &artery : right_courses()) arteries.push_back(artery);
    for (Vessel &artery : arteries) artery.flow_ml_min = resting_flow_ml_min(artery.name);
    return arteries;
}

VesselTree heart_tree()
{
    VesselTree tree = aorta_tree();
    tree.name = "heart";
    tree.title = "Aorta with the coronary arteries of a beating heart";
    const std::vector<Vessel> coronaries = coronary_arteries();
    tree.coronary_count = coronaries.size();
    tree.vessels.insert(tree.vessels.end(), coronaries.begin(), coronaries.end());
    return tree;
}

} // namespace anatomy
