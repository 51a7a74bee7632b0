/* The program `anatomy` makes the anatomy that ships with Cournand (docs/anatomy.md), or an anatomy from a
 * user's file of vessels (docs/vessels.md). */
#include "host/base/command_values.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/cli/parse.hpp"
#include "tools/anatomy/borrowed_beat.hpp"
#include "tools/anatomy/heart_sequence.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/program/making.hpp"
#include "tools/anatomy/program/person.hpp"
#include "tools/anatomy/varied/coronaries.hpp"
#include "tools/anatomy/varied/variety.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/mesh/sequence.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace
{

using namespace anatomy;

std::vector<Body> shipped_man(const VesselTree &tree, const Fineness &fineness)
{
    return patient_bodies(tree, fineness);
}

int make(const Options &options, const char *kind,
         std::vector<Body> (*bodies_of)(const VesselTree &, const Fineness &))
{
    std::optional<DrawnAorta> drawn;
    if (options.seed) drawn = drawn_aorta(*options.seed);
    VesselTree tree = drawn ? tree_of(drawn->draft, "aorta.toml") : vessels_for(kind, options);
    if (drawn) {
        tree.made_by = crn::formatted("%s --seed %s", kind, std::to_string(drawn->seed).c_str());
        tree.seed = drawn->seed;
    }
    const std::vector<Body> bodies = (options.bodies ? bodies_of : no_bodies)(tree, options.fineness);
    if (tree.is_in_patient && options.bodies)
        make_breathing_scene(options, tree, bodies, {});
    else
        make_scene(options, tree, bodies, [](const std::string &, const Mesh &) {});
    if (drawn) crn::write_whole_file((options.folder / "vessels.toml").string(), vessel_file_text(*drawn));
    return 0;
}

/* The options of `anatomy draw`. */
struct DrawOptions {
    std::uint64_t seed = 0;
    std::string file;
    bool is_coronary = false;
};

/* Prints what was drawn. */
void print_drawn(const std::string &file, const DrawnCoronaries &drawn)
{
    std::printf("%s: %s, %zu arteries, the LAD ends %s, %u attempts refused\n", file.c_str(),
                drawn.draft.title.c_str(), drawn.arteries.size(), end_of_lad(drawn).c_str(), drawn.refused);
}

/* Writes the vessel file of a seed, and prints what was drawn. */
int draw(const DrawOptions &options)
{
    const std::string &file = options.file;
    crn::check_outputs({}, {{"--output", file}});
    if (options.is_coronary) {
        const DrawnCoronaries drawn = drawn_coronaries(options.seed);
        crn::write_whole_file(file, coronary_file_text(drawn));
        print_drawn(file, drawn);
        return 0;
    }
    const DrawnAorta drawn = drawn_aorta(options.seed);
    crn::write_whole_file(file, vessel_file_text(drawn));
    std::printf(
        "%s: %s, drop %.2f widths, aorta %.2f of the shipped diameters, iliac tortuosity %.3f right and "
        "%.3f left, %u attempts refused\n",
        file.c_str(), drawn.draft.title.c_str(), drawn.arch.drop_widths, drawn.aorta_scale,
        drawn.right_tortuosity, drawn.left_tortuosity, drawn.refused);
    return 0;
}

int make_heart(const Options &options)
{
    std::optional<DrawnCoronaries> drawn;
    if (options.seed) drawn = drawn_coronaries(*options.seed);
    VesselTree tree = drawn ? tree_of(drawn->draft, "heart.toml") : vessels_for("heart", options);
    if (drawn) {
        tree.made_by = crn::formatted("heart --seed %s", std::to_string(drawn->seed).c_str());
        tree.seed = drawn->seed;
    }
    make_heart_scene(options, tree, patient_bodies(tree, options.fineness));
    if (drawn) {
        const std::string file = (options.folder / "vessels.toml").string();
        crn::write_whole_file(file, coronary_file_text(*drawn));
        print_drawn(file, *drawn);
    }
    return 0;
}

/* The options of `anatomy beat`. */
struct BeatOptions {
    crn::bake::MeshText mesh;
    std::filesystem::path folder;
    std::vector<double> left_mm, right_mm, apex_mm;
};

/* Moves the mesh of another heart in the same way as the shipped heart beats. */
int make_beat(const BeatOptions &options)
{
    crn::check_output_folder({"--output", options.folder.string()});
    const auto place = [](const std::vector<double> &xyz) { return Vec3(xyz[0], xyz[1], xyz[2]); };
    const HeartPlacement placement =
        place_heart({place(options.left_mm), place(options.right_mm), place(options.apex_mm)});
    const crn::bake::Mesh mesh = crn::bake::load_mesh(options.mesh);
    Mesh rest{{mesh.vertices_mm.begin(), mesh.vertices_mm.end()}, {}};
    for (const auto &triangle : mesh.triangles)
        rest.triangles.push_back({triangle[0], triangle[1], triangle[2]});
    const std::string name = file_stem(options.folder.filename().string());
    const double longest_mm = write_borrowed_beat(options.folder, name, rest, placement);
    std::printf("the other heart is %.2f times as large as the shipped one; places are off by %.1f (left "
                "ostium), %.1f "
                "(right ostium) and %.1f mm (apex)\n",
                1.0 / placement.scale, placement.residual_mm[0], placement.residual_mm[1],
                placement.residual_mm[2]);
    std::printf("%s: %zu vertices in %d frames, which go %.1f mm at most\n", options.folder.string().c_str(),
                rest.vertices_mm.size(), BEAT_FRAMES, longest_mm);
    return 0;
}

void add_beat_options(CLI::App &command, BeatOptions &options)
{
    command.add_option("MESH", options.mesh.file, "Its mesh at the end of diastole: STL, OBJ, PLY or glTF")
        ->type_name("FILE")
        ->required();
    command
        .add_option("-o,--output", options.folder, "Folder for the 24 meshes; the inhaled one goes beside it")
        ->type_name("FOLDER")
        ->group("Outputs")
        ->required();
    options.mesh.placement.unit = "mm";
    command.add_option("--unit", options.mesh.placement.unit, "Of the mesh")
        ->check(crn::one_of({"mm", "cm", "m"}))
        ->capture_default_str();
    command
        .add_option("--part", options.mesh.parts,
                    "Only nodes of this name, which may end in *; may be given often")
        ->take_all();
    const HeartLandmarks shipped = shipped_landmarks();
    const auto place = [&](const char *name, std::vector<double> &xyz, const char *what, const Vec3 &there) {
        const std::string text =
            crn::formatted("%s: X Y Z in mm, patient frame (in the shipped heart %.1f %.1f %.1f)", what,
                           there.x(), there.y(), there.z());
        command.add_option(name, xyz, text)->expected(3)->required();
    };
    place("--left", options.left_mm, "where the left coronary artery begins", shipped.left_ostium_mm);
    place("--right", options.right_mm, "where the right one begins", shipped.right_ostium_mm);
    place("--apex", options.apex_mm, "the heart's apex", shipped.apex_mm);
}

int check(const std::filesystem::path &folder)
{
    bool is_good = true;
    for (const crn::mesh::SequenceReport &report :
         crn::mesh::check_sequence(crn::mesh::read_sequence(folder))) {
        std::printf("%-20s %7zu vertices %7zu triangles  step %6.2f, to the first frame %6.2f%s%s\n",
                    report.body.c_str(), report.vertices, report.triangles, report.step_max, report.wrap_max,
                    report.fault.empty() ? "" : ": ", report.fault.c_str());
        is_good = is_good && report.fault.empty();
    }
    std::printf("%s: %s\n", folder.string().c_str(), is_good ? "good" : "not usable as a beat");
    return is_good ? 0 : 1;
}

/* Prints one line for each given diameter, with its place in the vessel and the source of its value. Tabs
 * separate the values of a line, so that scripts can read the lines. */
int list(const VesselTree &tree)
{
    std::vector<Vessel> vessels = tree.vessels;
    vessels.insert(vessels.end(), tree.small.begin(), tree.small.end());
    std::printf("vessel\tstation\tdiameter_mm\tx_mm\ty_mm\tz_mm\ttangent_x\ttangent_y\ttangent_z\tsource\n");
    for (const Vessel &vessel : vessels) {
        const Curve curve = vessel_curve(vessel, 1.0);
        for (const Station &station : vessel.stations) {
            if (station.name.empty()) continue;
            size_t index = 0;
            for (size_t i = 0; i < curve.size(); i++)
                if ((curve[i].position_mm - station.position_mm).norm() <
                    (curve[index].position_mm - station.position_mm).norm())
                    index = i;
            const Vec3 tangent = curve_tangent(curve, index);
            std::printf("%s\t%s\t%.2f\t%.1f\t%.1f\t%.1f\t%.4f\t%.4f\t%.4f\t%s\n", vessel.name.c_str(),
                        station.name.c_str(), station.diameter_mm, station.position_mm.x(),
                        station.position_mm.y(), station.position_mm.z(), tangent.x(), tangent.y(),
                        tangent.z(), station.source.c_str());
        }
        std::printf("%s\tlength\t%.1f\t\t\t\t\t\t\tmm along the centreline\n", vessel.name.c_str(),
                    curve.back().arc_mm);
    }
    return 0;
}

/* Reads the vessels either of a shipped anatomy, which is given by its name, or of a user's file, which is
 * given by its path. */
VesselTree tree_named(const std::string &name)
{
    const std::vector<std::string> shipped = {"aorta", "heart", "phantom", "access"};
    if (std::find(shipped.begin(), shipped.end(), name) != shipped.end()) return shipped_vessels(name);
    if (name.find('/') == std::string::npos && !name.ends_with(".toml"))
        throw std::invalid_argument("there is no anatomy '" + name + "'" + crn::suggestion(name, shipped) +
                                    "; a file's name ends with .toml");
    return read_vessels(name);
}

void add_making_options(CLI::App &command, Options &options)
{
    command.add_option("-o,--output", options.folder, "Folder for scene.toml, meshes and centrelines")
        ->type_name("FOLDER")
        ->group("Outputs")
        ->required();
    command.add_option("--lumen-mm", options.fineness.lumen_voxel_mm, "Grid spacing of the lumen")
        ->check(CLI::Range(0.3, 3.0))
        ->capture_default_str();
    command
        .add_option("--lumen-from", options.lumen_from_mm,
                    "Diameter in mm from which small arteries, else picture and flow only, are a part of the "
                    "lumen: instruments can enter them")
        ->check(CLI::Range(0.8, 5.0));
    command
        .add_option("--body-scale", options.fineness.body_scale,
                    "Multiplies the grid spacing of every body (1.1-4 mm)")
        ->check(CLI::Range(0.5, 4.0))
        ->capture_default_str();
    command.add_flag("!--no-bodies", options.bodies, "Only lumen, centrelines and scene");
    command
        .add_option(
            "--lesion", options.lesions,
            "A stenosis, BRANCH:PERCENT:LENGTH_MM:AT_MM[:ECCENTRICITY[:PLAQUE_DEG[:CALCIFIED_DEG]]], by "
            "diameter, its middle AT_MM behind the ostium; may be given often")
        ->take_all();
    command
        .add_option("--threads", options.threads,
                    "Bodies that are meshed at the same time; the files do not depend on it")
        ->check(CLI::Range(1u, 64u))
        ->capture_default_str();
    command.add_flag("--quiet", options.quiet, "No progress lines on the terminal");
}

void add_vessels_option(CLI::App &command, Options &options)
{
    command
        .add_option("--vessels", options.vessels,
                    "A file of your own vessels in place of those that ship (docs/vessels.md)")
        ->type_name("FILE");
}

template <typename Seed> CLI::Option *add_seed(CLI::App &command, Seed &seed)
{
    return command
        .add_option("--seed", seed, "Draws other arteries: branches, courses, diameters (docs/vessels.md)")
        ->type_name("N")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{UINT32_MAX}));
}

void add_draw_options(CLI::App &command, DrawOptions &options)
{
    add_seed(command, options.seed)->required();
    command.add_flag("--coronary", options.is_coronary,
                     "Draws coronary arteries that leave the shipped aorta, for `anatomy heart`");
    command.add_option("-o,--output", options.file, "The vessel file")
        ->type_name("FILE")
        ->group("Outputs")
        ->required();
}

constexpr const char *EXAMPLES =
    "Examples:\n"
    "  anatomy aorta -o out/aorta && bake out/aorta/scene.toml -o out/aorta.scene\n"
    "  anatomy phantom -o out/phantom\n"
    "  anatomy access -o out/access       a phantom with a long winding way in, to measure instruments "
    "in\n"
    "  anatomy heart -o out/heart         a beating heart: 24 frames in out/heart/beat\n"
    "  anatomy heart -o out/lad --lesion LAD:75:14:22\n"
    "  anatomy beat lumen.ply --left 14 507 23 --right 0 501 40 --apex 73 434 81 -o out/beat/lumen\n"
    "  anatomy check out/heart/beat       a folder of 24 OBJ files, from here or elsewhere\n"
    "  anatomy list            every stated diameter, its place and its source\n"
    "  anatomy list phantom\n"
    "  anatomy list my.toml    checks a file of your own vessels (docs/vessels.md)\n"
    "  anatomy aorta --vessels my.toml -o out/mine\n"
    "  anatomy aorta --seed 7 -o out/seven     another man's arteries, drawn from a seed\n"
    "  anatomy heart --seed 7 -o out/heart7    other coronary arteries, drawn from a seed\n"
    "  anatomy draw --seed 7 -o seven.toml     only the file of these arteries\n"
    "  anatomy person --seed 7 -o out/seven    another person: sex, age, size, weight, bones, arteries\n"
    "  anatomy person --seed 7 --sex f --age 81 --arch III --coronary -o out/old\n"
    "  anatomy seeds --count 10000             checks that every seed gives a plausible person";

int run(int argc, char **argv)
{
    CLI::App app{"Makes the anatomy that ships with Cournand: closed meshes, centrelines and the scene text "
                 "for `bake`",
                 "anatomy"};
    app.footer(EXAMPLES);
    app.require_subcommand(1);
    Options options;
    auto *aorta = app.add_subcommand(
        "aorta", "A man's arteries from the groins to the arch, with bones, lungs and skin");
    auto *phantom = app.add_subcommand("phantom", "Aorto-iliac and renal silicone phantom for benchmarks");
    auto *access = app.add_subcommand(
        "access", "Silicone phantom with a long winding access, to measure instruments in; lumen only");
    auto *heart = app.add_subcommand(
        "heart", "The same man with coronary arteries and a heart that beats, in 24 frames of one topology");
    auto *beat = app.add_subcommand(
        "beat", "The shipped heart's beat for the mesh of another heart, known in one phase only");
    auto *checked = app.add_subcommand(
        "check", "Whether a folder of 24 OBJ files is a beat: topology, inverted faces, jump at the wrap");
    auto *table = app.add_subcommand("list", "Stated diameters with position and source, tab separated");
    for (CLI::App *command : {aorta, phantom, access, heart}) {
        add_making_options(*command, options);
        add_vessels_option(*command, options);
    }
    heart
        ->add_flag("--heart-only", options.heart_only,
                   "Only the heart and its vessels, without scene and lumen")
        ->excludes("--lesion"); // a lesion belongs to a scene
    DrawOptions draw_options;
    add_seed(*aorta, options.seed)->excludes("--vessels");
    add_seed(*heart, options.seed)->excludes("--vessels");
    auto *drawn =
        app.add_subcommand("draw", "A vessel file with the arteries of another man, drawn from a seed");
    add_draw_options(*drawn, draw_options);
    PersonCommand person_command(app,
                                 [](CLI::App &command, Options &all) { add_making_options(command, all); });
    BeatOptions beat_options; // their help states where the heart that ships has its landmarks
    const std::string_view first = argc > 1 ? argv[1] : "";
    if (first == "beat" || first == "--generate" || first == "--complete")
        add_beat_options(*beat, beat_options);
    std::filesystem::path folder;
    checked->add_option("FOLDER", folder, "The folder of OBJ files")->type_name("FOLDER")->required();
    std::string which = "aorta";
    table->add_option("anatomy", which, "Aorta, heart, phantom or access, or a file of your own vessels")
        ->capture_default_str();
    app.set_version_flag("--version", crn::version_of("anatomy"));
    if (const std::optional<int> code = crn::parse_command_line(app, argc, argv)) return *code;
    if (*table) return list(tree_named(which));
    if (*checked) return check(folder);
    if (*drawn) return draw(draw_options);
    if (*beat) return make_beat(beat_options);
    if (const std::optional<int> code = person_command.run()) return *code;
    if (*heart) return make_heart(options);
    if (*aorta) return make(options, "aorta", shipped_man);
    if (*access) return make(options, "access", no_bodies);
    return make(options, "phantom", phantom_bodies);
}

} // namespace

int main(int argc, char **argv)
{
    try {
        return run(argc, argv);
    } catch (const std::invalid_argument &error) {
        crn::say(stderr, "anatomy: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "anatomy: %s\n", error.what());
        return 1;
    }
}
