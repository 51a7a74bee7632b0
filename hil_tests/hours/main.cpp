// The program hours runs a device in FREE_RUN for hours of simulated time (docs/soak.md, "24 hours"). The
// exit code is 0 if every figure keeps its promise, 1 if one does not or the program failed, and 2 for wrong
// usage.
#include "hil_tests/hours/board.hpp"
#include "hil_tests/hours/campaign.hpp"
#include "hil_tests/hours/emulated_board.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "shared/wire/wire_frame.h"
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;

struct Options {
    hours::CampaignSettings campaign;
    std::vector<std::string> scenes = {"out/phantom.scene", "out/aorta.scene"};
    std::string tool_folder = "shared/examples/instruments", stent_folder = "shared/examples/stents";
    std::string folder = "out/hours";
    std::uint32_t element_um = 8000;
    std::uint64_t begin_ms = 0;
    bool is_emulated = false;
};

void parse(CLI::App &app, Options &options)
{
    hours::CampaignSettings &campaign = options.campaign;
    app.add_option("--hours", campaign.hours, "Of simulated time, those of former calls included")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 10000.0));
    app.add_option("--seed", campaign.seed, "Decides every session, together with its number")
        ->capture_default_str();
    app.add_option("--scene", options.scenes, "Baked scenes, several times; \"free\": free space")
        ->capture_default_str();
    app.add_option("--seconds-max", campaign.seconds_max, "Longest run of most sessions")
        ->capture_default_str()
        ->check(CLI::Range(5, 3600));
    app.add_option("--long-every", campaign.long_every, "One session in so many runs for 80 minutes; 0: none")
        ->capture_default_str();
    app.add_option("--element-um", options.element_um, "Shortest element of a tool's shaft")
        ->capture_default_str()
        ->check(CLI::Range(1000, 20000));
    app.add_option("--warm", campaign.warm_sessions, "Sessions before the heap may no longer grow")
        ->capture_default_str();
    app.add_option("--begin-ms", options.begin_ms, "Time of the device's clock at power-up")
        ->capture_default_str();
    app.add_flag("--m7", options.is_emulated,
                 "On the emulated Cortex-M7, whose image `make firmware` builds");
    app.add_option("--folder", options.folder, "Where the rows go")->capture_default_str();
    app.footer("Examples:\n  hours --hours 0.1\n  hours --hours 24 --seed 7");
}

void check(Options &options)
{
    for (std::string &scene : options.scenes) {
        if (scene == "free") scene.clear();
        if (!scene.empty() && !fs::exists(scene))
            throw crn::UsageError(scene + " is not there: `make hours` makes all scenes, `make " + scene +
                                  "` this one");
    }
}

std::string key_of(const Options &options, const soak::Catalogue &catalogue)
{
    std::uint32_t crc = 0;
    const auto add = [&](const std::string &path) {
        const std::string bytes = crn::read_text_file(path);
        crc = crn_wire_crc32(crc, reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
    };
    add("/proc/self/exe");
    for (const soak::SoakTool &tool : catalogue.tools) add(tool.path);
    for (const soak::SoakScene &scene : catalogue.scenes)
        if (!scene.path.empty()) add(scene.path);
    char text[160];
    std::snprintf(text, sizeof text,
                  "hours: seed %llu, program, instruments and scenes %08x, %u um, runs to %u s",
                  static_cast<unsigned long long>(options.campaign.seed), unsigned{crc}, options.element_um,
                  options.campaign.seconds_max);
    return text;
}

int run(Options &options)
{
    soak::Catalogue catalogue =
        soak::read_catalogue(options.scenes, options.tool_folder, options.stent_folder);
    hours::coarsen(catalogue, options.element_um);
    hours::CampaignSettings &campaign = options.campaign;
    const char *place = options.is_emulated ? "m7" : "host";
    campaign.path = (fs::path(options.folder) / (std::string(place) + "_sessions.tsv")).string();
    campaign.key = key_of(options, catalogue);
    const hours::Sums sums = run_campaign(catalogue, campaign, [&](std::uint64_t begin_ms) {
        begin_ms += options.begin_ms;
        std::unique_ptr<hours::Station> station;
        if (options.is_emulated)
            station = std::make_unique<hours::EmulatedBoard>(campaign.seed, begin_ms);
        else
            station = std::make_unique<hours::Board>(
                hours::BoardSettings{.seed = campaign.seed, .begin_ms = begin_ms});
        return station;
    });
    const std::string table = hours::bench_rows(sums, place);
    const std::string path = (fs::path(options.folder) / (std::string(place) + ".tsv")).string();
    crn::write_whole_file(path, table);
    std::printf("%swritten: %s\n", table.c_str(), path.c_str());
    std::string why;
    const bool is_good = hours::is_kept(sums, why);
    std::fputs(why.c_str(), stderr);
    if (crn::is_interrupted()) {
        std::fprintf(stderr, "hours: interrupted; the same command goes on with the next session\n");
        return 1;
    }
    return is_good ? 0 : 1;
}

// Blocks that the C library keeps for the next request of a thread (tcache) look like blocks in use. Without
// them, the heap in use after a session is exactly that before it, if nothing leaks.
void run_without_kept_blocks(char **argv)
{
    const char name[] = "GLIBC_TUNABLES";
    if (getenv(name) != nullptr) return;
    setenv(name, "glibc.malloc.tcache_count=0", 1);
    execv("/proc/self/exe", argv);
}

} // namespace

int main(int argc, char **argv)
{
    run_without_kept_blocks(argv);
    Options options;
    CLI::App app("Runs a device in FREE_RUN for hours of simulated time (docs/soak.md)");
    parse(app, options);
    app.set_version_flag("--version", crn::version_of("hours"));
    try {
        app.parse(argc, argv);
        check(options);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const crn::UsageError &error) {
        std::fprintf(stderr, "hours: %s\n", error.what());
        return 2;
    }
    crn::watch_for_interrupt();
    try {
        return run(options);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "hours: %s\n", error.what());
        return 1;
    }
}
