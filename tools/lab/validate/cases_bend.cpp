// Tests the bending of a rod at rest: large deflections, weight, three-point bending, and curved tips.
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

// Sets up a cantilever, which is a rod that leaves the introducer along +x.
struct Cantilever {
    double bend_N_m2, length_m;
    unsigned elements;
    Rig rig;

    Cantilever(double bend, double length, unsigned count)
        : bend_N_m2(bend), length_m(length), elements(count),
          rig({tool(bend, length, count)}, nullptr, {{length}})
    {
        length_m = rig.inserted();
    }
    static Tool tool(double bend, double length, unsigned count)
    {
        double element = element_length(length, count);
        return uniform_tool({.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3}, element * (count + 8), element);
    }
    Vector3d tip() const { return rig.position(0) / length_m; }
};

Series of_reference(const std::string &label, const PlaneShape &shape)
{
    Series series{label, {}, {}, false, 6};
    for (std::size_t i = 0; i < shape.x.size(); i += 20) {
        series.x.push_back(shape.x[i]);
        series.y.push_back(shape.y[i]);
    }
    return series;
}

Series of_rig(const std::string &label, const Cantilever &c, int colour)
{
    Series series{label, {}, {}, true, colour};
    std::vector<Vector3d> points = c.rig.shape();
    for (std::size_t i = 0; i < points.size(); i += 12) {
        series.x.push_back(points[i][0] / c.length_m);
        series.y.push_back(points[i][2] / c.length_m);
    }
    return series;
}

void compare_tip(Result &result, const std::string &what, const Cantilever &c, const PlaneShape &shape,
                 double tolerance_pct)
{
    Vector3d tip = c.tip();
    double off = std::hypot(tip[0] - shape.x.back(), tip[2] - shape.y.back());
    result.error(what, "y/L", shape.y.back(), tip[2], 100 * off, "% of L", tolerance_pct);
}

// --- dead load at the tip ---

void tip_load(Result &result, bool quick)
{
    result.title = "Cantilever with a dead load at its tip";
    result.setup = "The rod leaves the mouth along x, without weight; the tip is loaded across. L = 0.1 m "
                   "for EI 2e-6 N m2, else "
                   "0.5 m; 5 g/m. Error: distance of the tip from the elastica's.";
    result.formula = "inextensible elastica EI theta' = M, M' = P cos theta, by shooting; load = P L^2 / EI";
    result.source = "Bisshopp and Drucker 1945";
    Plot plot{"Tip-loaded cantilever, EI 1.85e-3, 256 elements", "x / L", "y / L", {}, true};
    for (unsigned elements : {64u, 256u}) {
        for (double bend : {2e-6, 1.85e-3, 4.9e-3}) {
            if (quick && (elements == 256 || bend > 4e-3)) continue;
            Cantilever c(bend, bend < 1e-5 ? 0.1 : 0.5, elements);
            const double first = 0.5;
            for (double load : {first, 1.0, 2.0, 4.0, 5.0, 10.0}) {
                if (quick && load != 1 && load != 10) continue;
                c.rig.set_tip_load({0, 0, -load * bend / (c.length_m * c.length_m)});
                settle(c.rig, 2e-6 * c.length_m, 20000);
                PlaneShape shape = elastica(load, 0);
                compare_tip(result,
                            std::to_string(elements) + "_elements.EI_" + power_text(bend) + ".load_" +
                                number_text(load),
                            c, shape, 0.1);
                if (elements == 256 && bend == 1.85e-3) {
                    plot.series.push_back(of_reference(load == first ? "elastica" : "", shape));
                    plot.series.push_back(
                        of_rig("load " + number_text(load), c, int(plot.series.size()) / 2));
                }
            }
        }
    }
    if (!plot.series.empty()) result.plots.push_back(plot);
}

// --- weight ---

// Increases the load in steps of 30 %. Returns the heaviest load at which the rod comes to rest and no number
// format is exceeded.
double heaviest(double bend_N_m2, double from, double to)
{
    Cantilever c(bend_N_m2, 0.5, 256);
    double fits = 0;
    for (double load = from; load <= to; load *= 1.3) {
        c.rig.set_gravity({0, 0, -load * bend_N_m2 / std::pow(c.length_m, 3) / 0.005});
        settle(c.rig, 1e-5, 3000);
        if (c.rig.saturated()) break;
        fits = load;
    }
    return fits;
}

// The lightest wire that the core accepts, 0.5 g/m in elements of 1 mm. Each element weighs 20.6 steps of the
// force's format, so its weight must not be rounded alone.
void light_wire(Result &result)
{
    const double bend = 2e-5, length = 0.1, mass = 5e-4;
    Rig rig({uniform_tool({.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .mass_kg_per_m = mass}, 0.12, 0.001)},
            nullptr, {{length}});
    rig.set_gravity({0, 0, -gravity_m_s2});
    rig.step(6000);
    const PlaneShape shape = elastica(0, mass * gravity_m_s2 * std::pow(length, 3) / bend);
    result.relative("light_wire.sag", "mm", -shape.y.back() * length * 1e3, -rig.position(0)[2] * 1e3, 0.5);
}

void self_weight(Result &result, bool quick)
{
    result.title = "Cantilever under its own weight";
    result.setup = "EI 1.85e-3 N m2, L 0.5 m; gravity is raised until w L^3 / EI is the load. Heavier than "
                   "any real wire: "
                   "Super Stiff has 3.";
    result.formula = "inextensible elastica under a load w per length, by shooting; load = w L^3 / EI";
    result.source = "Bickley 1934";
    Plot plot{"Cantilever under its own weight, 256 elements", "x / L", "y / L", {}, true};
    for (unsigned elements : {64u, 256u}) {
        if (quick && elements == 256) continue;
        Cantilever c(1.85e-3, 0.5, elements);
        const double first = 1;
        for (double load : {first, 2.0, 5.0, 10.0, 20.0, 50.0}) {
            if (quick && load != 5 && load != 50) continue;
            c.rig.set_gravity({0, 0, -load * c.bend_N_m2 / std::pow(c.length_m, 3) / 0.005});
            settle(c.rig, 2e-6 * c.length_m, 20000);
            PlaneShape shape = elastica(0, load);
            compare_tip(result, std::to_string(elements) + "_elements.load_" + number_text(load), c, shape,
                        0.1);
            if (elements == 256) {
                plot.series.push_back(of_reference(load == first ? "elastica" : "", shape));
                plot.series.push_back(of_rig("load " + number_text(load), c, int(plot.series.size()) / 2));
            }
        }
    }
    light_wire(result);
    if (quick) return;
    result.plots.push_back(plot);
    for (double bend : {1.85e-3, 4.9e-3}) {
        double load = heaviest(bend, 50, 3000);
        result.reported("heaviest_without_saturation.EI_" + power_text(bend), "w L^3/EI", load, load);
    }
}

// --- three-point bend ---

// Models half of the span of a three-point bending test. By symmetry the middle of the beam is clamped, and
// each support pushes with P / 2. Returns the load P on the beam divided by the beam's deflection.
// `mass_factor` multiplies the mass m of the rod. The result depends on the time step h only through the
// inertia m / h^2 of a node of mass m, and through the drag. A mass factor of 4 therefore has the same effect
// as a time step of half the length.
double bench_stiffness(double bend_N_m2, double span_m, double deflection_m, double mass_factor, int ticks)
{
    double half = span_m / 2, element = element_length(half, bend_N_m2 > 2e-3 ? 10 : 20);
    Knot knot{.bend_N_m2 = bend_N_m2, .twist_N_m2 = bend_N_m2 / 1.3, .mass_kg_per_m = 0.005 * mass_factor};
    Rig rig({uniform_tool(knot, element * 30, element)}, nullptr, {{half}});
    double load = 48 * bend_N_m2 / std::pow(span_m, 3) * deflection_m;
    for (int tick = 1; tick <= ticks; tick++) {
        rig.set_tip_load({0, 0, load / 2 * tick / ticks});
        rig.step();
    }
    settle(rig, 1e-8, 4000);
    return load / rig.position(0)[2];
}

void three_point(Result &result, bool)
{
    result.title = "Three-point bend of the bench, 40 mm span";
    result.setup = "Half of the symmetric span: the mouth clamps the middle, the tip carries P / 2, elements "
                   "of 1 mm (2 mm for Lunderquist), deflection "
                   "0.4 mm, loaded in 0.1 s. Half the time step: the core's step is fixed at 1 ms, and h "
                   "enters the solve only as "
                   "m / h^2 and as drag per tick; four times the mass and twice the ticks therefore are the "
                   "equations at 0.5 ms "
                   "(with twice the drag).";
    result.formula = "k = 48 EI / L^3";
    result.source = "Euler-Bernoulli beam; EI from Harrison et al. 2011";
    const std::pair<const char *, double> wires[] = {{"plain_Amplatz", 2.91e-4},
                                                     {"Super_Stiff", 1.85e-3},
                                                     {"Lunderquist", 4.86e-3},
                                                     {"Glidewire_tip", 6e-6}};
    Plot plot{"Three-point bend, 40 mm span", "EI (N m2)", "k / (48 EI / L^3)", {}, false, true};
    Series whole{"1 ms", {}, {}, true}, half{"0.5 ms", {}, {}, true}, line{"beam", {}, {}};
    for (auto [name, bend] : wires) {
        double reference = 48 * bend / std::pow(0.04, 3);
        double k = bench_stiffness(bend, 0.04, 4e-4, 1, 100),
               k_half = bench_stiffness(bend, 0.04, 4e-4, 4, 200);
        result.relative(std::string("EI.") + name, "N/m", reference, k, 1);
        result.relative(std::string("half_step.") + name, "N/m", k, k_half, 1);
        for (auto [series, value] :
             {std::pair{&whole, k / reference}, {&half, k_half / reference}, {&line, 1.0}}) {
            series->x.push_back(bend);
            series->y.push_back(value);
        }
    }
    plot.series = {line, whole, half};
    result.plots.push_back(plot);
}

// --- curved tips ---

// A rod whose resting shape has the curvature 1/R is held straight by supports on the x axis. The first span
// (length a) reaches from the clamp at the base to the support `second`. The second span (length d) reaches
// from the support `second` to the tip. Clapeyron's theorem of three moments gives the moment at the support
// `second`, in units of EI/R (a moment). The moment at the support `second` is near EI/R but not equal to it,
// because the last span has supports but no clamp at its ends.
double three_moments(double a, double d)
{
    return (3 * d + 1.5 * a) / (2 * d + 1.5 * a);
}

void curved_tip(Result &result, bool)
{
    result.title = "Rest curvature: free circle, and the moment that straightens it";
    result.setup = "A rod of four radii with uniform rest curvature. Free: chord of its circle. "
                   "Straightened: two springs hold the "
                   "tip and a node half a radius behind it on the axis, free along it; the tip spring's "
                   "force times that arm.";
    result.formula =
        "chord = 2 R sin(s / 2R); moment = EI / R (3d + 1.5a) / (2d + 1.5a), d the arm, a the span behind it";
    result.source = "Euler-Bernoulli beam; Clapeyron's three moments";
    for (auto [radius, bend] : {std::pair{0.003, 2e-6}, {0.015, 1e-4}, {0.05, 1e-3}}) {
        std::string name = "R_" + number_text(radius * 1e3) + "mm.EI_" + power_text(bend);
        double length = 4 * radius, element = element_length(length, 60);
        Knot knot{.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .rest_curvature_per_m = 1 / radius};
        Tool tool = uniform_tool(knot, std::max(0.021, element * 70), element);
        Rig held({tool}, nullptr, {{length}});
        auto second = unsigned(std::lround(radius / 2 / element));
        Hold hold{.anchor_m = held.position(0),
                  .second = second,
                  .second_anchor_m = held.position(second),
                  .axial_free = true};
        held.set_hold(hold);
        held.step(2000);
        double arm = held.arc(second), moment = bend / radius * three_moments(held.inserted() - arm, arm);
        result.relative("moment." + name, "N m", moment, held.hold_force(0).norm() * arm, 1);
        Rig free({tool}, nullptr, {{length}});
        settle(free, 1e-7, 20000);
        double s = free.inserted(), chord = 2 * radius * std::fabs(std::sin(s / 2 / radius));
        double ours = free.position(0).norm();
        result.error("chord." + name, "mm", chord * 1e3, ours * 1e3, 100 * (ours - chord) / s, "% of arc",
                     0.2);
    }
}

} // namespace

std::vector<Case> bend_cases()
{
    return {{"tip_load", tip_load},
            {"self_weight", self_weight},
            {"three_point", three_point},
            {"curved_tip", curved_tip}};
}

} // namespace crn::validate
