#include "tools/lab/figures/figures.hpp"
#include "host/base/format.hpp"
#include "tools/lab/figures/chart.hpp"
#include "tools/lab/figures/thesis_values.hpp"
#include "tools/lab/figures/vessel_picture.hpp"
#include <algorithm>
#include <cmath>

namespace vcsim3
{
namespace
{

constexpr int width = 1200;
constexpr double small_text = 1.5;
const Axis compression_axis{1e-4, 100.0, true, "compression (%)"};

bool is_direct(const std::string &token)
{
    return token == "direct";
}

std::string setting(const Study &study)
{
    std::string text;
    const Preset &p = *study.preset;
    text =
        crn::formatted("%s (Table 5.1): EI %.3g N m2, %d elements of %.3g mm, friction %.1f, hand %.0f mm/s",
                       p.instrument, p.bend_N_m2(), study.protocol.element_count,
                       study.protocol.element_m * 1e3, wall_friction, study.protocol.speed_m_s * 1e3);
    return text;
}

std::string stepping(const Study &study)
{
    std::string text;
    const Preset &p = *study.preset;
    text = crn::formatted(
        "baseline: %d steps per ms, %.3g kg/m (mass x %.3g), rotational inertia x %.3g, all modes alike; "
        "direct: 1 step per ms, %.3g kg/m",
        p.substeps, p.mass_kg_per_m(), p.mass_scale, p.inertia_scale, direct_mass_kg_per_m);
    return text;
}

struct Bar {
    double x0, x1;
};

void draw_value_bar(Chart &chart, Bar bar, double value, Colour colour, const std::string &label)
{
    chart.canvas().rectangle(bar.x0, chart.y_of(value), bar.x1, chart.bottom(), colour);
    chart.canvas().text((bar.x0 + bar.x1) / 2, chart.y_of(value) - 16, label, small_text, ink, Align::centre);
}

} // namespace

void draw_compression(const Study &study, const std::string &path)
{
    Canvas canvas(width, 640, paper);
    draw_title(canvas, "Figure 5.11: compression by type and number of distance iterations",
               {setting(study), stepping(study)});
    Chart chart(canvas, 110, 130, width - 30, 560, compression_axis);
    chart.draw_frame();
    const double slot = (chart.right() - chart.left()) / static_cast<double>(study.runs.size());
    for (std::size_t i = 0; i < study.runs.size(); i++) {
        const CompressionResult &run = study.runs[i];
        const double x = chart.left() + slot * static_cast<double>(i), middle = x + slot / 2;
        const auto thesis = thesis_compression_pct(run.token);
        const double half = slot * (thesis ? 0.42 : 0.25);
        const Bar ours = {middle - half, thesis ? middle - 1 : middle + half};
        if (run.is_sound) {
            draw_value_bar(chart, ours, run.pushing_pct,
                           is_direct(run.token) ? direct_colour : baseline_colour,
                           short_number(run.pushing_pct, 2));
        } else {
            canvas.text(middle, chart.bottom() - 16, "burst", small_text, ink, Align::centre);
        }
        if (thesis)
            draw_value_bar(chart, {middle + 1, middle + half}, *thesis, thesis_colour, short_number(*thesis));
        canvas.text(middle, chart.bottom() + 10, run.name, small_text, ink, Align::centre);
    }
    draw_legend(canvas, width - 400, 134,
                {{baseline_colour, "baseline, measured here"},
                 {thesis_colour, "thesis, where its text has a number"},
                 {direct_colour, "our direct solver (firmware core)"}});
    canvas.text(
        24, 592,
        "Compression: 1 - length / rest length of the part in the vessel, mean over the last 0.1 s of "
        "pushing.",
        small_text, quiet);
    canvas.text(24, 612, "The thesis' other bars have no number in its text; its axis ends at 14 %.",
                small_text, quiet);
    canvas.write_png(path);
}

void draw_shapes(const Study &study, const Vessel &vessel, const std::string &path)
{
    const double pixels_per_mm = 2.0, free_radius_mm = 1.2, touching_radius_mm = 1.9;
    const VesselPicture picture(vessel, pixels_per_mm);
    const int columns = 5, rows = (static_cast<int>(study.runs.size()) + columns - 1) / columns;
    const int panel_width = picture.width() + 16, panel_height = picture.height() + 44, head = 96;
    Canvas canvas(std::max(columns * panel_width + 20, 1000), head + rows * panel_height + 10, paper);
    draw_title(canvas, "Figure 5.12: shape of the rod at rest after the push",
               {setting(study),
                "green: mass point touches the wall (drawn larger), red: free; in brackets the "
                "compression while pushing"});
    for (std::size_t i = 0; i < study.runs.size(); i++) {
        const CompressionResult &run = study.runs[i];
        const double left = 10.0 + static_cast<double>(i % columns) * panel_width;
        const double top = head + static_cast<double>(i / columns) * panel_height;
        const std::string title =
            run.name + (run.is_sound ? " (" + short_number(run.pushing_pct) + " %)" : " (burst)");
        canvas.text(left + panel_width / 2.0, top, title, 2.0, is_direct(run.token) ? direct_colour : ink,
                    Align::centre);
        canvas.text(left + panel_width / 2.0, top + 20, std::to_string(run.contacts) + " touching",
                    small_text, quiet, Align::centre);
        picture.draw(canvas, left, top + 34, run.shape, free_radius_mm, touching_radius_mm);
    }
    canvas.write_png(path);
}

void draw_convergence(const Study &study, const std::string &path)
{
    Canvas canvas(width, 640, paper);
    draw_title(canvas, "Figure 5.13: compression by number of local iterations",
               {setting(study), stepping(study)});
    Chart chart(canvas, 110, 120, width - 250, 550, compression_axis);
    chart.draw_frame();
    const Axis iterations{1.0, 300.0, true, ""};
    const auto x_of = [&](double count) {
        return chart.left() + 20 + iterations.share(count) * (chart.right() - chart.left() - 40);
    };
    double last[2][2] = {};
    for (const CompressionResult &run : study.runs) {
        Mode mode;
        if (!parse_mode(run.token, mode) || mode.kind != Mode::Kind::local) continue;
        const double x = x_of(mode.iterations);
        canvas.text(x, chart.bottom() + 10, std::to_string(mode.iterations), small_text, ink, Align::centre);
        const auto thesis = thesis_compression_pct(run.token);
        const double values[2] = {run.is_sound ? run.pushing_pct : 0.0, thesis.value_or(0.0)};
        const Colour colours[2] = {baseline_colour, {120, 124, 132}};
        for (int k = 0; k < 2; k++) {
            if (values[k] <= 0.0) continue;
            const double y = chart.y_of(values[k]);
            if (last[k][0] > 0.0) canvas.line(last[k][0], last[k][1], x, y, 2.0, colours[k]);
            canvas.disc(x, y, 5.0, colours[k]);
            // Our numbers are written below our curve, and the thesis' numbers above the thesis' curve,
            // because both curves fall.
            canvas.text(x, k == 0 ? y + 10 : y - 22, short_number(values[k]), small_text, colours[k],
                        Align::centre);
            last[k][0] = x;
            last[k][1] = y;
        }
    }
    for (const char *token : {"penalty", "global", "direct"}) {
        const CompressionResult *run = find_run(study, token);
        if (!run || !run->is_sound) continue;
        const Colour colour = is_direct(token) ? direct_colour : quiet;
        const double y = chart.y_of(run->pushing_pct);
        canvas.dashed(chart.left(), y, chart.right(), y, 1.5, colour);
        canvas.text(chart.right() + 8, y - 6, run->name + " " + short_number(run->pushing_pct), small_text,
                    colour);
    }
    canvas.text((chart.left() + chart.right()) / 2, chart.bottom() + 34, "local iterations per step",
                small_text, ink, Align::centre);
    draw_legend(canvas, chart.right() + 12, 126,
                {{baseline_colour, "baseline"}, {thesis_colour, "thesis"}, {direct_colour, "direct solver"}});
    canvas.write_png(path);
}

} // namespace vcsim3
