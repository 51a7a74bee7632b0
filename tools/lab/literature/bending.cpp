// Bends wires over two supports, as a testing machine does.
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/shipped.hpp"
#include "tools/lab/validate/support.hpp"

#include <cmath>

namespace crn::literature
{

namespace
{

constexpr double wire_diameter_m = 889e-6; // 0.035 in
const double second_moment_m4 = M_PI / 64 * std::pow(wire_diameter_m, 4);

// Half of the span: by symmetry its middle is clamped, and the support pushes the end with half of the force.
class Bench
{
  public:
    Bench(double bend_N_m2, double span_m)
        : bend_N_m2_(bend_N_m2), span_m_(span_m),
          rig_({validate::uniform_tool({.bend_N_m2 = bend_N_m2, .twist_N_m2 = 0.77 * bend_N_m2},
                                       element(span_m) * (elements + 8), element(span_m))},
               nullptr, {{span_m / 2}})
    {
    }

    // Returns the force that bends the middle by `deflection_m`. The force grows slowly until it does.
    double force_N(double deflection_m)
    {
        double force = 48 * bend_N_m2_ / std::pow(span_m_, 3) * deflection_m;
        for (int round = 0; round < 12; round++) {
            for (int tick = 1; tick <= 200; tick++) {
                rig_.set_tip_load({0, 0, (held_N_ + (force - held_N_) * tick / 200) / 2});
                rig_.step();
            }
            held_N_ = force;
            validate::settle(rig_, 1e-8, 6000);
            const double bent = rig_.position(0)[2];
            if (std::fabs(bent / deflection_m - 1) < 1e-4) break;
            force *= deflection_m / bent;
        }
        return force;
    }

  private:
    static constexpr unsigned elements = 12;
    static double element(double span_m) { return validate::element_length(span_m / 2, elements); }
    double bend_N_m2_, span_m_, held_N_ = 0;
    validate::Rig rig_;
};

// Young's modulus as the testing machine computes it from the slope of force over deflection.
double flexural_modulus_GPa(double modulus_GPa)
{
    constexpr double span_m = 0.04, deflection_m = 0.0005;
    Bench bench(modulus_GPa * 1e9 * second_moment_m4, span_m);
    const double slope_N_m = bench.force_N(deflection_m) / deflection_m;
    return slope_N_m * std::pow(span_m, 3) / (48 * second_moment_m4) * 1e-9;
}

Figures harrison()
{
    Figures figures;
    for (auto [name, GPa] : {std::pair{"amplatz", 9.5},
                             {"heavy_duty_softest", 11.4},
                             {"heavy_duty_stiffest", 14.5},
                             {"amplatz_stiff", 17.0},
                             {"amplatz_extra_stiff", 29.2},
                             {"amplatz_super_stiff", 60.3},
                             {"amplatz_ultra_stiff", 65.4},
                             {"backup_meier", 139.6},
                             {"lunderquist", 158.4}})
        figures.values[name] = flexural_modulus_GPa(GPa);
    return figures;
}

// The span is assumed; over it the ratios of the forces do not depend much on it.
Figures chaudhuri()
{
    constexpr double span_m = 0.12;
    const auto curve = [](const char *label, double bend_N_m2) {
        validate::Series series{label, {}, {}};
        Bench bench(bend_N_m2, span_m);
        for (double mm : {0.0, 3.0, 6.0, 9.0, 12.0, 15.0}) {
            series.x.push_back(mm);
            series.y.push_back(mm > 0 ? bench.force_N(mm * 1e-3) : 0);
        }
        return series;
    };
    const validate::Series lunderquist = curve("Lunderquist", 158.4e9 * second_moment_m4),
                           amplatz = curve("Amplatz Super Stiff", shaft_bend_N_m2("amplatz_super_stiff")),
                           radifocus = curve("Radifocus Stiff", shaft_bend_N_m2("terumo_stiff_angled"));
    Figures figures;
    figures.values["lunderquist_to_amplatz"] = lunderquist.y.back() / amplatz.y.back();
    figures.values["radifocus_to_amplatz"] = radifocus.y.back() / amplatz.y.back();
    figures.curves.push_back({"Force over deflection, span 120 mm",
                              "deflection of the middle (mm)",
                              "force (N)",
                              {lunderquist, amplatz, radifocus}});
    return figures;
}

} // namespace

std::vector<Experiment> bending_experiments()
{
    return {{"flexural_modulus", harrison}, {"deflection_15_mm", chaudhuri}};
}

} // namespace crn::literature
