// This is the program hil_rt1062. It runs the board's image on the emulated chip: alone, with what its
// console says; with the test cases of hil_tests/cases; or with the aorta session, whose hash must be the
// host's.
#include "hil_tests/cases/aorta_session.hpp"
#include "hil_tests/cases/cases.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/rt1062/bench/board_bench.hpp"
#include "hil_tests/rt1062/bench/serve.hpp"
#include "host/base/version.hpp"
#include "host/link/sim_transport.hpp"
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace
{

using Clock = std::chrono::steady_clock;

struct Options {
    std::string image = "build/firmware/cournand-imxrt1062.elf", case_name, figures;
    hil::AortaFiles files;
    std::uint32_t ticks_max = UINT32_MAX;
    double boot_ms = 1000;
    bool lists = false, boots = false, runs_aorta = false, counts = false;
    std::vector<std::string> command;
};

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

int boot(const Options &options)
{
    const Clock::time_point begin = Clock::now();
    hil::BoardBench bench({}, options.image);
    rt_chip *chip = rt_engine_chip(&bench.engine());
    const double enumerated_s = seconds_since(begin);
    bench.advance(static_cast<std::uint32_t>(options.boot_ms));
    std::printf("%.*s", static_cast<int>(chip->uart.text_bytes), chip->uart.text);
    std::printf("enumerated after %.2f s of wall time; %.1f ms of the chip's time and %.1f million "
                "instructions run\n",
                enumerated_s, static_cast<double>(chip->now) / (RT_INSTANTS_PER_us * 1e3),
                static_cast<double>(rt_engine_instructions(&bench.engine())) * 1e-6);
    bench.check_trouble();
    return rt_report(chip, stdout, rt_engine_place, &bench.engine()) == 0 ? 0 : 1;
}

// Prints a line of TAP.
void print_result(int number, const std::string &name, const std::string &failure, double seconds)
{
    std::printf("%s %d - %s (%.1f s)\n", failure.empty() ? "ok" : "not ok", number, name.c_str(), seconds);
    if (!failure.empty()) std::printf("# %s\n", failure.c_str());
    std::fflush(stdout);
}

// Cycles of a tick with its USB traffic: instructions, and the waiting for lines of the PSRAM.
void print_counts(const hil::AortaRun &run, const std::vector<double> &misses)
{
    std::vector<double> of_tick;
    for (std::size_t i = 0; i + 1 < misses.size(); i += 2) of_tick.push_back(misses[i + 1] - misses[i]);
    std::printf(
        "#- cycles a tick: median %.0f, p99.9 %.0f, most %.0f; misses a tick: median %.0f, p99.9 %.0f, "
        "most %.0f\n",
        hil::quantile_of(run.tick_instructions, 0.5), hil::quantile_of(run.tick_instructions, 0.999),
        hil::quantile_of(run.tick_instructions, 1.0), hil::quantile_of(of_tick, 0.5),
        hil::quantile_of(of_tick, 0.999), hil::quantile_of(of_tick, 1.0));
}

// The figures that tools/bars compares with their limits.
void write_figures(const std::string &path, bool is_equal, double enumerated_s)
{
    if (path.empty()) return;
    std::ofstream file(path);
    file << "hil.rt1062_hash_differs\t" << (is_equal ? 0 : 1) << '\n'
         << hil::text("hil.rt1062_enumerated_s\t%.2f\n", enumerated_s);
    if (!file.flush()) throw std::runtime_error("cannot write " + path + ": check folder and disk");
}

int run_aorta(const Options &options)
{
    std::printf("1..1\n");
    crn::SimTransport host;
    const hil::AortaRun expected = hil::run_aorta(host, options.files, options.ticks_max);
    const Clock::time_point begin = Clock::now();
    hil::BoardLevel level(options.image);
    const auto bench = level.make({});
    const double enumerated_s = seconds_since(begin);
    auto &board = dynamic_cast<hil::BoardBench &>(*bench);
    std::vector<double> misses; // at the begin and at the end of every tick
    const auto busy_cycles = [&] {
        misses.push_back(static_cast<double>(rt_engine_cache_misses(&board.engine())));
        return rt_engine_busy_cycles(&board.engine());
    };
    const hil::AortaRun run = hil::run_aorta(bench->pipe(), options.files, options.ticks_max,
                                             options.counts ? busy_cycles : std::function<double()>{});
    const rt_chip *chip = rt_engine_chip(&board.engine());
    const bool is_equal = run.hash == expected.hash && run.ticks == expected.ticks;
    const std::string figures = hil::text(
        "aorta_session: %u ticks, hash %016llx, host-only %016llx, %.1f s of the chip's time", run.ticks,
        static_cast<unsigned long long>(run.hash), static_cast<unsigned long long>(expected.hash),
        static_cast<double>(chip->now) / RT_INSTANTS_PER_s);
    print_result(1, figures, is_equal ? "" : "the hashes differ", seconds_since(begin));
    if (options.counts) print_counts(run, misses);
    board.check_report();
    std::printf("# final hash %016llx\n", static_cast<unsigned long long>(run.hash));
    write_figures(options.figures, is_equal, enumerated_s);
    return is_equal ? 0 : 1;
}

// Cases that a rig of metal with this board cannot pass, and why.
struct Unfit {
    const char *name, *why;
};
constexpr Unfit unfit_cases[] = {
    {"a_free_run_closes_the_loop_as_at_level_0", "the board's force sensor has coarser counts than level 0"},
};

const char *why_unfit(const char *name)
{
    for (const Unfit &unfit : unfit_cases)
        if (std::string(unfit.name) == name) return unfit.why;
    return nullptr;
}

int run_cases(const Options &options)
{
    hil::BoardLevel level(options.image);
    int failed = 0, count = 0;
    for (const hil::Case &one : hil::all_cases()) {
        if (!options.case_name.empty() && options.case_name != one.name) continue;
        if (options.case_name.empty() && why_unfit(one.name) != nullptr) {
            std::printf("# left out: %s: %s\n", one.name, why_unfit(one.name));
            continue;
        }
        hil::Report report;
        std::string failure;
        const Clock::time_point begin = Clock::now();
        try {
            one.run(level, {.pause_s = 0.2, .spread = 4}, report);
        } catch (const std::exception &error) {
            failure = error.what();
        }
        count++;
        failed += !failure.empty();
        print_result(count, one.name + (": " + report.text), failure, seconds_since(begin));
    }
    if (count > 0) std::printf("1..%d\n", count);
    if (count > 0) return failed == 0 ? 0 : 1;
    std::fprintf(stderr, "hil_rt1062: no case '%s'; --list names them\n", options.case_name.c_str());
    return 2;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("The board's image on the emulated i.MX RT1062 (docs/rt1062.md)");
    app.add_option("--image", options.image, "Image of the board")->capture_default_str();
    app.add_option("--case", options.case_name, "Only this case");
    app.add_flag("--list", options.lists, "Names of the cases");
    app.add_flag("--boot", options.boots,
                 "Only boot, enumerate, and print the console and the model's report");
    app.add_option("--boot-ms", options.boot_ms, "With --boot: milliseconds after the enumeration")
        ->capture_default_str();
    app.add_flag("--aorta", options.runs_aorta, "Only the aorta session, to the hash of the host alone");
    app.add_flag("--counts", options.counts,
                 "With --aorta: one tick a request, and the cycles and cache misses of a tick");
    app.add_option("--aorta-ticks", options.ticks_max, "Only so many ticks of it");
    app.add_option("--scene", options.files.scene, "Scene of the aorta session")->capture_default_str();
    app.add_option("--figures", options.figures, "With --aorta: a file for hash and time of enumeration");
    app.add_option(
        "command", options.command,
        "A command that runs beside the board in real time; {mailbox} becomes the place of its USB tokens");
    app.footer("Examples:\n  hil_rt1062 --boot\n  hil_rt1062 --aorta --aorta-ticks 2000\n  hil_rt1062 -- "
               "bridge --mailbox {mailbox} ...");
    app.set_version_flag("--version", crn::version_of("hil_rt1062"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        if (options.lists) {
            for (const hil::Case &one : hil::all_cases()) std::printf("%s\n", one.name);
            return 0;
        }
        if (!options.command.empty()) return hil::serve_board(options.image, options.command);
        return options.boots ? boot(options) : options.runs_aorta ? run_aorta(options) : run_cases(options);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hil_rt1062: %s\n", error.what());
        return 1;
    }
}
