// Reads the command line of `literature`, which repeats published measurements with the simulator
// (docs/literature.md).
#include "host/base/command_values.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "tools/lab/literature/pages.hpp"
#include "tools/lab/validate/docs_page.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

namespace
{

using namespace crn::literature;

constexpr const char *examples =
    "Examples:\n"
    "  literature                        every table; writes out/literature.tsv and out/literature/*.svg\n"
    "  literature --only ffr             the tables with that text in their name\n"
    "  literature --list                 the tables, and what becomes of each\n"
    "  literature --docs docs/literature.md   also renew the page between its two marks\n"
    "  literature --expect               also renew the list of verdicts, after a look at the figures\n"
    "Exit codes: 0 no table is worse than the tracked list says, 1 a table that passed fails, 2 usage.\n";

struct Options {
    std::string only, folder = "out", docs, tables = "tools/lab/literature/tables",
                      expected = "tools/lab/literature/expected.tsv";
    unsigned jobs = std::max(1u, std::thread::hardware_concurrency());
    bool list = false, expect = false;
};

// Pairs tables with experiments. Throws std::runtime_error if one lacks the other.
std::vector<std::pair<const Table *, Experiment>> pairs(const std::vector<Table> &tables)
{
    std::vector<Experiment> experiments = all_experiments();
    std::vector<std::pair<const Table *, Experiment>> all;
    for (const Table &table : tables) {
        if (table.kind == Kind::not_reproducible) continue;
        const auto found = std::find_if(experiments.begin(), experiments.end(),
                                        [&](const Experiment &one) { return one.table == table.name; });
        if (found == experiments.end())
            throw std::runtime_error(table.name +
                                     ".toml: no experiment has this name (tools/lab/literature)");
        all.emplace_back(&table, std::move(*found));
        experiments.erase(found);
    }
    if (!experiments.empty())
        throw std::runtime_error("the experiment '" + experiments.front().table + "' has no published table");
    return all;
}

Measured measure(const Table &table, const Experiment &experiment)
{
    Measured one;
    one.table = &table;
    const auto began = std::chrono::steady_clock::now();
    try {
        one.figures = experiment.run();
        check_complete(table, one.figures);
    } catch (const std::exception &error) {
        one.failure = error.what();
    }
    one.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return one;
}

// Each thread takes one table after the other. Experiments share no data, so the figures do not depend on the
// number of threads. After Ctrl-C, no further experiment begins, and no file is written.
std::vector<Measured> measure_all(const std::vector<std::pair<const Table *, Experiment>> &work,
                                  const Options &options)
{
    std::vector<Measured> results(work.size());
    std::atomic<std::size_t> next{0}, done{0};
    std::mutex printing;
    auto run = [&] {
        for (std::size_t i = next++; i < work.size() && !crn::is_interrupted(); i = next++) {
            results[i] = measure(*work[i].first, work[i].second);
            std::lock_guard<std::mutex> lock(printing);
            std::fprintf(stderr, "%2zu/%zu  %-7s %-24s %5.1f s\n", ++done, work.size(),
                         results[i].verdict().c_str(), work[i].first->name.c_str(), results[i].seconds);
        }
    };
    std::vector<std::thread> threads;
    for (unsigned k = 0; k < options.jobs; k++) threads.emplace_back(run);
    for (std::thread &thread : threads) thread.join();
    return results;
}

void write_results(const std::vector<Measured> &all, const std::vector<Table> &tables, const Options &options)
{
    const std::string pictures = options.folder + "/literature";
    std::filesystem::create_directories(pictures);
    for (const Measured &one : all) {
        crn::write_whole_file(pictures + "/" + one.table->name + ".svg", picture(one));
        for (std::size_t k = 0; k < one.figures.curves.size(); k++)
            crn::write_whole_file(pictures + "/" + one.table->name + "_" + std::to_string(k + 1) + ".svg",
                                  crn::validate::svg(one.figures.curves[k]));
    }
    crn::write_whole_file(options.folder + "/literature.tsv", tsv(all, options.only.empty()));
    if (!options.docs.empty())
        crn::validate::write_between_marks(options.docs, "literature", markdown(all, tables));
}

void print_failures(const std::vector<Measured> &all)
{
    for (const Measured &one : all) {
        if (!one.failure.empty())
            std::printf("%s stopped: %s\n", one.table->name.c_str(), one.failure.c_str());
        for (const Row &row : one.table->rows) {
            if (!one.failure.empty() || !one.is_judged(row) || one.passed(row)) continue;
            std::printf("%s.%s: ours %s %s, published %s (%s)\n", one.table->name.c_str(), row.name.c_str(),
                        crn::number_text(one.value(row), 4).c_str(), row.unit.c_str(),
                        row.published().c_str(), distance_text(row, one.value(row)).c_str());
        }
    }
}

int print_comparison(const Comparison &comparison, const std::string &file)
{
    for (const std::string &name : comparison.better)
        std::printf("%s passes now: renew %s with --expect\n", name.c_str(), file.c_str());
    for (const std::string &name : comparison.unknown)
        std::printf("%s is not in %s: add it with --expect\n", name.c_str(), file.c_str());
    for (const std::string &name : comparison.gone)
        std::printf("%s is in %s, but no table has this name: renew it with --expect\n", name.c_str(),
                    file.c_str());
    for (const std::string &name : comparison.worse)
        std::printf("%s passed before and fails now\n", name.c_str());
    return comparison.worse.empty() ? 0 : 1;
}

int finish(const std::vector<Measured> &all, const std::vector<Table> &tables, const Options &options)
{
    write_results(all, tables, options);
    print_failures(all);
    Expectations expected;
    if (options.expect) {
        for (const Measured &one : all)
            if (one.table->kind == Kind::validation)
                expected[one.table->name] = one.verdict() == "pass" ? "pass" : "fail";
        crn::write_whole_file(options.expected, expectations_text(expected));
    } else {
        expected = read_expectations(options.expected);
    }
    const auto number = [&](const char *verdict) {
        return std::count_if(all.begin(), all.end(),
                             [&](const Measured &one) { return one.verdict() == verdict; });
    };
    std::printf("%zu tables: %td pass, %td fail, %td stopped, %td are inputs\nwritten: %s/literature.tsv "
                "%s/literature/*.svg\n",
                all.size(), number("pass"), number("fail"), number("stopped"), number("input"),
                options.folder.c_str(), options.folder.c_str());
    return print_comparison(compare(all, expected, options.only.empty()), options.expected);
}

void print_list(const std::vector<Table> &tables)
{
    for (const Table &table : tables)
        std::printf("%-24s %-17s %s\n", table.name.c_str(),
                    table.kind == Kind::validation ? "validation"
                    : table.kind == Kind::input    ? "input"
                                                   : "not reproducible",
                    table.title.c_str());
}

int run(Options options)
{
    const std::vector<Table> tables = read_tables(options.tables);
    auto work = pairs(tables);
    if (options.list) {
        print_list(tables);
        return 0;
    }
    std::erase_if(work,
                  [&](const auto &one) { return one.first->name.find(options.only) == std::string::npos; });
    if (work.empty())
        throw crn::UsageError("no table that can be run has '" + options.only +
                              "' in its name; --list prints the names");
    const bool is_whole = options.only.empty();
    if (!is_whole && (options.expect || !options.docs.empty()))
        throw crn::UsageError("--expect and --docs need all tables, so they cannot go with --only");
    crn::check_output_folder({"--output", options.folder});
    crn::check_outputs({}, {{"--docs", options.docs}});
    crn::watch_for_interrupt();
    const std::vector<Measured> all = measure_all(work, options);
    if (crn::is_interrupted()) {
        std::fprintf(stderr, "literature: stopped; nothing was written\n");
        return 1;
    }
    return finish(all, tables, options);
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app{"literature: repeats published measurements with the simulator (docs/literature.md)"};
    app.footer(examples);
    app.add_option("--only", options.only, "only tables with this text in their name");
    app.add_option("-o,--output", options.folder, "folder for literature.tsv and the pictures")
        ->capture_default_str();
    app.add_option("-j,--jobs", options.jobs, "tables at a time")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
    app.add_option("--docs", options.docs, "also renew this page between its marks");
    app.add_option("--tables", options.tables, "folder with the published tables")->capture_default_str();
    app.add_option("--expected", options.expected, "tracked list of verdicts")->capture_default_str();
    app.add_flag("--expect", options.expect, "renew the list of verdicts");
    app.add_flag("--list", options.list, "print the tables and stop");
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("literature"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return run(options);
    } catch (const crn::UsageError &error) {
        crn::say(stderr, "literature: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "literature: %s\n", error.what());
        return 1;
    }
}
