// The program reference_rod makes calibration cases whose correct answer is known (docs/reference_rod.md).
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "tools/lab/reference_rod/truth_options.hpp"
#include <cstdio>

namespace
{

using namespace crn::reference;

void add_options(CLI::App &app, TruthRequest &request, std::vector<std::string> &depths)
{
    add_truth_options(app, request, depths);
    for (const char *needed : {"--instrument", "--scene", "--depth"}) app.get_option(needed)->required();
    app.add_option("-o,--output", request.folder, "folder of the case")->required();
    app.add_option("--shape-noise-mm", request.shape_noise_mm,
                   "also write depth_N.csv: the truth with this noise; negative: a scan gives them")
        ->capture_default_str();
    app.add_option("--seed", request.seed, "of the noise")->capture_default_str();
}

int make(const TruthRequest &request)
{
    crn::check_output_folder({"--output", request.folder.string()});
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
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("reference_rod"));
    try {
        app.parse(argc, argv);
        for (const std::string &text : depths) request.depths.push_back(depth_from(text));
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const std::invalid_argument &error) {
        crn::say(stderr, "reference_rod: %s\n", error.what());
        return 2;
    }
    try {
        return make(request);
    } catch (const std::exception &error) {
        crn::say(stderr, "reference_rod: %s\n", error.what());
        return 1;
    }
}
