#include "tools/lab/figures/page.hpp"
#include "host/base/number_text.hpp"
#include "tools/lab/figures/tables.hpp"

namespace vcsim3
{
namespace
{

const char *const head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
)";
const char *const style = R"(<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #1e1e28; max-width: 1240px; margin: 2em auto; padding: 0 1em; }
img { max-width: 100%; height: auto; border: 1px solid #dee0e6; }
table { border-collapse: collapse; font-size: 14px; margin: 1em 0; display: block; overflow-x: auto; }
th, td { padding: 3px 10px; text-align: right; border-bottom: 1px solid #dee0e6; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
.good { color: #146c2e; } .bad { color: #b3261e; }
</style></head><body>
)";

std::string paragraph(const std::string &text)
{
    return "<p>" + text + "</p>\n";
}

std::string verdict(const Study &study)
{
    const std::vector<std::string> faults = order_faults(study);
    if (faults.empty())
        return "<p class=\"good\"><b>Reproduced:</b> penalty &gt; 5 &gt; 10 &gt; 25 &gt; 50 local, and the "
               "direct "
               "solver below every mode that was run.</p>\n";
    std::string text = "<p class=\"bad\"><b>Not reproduced:</b> ";
    for (std::size_t i = 0; i < faults.size(); i++) text += (i ? "; " : "") + faults[i];
    return text + ".</p>\n";
}

std::string figure(const std::string &title, const std::string &image, const std::string &text)
{
    return "<h2>" + title + "</h2>\n<p><a href=\"" + image + "\"><img src=\"" + image + "\" alt=\"" + title +
           "\"></a></p>\n" + text;
}

std::string introduction(const Study &study, const std::string &vessel_name)
{
    const Preset &p = *study.preset;
    return paragraph("Written by <code>make thesis</code>. The baseline is the thesis' own rod (CoRdE: mass "
                     "points, a "
                     "quaternion per segment, parallel constraint, explicit integration) in double "
                     "precision; the direct "
                     "solver is the firmware core. Both are fed into the same lumen (" +
                     vessel_name +
                     ") by the same hand. Equations, units and limits: <code>docs/thesis.md</code>.") +
           paragraph("Rod: " + std::string(p.instrument) + " of Table 5.1, EI " +
                     crn::number_text(p.bend_N_m2(), 3) + " N m&sup2;, " +
                     std::to_string(study.protocol.element_count) + " elements of " +
                     crn::number_text(study.protocol.element_m * 1e3, 4) + " mm, friction " +
                     crn::number_text(wall_friction, 4) +
                     ", mixing 1.0, Baumgarte 0.1, no weight. Baseline, all modes alike: " +
                     std::to_string(p.substeps) + " steps per millisecond, " +
                     crn::number_text(p.mass_kg_per_m(), 3) + " kg/m (the table's density &times; " +
                     crn::number_text(p.mass_scale, 4) + "), rotational inertia &times; " +
                     crn::number_text(p.inertia_scale, 4) + ". Direct solver: 1 step per millisecond, " +
                     crn::number_text(direct_mass_kg_per_m * 1e3, 4) + " g/m, no scale.");
}

std::string compression_text(const Study &study)
{
    return verdict(study) + to_html(compression_table(study)) +
           paragraph(
               "The thesis' levels are higher. A chain that needs the force F to be passed on and has N "
               "iterations "
               "per step is compressed by about F h&sup2; / (m l &beta; N) per segment, so the level is set "
               "by step, "
               "mass and force, which the thesis does not state; the order and the fall with N are what "
               "the method itself gives. The one global iteration does not see the wall that is answered "
               "after it: its compression sits in the first segments at the tip.");
}

std::string times_text(const Study &study)
{
    return to_html(times_table(study)) +
           paragraph(
               "Constraints grow in proportion to the iterations, as in the thesis. Times belong to this "
               "machine; "
               "the ratios and, where they were counted, the instructions (callgrind) do not. The thesis' "
               "collision detection worked on triangles and was its dearest phase; both rods here read the "
               "same "
               "distance field, so detection is cheap.");
}

std::string presets_text(const Study &study)
{
    std::string text = "<h2>Table 5.1 as presets</h2>\n" + to_html(preset_table());
    if (study.stability.empty()) return text;
    return text +
           paragraph(
               "Smallest stable number of steps per millisecond when 96 mm of rod are pushed into a tube of "
               "85 mm "
               "(no segment grows by a tenth). A preset's own number is the smallest with step ratio 2/l "
               "&radic;(Kp/mass per length) h &le; 1.5.") +
           to_html(stability_table(study));
}

} // namespace

std::string page_head(const std::string &title)
{
    return std::string(head) + "<title>" + title + "</title>\n" + style + "<h1>" + title + "</h1>\n";
}

std::string page_html(const Study &study, const std::string &vessel_name)
{
    std::string text = page_head("The thesis' rod beside ours") + introduction(study, vessel_name);
    text += figure("Figure 5.11: compression", "figure_5_11.png", compression_text(study));
    text += figure("Figure 5.12: shapes", "figure_5_12.png",
                   paragraph("Node positions: <a href=\"figure_5_12.tsv\">figure_5_12.tsv</a>."));
    text += figure("Figure 5.13: convergence", "figure_5_13.png",
                   paragraph("Both axes are logarithmic: a straight line of slope -1 is a compression that "
                             "halves when the iterations double."));
    if (!study.times.empty()) text += figure("Figure 5.14: cost", "figure_5_14.png", times_text(study));
    return text + presets_text(study) +
           paragraph(
               "Data: <a href=\"figure_5_11.tsv\">figure_5_11.tsv</a> (also 5.13), "
               "<a href=\"figure_5_14.tsv\">figure_5_14.tsv</a>, <a href=\"presets.tsv\">presets.tsv</a>, "
               "<a href=\"thesis.json\">thesis.json</a>.") +
           "</body></html>\n";
}

} // namespace vcsim3
