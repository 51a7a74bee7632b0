// This is the program hil. The program runs the test cases and the aorta session at every test level,
// measures the processor time of the session, and prints one table at the end.
#include "hil_tests/cases/budget.hpp"
#include "hil_tests/cases/cases.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/cases/remote_bench.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/version.hpp"
#include "host/link/sim_transport.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <string>
#include <sys/wait.h>
#include <vector>

namespace
{

using Clock = std::chrono::steady_clock;

struct Options {
    std::string level, case_name, debugger, bench, serial, counts, overruns;
    std::vector<std::string> also;
    bool lists = false, only_aorta = false, without_aorta = false;
    std::uint32_t ticks_max = UINT32_MAX, elements = 256;
    hil::CaseOptions cases{.pause_s = 10.0, .ticks = 2000, .free_ms = 4000};
    hil::AortaFiles files;
};

struct Row {
    std::string level, name, failure;
    hil::Report report;
    double seconds;
};

// One line per level.
struct Sum {
    std::string level, hash;
    int cases = 0, passed = 0;
    double seconds = 0.0, worst_instructions = 0.0;
};

class Table
{
  public:
    // Runs the function `work`; an exception from `work` counts as a failed test case.
    template <class Work> void run(const std::string &level, const std::string &name, Work work)
    {
        if (crn::is_interrupted()) return;
        std::fprintf(stderr, "%-4s %s ...\n", level.c_str(), name.c_str());
        hil::Report report;
        std::string failure;
        const Clock::time_point begin = Clock::now();
        try {
            work(report);
        } catch (const std::exception &error) {
            failure = error.what();
        }
        const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        if (!failure.empty() && report.passed == report.cases) report.passed = 0;
        rows_.push_back({level, name, failure, report, seconds});
        if (!failure.empty()) std::fprintf(stderr, "     FAILED: %s\n", failure.c_str());
    }

    // Prints the table of results and returns the number of failures.
    int print() const
    {
        int failed = 0;
        std::printf("\n%-5s %-6s %7s  %s\n", "level", "result", "s", "case: figures");
        for (const Row &row : rows_) {
            failed += !row.failure.empty();
            std::printf("%-5s %-6s %7.2f  %s: %s%s%s\n", row.level.c_str(),
                        row.failure.empty() ? "ok" : "FAILED", row.seconds, row.name.c_str(),
                        row.failure.c_str(), row.failure.empty() || row.report.text.empty() ? "" : "; ",
                        row.report.text.c_str());
            for (const std::string &inner : row.report.rows) std::printf("      %s\n", inner.c_str());
        }
        print_sums();
        std::printf("%zu passed, %d failed%s\n", rows_.size() - static_cast<std::size_t>(failed), failed,
                    crn::is_interrupted() ? ", interrupted" : "");
        return failed;
    }

  private:
    void print_sums() const
    {
        std::vector<Sum> sums;
        for (const Row &row : rows_) {
            const auto there = std::find_if(sums.begin(), sums.end(),
                                            [&](const Sum &sum) { return sum.level == row.level; });
            Sum &sum = there != sums.end() ? *there : sums.emplace_back(Sum{.level = row.level, .hash = {}});
            sum.cases += row.report.cases;
            sum.passed += row.report.passed;
            sum.seconds += row.seconds;
            if (!row.report.hash.empty() && sum.hash.empty()) sum.hash = row.report.hash;
            sum.worst_instructions = std::max(sum.worst_instructions, row.report.worst_instructions);
        }
        std::printf("\n%-5s %6s %6s %8s  %-16s  %s\n", "level", "cases", "passed", "s", "aorta session",
                    "worst instructions of a tick");
        for (const Sum &sum : sums) {
            std::printf("%-5s %6d %6d %8.2f  %-16s  %s\n", sum.level.c_str(), sum.cases, sum.passed,
                        sum.seconds, sum.hash.empty() ? "-" : sum.hash.c_str(),
                        sum.worst_instructions > 0 ? hil::text("%.0f", sum.worst_instructions).c_str() : "-");
        }
    }

    std::vector<Row> rows_;
};

bool is_wanted(const std::string &wanted, const char *name)
{
    return wanted.empty() || wanted == name;
}

std::string hex(std::uint64_t hash)
{
    return hil::text("%016llx", static_cast<unsigned long long>(hash));
}

void check_hash(const hil::AortaRun &expected, const hil::AortaRun &run, hil::Report &report)
{
    report.hash = hex(run.hash);
    report.add(hil::text("%u ticks, hash %s, %.1f times real time", unsigned{run.ticks},
                         hex(run.hash).c_str(), run.ticks * 1e-3 / run.seconds));
    hil::check(run.hash == expected.hash && run.ticks == expected.ticks,
               "hash %s after %u ticks, host-only %s after %u", hex(run.hash).c_str(), unsigned{run.ticks},
               hex(expected.hash).c_str(), unsigned{expected.ticks});
}

// The limits for processor instructions per tick are 500,000 for the median, 600,000 for 99.9 % of the ticks,
// and 900,000 for the maximum.
void judge_instructions(const hil::AortaRun &run, hil::Report &report)
{
    const double median = hil::quantile_of(run.tick_instructions, 0.5),
                 rare = hil::quantile_of(run.tick_instructions, 0.999),
                 most = hil::quantile_of(run.tick_instructions, 1.0);
    report.worst_instructions = most;
    std::size_t twice = 0;
    for (std::uint16_t solves : run.tick_solves) twice += solves > 1;
    report.add(hil::text("%u elements: median %.0f, p99.9 %.0f, max %.0f instructions per tick, %zu of %zu "
                         "ticks with two solves",
                         unsigned{run.elements}, median, rare, most, twice, run.tick_solves.size()));
    hil::check(median <= 500e3 && rare <= 600e3 && most <= 900e3,
               "%s; allowed: median 500,000, p99.9 600,000, max 900,000", report.text.c_str());
}

// Writes one line for each tick of the counted session. The line of a tick contains the number of
// instructions and the number of solver runs, so that the user can find expensive ticks.
void write_counts(const hil::AortaRun &run, crn::PendingFile &file)
{
    for (std::size_t i = 0; i < run.tick_instructions.size(); i++)
        file.write(hil::text("%zu\t%.0f\t%u\n", i, run.tick_instructions[i], unsigned{run.tick_solves[i]}));
    file.commit();
}

// Writes one line for each millisecond of the session in FREE_RUN: its number, and the processor time in
// microseconds that the device needed.
void write_overruns(const hil::Overruns &run, crn::PendingFile &file)
{
    for (std::size_t i = 0; i < run.edge_us.size(); i++)
        file.write(hil::text("%zu\t%.2f\n", i, run.edge_us[i]));
    file.commit();
}

// No edge may be late.
void judge_overruns(const hil::Overruns &run, hil::Report &report)
{
    report.add(hil::text("%zu of %zu ticks over 1 ms, longest %.0f us", run.count(), run.edge_us.size(),
                         run.worst_us()));
    hil::check(run.count() == 0, "%s; allowed: none", report.text.c_str());
}

// Runs only the counted sessions, which measure the cost of a tick on the emulated processor. The counted
// number of instructions is equal on every machine.
void count_only(const Options &options, Table &table)
{
    hil::AortaFiles files = options.files;
    if (options.elements > 0) files.element_shaft_um = hil::shaft_of(options.files, options.elements);
    if (!options.counts.empty()) {
        table.run("L1", "m7_instructions_per_tick", [&](hil::Report &report) {
            crn::PendingFile file(options.counts);
            crn::SimTransport pipe;
            const hil::AortaRun alone = hil::run_aorta(pipe, files, options.ticks_max);
            const hil::AortaRun counted = hil::count_aorta(files, options.ticks_max);
            check_hash(alone, counted, report);
            write_counts(counted, file);
            judge_instructions(counted, report);
        });
    }
    if (!options.overruns.empty()) {
        table.run("L1", "tick_overruns_at_500_mips", [&](hil::Report &report) {
            crn::PendingFile file(options.overruns);
            const hil::Overruns run = hil::overruns_of_aorta(files, 1, options.ticks_max);
            write_overruns(run, file);
            judge_overruns(run, report);
        });
    }
}

void run_aorta(const Options &options, Table &table)
{
    hil::AortaRun expected, counted;
    table.run("host", "aorta_session", [&](hil::Report &report) {
        crn::SimTransport pipe;
        expected = hil::run_aorta(pipe, options.files, options.ticks_max);
        check_hash(expected, expected, report);
    });
    if (options.ticks_max == UINT32_MAX) setenv("AORTA_HASH", hex(expected.hash).c_str(), 1);
    if (is_wanted(options.level, "L0")) {
        table.run("L0", "aorta_session", [&](hil::Report &report) {
            hil::SimBench bench({});
            check_hash(expected, hil::run_aorta(bench.pipe(), options.files, options.ticks_max), report);
        });
    }
    if (options.level == "rig") {
        table.run("rig", "aorta_session", [&](hil::Report &report) {
            const auto bench = hil::MetalLevel(options.serial).make({});
            check_hash(expected, hil::run_aorta(bench->pipe(), options.files, options.ticks_max), report);
        });
    }
    if (!is_wanted(options.level, "L1")) return;
    hil::AortaFiles budget = options.files;
    table.run("L1", "aorta_session", [&](hil::Report &report) {
        budget.element_shaft_um = hil::shaft_of(options.files, 256);
        crn::Emulator emulator({.icount_shift = 0});
        crn::EmulatedTransport pipe(emulator);
        check_hash(expected, hil::run_aorta(pipe, options.files, options.ticks_max), report);
    });
    // A run takes minutes, because the emulated processor counts its time in instructions. Other programs on
    // the machine do not change the counted instructions, so several runs may share one machine.
    std::array<std::future<hil::Overruns>, 2> overruns;
    for (std::size_t shift : {0, 1})
        overruns[shift] = std::async(std::launch::async, hil::overruns_of_aorta, budget,
                                     static_cast<int>(shift), options.ticks_max);
    table.run("L1", "aorta_session_of_256_elements", [&](hil::Report &report) {
        crn::SimTransport pipe;
        const hil::AortaRun alone = hil::run_aorta(pipe, budget, options.ticks_max);
        counted = hil::count_aorta(budget, options.ticks_max);
        check_hash(alone, counted, report);
    });
    table.run("L1", "m7_instructions_per_tick",
              [&](hil::Report &report) { judge_instructions(counted, report); });
    for (std::size_t shift : {0, 1}) {
        const int mips = 1000 >> shift;
        table.run("L1", "tick_overruns_at_" + std::to_string(mips) + "_mips",
                  [&](hil::Report &report) { judge_overruns(overruns[shift].get(), report); });
    }
}

// Shows a command's output to the user while the command runs. The function counts the test cases in the
// output, and collects the measured figures, which are the lines that begin with "#-" (such as "#- 3,000
// round trips/s").
void follow(const std::string &command, hil::Report &report)
{
    std::FILE *pipe = popen((command + " 2>&1").c_str(), "r");
    hil::check(pipe != nullptr, "'%s' cannot be started", command.c_str());
    char buffer[1024];
    report.cases = report.passed = 0;
    while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) {
        std::fputs(buffer, stderr);
        std::string line(buffer);
        line.erase(line.find_last_not_of("\r\n") + 1);
        // A line of results is either in TAP format, or a row of a table such as this program prints.
        const bool is_row = line.size() > 12 && line[0] == 'L' && line[2] == ' ';
        const bool is_ok = line.starts_with("ok ") || (is_row && line.compare(6, 6, "ok    ") == 0);
        const bool is_not_ok = line.starts_with("not ok ") || (is_row && line.compare(6, 6, "FAILED") == 0);
        report.cases += is_ok || is_not_ok;
        report.passed += is_ok;
        if (is_row && line.find(": ") != std::string::npos) report.rows.push_back(line);
        if (line.starts_with("# link.")) report.add(line.substr(2));
        if (line.starts_with("#- ")) report.add(line.substr(3));
        if (line.starts_with("# final hash ")) report.hash = line.substr(line.find_last_of(' ') + 1);
    }
    const int status = pclose(pipe);
    if (report.cases == 0) report.cases = report.passed = 1;
    hil::check(status == 0, "'%s' ended with %d", command.c_str(),
               WIFEXITED(status) ? WEXITSTATUS(status) : status);
}

void run_commands(const Options &options, Table &table)
{
    for (const std::string &words : options.also) {
        const std::size_t first = words.find(' '), second = words.find(' ', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string level = words.substr(0, first);
        if (!is_wanted(options.level, level.c_str())) continue;
        table.run(level, words.substr(first + 1, second - first - 1),
                  [&](hil::Report &report) { follow(words.substr(second + 1), report); });
    }
}

void parse(CLI::App &app, Options &options)
{
    app.add_option("--level", options.level,
                   "Only this level; the cases of L2 and L3 need a --bench, rig is one on USB here")
        ->check(CLI::IsMember({"L0", "L1", "L2", "L3", "rig"}));
    app.add_option("--bench", options.bench, "L2, L3: the bench of a hil_rig, whose device is on USB here");
    app.add_option("--serial", options.serial, "L2, L3, rig: of the device, with several");
    app.add_option("--case", options.case_name, "Only this case");
    app.add_option("--gdb", options.debugger, "Socket on which the emulated device waits for gdb");
    app.add_flag("--list", options.lists, "Names of the cases");
    app.add_flag("--aorta", options.only_aorta, "Only the aorta session and its costs");
    app.add_flag("--no-aorta", options.without_aorta,
                 "Without the aorta session, which needs out/aorta.scene");
    app.add_option("--counts", options.counts,
                   "Only the aorta session at L1, and what each of its ticks costs into this file");
    app.add_option("--overruns", options.overruns,
                   "Only the aorta session in FREE_RUN at 500 instructions per us, and how long each edge "
                   "takes into this file");
    app.add_option("--elements", options.elements,
                   "With --counts or --overruns: of the J wire; 0: as it ships")
        ->capture_default_str()
        ->check(CLI::IsMember({0, 128, 256}));
    app.add_option("--aorta-ticks", options.ticks_max, "Only so many ticks of it");
    app.add_option("--scene", options.files.scene, "Scene of the aorta session")->capture_default_str();
    app.add_option("--pause", options.cases.pause_s, "Seconds that a pause lasts")->capture_default_str();
    app.add_option("--ticks", options.cases.ticks, "Ticks of sessions in LOCKSTEP")->capture_default_str();
    app.add_option("--free-run", options.cases.free_ms, "Milliseconds of sessions in FREE_RUN")
        ->capture_default_str();
    app.add_option("--spread", options.cases.spread, "Of the rig's faults only every so many")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    app.add_option("--also", options.also,
                   "\"LEVEL NAME COMMAND\": one more row, passed when the command ends with 0")
        ->expected(1)
        ->take_all();
    app.footer("Examples:\n  hil --level L1 --case a_pause_in_lockstep_changes_nothing\n  hil --aorta "
               "--aorta-ticks 2000");
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("Cases for a device with its rig, at every level of emulation (docs/hil.md)");
    parse(app, options);
    app.set_version_flag("--version", crn::version_of("hil"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    if (options.lists) {
        for (const hil::Case &one : hil::all_cases()) std::printf("%s\n", one.name);
        return 0;
    }
    crn::watch_for_interrupt();
    Table table;
    if (!options.counts.empty() || !options.overruns.empty()) {
        count_only(options, table);
        return table.print() == 0 && !crn::is_interrupted() ? 0 : 1;
    }
    hil::SimLevel l0;
    hil::EmulatedLevel l1(0, options.debugger);
    bool is_known = options.case_name.empty();
    hil::RemoteLevel remote(options.level, options.bench, options.serial);
    std::vector<hil::Level *> levels = {&l0, &l1};
    hil::MetalLevel metal(options.serial);
    if (!options.bench.empty()) levels = {&remote};
    if (options.level == "rig") levels = {&metal};
    for (hil::Level *level : levels) {
        for (const hil::Case &one : hil::all_cases()) {
            if (!is_wanted(options.case_name, one.name)) continue;
            is_known = true;
            if (level == &metal && one.needs_plant) continue;
            if (options.only_aorta || !is_wanted(options.level, level->name())) continue;
            table.run(level->name(), one.name,
                      [&](hil::Report &report) { one.run(*level, options.cases, report); });
        }
    }
    if (!is_known) {
        std::fprintf(stderr, "hil: no case '%s'; --list names them\n", options.case_name.c_str());
        return 2;
    }
    if (options.case_name.empty() && !options.without_aorta) run_aorta(options, table);
    if (options.case_name.empty() && !options.only_aorta) run_commands(options, table);
    return table.print() == 0 && !crn::is_interrupted() ? 0 : 1;
}
