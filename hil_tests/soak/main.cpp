// The program soak runs random valid sessions for hours and judges them by the limits (bars) of docs/soak.md.
// The exit code is 0 if no session exceeded a limit, 1 if a session exceeded a limit or the program failed,
// and 2 for wrong usage.
#include "hil_tests/soak/campaign.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "shared/wire/wire_frame.h"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

namespace
{

namespace fs = std::filesystem;

const char shipped_tools[] = "shared/examples/instruments", shipped_stents[] = "shared/examples/stents";

struct Options {
    soak::CampaignSettings campaign;
    std::vector<std::string> scenes = {"out/aorta.scene", "out/heart.scene", "out/phantom.scene",
                                       "out/lad_pci.scene", "out/renal_pci.scene"};
    std::string tool_folder = shipped_tools, stent_folder = shipped_stents;
    std::optional<std::uint32_t> print, only; // index of a session
    std::string script;                       // judged instead of a drawn session
    std::vector<std::string> tools, stents;   // of it
    std::uint32_t disturb_tick = 0; // for tests: the recording is changed at this tick before its replay
};

void parse_goals(CLI::App &app, Options &options)
{
    soak::CampaignSettings &campaign = options.campaign;
    app.add_option("--seed", campaign.seed, "Decides every session, together with its number")
        ->capture_default_str();
    app.add_option("--sessions", campaign.sessions, "At least so many, those of former calls included")
        ->capture_default_str();
    app.add_option("--ticks", campaign.ticks, "At least so many ms of sessions, the same way")
        ->capture_default_str();
    app.add_option("--hours", campaign.hours, "So long instead of sessions and ticks; 0: they decide")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 10000.0));
    app.add_option("--jobs", campaign.jobs, "Sessions at a time")
        ->capture_default_str()
        ->check(CLI::Range(1, 1024));
    app.add_option("--seconds-min", campaign.draw.seconds_min, "Shortest session to draw")
        ->capture_default_str()
        ->check(CLI::Range(1, 3600));
    app.add_option("--seconds-max", campaign.draw.seconds_max, "Longest session to draw")
        ->capture_default_str()
        ->check(CLI::Range(1, 3600));
    app.add_option("--session-ticks", campaign.trial.ticks_max, "A session that takes longer ends there")
        ->capture_default_str();
    app.add_option("--folder", campaign.folder, "Where rows and shrunk scripts go")->capture_default_str();
    app.add_option("--shrink", campaign.shrink.trials, "Trials to make a broken session short")
        ->capture_default_str();
}

void parse_bars(CLI::App &app, Options &options)
{
    soak::Bars &bars = options.campaign.trial.bars;
    app.add_option("--penetration-mm", bars.penetration_mm, "Bar on the deepest contact")
        ->capture_default_str();
    app.add_option("--length-pct", bars.length_pct, "Bar on the length error")->capture_default_str();
    app.add_option("--force-N", bars.force_N, "Bar on the force at a hand")->capture_default_str();
    app.add_option("--disturb-replay", options.disturb_tick, "Tests: change the recording at this tick")
        ->group("");
}

void parse(CLI::App &app, Options &options)
{
    parse_goals(app, options);
    parse_bars(app, options);
    app.add_option("--scene", options.scenes, "Baked scenes, several times; \"free\": free space")
        ->capture_default_str();
    app.add_option("--instruments", options.tool_folder, "Folder of instruments")->capture_default_str();
    app.add_option("--stents-from", options.stent_folder, "Folder of stents")->capture_default_str();
    app.add_option("--print", options.print, "Only print this session: its command and its script");
    app.add_option("--only", options.only, "Only this session; no row is written");
    app.add_option("--session", options.script,
                   "Judge this script with --scene, --tool and --stent; no row is written");
    app.add_option("--tool", options.tools, "With --session: from the innermost");
    app.add_option("--stent", options.stents, "With --session");
    app.footer("Examples:\n  soak --seed 7 --hours 1 --jobs 2\n  soak --seed 7 --print 41 > out/41.session\n"
               "  soak --session out/soak/7_41.session --scene out/aorta.scene --tool "
               "shared/examples/instruments/j_wire.toml");
}

void check(Options &options)
{
    soak::CampaignSettings &campaign = options.campaign;
    if (campaign.draw.seconds_max < campaign.draw.seconds_min)
        throw crn::UsageError("--seconds-max is less than --seconds-min");
    if (!options.script.empty() && (options.scenes.size() != 1 || options.tools.empty()))
        throw crn::UsageError("--session needs one --scene and at least one --tool");
    if (options.script.empty() && !(options.tools.empty() && options.stents.empty()))
        throw crn::UsageError("--tool and --stent go with --session");
    for (std::string &scene : options.scenes) {
        if (scene == "free") scene.clear();
        if (!scene.empty() && !fs::exists(scene))
            throw crn::UsageError(scene + " is not there: `make soak` makes all scenes, `make " + scene +
                                  "` this one");
    }
    if (options.disturb_tick > 0)
        campaign.trial.disturb = [tick = options.disturb_tick](crn::Recording &recording) {
            if (tick < recording.ticks.size()) recording.ticks[tick].input.hands[0].translation_counts += 100;
        };
}

// Returns the key, a text that changes when anything changes that affects the results. The key changes with
// the program, a scene, an instrument or a limit; with a new key, the program begins a new file of results.
std::string key_of(const Options &options, const soak::Catalogue &catalogue)
{
    std::uint32_t crc = 0;
    const auto add = [&](const std::string &path) {
        const std::string bytes = crn::read_text_file(path);
        crc = crn_wire_crc32(crc, reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
    };
    add("/proc/self/exe");
    for (const soak::SoakTool &tool : catalogue.tools) add(tool.path);
    for (const soak::SoakStent &stent : catalogue.stents) add(stent.path);
    const soak::CampaignSettings &campaign = options.campaign;
    char text[200];
    std::snprintf(text, sizeof text,
                  "soak: seed %llu, program and instruments %08x, bars %g mm %g %% %g N, %d to %d s",
                  static_cast<unsigned long long>(campaign.seed), unsigned{crc},
                  campaign.trial.bars.penetration_mm, campaign.trial.bars.length_pct,
                  campaign.trial.bars.force_N, campaign.draw.seconds_min, campaign.draw.seconds_max);
    std::string key = text;
    for (const soak::SoakScene &scene : catalogue.scenes) {
        std::snprintf(text, sizeof text, "%08x", unsigned{scene.file.crc32});
        key += ", " + (scene.path.empty() ? "free space" : scene.path + " " + text);
    }
    return key;
}

std::vector<std::string> lines_of(const std::string &text)
{
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
        if (!line.empty() && line[0] != '#') lines.push_back(line);
    return lines;
}

// Judges one session and prints the details of the verdict.
int judge_one(const Options &options, const soak::Catalogue &catalogue, const soak::DrawnSession &session)
{
    const std::optional<soak::Row> row = soak::judge_session(catalogue, options.campaign, session);
    if (!row) {
        std::fprintf(stderr, "soak: interrupted\n");
        return 1;
    }
    const soak::Verdict &verdict = row->verdict;
    std::printf("%s: %s; %s\n", soak::name_of(session).c_str(),
                session.scene.empty() ? "free space" : session.scene.c_str(), row->tools.c_str());
    std::printf(
        "%u ticks, penetration %.3f mm, length error %.3f %%, force %.2f N, %u ticks capped, %.0f mg iodine, "
        "hash %016llx\n",
        unsigned{verdict.ticks}, verdict.penetration_mm, verdict.length_pct, verdict.force_N,
        unsigned{verdict.capped}, verdict.injected_mg, static_cast<unsigned long long>(verdict.hash));
    if (verdict.broken.empty()) {
        std::printf("every bar held\n");
        return 0;
    }
    std::printf("broken at tick %u: %s\nshrunk: %s\n", unsigned{verdict.tick}, verdict.text.c_str(),
                row->script.c_str());
    return 1;
}

int finish(const Options &options, const soak::RowsFile &rows)
{
    const soak::Summary sum = soak::sum_of(rows);
    const std::string table = soak::bench_rows(sum, options.campaign.seed);
    const std::string path = (fs::path(options.campaign.folder) / "soak.tsv").string();
    crn::write_whole_file(path, table);
    std::printf("%swritten: %s\n", table.c_str(), path.c_str());
    if (crn::is_interrupted())
        std::fprintf(stderr, "soak: interrupted; the same command goes on with the next session\n");
    return sum.broken > 0 ? 1 : 0;
}

int run(const Options &options)
{
    const soak::CampaignSettings &campaign = options.campaign;
    fs::create_directories(campaign.folder);
    const soak::Catalogue catalogue =
        soak::read_catalogue(options.scenes, options.tool_folder, options.stent_folder);
    if (!options.script.empty())
        return judge_one(options, catalogue,
                         {campaign.seed, 0, options.scenes[0], options.tools, options.stents,
                          lines_of(crn::read_text_file(options.script))});
    if (options.only)
        return judge_one(options, catalogue,
                         draw_session(catalogue, campaign.seed, *options.only, campaign.draw));
    if (options.print) {
        const soak::DrawnSession session =
            draw_session(catalogue, campaign.seed, *options.print, campaign.draw);
        std::printf("# %s\n# %s\n%s", soak::name_of(session).c_str(),
                    soak::command_of(session, "FILE").c_str(), soak::script_of(session).c_str());
        return 0;
    }
    const std::string path =
        (fs::path(campaign.folder) / ("seed_" + std::to_string(campaign.seed) + ".tsv")).string();
    soak::RowsFile rows(path, key_of(options, catalogue));
    if (rows.was_put_aside())
        std::printf("%s.old: rows of another program, scene or bar are put aside\n", path.c_str());
    std::printf("seed %llu: %zu sessions are in %s already\n", static_cast<unsigned long long>(campaign.seed),
                rows.rows().size(), path.c_str());
    run_campaign(catalogue, campaign, rows);
    return finish(options, rows);
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    options.campaign.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    CLI::App app("Draws random legal sessions and holds every tick against bars (docs/soak.md)");
    parse(app, options);
    app.set_version_flag("--version", crn::version_of("soak"));
    try {
        app.parse(argc, argv);
        check(options);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const crn::UsageError &error) {
        std::fprintf(stderr, "soak: %s\n", error.what());
        return 2;
    }
    crn::watch_for_interrupt();
    try {
        return run(options);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "soak: %s\n", error.what());
        return 1;
    }
}
