// Defines the command-line options for making a case with a known answer; the commands `reference_rod` and
// `ct simulate --instrument` both use these options.
#pragma once
#include "tools/lab/reference_rod/truth.hpp"
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace crn::reference
{

// Adds all options except the folder of the case and the seed. `depths` are passed to take_depths.
inline void add_truth_options(CLI::App &app, TruthRequest &request, std::vector<std::string> &depths)
{
    app.add_option("--instrument", request.instrument, "nominal instrument file, or FILE:preset");
    app.add_option("--scene", request.scene, "baked lumen");
    app.add_option("--surface", request.surface, "closed mesh of the lumen in mm, to go into the case");
    app.add_option("--name", request.name, "of the case");
    app.add_option("--depth", depths, "NAME:INSERTED_MM:TURN_DEG, once per depth, rising")->take_all();
    app.add_option("--shaft-factor", request.shaft_factor, "the truth's EI of the shaft over the file's")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--tip-factor", request.tip_factor, "the truth's alpha over the file's")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--friction", request.friction, "against the wall")
        ->check(CLI::Range(0.0, 0.6))
        ->capture_default_str();
    const auto add_mm = [&app](const char *name, double &value_m, const char *what) {
        app.add_option_function<double>(
               name, [&value_m](double value_mm) { value_m = value_mm * 1e-3; },
               std::string(what) + " (default " + std::to_string(value_m * 1e3).substr(0, 4) + ")")
            ->check(CLI::Range(0.1, 5.0));
    };
    add_mm("--edge-tip-mm", request.cut.tip_m, "longest edge of the truth at the tip");
    add_mm("--edge-shaft-mm", request.cut.shaft_m, "and elsewhere");
    add_mm("--feed-step-mm", request.step.feed_m, "longest step of the hand");
    app.add_option("--force-noise-mN", request.force_noise_mN, "of the hand's force; negative: not measured")
        ->capture_default_str();
}

// Reads "NAME:INSERTED_MM:TURN_DEG". Throws std::invalid_argument, whose message states the expected form of
// the option.
inline insertion::Depth depth_from(const std::string &text)
{
    const std::size_t turn = text.rfind(':'), inserted = turn == 0 ? turn : text.rfind(':', turn - 1);
    insertion::Depth depth;
    try {
        std::size_t end_inserted = 0, end_turn = 0;
        const std::string a = text.substr(inserted + 1, turn - inserted - 1), b = text.substr(turn + 1);
        depth.inserted_mm = std::stod(a, &end_inserted);
        depth.turn_deg = std::stod(b, &end_turn);
        if (inserted == std::string::npos || end_inserted != a.size() || end_turn != b.size())
            throw std::invalid_argument(text);
    } catch (const std::exception &) {
        throw std::invalid_argument("--depth " + text +
                                    ": write NAME:INSERTED_MM:TURN_DEG, such as iliac:240:0");
    }
    depth.name = text.substr(0, inserted);
    return depth;
}

} // namespace crn::reference
