// This is the program hil_campaign. The program injects faults on purpose (docs/hil.md): all faults, an
// evenly spread selection of them, or one fault that a line of text names.
#include "hil_tests/campaign/passivity.hpp"
#include "hil_tests/campaign/table.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/version.hpp"
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

namespace
{

struct Options {
    std::string only, kind, level = "L0", file = "out/hil_campaign.tsv";
    std::size_t spread = 0, passivity = 0;
    bool lists = false;
};

std::vector<hil::Fault> chosen(const Options &options)
{
    if (!options.only.empty()) return {hil::fault_of(options.only)};
    std::vector<hil::Fault> faults = hil::all_faults();
    if (!options.kind.empty())
        std::erase_if(faults, [&](const hil::Fault &fault) { return !fault.is_group(options.kind.c_str()); });
    return options.spread == 0 ? faults : hil::spread_of(faults, options.spread);
}

void parse(CLI::App &app, Options &options)
{
    app.add_option("--level", options.level, "L0: the app in this process; L1: the image in an emulator")
        ->capture_default_str()
        ->check(CLI::IsMember({"L0", "L1"}));
    app.add_option("--only", options.only, "One fault by its line");
    app.add_option("--kind", options.kind, "Only faults whose name begins with this");
    app.add_option("--spread", options.spread, "So many, spread over all kinds; 0: all")
        ->capture_default_str();
    app.add_option("--tsv", options.file, "Where the results go, one line each; empty: nowhere")
        ->capture_default_str();
    app.add_option(
        "--passivity", options.passivity,
        "Instead of faults, every n-th trial of the grid of gain, coupling, damping, lag and hand");
    app.add_flag("--list", options.lists, "The lines of the faults");
    app.footer("Example:\n  hil_campaign --only \"link.flip session=lockstep way=to_device frame=30 bit=43 "
               "seed=1\"");
}

int run(const Options &options)
{
    if (options.passivity > 0) {
        hil::SimLevel level;
        return hil::run_passivity_grid(level, options.passivity, options.file) == 0 ? 0 : 1;
    }
    const std::vector<hil::Fault> faults = chosen(options);
    if (options.lists) {
        for (const hil::Fault &fault : faults) std::printf("%s\n", hil::line_of(fault).c_str());
        return 0;
    }
    hil::SimLevel l0;
    hil::EmulatedLevel l1;
    hil::Level &level = options.level == "L1" ? static_cast<hil::Level &>(l1) : l0;
    const hil::Undisturbed undisturbed = hil::run_undisturbed(l0);
    const bool writes = !options.file.empty() && options.only.empty();
    if (writes) {
        const auto folder = std::filesystem::path(options.file).parent_path();
        if (!folder.empty()) std::filesystem::create_directories(folder);
        crn::check_outputs({}, {{"--tsv", options.file}});
    }
    hil::CampaignTable table(options.level);
    for (const hil::Fault &fault : faults) {
        if (crn::is_interrupted()) break;
        if (table.count() % 250 == 0)
            std::fprintf(stderr, "%zu of %zu faults\n", table.count(), faults.size());
        const hil::Outcome outcome = hil::run_fault(level, fault, undisturbed);
        table.add(fault, outcome);
        if (!options.only.empty() && !outcome.message.empty())
            std::printf("host: %s\n", outcome.message.c_str());
    }
    table.print();
    if (writes) table.write(options.file);
    return table.failures() == 0 && !crn::is_interrupted() ? 0 : 1;
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("Breaks link, host, device and rig on purpose, and judges what comes of it (docs/hil.md)");
    parse(app, options);
    app.set_version_flag("--version", crn::version_of("hil_campaign"));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    crn::watch_for_interrupt();
    try {
        return run(options);
    } catch (const std::invalid_argument &error) {
        std::fprintf(stderr, "hil_campaign: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hil_campaign: %s\n", error.what());
        return 1;
    }
}
