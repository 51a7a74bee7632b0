// Command line of `vcsim3` (docs/thesis.md).
#include "host/base/command_values.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "tools/lab/figures/figures.hpp"
#include "tools/lab/figures/instructions.hpp"
#include "tools/lab/figures/page.hpp"
#include "tools/lab/figures/tables.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <unistd.h>

namespace
{

using namespace vcsim3;
namespace fs = std::filesystem;

constexpr const char *examples =
    "Examples:\n"
    "  vcsim3 figures --scene out/phantom.scene -o out/thesis      all figures: what `make thesis` does\n"
    "  vcsim3 run local25 --scene out/phantom.scene                one mode, one line\n"
    "  vcsim3 run direct --scene out/phantom.scene                 our solver in the same experiment\n"
    "  vcsim3 presets                                              Table 5.1 as the baseline reads it\n"
    "  vcsim3 stability --preset bentson                           smallest stable steps per millisecond\n"
    "Modes: global, penalty, local1 .. local10000; presets: see `vcsim3 presets`.\n"
    "Exit codes: 0 done, 1 failed or the figures do not show the thesis' order, 2 usage.\n";

struct Options {
    std::string scene = "out/phantom.scene", output = "out/thesis", preset = "amplatz", states, token;
    std::vector<std::string> modes;
    int elements = 256, count = 10, threads = 1;
    double element_mm = preset_element_m * 1e3, speed_mm_s = 50.0;
    bool with_times = true, with_stability = true, with_instructions = false;

    const Preset &chosen() const
    {
        return *find_preset(preset); // checked by the command line
    }
    Protocol protocol() const
    {
        Protocol protocol;
        protocol.element_count = elements;
        protocol.element_m = element_mm * 1e-3;
        protocol.speed_m_s = speed_mm_s * 1e-3;
        return protocol;
    }
};

// Reports progress on standard error. On a terminal, the program prints the completed fraction of the work;
// in a file, it prints only the beginning of each part.
bool report(const std::string &what, double share)
{
    static const bool is_watched = isatty(2) != 0;
    static int shown_permille = -1;
    static std::string begun;
    if (share >= 0.0 && begun != what) {
        begun = what;
        if (!is_watched) std::fprintf(stderr, "%s ...\n", what.c_str());
    }
    if (share < 0.0) {
        std::fprintf(stderr, "%s%s\n", is_watched ? "\r\x1b[K" : "", what.c_str());
    } else if (is_watched && static_cast<int>(share * 1000) != shown_permille) {
        shown_permille = static_cast<int>(share * 1000);
        std::fprintf(stderr, "\r%s: %.1f %%\x1b[K%s", what.c_str(), share * 100,
                     share >= 1.0 ? "\r\x1b[K" : "");
    }
    return !crn::is_interrupted();
}

void write_file(const fs::path &path, const std::string &text)
{
    crn::write_whole_file(path.string(), text);
}

std::vector<Mode> modes_of(const Options &options)
{
    if (options.modes.empty()) return thesis_modes();
    std::vector<Mode> modes;
    for (const std::string &token : options.modes) {
        modes.emplace_back();
        parse_mode(token, modes.back()); // checked by the command line
    }
    return modes;
}

int command_figures(const Options &options)
{
    const Vessel vessel(options.scene);
    StudySettings settings;
    settings.preset = &options.chosen();
    settings.protocol = options.protocol();
    settings.modes = modes_of(options);
    settings.with_times = options.with_times;
    settings.with_stability = options.with_stability;
    settings.threads = options.threads;
    crn::check_output_folder({"--output", options.output});
    const fs::path folder = options.output, states = folder / "states";
    fs::create_directories(states);
    Study study = make_study(settings, vessel, report);
    for (const CompressionResult &run : study.runs)
        write_file(states / (run.token + ".state"), {run.state.begin(), run.state.end()});
    if (options.with_instructions)
        count_instructions(study, states.string(),
                           {"--scene", options.scene, "--preset", options.preset, "--elements",
                            std::to_string(options.elements), "--element-mm",
                            crn::number_text(options.element_mm, 12)},
                           report);
    write_file(folder / "figure_5_11.tsv", to_tsv(compression_table(study)));
    write_file(folder / "figure_5_12.tsv", to_tsv(shape_table(study)));
    write_file(folder / "presets.tsv", to_tsv(preset_table()));
    write_file(folder / "thesis.json", to_json(study));
    draw_compression(study, (folder / "figure_5_11.png").string());
    draw_shapes(study, vessel, (folder / "figure_5_12.png").string());
    draw_convergence(study, (folder / "figure_5_13.png").string());
    if (options.with_times) {
        write_file(folder / "figure_5_14.tsv", to_tsv(times_table(study)));
        draw_times(study, (folder / "figure_5_14.png").string());
    }
    if (options.with_stability) write_file(folder / "stability.tsv", to_tsv(stability_table(study)));
    write_file(folder / "index.html", page_html(study, vessel.name()));
    std::fputs(to_tsv(compression_table(study)).c_str(), stdout);
    std::fputs(to_tsv(times_table(study)).c_str(), stdout);
    std::printf("written to %s\n", (folder / "index.html").c_str());
    const std::vector<std::string> faults = order_faults(study);
    for (const std::string &fault : faults) crn::say(stderr, "vcsim3: %s\n", fault.c_str());
    return faults.empty() ? 0 : 1;
}

int command_run(const Options &options)
{
    const Vessel vessel(options.scene);
    const Watch watch = [&](double share) { return report(options.token, share); };
    Study study;
    study.preset = &options.chosen();
    study.protocol = options.protocol();
    Mode mode;
    study.runs.push_back(parse_mode(options.token, mode)
                             ? compress_baseline(options.chosen(), mode, vessel, study.protocol, watch)
                             : compress_direct(options.chosen(), vessel, study.protocol, watch));
    std::fputs(to_tsv(compression_table(study)).c_str(), stdout);
    return study.runs.front().is_sound ? 0 : 1;
}

int command_stability(const Options &options)
{
    std::printf("preset\tsteps_per_ms\tsmallest_penalty\tsmallest_10_local\tsmallest_1_global\n");
    for (const Preset &preset : presets()) {
        if (!options.preset.empty() && options.preset != preset.token) continue;
        const Watch watch = [&](double share) { return report(preset.token, share); };
        const int penalty = smallest_stable_substeps(preset, {Mode::Kind::penalty, 1}, watch);
        const int local = smallest_stable_substeps(preset, {Mode::Kind::local, 10}, watch);
        const int global = smallest_stable_substeps(preset, {Mode::Kind::global, 1}, watch);
        std::printf("%s\t%d\t%d\t%d\t%d\n", preset.token, preset.substeps, penalty, local, global);
        std::fflush(stdout);
    }
    return 0;
}

int command_steps(const Options &options)
{
    const Vessel vessel(options.scene);
    const fs::path path = fs::path(options.states) / (options.token + ".state");
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(path.string() + ": cannot be read; `vcsim3 figures` writes it");
    CompressionResult run;
    run.name = run.token = options.token;
    run.state.assign(std::istreambuf_iterator<char>(file), {});
    run_measured_steps(run, options.count, options.chosen(), vessel, options.protocol());
    return 0;
}

std::string check_token(const std::string &token)
{
    Mode mode;
    return token == "direct" || parse_mode(token, mode)
               ? ""
               : "'" + token + "' is no mode: global, penalty, local1 .. local10000 or direct";
}

std::string check_mode(const std::string &token)
{
    Mode mode;
    return parse_mode(token, mode) ? "" : "'" + token + "' is no mode: global, penalty, local1 .. local10000";
}

std::string check_preset(const std::string &token)
{
    return find_preset(token) ? "" : "'" + token + "' is no preset: `vcsim3 presets` lists them";
}

void add_experiment(CLI::App &command, Options &options)
{
    command.add_option("--scene", options.scene, "the vessel, baked")->capture_default_str();
    command.add_option("--preset", options.preset, "row of Table 5.1")
        ->check(CLI::Validator(check_preset, "PRESET"))
        ->capture_default_str();
    command.add_option("--elements", options.elements, "of the rod; all are in the vessel at the end")
        ->check(CLI::Range(16, 370))
        ->capture_default_str();
    command.add_option("--element-mm", options.element_mm, "length of each")
        ->check(CLI::Range(1.0, 8.0))
        ->capture_default_str();
    command.add_option("--speed-mm-s", options.speed_mm_s, "of the hand")
        ->check(CLI::Range(5.0, 200.0))
        ->capture_default_str();
}

void add_token(CLI::App &command, Options &options)
{
    command.add_option("MODE", options.token, "a mode of the baseline, or direct")
        ->required()
        ->check(CLI::Validator(check_token, "MODE"));
}

void add_figures(CLI::App &command, Options &options)
{
    add_experiment(command, options);
    command.add_option("-o,--output", options.output, "folder for pictures, tables and index.html")
        ->capture_default_str();
    command.add_option("--modes", options.modes, "instead of the thesis' nine")
        ->check(CLI::Validator(check_mode, "MODE"));
    command.add_option("--threads", options.threads, "runs at the same time; changes no result")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command.add_flag("!--no-times", options.with_times, "leave out Figure 5.14");
    command.add_flag("!--no-stability", options.with_stability,
                     "leave out the presets' smallest stable steps");
    command.add_flag("--instructions", options.with_instructions, "count instructions too (needs valgrind)");
}

} // namespace

int main(int argc, char **argv)
{
    CLI::App app{
        "vcsim3: the thesis' own rod (CoRdE) as a baseline in double precision, beside our direct solver"};
    app.footer(examples);
    app.require_subcommand(1);
    Options options;
    CLI::App *figures =
        app.add_subcommand("figures", "make Figures 5.11 to 5.14 as tables, pictures and a page");
    CLI::App *run = app.add_subcommand("run", "one compression run, as a line of the table");
    CLI::App *presets_command = app.add_subcommand("presets", "list the presets, tab separated");
    CLI::App *stability = app.add_subcommand("stability", "measure the presets' smallest stable steps");
    CLI::App *steps =
        app.add_subcommand("steps", "repeat the last step of a run of `figures`, for callgrind");
    add_figures(*figures, options);
    add_token(*run, options);
    add_experiment(*run, options);
    std::string only_preset;
    stability->add_option("--preset", only_preset, "only this one")
        ->check(CLI::Validator(check_preset, "PRESET"));
    add_token(*steps, options);
    add_experiment(*steps, options);
    steps->add_option("--states", options.states, "folder with the states that `figures` wrote")->required();
    steps->add_option("--count", options.count, "steps")->check(CLI::Range(1, 100000))->capture_default_str();
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("vcsim3"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    crn::watch_for_interrupt();
    try {
        if (*figures) return command_figures(options);
        if (*run) return command_run(options);
        if (*steps) return command_steps(options);
        if (*stability) {
            options.preset = only_preset;
            return command_stability(options);
        }
        if (*presets_command) std::fputs(to_tsv(preset_table()).c_str(), stdout);
        return 0;
    } catch (const Interrupted &) {
        std::fprintf(stderr, "\nvcsim3: interrupted; what was being made is not written\n");
    } catch (const std::exception &error) {
        crn::say(stderr, "vcsim3: %s\n", error.what());
    }
    return 1;
}
