// This is the program hil_rt1062_faults: it draws faults of the emulated chip from seeds, and judges each
// (docs/rt1062.md, "Faults at the registers").
#include "hil_tests/rt1062/faults/chip_session.hpp"
#include "host/base/version.hpp"
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>

namespace
{

struct Options {
    std::string image = "build/firmware/cournand-imxrt1062.elf", file = "out/hil_rt1062_faults.tsv";
    std::uint32_t count = 2100, first = 1, jobs = 1;
    std::vector<std::uint32_t> only;
};

struct Row {
    std::uint32_t count = 0, failed = 0;
    double safe_ms = -1, bar_ms = 0, peak_N = 0, asked_N = 0;
    std::map<std::string, std::uint32_t> endings;
};

class Table
{
  public:
    void add(const hil::ChipFault &fault, const hil::ChipOutcome &outcome)
    {
        Row &row = rows_[fault.kind];
        const bool is_good = outcome.failure[0] == '\0';
        row.count++;
        row.failed += !is_good;
        if (outcome.bar_ms > 0) { // of those that must end the force
            row.safe_ms = std::max(row.safe_ms, outcome.safe_ms);
            row.bar_ms = std::max(row.bar_ms, outcome.bar_ms);
        }
        row.peak_N = std::max(row.peak_N, outcome.peak_N);
        row.asked_N = std::max(row.asked_N, outcome.asked_N);
        row.endings[outcome.ending]++;
        failed_ += !is_good;
        lines_.push_back(hil::text("%u\t%s\t%s\t%s\t%.2f\t%.3f\t%.3f\t%s\t%.2f\t", fault.seed,
                                   fault.kind.c_str(), is_good ? "ok" : "FAILED", outcome.ending,
                                   outcome.safe_ms, outcome.peak_N, outcome.asked_N, fault.what.c_str(),
                                   outcome.wall_s) +
                         outcome.failure);
        if (!is_good)
            std::printf("FAILED: seed %u, %s, %s: %s (%s)\n", fault.seed, fault.kind.c_str(),
                        fault.what.c_str(), outcome.failure, outcome.ending);
        if (lines_.size() % 100 == 0) std::fprintf(stderr, "%zu faults\n", lines_.size());
        std::fflush(stdout);
    }

    void print() const
    {
        std::printf("%-20s %6s %7s %8s %7s %8s  %s\n", "fault", "count", "failed", "worst ms", "max N",
                    "asked N", "endings");
        for (const auto &[name, row] : rows_) {
            std::string endings;
            for (const auto &[ending, count] : row.endings)
                endings += (endings.empty() ? "" : ", ") + std::to_string(count) + " " + ending;
            const std::string safe = row.bar_ms > 0 ? hil::text("%.1f/%.0f", row.safe_ms, row.bar_ms) : "-";
            std::printf("%-20s %6u %7u %8s %7.2f %8.2f  %s\n", name.c_str(), row.count, row.failed,
                        safe.c_str(), row.peak_N, row.asked_N, endings.c_str());
        }
        std::printf("hil.rt1062_faults\t%zu\nhil.rt1062_violations\t%zu\n", lines_.size(), failed_);
    }

    void write(const std::string &path) const
    {
        const auto folder = std::filesystem::path(path).parent_path();
        if (!folder.empty()) std::filesystem::create_directories(folder);
        std::ofstream file(path);
        file << "seed\tkind\tresult\tending\tsafe_ms\tpeak_N\tasked_N\tfault\twall_s\tfailure\n";
        for (const std::string &line : lines_) file << line << '\n';
        file << "hil.rt1062_faults\t" << lines_.size() << "\nhil.rt1062_violations\t" << failed_ << '\n';
        if (!file.flush()) throw std::runtime_error("cannot write " + path + ": check folder and disk");
    }
    std::size_t failed() const { return failed_; }

  private:
    std::map<std::string, Row> rows_;
    std::vector<std::string> lines_;
    std::size_t failed_ = 0;
};

int run(const Options &options)
{
    std::vector<std::uint32_t> seeds = options.only;
    if (seeds.empty()) {
        seeds.resize(options.count);
        std::iota(seeds.begin(), seeds.end(), options.first);
    }
    Table table;
    hil::run_chip_faults(options.image, seeds, options.jobs,
                         [&](const hil::ChipFault &fault, const hil::ChipOutcome &outcome) {
                             table.add(fault, outcome);
                             if (!options.only.empty())
                                 std::printf("%u %s: %s: %s\n", fault.seed, fault.kind.c_str(),
                                             fault.what.c_str(), outcome.ending);
                         });
    table.print();
    if (options.only.empty() && !options.file.empty()) table.write(options.file);
    return table.failed() == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("Faults of the emulated i.MX RT1062 in a session with powered motors (docs/rt1062.md)");
    app.add_option("--image", options.image, "Image of the board")->capture_default_str();
    app.add_option("--count", options.count, "So many faults")->capture_default_str();
    app.add_option("--first", options.first, "The first seed")->capture_default_str();
    app.add_option("--only", options.only, "Only the faults of these seeds");
    app.add_option("--jobs", options.jobs, "So many at a time")->capture_default_str();
    app.add_option("--tsv", options.file, "Where the results go, one line each; empty: nowhere")
        ->capture_default_str();
    app.footer("Examples:\n  hil_rt1062_faults --count 60\n  hil_rt1062_faults --only 17");
    app.set_version_flag("--version", crn::version_of("hil_rt1062_faults"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return run(options);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hil_rt1062_faults: %s\n", error.what());
        return 1;
    }
}
