// The program `chip` prices ticks of the core on a Cortex-M7 with the memories of a board (docs/budget.md).
// `make budget` runs it. Each line of its output is a name, then mean, 99.9th percentile and largest value.
#include "firmware/bench/budget_case.h"
#include "host/script/session.hpp"
#include "host/session/device.hpp"
#include "tools/chip/drive.hpp"
#include "tools/chip/figures.hpp"
#include "tools/chip/twin.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace
{

using namespace chip;

struct Options {
    std::string image, recording, case_file, scene;
    std::vector<std::string> tools;
    bool shows_functions = false, shows_dearest = false;
    std::uint32_t samples = 1000, seed = 1, seeds = 1, ticks = 12000, tick = 0;
};

// The budget's cases, as firmware/bench/budget_make.c writes them: the first tick is not counted.
void price_case(const Options &options)
{
    Processor processor(options.image);
    const auto code = disassemble(options.image);
    Pricer pricer(processor, code, "crn_step");
    std::ifstream file(options.case_file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const std::span<std::uint8_t> memory = processor.memory_of("chip_case");
    if (bytes.size() < sizeof(budget_case) || bytes.size() > memory.size())
        throw PriceError("'" + options.case_file + "' is no case; `budget_make make N FILE` writes one");
    std::copy(bytes.begin(), bytes.end(), memory.begin());
    budget_case head;
    std::copy_n(bytes.begin(), sizeof head, reinterpret_cast<char *>(&head));
    if (processor.call("chip_start") == 0) throw PriceError("the core refuses the case; build it anew");
    const NearWords near = read_near(processor);
    pricer.set_scene({0, 0, near.bricks, near.slot_count});
    std::uint32_t is_right = 0;
    for (std::uint32_t tick = 0; tick < head.ticks; tick++)
        is_right = processor.call("chip_tick", tick, &pricer);
    if (head.ticks < 2) throw PriceError("the case has no tick behind its first; build it anew");
    if (is_right == 0) throw PriceError("the state's hash is not the PC's; build the case anew");
    std::vector<TickPrice> ticks = pricer.take_ticks();
    ticks.erase(ticks.begin());
    print_figures(ticks);
    if (options.shows_functions) print_functions(processor, pricer.spent(), head.ticks);
}

// A second emulated device, because the first one has added up what all ticks spent.
void print_dearest(const Options &options, const crn::Recording &recording,
                   const std::vector<std::uint32_t> &at, const std::vector<TickPrice> &prices)
{
    const auto dearest =
        std::max_element(prices.begin(), prices.end(), [](const TickPrice &a, const TickPrice &b) {
            return a.core_cycles < b.core_cycles;
        });
    if (dearest == prices.end()) return;
    const std::uint32_t tick = at[static_cast<std::size_t>(dearest - prices.begin())];
    ChipDevice chip(options.image);
    price_recording(chip, recording, {tick});
    std::printf("dearest tick %u\n", tick);
    print_functions(chip.processor(), chip.pricer().spent(), 1);
}

void price_recorded(const Options &options)
{
    const crn::Recording recording = crn::read_recording(options.recording);
    const auto count = static_cast<std::uint32_t>(recording.ticks.size());
    const std::uint32_t every = std::max(count / options.samples, 3u);
    std::vector<std::uint32_t> at;
    for (std::uint32_t tick = every; tick <= count; tick += every) at.push_back(tick);
    ChipDevice chip(options.image);
    std::vector<TickPrice> prices, around;
    for (const PricedTick &tick : price_recording(chip, recording, at)) {
        prices.push_back(tick.price);
        around.push_back(tick.around);
    }
    print_figures(prices);
    std::vector<double> app;
    for (const TickPrice &price : around) app.push_back(price.core_cycles);
    std::printf("app_cycles %.0f\n", percentile(app, 0.999));
    std::printf("scene_bytes %u\n", recording.header.scene_bytes);
    for (const char *name : {"nodes", "positions", "estimate"})
        std::printf("%s %u\n", name, chip.processor().call(std::string("chip_") + name));
    const NearWords near = read_near(chip.processor());
    std::printf("near_slots %u\nnear_nodes %u\n", near.slot_count, near.node_count);
    if (options.shows_functions) print_functions(chip.processor(), chip.pricer().spent(), prices.size());
    if (options.shows_dearest) print_dearest(options, recording, at, prices);
}

TwinSetUp set_up_of(const Options &options)
{
    TwinSetUp set_up{options.scene, {}, {}, {}, crn::host_rig()};
    for (const std::string &tool : options.tools) set_up.tools.push_back(crn::read_instrument(tool));
    const crn::SceneFile scene = crn::read_scene(options.scene);
    const std::vector<std::uint32_t> unstated(set_up.tools.size(), crn::inserted_unstated);
    set_up.entry = crn::entry_of(scene, set_up.tools.size(), unstated);
    return set_up;
}

bool has_balloon(const TwinSetUp &set_up)
{
    return std::any_of(set_up.tools.begin(), set_up.tools.end(),
                       [](const crn::Instrument &tool) { return tool.table.balloon_count > 0; });
}

struct Found {
    std::uint32_t seed = 0, tick = 0;
    TickPrice price;
    double cycles() const { return price.cycles(boards[0]); }
};

// Prices the drive of one seed: two ticks in every `every` ticks between two ticks.
Found dearest(ChipDevice &chip, const TwinSetUp &set_up, std::uint32_t seed, std::uint32_t from,
              std::uint32_t to, std::uint32_t every)
{
    Twin twin(chip, set_up);
    Drive drive(seed, static_cast<std::uint32_t>(set_up.tools.size()), has_balloon(set_up));
    Found best;
    while (twin.tick() + 2 <= to) {
        const crn_wire_tick_input first = drive.next();
        if (twin.tick() + 2 < from || (twin.tick() + 2 - from) % every != 0) {
            twin.advance({&first, 1});
            continue;
        }
        const crn_wire_tick_input second = drive.next();
        const std::optional<PricedTick> tick = twin.price(first, second);
        if (!tick) continue;
        const Found found{seed, twin.tick(), tick->price};
        if (found.cycles() > best.cycles()) best = found;
    }
    return best;
}

// Looks through all seeds coarsely, and around the dearest tick of the dearest seed at every second tick.
void search(const Options &options)
{
    constexpr std::uint32_t coarse = 200, around = 200;
    ChipDevice chip(options.image);
    const TwinSetUp set_up = set_up_of(options);
    Found best;
    for (std::uint32_t seed = 1; seed <= options.seeds; seed++) {
        const Found found = dearest(chip, set_up, seed, coarse, options.ticks, coarse);
        if (found.cycles() > best.cycles()) best = found;
        std::fprintf(stderr, "seed %u: %.0f cycles at tick %u\n", seed, found.cycles(), found.tick);
    }
    const std::uint32_t from = best.tick > around + 2 ? best.tick - around : 2;
    for (const std::uint32_t begin : {from, from + 1}) {
        const Found found = dearest(chip, set_up, best.seed, begin, best.tick + around, 2);
        if (found.cycles() > best.cycles()) best = found;
    }
    std::printf("seed %u\ntick %u\n", best.seed, best.tick);
    print_figures({best.price});
}

void price_found(const Options &options)
{
    ChipDevice chip(options.image);
    const Found found = dearest(chip, set_up_of(options), options.seed, options.tick, options.tick, 1);
    if (found.tick == 0)
        throw PriceError("the drive has no such tick any more; `make budget-search` looks anew");
    print_figures({found.price});
    if (options.shows_functions) print_functions(chip.processor(), chip.pricer().spent(), 1);
}

void add_drive(CLI::App *command, Options &options)
{
    command->add_option("--scene", options.scene, "Baked scene")->required();
    command->add_option("--tool", options.tools, "Instrument, from the innermost")->required();
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    CLI::App app("Prices ticks of the core on a Cortex-M7 (docs/budget.md)", "chip");
    app.require_subcommand(1);
    app.add_option("--image", options.image, "chip_device.elf, or chip_case.elf for a case")->required();
    app.add_flag("--functions", options.shows_functions,
                 "Print what each function takes of a case, session or found tick");
    CLI::App *one_case = app.add_subcommand("case", "A case of the budget");
    one_case->add_option("file", options.case_file, "Written by `budget_make make`")->required();
    CLI::App *session = app.add_subcommand("session", "Ticks of a recording, at equal distances");
    session->add_option("recording", options.recording, "Recording")->required();
    session->add_flag("--dearest", options.shows_dearest,
                      "Print what each function takes of the dearest tick");
    session->add_option("--samples", options.samples, "Ticks to price")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    CLI::App *looks = app.add_subcommand("search", "Looks for the dearest tick of many random drives");
    add_drive(looks, options);
    looks->add_option("--seeds", options.seeds, "Drives")->capture_default_str();
    looks->add_option("--ticks", options.ticks, "Length of a drive")->capture_default_str();
    CLI::App *found = app.add_subcommand("found", "The tick that a search found");
    add_drive(found, options);
    found->add_option("--seed", options.seed, "Of the drive")->required();
    found->add_option("--tick", options.tick, "Of the drive")->required();
    try {
        app.parse(argc, argv);
        if (*one_case) price_case(options);
        if (*session) price_recorded(options);
        if (*looks) search(options);
        if (*found) price_found(options);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "chip: %s\n", error.what());
        return 1;
    }
    return 0;
}
