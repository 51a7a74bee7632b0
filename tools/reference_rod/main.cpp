// reference_rod: makes cases with a known answer. See docs/reference_rod.md.
#include "tools/reference_rod/truth.hpp"
#include <CLI/CLI.hpp>
#include <cstdio>

namespace
{

using namespace seld::reference;

// "NAME:INSERTED_MM:TURN_DEG"
seld::insertion::Depth depth_from(const std::string &text)
{
    const std::size_t turn = text.rfind(':'), inserted = turn == 0 ? turn : text.rfind(':', turn - 1);
    seld::insertion::Depth depth;
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

void add_options(CLI::App &app, TruthRequest &request, std::vector<std::string> &depths)
{
    app.add_option("--instrument", request.instrument, "nominal instrument file, or FILE:preset")->required();
    app.add_option("--scene", request.scene, "baked lumen")->required();
    app.add_option("--surface", request.surface, "closed mesh of the lumen in mm, to go into the case");
    app.add_option("-o,--output", request.folder, "folder of the case")->required();
    app.add_option("--name", request.name, "of the case");
    app.add_option("--depth", depths, "NAME:INSERTED_MM:TURN_DEG, once per depth, rising")
        ->required()
        ->take_all();
    app.add_option("--shaft-factor", request.shaft_factor, "the truth's EI of the shaft over the file's")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--tip-factor", request.tip_factor, "the truth's alpha over the file's")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    app.add_option("--friction", request.friction, "against the wall")
        ->check(CLI::Range(0.0, 0.6))
        ->capture_default_str();
    app.add_option("--shape-noise-mm", request.shape_noise_mm,
                   "also write depth_N.csv: the truth with this noise; negative: a scan gives them")
        ->capture_default_str();
    app.add_option("--force-noise-mN", request.force_noise_mN, "of the hand's force; negative: not measured")
        ->capture_default_str();
    app.add_option("--seed", request.seed, "of the noise")->capture_default_str();
}

int make(const TruthRequest &request)
{
    const Truth truth = make_case(
        request, [](const std::string &depth) { std::fprintf(stderr, "  reached %s\n", depth.c_str()); });
    std::printf("%s: EI of the shaft %.4g N m2, alpha %.4g; %d steps, %d not at rest, %.4f mN left over\n",
                (request.folder / "case.toml").string().c_str(), truth.stiffness.shaft_N_m2,
                truth.stiffness.tip_over_shaft, truth.run.steps, truth.run.unsettled, truth.run.residual_mN);
    return 0;
}

} // namespace

int main(int argc, char **argv)
{
    CLI::App app{"Inserts an instrument of known stiffness into a lumen by an independent model, and writes "
                 "a case for "
                 "`calibrate`."};
    app.footer("Examples:\n"
               "  reference_rod --instrument rosen.toml --scene out/access.scene --depth iliac:240:0 --depth "
               "aortic:300:0 \\\n"
               "      --depth renal:362:90 --shaft-factor 1.3 --tip-factor 0.7 --shape-noise-mm 0.1 -o "
               "out/cases/rosen\n"
               "Exit codes: 0 done, 1 the input is unusable (the message says why), 2 usage.");
    TruthRequest request;
    std::vector<std::string> depths;
    add_options(app, request, depths);
    try {
        app.parse(argc, argv);
        for (const std::string &text : depths) request.depths.push_back(depth_from(text));
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const std::invalid_argument &error) {
        std::fprintf(stderr, "reference_rod: %s\n", error.what());
        return 2;
    }
    try {
        return make(request);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "reference_rod: %s\n", error.what());
        return 1;
    }
}
