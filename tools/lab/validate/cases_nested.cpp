// Tests tools inside one another for the friction between them, which grows with the pull through bends, and
// tools in blood for their weight.
#include "host/base/number_text.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/elastica.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

// --- capstan between tools ---

constexpr double bend_m = 0.06, lead_m = 0.04, out_m = 0.06, tube_m = 0.003, element_m = 0.003;

// A tube with one bend, or with two bends whose planes are square to each other, so that a full turn does not
// meet itself.
Path bends(double angle_rad)
{
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.03 + lead_m).bend(bend_m, std::min(angle_rad, M_PI));
    if (angle_rad > M_PI) path.straight(0.05).roll(M_PI / 2).bend(bend_m, angle_rad - M_PI);
    return path.straight(out_m + 0.05);
}

// Soft tools, so that their bending hardly presses: the radii of a wire of 0.035 in, a catheter and a guide.
std::vector<Tool> soft_tools(unsigned count, double length_m, double friction)
{
    const double outer_m[] = {445e-6, 750e-6, 1350e-6}, inner_m[] = {0, 500e-6, 900e-6};
    std::vector<Tool> tools;
    for (unsigned k = 0; k < count; k++) {
        const double bend = 1e-6;
        Tool tool = uniform_tool(
            {.bend_N_m2 = bend, .twist_N_m2 = bend, .radius_m = outer_m[k], .radius_inner_m = inner_m[k]},
            length_m, element_m);
        tool.lumen_friction = friction;
        tools.push_back(tool);
    }
    return tools;
}

// The angle by which the line turns between the introducer and an arc length from the tip.
double turning(const Rig &rig, double from_m)
{
    std::vector<Vector3d> points = rig.shape();
    double sum = 0;
    for (unsigned i = 1; i + 1 < points.size(); i++) {
        if (rig.arc(i) < from_m) continue;
        Vector3d a = (points[i - 1] - points[i]).normalized(), b = (points[i] - points[i + 1]).normalized();
        sum += std::atan2(a.cross(b).norm(), a.dot(b));
    }
    return sum;
}

// Where tools lie at the beginning of a draw, behind the end of the bends.
struct Places {
    std::vector<double> back_m; // of every tool's tip; negative: it comes out
    unsigned moved = 0;         // the hands of the tools 0 .. moved draw
};

struct Draw {
    double ratio = 0,
           angle_rad = 0; // force on the moved hands divided by the load; angle inside of the lumen
};

// A dead load pulls the leading tip out of the tools around it, which hands hold. The hands of the tools 0 ..
// moved draw these tools back, or let them go forwards, at 10 mm/s.
Draw draw(const Places &places, double angle_rad, double friction, int way)
{
    Path path = bends(angle_rad);
    LumenField field = tube_field(path, tube_m, 0);
    const double inside_m = path.length() - 0.03 - out_m - 0.05 + 0.03;
    const unsigned tools = static_cast<unsigned>(places.back_m.size()), moved = places.moved;
    Start start;
    double longest_m = 0;
    for (double back_m : places.back_m) {
        start.inserted_m.push_back(inside_m - back_m);
        longest_m = std::max(longest_m, inside_m - back_m);
    }
    Rig rig(soft_tools(tools, longest_m + 0.1, friction), &field, start);
    std::vector<Vector3d> nodes;
    for (unsigned i = 0; i < rig.free_count(); i++)
        nodes.push_back(path.at(0.03 + rig.inserted() - rig.arc(i)));
    rig.place(nodes);
    const double load_N = 1;
    rig.set_tip_load(load_N * path.end_direction());
    rig.step(1500);
    const int ticks = 1500;
    Draw result;
    for (int tick = 1; tick <= ticks; tick++) {
        for (unsigned k = 0; k <= moved; k++) rig.feed(way * 1e-5 * tick, k);
        rig.step();
        if (tick <= ticks / 2) continue;
        double hands_N = 0, front_m = 0;
        for (unsigned k = 0; k <= moved; k++) hands_N -= rig.handle_axial(k);
        for (unsigned k = moved + 1; k < tools; k++) front_m = std::max(front_m, rig.inserted(k));
        result.ratio += hands_N / load_N / (ticks - ticks / 2);
        result.angle_rad += turning(rig, rig.inserted() - front_m) / (ticks - ticks / 2);
    }
    return result;
}

// Tips of the tools 0 .. moved come out by 30 mm and less, and the others end with the bends.
Places level(unsigned tools, unsigned moved)
{
    Places places;
    for (unsigned k = 0; k < tools; k++) places.back_m.push_back(k <= moved ? -0.035 + 0.005 * k : 0.0);
    places.moved = moved;
    return places;
}

void nested_capstan(Result &result, bool quick)
{
    result.title = "Capstan between tools: a wire drawn through a bent catheter";
    result.setup = "A frictionless tube of 3 mm with bends of R 60 mm; tools with EI 1e-6 N m2 and elements "
                   "of 3 mm. 1 N "
                   "pulls the wire's tip out of the catheter. Hands hold the outer tools and draw the inner "
                   "ones back at "
                   "10 mm/s, or let them go. Mean over 7.5 mm. Angle: sum over the nodes inside the lumen. "
                   "What bending adds, some 0.003 N at each end of a bend, is not in the reference.";
    result.formula = "hand / tip = e^(mu angle), e^(-mu angle) when the wire goes forwards";
    result.source = "Euler, Eytelwein";
    Plot plot{"Pull through a bent catheter", "angle (degrees)", "hand / tip", {}};
    int colour = 0;
    for (double mu : {0.05, 0.1, 0.2, 0.4}) {
        Series ours{"mu " + number_text(mu), {}, {}, true, colour},
            line{"e^(mu angle)", {}, {}, false, colour};
        colour++;
        for (int angle : {0, 90, 180, 270, 360}) {
            if (quick && !(mu == 0.2 && angle == 180) && !(mu == 0.4 && angle == 360)) continue;
            Draw got = draw(level(2, 0), angle * degree, mu, -1);
            result.relative("wire." + std::to_string(angle) + "_deg.mu_" + number_text(mu), "",
                            std::exp(mu * got.angle_rad), got.ratio, 2);
            ours.x.push_back(got.angle_rad / degree);
            ours.y.push_back(got.ratio);
        }
        for (int angle = 0; angle <= 360; angle += 10) {
            line.x.push_back(angle);
            line.y.push_back(std::exp(mu * angle * degree));
        }
        plot.series.push_back(ours);
        plot.series.push_back(line);
    }
    result.plots.push_back(plot);
    for (double mu : {0.1, 0.4}) {
        if (quick && mu > 0.1) continue;
        for (int angle : {90, 180, 360}) {
            if (quick && angle != 180) continue;
            std::string name = std::to_string(angle) + "_deg.mu_" + number_text(mu);
            Draw forwards = draw(level(2, 0), angle * degree, mu, 1);
            double left = std::exp(-mu * forwards.angle_rad);
            result.error("forwards." + name, "", left, forwards.ratio, 100 * (forwards.ratio - left),
                         "% of the load", 1.5);
            Draw three = draw(level(3, 0), angle * degree, mu, -1);
            result.relative("wire_of_three." + name, "", std::exp(mu * three.angle_rad), three.ratio, 2);
            Draw two = draw(level(3, 1), angle * degree, mu, -1);
            result.relative("wire_and_catheter." + name, "", std::exp(mu * two.angle_rad), two.ratio, 2);
            // The middle tip lies behind the bends, so the wire rubs in the guide itself.
            Draw apart = draw({{-0.03, 0.10, 0.0}, 0}, angle * degree, mu, -1);
            result.relative("wire_in_guide." + name, "", std::exp(mu * apart.angle_rad), apart.ratio, 2);
        }
    }
}

// --- weight in blood ---

// Tools leave the introducer level and sag by their weight, less that of the blood that they displace.
void weight_in_blood(Result &result, bool quick)
{
    result.title = "Weight of tools in blood";
    result.setup =
        "Cantilevers of 0.2 m, full of blood of 1060 kg/m3 and in it: a catheter of 5F, one of 6F, a wire, "
        "and the wire in the catheter; elements of 2 mm. Error of the sag at the tip.";
    result.formula = "elastica by shooting; w = sum (m - 1060 pi (ro^2 - ri^2)) g";
    result.source = "Archimedes; Bickley 1934";
    const Knot wire{.bend_N_m2 = 3e-4, .mass_kg_per_m = 0.0039, .radius_m = 445e-6};
    const Knot catheter_5f{
        .bend_N_m2 = 4e-4, .mass_kg_per_m = 0.0025, .radius_m = 835e-6, .radius_inner_m = 485e-6};
    const Knot guide_6f{
        .bend_N_m2 = 9e-4, .mass_kg_per_m = 0.0032, .radius_m = 1e-3, .radius_inner_m = 0.9e-3};
    struct Setting {
        std::string name;
        std::vector<Knot> knots;
    };
    for (const Setting &setting :
         {Setting{"wire", {wire}}, Setting{"catheter_5f", {catheter_5f}}, Setting{"guide_6f", {guide_6f}},
          Setting{"wire_in_catheter", {wire, catheter_5f}}}) {
        if (quick && setting.name != "catheter_5f") continue;
        std::vector<Tool> tools;
        Start start;
        start.blood_kg_m3 = 1060;
        double bend = 0, weight_N_m = 0;
        for (const Knot &knot : setting.knots) {
            tools.push_back(uniform_tool(knot, 0.25, element_length(0.2, 100)));
            start.inserted_m.push_back(0.2 - 1e-6 * double(start.inserted_m.size()));
            bend += knot.bend_N_m2;
            double area = M_PI * (knot.radius_m * knot.radius_m - knot.radius_inner_m * knot.radius_inner_m);
            weight_N_m += (knot.mass_kg_per_m - start.blood_kg_m3 * area) * gravity_m_s2;
        }
        Rig rig(tools, nullptr, start);
        rig.set_gravity({0, 0, -gravity_m_s2});
        settle(rig, 1e-8, 20000);
        double length = rig.inserted();
        PlaneShape shape = elastica(0, weight_N_m * length * length * length / bend);
        result.relative("sag." + setting.name, "mm", 1e3 * length * shape.y.back(), 1e3 * rig.position(0)[2],
                        0.1);
    }
}

} // namespace

std::vector<Case> nested_cases()
{
    return {{"nested_capstan", nested_capstan}, {"weight_in_blood", weight_in_blood}};
}

} // namespace crn::validate
