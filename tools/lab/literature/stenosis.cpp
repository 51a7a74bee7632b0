// Measures the fractional flow reserve of drawn lesions in the shipped heart.
#include "host/base/number_text.hpp"
#include "host/effects/lesion_figures.hpp"
#include "tools/bake/lesion.hpp"
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/heart_flow.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace crn::literature
{

namespace
{

struct Lesion {
    double stenosis_percent, length_mm, minimum_mm, ffr;
};

// Draws from a normal distribution within limits. The generator's numbers are the same on every machine, the
// distributions of the standard library are not.
class Draw
{
  public:
    double even() { return (generator_() + 0.5) / 4294967296.0; }
    double even(double low, double high) { return low + (high - low) * even(); }
    double normal(double mean, double deviation, double low, double high)
    {
        for (;;) {
            const double value =
                mean + deviation * std::sqrt(-2 * std::log(even())) * std::cos(2 * M_PI * even());
            if (value >= low && value <= high) return value;
        }
    }

  private:
    std::mt19937 generator_{20261129};
};

Lesion measured(const VesselTree &heart, const std::string &branch, double at_mm, double stenosis_percent,
                double length_mm)
{
    VesselTree tree = heart;
    bake::LesionText text;
    text.name = "lesion";
    text.branch = branch;
    text.at_mm = at_mm;
    text.length_mm = length_mm;
    text.stenosis_percent = stenosis_percent;
    bake::place_lesions(tree, {text});
    const LesionFigures figures = lesion_figures(tree, blood_mPa_s).at(0);
    return {figures.diameter_percent(), length_mm, figures.minimum_diameter_mm, figures.ffr};
}

double correlation(const std::vector<Lesion> &lesions, double Lesion::*member)
{
    double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    const double n = double(lesions.size());
    for (const Lesion &one : lesions) {
        x += one.*member / n;
        y += one.ffr / n;
    }
    for (const Lesion &one : lesions) {
        xx += std::pow(one.*member - x, 2);
        yy += std::pow(one.ffr - y, 2);
        xy += (one.*member - x) * (one.ffr - y);
    }
    return std::fabs(xy / std::sqrt(xx * yy));
}

double percent_at_most(const std::vector<Lesion> &lesions, double ffr)
{
    return 100.0 *
           double(std::count_if(lesions.begin(), lesions.end(),
                                [&](const Lesion &one) { return one.ffr <= ffr; })) /
           double(lesions.size());
}

validate::Series dots(const std::string &label, const std::vector<Lesion> &lesions, double Lesion::*member)
{
    validate::Series series{label, {}, {}, true};
    for (const Lesion &one : lesions) {
        series.x.push_back(one.*member);
        series.y.push_back(one.ffr);
    }
    return series;
}

// The source states means and deviations, but not the arteries: two thirds of the lesions are in the LAD, and
// one third in the right artery. The reference diameter is that of the heart where the lesion lies.
Figures long_lesions()
{
    const VesselTree heart = heart_flow_tree();
    Draw draw;
    std::vector<Lesion> lesions;
    for (int k = 0; k < 106; k++) {
        const bool is_left = k % 3 != 2;
        const double length = draw.normal(28.7, 10.6, 20, 48);
        const double at = draw.even(length / 2 + 4, is_left ? 48 : 56);
        lesions.push_back(
            measured(heart, is_left ? "LAD" : "RCA", at, draw.normal(49.0, 8.7, 40, 70), length));
    }
    return {{{"below_075", percent_at_most(lesions, 0.75)},
             {"length", correlation(lesions, &Lesion::length_mm)},
             {"minimum_diameter", correlation(lesions, &Lesion::minimum_mm)},
             {"stenosis", correlation(lesions, &Lesion::stenosis_percent)}},
            {{"Long intermediate lesions",
              "length (mm)",
              "FFR",
              {dots("drawn lesions", lesions, &Lesion::length_mm)}}}};
}

Figures severities()
{
    const VesselTree heart = heart_flow_tree();
    Draw draw;
    Figures figures;
    validate::Plot plot{"Lesions of three classes", "diameter stenosis (%)", "FFR", {}};
    for (auto [name, low, high] : {std::tuple{"from_50_to_70", 50.0, 70.0},
                                   {"from_71_to_90", 71.0, 90.0},
                                   {"from_91_to_99", 91.0, 99.0}}) {
        std::vector<Lesion> lesions;
        for (int k = 0; k < 100; k++) {
            const char *branch = k % 3 == 0 ? "RCA" : k % 3 == 1 ? "LCX" : "LAD";
            const double length = draw.normal(13, 6, 6, 24), end = k % 3 == 1 ? 30 : 45;
            lesions.push_back(
                measured(heart, branch, draw.even(length / 2 + 4, end), draw.even(low, high), length));
        }
        figures.values[name] = percent_at_most(lesions, 0.80);
        plot.series.push_back(
            dots(number_text(low) + " to " + number_text(high) + " %", lesions, &Lesion::stenosis_percent));
    }
    figures.curves.push_back(plot);
    return figures;
}

} // namespace

std::vector<Experiment> stenosis_experiments()
{
    return {{"ffr_long_lesions", long_lesions}, {"ffr_severity", severities}};
}

} // namespace crn::literature
