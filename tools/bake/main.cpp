// Command line of `bake` (docs/scene.md).
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "host/cli/parse.hpp"
#include "tools/bake/bake.hpp"
#include "tools/bake/fault.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>

namespace
{

constexpr const char *examples =
    "Examples:\n"
    "  bake shared/examples/steve_iliac_arch.toml --data ../shared/anatomy -o out/steve.scene\n"
    "  bake shared/examples/real_patient.toml -o out/real.scene      real bones, heart and vessels, where "
    "they are\n"
    "  bake aorta/scene.toml -o aorta.scene --surface aorta.ply      also keep the lumen's surface\n"
    "Exit codes: 0 done, 1 the input is unusable (the message says why), 2 usage.\n";

std::string data_folder()
{
    const char *folder = std::getenv("CRN_ANATOMY");
    return folder ? folder : "../shared/anatomy";
}

} // namespace

int main(int argc, char **argv)
{
    crn::bake::Options options;
    options.folders = {data_folder(), "build/anatomy/aorta"};
    std::string surface;
    CLI::App app{
        "Makes the binary scene of a lumen (and the bodies of its picture) from a text and meshes or "
        "centrelines",
        "bake"};
    app.footer(examples);
    app.add_option("SCENE", options.scene, "The scene's text, a TOML file (docs/scene.md)")
        ->type_name("FILE")
        ->required();
    app.add_option("-o,--output", options.output, "The scene to write; bodies go beside it as .bodies")
        ->type_name("FILE")
        ->group("Outputs")
        ->required();
    app.add_option("--data", options.folders.data, "Folder that paths beginning with data: are in")
        ->type_name("FOLDER")
        ->capture_default_str();
    app.add_option("--shipped", options.folders.shipped,
                   "Folder that paths beginning with shipped: are in, as `anatomy` writes it")
        ->type_name("FOLDER")
        ->capture_default_str();
    app.add_option("--surface", surface, "Also write the lumen's surface there (PLY, mm, patient frame)")
        ->type_name("FILE")
        ->group("Outputs");
    app.add_option("--seed", options.seed, "Seed of the random points and poses of the report")
        ->capture_default_str();
    app.add_option("--poses", options.poses, "Capsule poses compared with libccd")
        ->capture_default_str()
        ->check(CLI::Range(0, 10000000));
    app.add_option("--points", options.points, "Random points of the field error")
        ->capture_default_str()
        ->check(CLI::Range(100, 100000000));
    app.set_version_flag("--version", crn::version_of("bake"));
    if (const std::optional<int> code = crn::parse_command_line(app, argc, argv)) return *code;
    options.surface = surface;
    crn::bake::Progress progress;
    crn::bake::Progress::catch_interrupts();
    try {
        crn::say(stdout, "%s", crn::bake::bake(options, progress).c_str());
        return 0;
    } catch (const crn::UsageError &error) {
        crn::say(stderr, "bake: %s\n", error.what());
        return 2;
    } catch (const crn::bake::Fault &fault) {
        progress.finish();
        crn::say(stderr, "bake: %s\n", fault.what());
    } catch (const std::exception &error) {
        progress.finish();
        crn::say(stderr, "bake: %s: %s\n", options.scene.c_str(), error.what());
    }
    return 1;
}
