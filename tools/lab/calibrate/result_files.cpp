// Writes a result as JSON, as a page and as pictures, with the canvas, charts and tables of the thesis
// baseline (vcsim3).
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/lab/calibrate/result.hpp"
#include "tools/lab/figures/chart.hpp"
#include "tools/lab/figures/page.hpp"
#include "tools/lab/figures/tables.hpp"
#include "tools/lab/figures/vessel_picture.hpp"
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace crn::calibrate
{
namespace
{

using Json = nlohmann::ordered_json;
using vcsim3::Canvas;
using vcsim3::Colour;

constexpr Colour reference_colour{200, 30, 30}, simulated_colour{10, 140, 50};
constexpr Colour method_colours[] = {{52, 101, 164}, {204, 85, 0}, {120, 60, 150}};

Json json_of(const Distances &d)
{
    return {{"rms_mm", d.rms_mm},
            {"mean_mm", d.mean_mm},
            {"deviation_mm", d.deviation_mm},
            {"max_mm", d.max_mm},
            {"nodes", d.count}};
}

Json json_of(const std::vector<Vector3d> &points)
{
    Json list = Json::array();
    for (const Vector3d &p : points) list.push_back({p.x(), p.y(), p.z()});
    return list;
}

Json json_of(const ParameterResult &p)
{
    Json json = {{"name", p.parameter.name},
                 {"unit", p.parameter.unit},
                 {"what", p.parameter.text},
                 {"bounds", {p.parameter.low, p.parameter.high}},
                 {"nominal", p.parameter.nominal},
                 {"fitted", p.fitted},
                 {"determined", p.is_determined},
                 {"range", {p.identified.low, p.identified.high}},
                 {"range_share", p.identified.span_share},
                 {"kept", p.kept}};
    if (!p.why.empty()) json["why"] = p.why;
    return json;
}

Json json_of(const DepthResult &depth)
{
    Json json = {{"name", depth.name}, {"inserted_mm", depth.inserted_mm}, {"fitted", depth.is_fitted}};
    json.update(json_of(depth.distances));
    if (depth.force_error) json["force_error"] = *depth.force_error;
    json["settle_ticks"] = depth.settle_ticks;
    if (depth.short_cuts_mm) json["short_cuts_mm"] = *depth.short_cuts_mm;
    json["simulated_mm"] = json_of(depth.simulated_mm);
    return json;
}

Json json_of(const MethodResult &method)
{
    Json json = {{"method", method_token(method.search.method)},
                 {"population", method.search.population},
                 {"generations", method.search.generations},
                 {"objective", method.best}};
    Json curve = Json::array();
    for (const GenerationFigures &g : method.curve)
        curve.push_back({{"evaluations", g.evaluations},
                         {"objective", g.best},
                         {"error_mm", g.best_error_mm},
                         {"mean_objective", g.mean}});
    json["curve"] = curve;
    return json;
}

std::string range_text(const ParameterResult &p)
{
    return number_text(p.identified.low, 3) + " to " + number_text(p.identified.high, 3);
}

vcsim3::Table parameter_table(const Result &result)
{
    vcsim3::Table table{
        {"parameter", "unit", "nominal", "fitted", "as good within", "bounds", "verdict", "in the file"}, {}};
    for (const ParameterResult &p : result.parameters)
        table.rows.push_back({p.parameter.text, p.parameter.unit, number_text(p.parameter.nominal, 4),
                              number_text(p.fitted, 4), range_text(p),
                              number_text(p.parameter.low, 3) + " to " + number_text(p.parameter.high, 3),
                              p.is_determined ? "determined" : "undetermined: " + p.why,
                              number_text(p.kept, 4)});
    return table;
}

std::vector<std::string> distance_cells(const Distances &d)
{
    return {number_text(d.rms_mm, 3), number_text(d.mean_mm, 3), number_text(d.deviation_mm, 3),
            number_text(d.max_mm, 3)};
}

vcsim3::Table depth_table(const Result &result)
{
    vcsim3::Table table{{"depth", "inserted mm", "RMS mm", "mean mm", "deviation mm", "max mm",
                         "force, relative", "short cuts mm"},
                        {}};
    const auto add = [&](std::vector<std::string> row, const Distances &d, std::vector<std::string> rest) {
        for (const std::string &cell : distance_cells(d)) row.push_back(cell);
        row.insert(row.end(), rest.begin(), rest.end());
        table.rows.push_back(row);
    };
    for (const DepthResult &depth : result.depths)
        add({depth.name + (depth.is_fitted ? "" : " (validation)"), number_text(depth.inserted_mm, 4)},
            depth.distances,
            {depth.force_error ? number_text(*depth.force_error, 3) : "-",
             depth.short_cuts_mm ? number_text(*depth.short_cuts_mm, 2) : "-"});
    add({"average", ""}, result.average, {"", ""});
    return table;
}

void draw_line(Canvas &canvas, const vcsim3::VesselPicture &picture, double left, double top,
               const std::vector<Vector3d> &line_mm, double thickness, Colour colour)
{
    for (std::size_t i = 0; i + 1 < line_mm.size(); i++) {
        const Eigen::Vector2d a = picture.place_of(line_mm[i] * 1e-3),
                              b = picture.place_of(line_mm[i + 1] * 1e-3);
        canvas.line(left + a.x(), top + a.y(), left + b.x(), top + b.y(), thickness, colour);
    }
}

} // namespace

std::string to_json(const Result &result)
{
    Json json = {{"case", result.name},
                 {"instrument", result.instrument},
                 {"rod", result.rod},
                 {"method", method_token(result.search.method)},
                 {"seed", result.search.seed},
                 {"evaluations", result.evaluations},
                 {"noise_mm", result.noise_mm},
                 {"force_trace", result.has_force},
                 {"optimum",
                  {{"objective", result.best.objective},
                   {"error_mm", result.best.error_mm},
                   {"force_error", result.best.force_error}}},
                 {"kept",
                  {{"objective", result.kept.objective},
                   {"error_mm", result.kept.error_mm},
                   {"force_error", result.kept.force_error}}}};
    json["parameters"] = Json::array();
    for (const ParameterResult &p : result.parameters) json["parameters"].push_back(json_of(p));
    json["depths"] = Json::array();
    for (const DepthResult &depth : result.depths) json["depths"].push_back(json_of(depth));
    json["average"] = json_of(result.average);
    json["searches"] = Json::array();
    for (const MethodResult &method : result.methods) json["searches"].push_back(json_of(method));
    return json.dump(1) + "\n";
}

std::string page_html(const Result &result)
{
    std::string text = vcsim3::page_head("Calibration: " + html_text(result.name));
    text += "<p>" + html_text(result.instrument) + ", " +
            (result.rod == "core" ? "our rod" : "the thesis' rod (CoRdE)") +
            ", fitted by <code>calibrate</code> (" + method_token(result.search.method) + ", " +
            std::to_string(result.evaluations) + " insertions, seed " + std::to_string(result.search.seed) +
            "). The error is equation 19 of the thesis, averaged over the fitted depths: " +
            number_text(result.kept.error_mm, 3) +
            " mm. Method and limits: <code>docs/calibrate.md</code>.</p>\n";
    text += "<h2>Parameters</h2>\n" + vcsim3::to_html(parameter_table(result)) +
            "<p>\"As good within\": how far a number can go while the objective rises by less than " +
            number_text(result.noise_mm, 4) +
            " mm, the others at the optimum or as the search has varied them.</p>\n";
    text +=
        "<h2>Distances</h2>\n" + vcsim3::to_html(depth_table(result)) +
        "<p>Of the simulated nodes to the nearest point of the reference, of the instrument as it is "
        "written. \"Short cuts\": RMS "
        "distance to the same insertion at the case's speed, with finer elements and a longer rest.</p>\n";
    text +=
        "<h2>Shapes</h2>\n<p><img src=\"shapes.png\" alt=\"phantom, reference red, simulated green\"></p>\n";
    text += "<h2>Searches</h2>\n<p><img src=\"curves.png\" alt=\"best objective by evaluations\"></p>\n";
    text += "<p>Data: <a href=\"result.json\">result.json</a>";
    text += result.instrument_file.empty() ? "; no instrument file, as our simulator has no such rod"
                                           : ", <a href=\"instrument.toml\">instrument.toml</a>";
    return text + ".</p>\n</body></html>\n";
}

void draw_shapes(const Result &result, const vcsim3::Vessel &vessel, const std::string &path)
{
    const double pixels_per_mm = 2.0, head = 84.0, gap = 16.0;
    const vcsim3::VesselPicture picture(vessel, pixels_per_mm);
    const double panel = picture.width() + gap;
    const int width =
        std::max(720, static_cast<int>(gap + panel * static_cast<double>(result.depths.size())));
    Canvas canvas(width, static_cast<int>(head + 50 + picture.height()), vcsim3::paper);
    vcsim3::draw_title(canvas, result.instrument,
                       {result.name, "red: reference, green: simulated; seen from the front"});
    for (std::size_t i = 0; i < result.depths.size(); i++) {
        const DepthResult &depth = result.depths[i];
        const double left = gap + panel * static_cast<double>(i), top = head + 40;
        canvas.text(left + panel / 2, head, depth.name, 2.0, vcsim3::ink, vcsim3::Align::centre);
        canvas.text(left + panel / 2, head + 20,
                    "RMS " + number_text(depth.distances.rms_mm, 3) + " mm, max " +
                        number_text(depth.distances.max_mm, 3) + " mm",
                    1.5, vcsim3::quiet, vcsim3::Align::centre);
        picture.draw(canvas, left, top, {}, 0, 0);
        draw_line(canvas, picture, left, top, depth.reference_mm, 4.0, reference_colour);
        draw_line(canvas, picture, left, top, depth.simulated_mm, 1.8, simulated_colour);
    }
    canvas.write_png(path);
}

void draw_curves(const Result &result, const std::string &path)
{
    Canvas canvas(900, 520, vcsim3::paper);
    double low = 1e3, high = 0.0, most = 1.0;
    for (const MethodResult &method : result.methods)
        for (const GenerationFigures &g : method.curve) {
            low = std::min(low, g.best);
            high = std::max(high, g.best);
            most = std::max(most, static_cast<double>(g.evaluations));
        }
    vcsim3::draw_title(canvas, "Best objective (mm) by insertions", {result.name});
    vcsim3::Chart chart(canvas, 110, 90, 870, 450,
                        {std::pow(10.0, std::floor(std::log10(low))),
                         std::pow(10.0, std::ceil(std::log10(std::min(high, 100.0)))), true,
                         "objective (mm)"});
    chart.draw_frame();
    std::vector<std::pair<Colour, std::string>> legend;
    for (const MethodResult &method : result.methods) {
        const Colour colour = method_colours[static_cast<std::size_t>(method.search.method)];
        const auto x_of = [&](double evaluations) {
            return chart.left() + (chart.right() - chart.left()) * evaluations / most;
        };
        for (std::size_t i = 0; i + 1 < method.curve.size(); i++) {
            const GenerationFigures &a = method.curve[i], &b = method.curve[i + 1];
            canvas.line(x_of(a.evaluations), chart.y_of(a.best), x_of(b.evaluations), chart.y_of(b.best), 2.0,
                        colour);
        }
        legend.emplace_back(colour, std::string(method_token(method.search.method)) + ": " +
                                        number_text(method.best, 3) + " mm");
    }
    for (int i = 0; i <= 5; i++)
        canvas.text(chart.left() + (chart.right() - chart.left()) * i / 5.0, chart.bottom() + 10,
                    number_text(most * i / 5.0, 4), 1.5, vcsim3::ink, vcsim3::Align::centre);
    vcsim3::draw_legend(canvas, 560, 100, legend);
    canvas.write_png(path);
}

} // namespace crn::calibrate
