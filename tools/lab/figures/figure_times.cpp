// Draws Figure 5.14 of the thesis twice: with the milliseconds per step that the thesis measured, and with
// our microseconds per step on this machine.
#include "tools/lab/figures/chart.hpp"
#include "tools/lab/figures/figures.hpp"
#include "tools/lab/figures/thesis_values.hpp"
#include <algorithm>

namespace vcsim3
{
namespace
{

constexpr int width = 1200;
constexpr double small_text = 1.5;
constexpr Colour phase_colours[4] = {{60, 70, 90}, {237, 201, 72}, {89, 161, 79}, {130, 160, 205}};
const char *const phase_names[4] = {"integrator", "constraints, contact response", "Cosserat forces",
                                    "collision detection"};

struct Stack {
    std::string name, label;
    double parts[4];
    double direct; // a separate bar
};

double height_of(const Stack &stack)
{
    return stack.parts[0] + stack.parts[1] + stack.parts[2] + stack.parts[3] + stack.direct;
}

// Splits the name of a mode, such as "25 Local", into two lines, so that the name fits below a narrow bar.
std::pair<std::string, std::string> two_lines(const std::string &name)
{
    if (name == "1 Global") return {"1", "glob."};
    if (name == "1 Penalty") return {"1", "pen."};
    const std::size_t space = name.find(' ');
    return space == std::string::npos ? std::pair(name, std::string())
                                      : std::pair(name.substr(0, space), std::string("local"));
}

void draw_stacks(Chart &chart, const std::vector<Stack> &stacks)
{
    chart.draw_frame();
    Canvas &canvas = chart.canvas();
    const double slot = (chart.right() - chart.left()) / static_cast<double>(stacks.size());
    for (std::size_t i = 0; i < stacks.size(); i++) {
        const double x = chart.left() + slot * static_cast<double>(i), middle = x + slot / 2;
        double sum = 0.0;
        const auto pile = [&](double part, Colour colour) {
            canvas.rectangle(x + slot * 0.18, chart.y_of(sum + part), x + slot * 0.82, chart.y_of(sum),
                             colour);
            sum += part;
        };
        for (int k = 0; k < 4; k++) pile(stacks[i].parts[k], phase_colours[k]);
        pile(stacks[i].direct, direct_colour);
        canvas.text(middle, chart.y_of(sum) - 16, stacks[i].label, small_text, ink, Align::centre);
        const auto [first, second] = two_lines(stacks[i].name);
        canvas.text(middle, chart.bottom() + 8, first, small_text, ink, Align::centre);
        canvas.text(middle, chart.bottom() + 24, second, small_text, ink, Align::centre);
    }
}

std::vector<Stack> thesis_stacks(const Study &study)
{
    std::vector<Stack> stacks;
    for (const TimingResult &time : study.times)
        if (const auto t = thesis_times(time.token))
            stacks.push_back({time.name,
                              short_number(t->total_ms),
                              {t->integrator_ms, t->constraints_ms, t->cosserat_ms, t->collisions_ms},
                              0.0});
    return stacks;
}

std::vector<Stack> measured_stacks(const Study &study)
{
    std::vector<Stack> stacks;
    for (const TimingResult &time : study.times) {
        const PhaseTimes &s = time.step;
        stacks.push_back(
            {time.name,
             short_number(time.total_s() * 1e6),
             {s.integrator_s * 1e6, s.constraints_s * 1e6, s.cosserat_s * 1e6, s.collisions_s * 1e6},
             time.direct_s * 1e6});
    }
    return stacks;
}

double tallest(const std::vector<Stack> &stacks)
{
    double most = 0.0;
    for (const Stack &stack : stacks) most = std::max(most, height_of(stack));
    return most * 1.08;
}

void draw_cost_of_a_millisecond(Canvas &canvas, const Study &study, double left, double right, double top,
                                double bottom)
{
    double direct_s = 0.0, most = 1.0;
    for (const TimingResult &time : study.times)
        if (time.direct_s > 0.0) direct_s = time.direct_s;
    for (const TimingResult &time : study.times) most = std::max(most, time.per_ms_s() / direct_s);
    Chart chart(canvas, left, top, right, bottom, {0.0, most * 1.1, false, "direct solver = 1"});
    chart.draw_frame();
    const double slot = (right - left) / static_cast<double>(study.times.size());
    for (std::size_t i = 0; i < study.times.size(); i++) {
        const TimingResult &time = study.times[i];
        const double ratio = time.per_ms_s() / direct_s, x = left + slot * static_cast<double>(i);
        canvas.rectangle(x + slot * 0.25, chart.y_of(ratio), x + slot * 0.75, bottom,
                         time.direct_s > 0.0 ? direct_colour : baseline_colour);
        canvas.text(x + slot / 2, chart.y_of(ratio) - 16, short_number(ratio) + " x", small_text, ink,
                    Align::centre);
        canvas.text(x + slot / 2, bottom + 8, time.name, small_text, ink, Align::centre);
    }
}

} // namespace

void draw_times(const Study &study, const std::string &path)
{
    Canvas canvas(width, 940, paper);
    draw_title(canvas, "Figure 5.14: cost of one step, 256 elements in the phantom",
               {"left: the thesis, ms per step on a Core2 Quad 2.66 GHz; right: us per step on this machine, "
                "the fastest "
                "of 600 steps",
                "a step of the baseline is 1/" + std::to_string(study.preset->substeps) +
                    " ms, one of the direct solver 1 ms: the lower chart compares the same simulated time"});
    const std::vector<Stack> thesis = thesis_stacks(study), measured = measured_stacks(study);
    if (!thesis.empty()) {
        Chart left(canvas, 100, 170, 560, 510, {0.0, tallest(thesis), false, "ms per step (thesis)"});
        draw_stacks(left, thesis);
    }
    Chart right(canvas, 660, 170, width - 20, 510, {0.0, tallest(measured), false, "us per step (here)"});
    draw_stacks(right, measured);
    double x = 24;
    for (int k = 0; k < 4; k++) {
        draw_legend(canvas, x, 112, {{phase_colours[k], phase_names[k]}});
        x += 44 + Canvas::text_width(phase_names[k], small_text);
    }
    draw_legend(canvas, x, 112, {{direct_colour, "direct solver, whole tick"}});
    canvas.text(24, 580,
                "Cost of one simulated millisecond, as a multiple of the direct solver's in the same run",
                2.0, ink);
    draw_cost_of_a_millisecond(canvas, study, 100, width - 20, 630, 880);
    canvas.write_png(path);
}

} // namespace vcsim3
