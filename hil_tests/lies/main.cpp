// This is the program hil_lies. The program runs every command that communicates with a device, with a device
// that sends false messages (docs/hil.md). The program uses all lies (false messages), an evenly spread
// selection of the lies, or the one lie that a line of text names.
#include "hil_tests/lies/judge.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/version.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <map>
#include <sstream>

namespace
{

struct Options {
    std::string only, command, file = "out/hil_lies.tsv";
    std::size_t spread = 0;
    unsigned jobs = 8, ticks = 5200;
    bool lists = false;
};

struct Totals {
    std::size_t cases = 0;
    double slowest_s = 0.0, interrupt_slowest_s = 0.0;
    unsigned false_hashes = 0, failed = 0;
};

Totals totals_of(const std::vector<hil::Verdict> &verdicts)
{
    Totals totals;
    totals.cases = verdicts.size();
    for (const hil::Verdict &verdict : verdicts) {
        totals.slowest_s = std::max(totals.slowest_s, verdict.seconds);
        totals.interrupt_slowest_s = std::max(totals.interrupt_slowest_s, verdict.interrupt_s);
        totals.false_hashes += verdict.is_false;
        totals.failed += !verdict.failure.empty();
    }
    return totals;
}

// Prints each total with its name on a line of its own. The program also adds the lines with the totals to
// the end of the table. `make bars` reads these lines.
std::string text_of(const Totals &totals, char between)
{
    std::ostringstream text;
    text << std::fixed << std::setprecision(3) << "lies.cases" << between << totals.cases
         << "\nlies.slowest_s" << between << totals.slowest_s << "\nlies.interrupt_slowest_s" << between
         << totals.interrupt_slowest_s << "\nlies.false_hashes" << between << totals.false_hashes
         << "\nlies.failed" << between << totals.failed << '\n';
    return text.str();
}

void write_table(const std::string &path, const std::vector<hil::LieCase> &cases,
                 const std::vector<hil::Verdict> &verdicts)
{
    std::ostringstream text;
    text << "command\tlie\tverdict\tcode\tseconds\tinterrupt_s\ttold\tmessage\n";
    for (std::size_t i = 0; i < cases.size(); i++) {
        const hil::Verdict &verdict = verdicts[i];
        text << cases[i].command->name << '\t' << hil::line_of(cases[i].lie) << '\t'
             << (verdict.failure.empty() ? "good" : verdict.failure) << '\t' << verdict.code << '\t'
             << verdict.seconds << '\t' << verdict.interrupt_s << '\t' << verdict.has_struck << '\t'
             << verdict.message << '\n';
    }
    text << text_of(totals_of(verdicts), '\t');
    const auto folder = std::filesystem::path(path).parent_path();
    if (!folder.empty()) std::filesystem::create_directories(folder);
    crn::write_whole_file(path, text.str());
}

int print(const std::vector<hil::LieCase> &cases, const std::vector<hil::Verdict> &verdicts)
{
    struct Row {
        unsigned cases = 0, told = 0, refused = 0, failed = 0;
        double slowest_s = 0.0, interrupt_slowest_s = 0.0;
    };
    std::map<std::string, Row> rows;
    for (std::size_t i = 0; i < cases.size(); i++) {
        const hil::Verdict &verdict = verdicts[i];
        Row &row = rows[cases[i].command->name];
        row.cases++;
        row.told += verdict.has_struck;
        row.refused += verdict.code == 1;
        row.failed += !verdict.failure.empty();
        row.slowest_s = std::max(row.slowest_s, verdict.seconds);
        row.interrupt_slowest_s = std::max(row.interrupt_slowest_s, verdict.interrupt_s);
        if (!verdict.failure.empty()) {
            std::printf("failed: %s: %s: %s (%.2f s) %s\n", cases[i].command->name,
                        hil::line_of(cases[i].lie).c_str(), verdict.failure.c_str(), verdict.seconds,
                        verdict.message.c_str());
        }
    }
    std::printf("%-16s %6s %6s %8s %10s %12s %7s\n", "command", "lies", "told", "refused", "slowest s",
                "Ctrl-C s", "failed");
    for (const auto &[name, row] : rows)
        std::printf("%-16s %6u %6u %8u %10.2f %12.2f %7u\n", name.c_str(), row.cases, row.told, row.refused,
                    row.slowest_s, row.interrupt_slowest_s, row.failed);
    const Totals totals = totals_of(verdicts);
    std::fputs(text_of(totals, ' ').c_str(), stdout);
    return totals.failed == 0 ? 0 : 1;
}

int run(const Options &options)
{
    std::vector<hil::LieCase> cases = hil::cases_of(options.spread);
    if (!options.only.empty()) {
        const hil::Lie lie = hil::lie_of_line(options.only);
        cases.clear();
        for (const hil::LiedTo &command : hil::lied_to())
            if (command.is_by_hid == lie.is_group("hid.")) cases.push_back({&command, lie});
    }
    std::erase_if(cases, [&](const hil::LieCase &one) {
        return !options.command.empty() && options.command != one.command->name;
    });
    if (options.lists) {
        for (const hil::LieCase &one : cases)
            std::printf("%s: %s\n", one.command->name, hil::line_of(one.lie).c_str());
        return 0;
    }
    const std::vector<hil::Verdict> verdicts =
        hil::judge(cases, options.jobs, options.ticks, [&](std::size_t done) {
            if (done % 200 == 0) std::fprintf(stderr, "%zu of %zu lies\n", done, cases.size());
        });
    const int code = print(cases, verdicts);
    if (!options.only.empty())
        for (std::size_t i = 0; i < cases.size(); i++)
            std::printf("%s: exit code %d: %s\n", cases[i].command->name, verdicts[i].code,
                        verdicts[i].message.c_str());
    if (!options.file.empty() && options.only.empty()) write_table(options.file, cases, verdicts);
    return crn::is_interrupted() ? 1 : code;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app(
        "Has a device lie to every command that talks to one, and judges what comes of it (docs/hil.md)");
    app.add_option("--only", options.only, "One lie by its line");
    app.add_option("--command", options.command, "One command, as --list names it");
    app.add_option("--spread", options.spread, "So many lies to each command; 0: all")->capture_default_str();
    app.add_option("--jobs", options.jobs, "Commands at the same time; most of them wait")
        ->capture_default_str()
        ->check(CLI::Range(1, 64));
    app.add_option("--ticks", options.ticks, "Length of the recorded session; snapshots come every 5000")
        ->capture_default_str();
    app.add_option("--tsv", options.file, "Where the results go, one line each; empty: nowhere")
        ->capture_default_str();
    app.add_flag("--list", options.lists, "The lines of the lies");
    app.footer("Example:\n  hil_lies --only \"hash.tick at=1 value=50\" --command \"run --record\"");
    app.set_version_flag("--version", crn::version_of("hil_lies"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    crn::watch_for_interrupt();
    try {
        return run(options);
    } catch (const std::invalid_argument &error) {
        std::fprintf(stderr, "hil_lies: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hil_lies: %s\n", error.what());
        return 1;
    }
}
