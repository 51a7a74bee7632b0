// Reads the command line of `validate`, which runs the validation suite of docs/validation.md.
#include "host/base/command_values.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/docs_page.hpp"

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

namespace
{

using namespace crn::validate;

constexpr const char *examples =
    "Examples:\n"
    "  validate                          every case; writes out/validation.html and out/validation.tsv\n"
    "  validate --only capstan           the cases with that text in their name\n"
    "  validate --quick --tap            a few figures per case in seconds, as a test\n"
    "  validate --docs docs/validation.md   also renew the table between the two marks of that page\n"
    "Exit codes: 0 every figure is within its tolerance, 1 some is not, 2 usage.\n";

struct Options {
    std::string only, folder = "out", docs;
    unsigned jobs = std::max(1u, std::thread::hardware_concurrency());
    bool quick = false, tap = false, list = false;
};

Result run_case(const Case &one, bool quick)
{
    Result result;
    result.name = one.name;
    auto began = std::chrono::steady_clock::now();
    try {
        one.run(result, quick);
    } catch (const std::exception &error) {
        result.failure = error.what();
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return result;
}

// The option `jobs` states the number of threads; each thread takes one case after the other from the list.
// Cases share no data, so the results do not depend on the number of threads.
std::vector<Result> run_all(const std::vector<Case> &cases, const Options &options)
{
    std::vector<Result> results(cases.size());
    std::atomic<std::size_t> next{0}, done{0};
    std::mutex printing;
    auto work = [&] {
        for (std::size_t i = next++; i < cases.size(); i = next++) {
            results[i] = run_case(cases[i], options.quick);
            if (options.tap) continue;
            std::lock_guard<std::mutex> lock(printing);
            std::fprintf(stderr, "%2zu/%zu  %-4s %-16s %5.1f s  %zu figures\n", ++done, cases.size(),
                         results[i].passed() ? "pass" : "FAIL", cases[i].name.c_str(), results[i].seconds,
                         results[i].rows.size());
        }
    };
    std::vector<std::thread> threads;
    for (unsigned k = 0; k < options.jobs; k++) threads.emplace_back(work);
    for (std::thread &thread : threads) thread.join();
    return results;
}

int finish(const std::vector<Result> &results, const Options &options)
{
    bool passed = std::all_of(results.begin(), results.end(), [](const Result &r) { return r.passed(); });
    if (options.tap) {
        std::fputs(tap(results).c_str(), stdout);
        return passed ? 0 : 1;
    }
    std::filesystem::create_directories(options.folder);
    std::string html_path = options.folder + "/validation.html",
                tsv_path = options.folder + "/validation.tsv";
    crn::write_whole_file(
        html_path, html(results, options.only.empty() ? "make validate" : "validate --only " + options.only));
    crn::write_whole_file(tsv_path, tsv(results));
    if (!options.docs.empty()) write_between_marks(options.docs, "validate", markdown(results));
    for (const Result &result : results) {
        if (!result.failure.empty())
            std::printf("%s stopped: %s\n", result.name.c_str(), result.failure.c_str());
        for (const Row &row : result.rows) {
            if (!row.passed()) {
                std::printf("%s: %s %s, reference %s, error %s %s, allowed %s\n", row.name.c_str(),
                            crn::number_text(row.value, 4).c_str(), row.unit.c_str(),
                            crn::number_text(row.reference, 4).c_str(),
                            crn::number_text(row.error, 4).c_str(), row.error_unit.c_str(),
                            crn::number_text(row.tolerance, 4).c_str());
            }
        }
    }
    std::printf("%s\nwritten: %s %s\n",
                passed ? "every figure is within its tolerance" : "some figures are outside their tolerance",
                html_path.c_str(), tsv_path.c_str());
    return passed ? 0 : 1;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app{"validate: compares the rod with closed forms, case by case (docs/validation.md)"};
    app.footer(examples);
    app.add_option("--only", options.only, "only cases with this text in their name");
    app.add_option("-o,--output", options.folder, "folder for validation.html and validation.tsv")
        ->capture_default_str();
    app.add_option("-j,--jobs", options.jobs, "cases at a time")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
    app.add_option("--docs", options.docs, "also renew the table in this page");
    app.add_flag("--quick", options.quick, "fewer figures per case");
    app.add_flag("--tap", options.tap, "print TAP on standard output and write no file");
    app.add_flag("--list", options.list, "print the names of the cases and stop");
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("validate"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    std::vector<Case> cases;
    for (const Case &one : all_cases()) {
        if (one.name.find(options.only) != std::string::npos) cases.push_back(one);
    }
    if (cases.empty()) {
        std::fprintf(stderr, "validate: no case has '%s' in its name; --list prints the names\n",
                     options.only.c_str());
        return 2;
    }
    if (options.list) {
        for (const Case &one : cases) std::printf("%s\n", one.name.c_str());
        return 0;
    }
    try {
        if (!options.tap) crn::check_output_folder({"--output", options.folder});
        crn::check_outputs({}, {{"--docs", options.docs}});
        return finish(run_all(cases, options), options);
    } catch (const crn::UsageError &error) {
        crn::say(stderr, "validate: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "validate: %s\n", error.what());
        return 1;
    }
}
