// Command line of `centreline` (docs/centreline.md).
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "host/cli/parse.hpp"
#include "tools/centreline/fit/commands.hpp"
#include "tools/centreline/program/patient_command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>

namespace
{

using crn::centreline::Options;

constexpr const char *examples =
    "Examples:\n"
    "  centreline edit coronaries.obj --project lca.toml -o lca.csv    click the points, F fits, Esc saves\n"
    "  centreline fit coronaries.obj --points lca.toml -o lca.csv      the same without a window\n"
    "  centreline auto build/anatomy/aorta/scene.toml -o aorta.vtp     everything from the mesh\n"
    "  centreline carry lca.csv frames/ -o out/lca                     through all frames of a beating "
    "heart\n"
    "  centreline convert a.mrk.json b.mrk.json -o tree.vtp            curves become a tree\n"
    "  centreline patient atlas.glb -o mine                            a playable scene, in one command\n"
    "  centreline show lca.csv --mesh coronaries.obj -o lca.png        a picture, manual points red\n"
    "Trees: .csv, .mrk.json (3D Slicer), .vtp (VMTK), .obj.\n"
    "Meshes: .stl, .obj, .ply, .gltf, .glb, or a scene's .toml.\n"
    "Exit codes: 0 done, 1 the input is unusable (the message says why), 2 usage.\n";

void add_mesh_options(CLI::App &command, Options &options)
{
    command.add_option("--unit", options.unit, "Of the mesh: m, cm, mm or um")
        ->check(crn::one_of({"m", "cm", "mm", "um"}))
        ->capture_default_str();
    command.add_option("--part", options.parts,
                       "Only this part of the mesh file; may end in *, may be repeated");
    command.add_option("--cap", options.cap, "Openings that are closed: none, flat or any")
        ->check(crn::one_of({"none", "flat", "any"}))
        ->capture_default_str();
    command.add_option("--data", options.data, "Folder of paths beginning with data: in a scene's text")
        ->type_name("FOLDER")
        ->capture_default_str();
    command.add_option("--shipped", options.shipped, "Folder of paths beginning with shipped:")
        ->type_name("FOLDER")
        ->capture_default_str();
}

void add_fit_options(CLI::App &command, Options &options)
{
    command
        .add_option("--voxel-mm", options.voxel_mm,
                    "Grid for the ways; 0: by the size of the vessel, 0.15 to 1 mm")
        ->check(CLI::Range(0.0, 5.0))
        ->capture_default_str();
    command.add_option("--spacing", options.automatic.grow.spacing, "Of neighbouring spheres, in radii")
        ->check(CLI::Range(0.1, 2.0))
        ->capture_default_str();
    command.add_option("--inlet-mm-s", options.flow.inlet_mm_s, "Mean speed of the blood in each inlet")
        ->check(CLI::Range(0.1, 5000.0))
        ->capture_default_str();
    command.add_option("--inlet-ml-min", options.flow.inlet_ml_min, "Or its flow; 0: by the speed")
        ->check(CLI::Range(0.0, 50000.0))
        ->capture_default_str();
}

void add_auto_options(CLI::App &command, Options &options)
{
    command
        .add_option("--prune", options.automatic.prune,
                    "A branch goes on at least so many radii of the vessel it leaves")
        ->check(CLI::Range(0.0, 100.0))
        ->capture_default_str();
    command.add_option("--shortest-mm", options.automatic.shortest_mm, "And at least so far")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
}

void add_tree_output(CLI::App &command, Options &options, bool is_required)
{
    CLI::Option *output =
        command.add_option("-o,--output", options.output, "The tree: .csv, .mrk.json, .vtp or .obj")
            ->type_name("FILE")
            ->group("Outputs");
    if (is_required) output->required();
}

void add_mesh(CLI::App &command, Options &options)
{
    command.add_option("MESH", options.mesh, "The vessel's surface")->type_name("FILE")->required();
    add_mesh_options(command, options);
    add_fit_options(command, options);
}

void add_making(CLI::App &app, Options &options)
{
    CLI::App *fit = app.add_subcommand("fit", "Spheres between points that a person gave");
    add_mesh(*fit, options);
    fit->add_option("--points", options.points, "Start, end and bifurcation points (TOML)")
        ->type_name("FILE")
        ->required();
    add_tree_output(*fit, options, true);
    CLI::App *automatic = app.add_subcommand("auto", "The whole tree from the mesh alone");
    add_mesh(*automatic, options);
    add_auto_options(*automatic, options);
    automatic
        ->add_option("--inlet", options.inlet_mm,
                     "x y z, mm: where the blood comes in; else the widest opening or end")
        ->expected(3);
    automatic
        ->add_option("--points", options.points,
                     "Also write the points that were found, for `fit` and `edit`")
        ->type_name("FILE")
        ->group("Outputs");
    add_tree_output(*automatic, options, true);
    CLI::App *edit = app.add_subcommand("edit", "A window to set, drag and fit points; resumes its project");
    add_mesh(*edit, options);
    add_auto_options(*edit, options);
    edit->add_option("--project", options.project, "The points, saved with Ctrl-S and at the end")
        ->type_name("FILE")
        ->group("Outputs")
        ->required();
    edit->add_option("--frames", options.frames, "End after so many screens (for tests); 0: until Esc")
        ->check(CLI::Range(0, 1000000));
    edit->add_option("--screenshot", options.screenshot, "PNG of the last screen")
        ->type_name("FILE")
        ->group("Outputs");
    add_tree_output(*edit, options, false);
}

void add_using(CLI::App &app, Options &options)
{
    CLI::App *convert =
        app.add_subcommand("convert", "From one format to another; curves that touch become a tree");
    convert->add_option("TREE", options.inputs, "One file or several")->type_name("FILE")->required();
    convert->add_flag("--as-is", options.as_is, "Do not join curves");
    convert->add_flag("--split", options.split, "Branches end where others leave");
    convert
        ->add_option("--inlet", options.inlet_mm,
                     "x y z, mm: the tree begins at the curve with an end there; else at the widest")
        ->expected(3);
    convert->add_option("--radii-from", options.radii_from, "Measure the radii in this mesh")
        ->type_name("FILE");
    convert
        ->add_option("--radii-times", options.radii_times,
                     "Widen every sphere: vessels drawn too thin are blown up again")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    convert->add_option("--axes", options.axes,
                        "Turn: the file's axes that become x, y and z, like +x,+z,-y");
    add_mesh_options(*convert, options);
    add_tree_output(*convert, options, true);
    CLI::App *carry = app.add_subcommand("carry", "One tree through a folder of meshes with one topology");
    carry->add_option("TREE", options.tree, "The tree of the first mesh")->type_name("FILE")->required();
    carry->add_option("FOLDER", options.folder, "One mesh per frame, numbered")
        ->type_name("FOLDER")
        ->required();
    carry->add_option("-o,--output", options.output, "Folder for tree_00.csv, tree_01.csv ...")
        ->type_name("FOLDER")
        ->group("Outputs")
        ->required();
    add_mesh_options(*carry, options);
    CLI::App *show = app.add_subcommand("show", "A picture of mesh and spheres");
    show->add_option("TREE", options.tree, "The tree; not needed with --wireframe")->type_name("FILE");
    show->add_flag("--wireframe", options.wireframe,
                   "The mesh as its edges, nearer ones darker, instead of as glass");
    show->add_option("--mesh", options.mesh, "The vessel's surface")->type_name("FILE")->required();
    show->add_option("--points", options.points, "Points to draw too")->type_name("FILE");
    show->add_flag("--names", options.with_names, "Write the points' names");
    show->add_option("-o,--output", options.output, "The PNG to write")
        ->type_name("FILE")
        ->group("Outputs")
        ->required();
    show->add_option("--turn", options.turn_deg,
                     "Degrees about the head axis, above 0 from the patient's left")
        ->check(CLI::Range(-360.0, 360.0))
        ->capture_default_str();
    show->add_option("--tilt", options.tilt_deg, "Degrees towards the head")
        ->check(CLI::Range(-90.0, 90.0))
        ->capture_default_str();
    show->add_option("--size", options.size, "Pixels")->check(CLI::Range(100, 4000))->capture_default_str();
    add_mesh_options(*show, options);
}

int run(const std::string &command, const Options &options, const crn::patient::SceneOptions &scene,
        const std::vector<std::string> &meshes)
{
    using namespace crn::centreline;
    if (command == "fit") return command_fit(options);
    if (command == "auto") return command_auto(options);
    if (command == "convert") return command_convert(options);
    if (command == "carry") return command_carry(options);
    if (command == "show") return command_show(options);
    if (command == "patient") return crn::patient::command_patient(scene, meshes);
    return command_edit(options);
}

} // namespace

int main(int argc, char **argv)
{
    Options options;
    crn::patient::SceneOptions scene;
    std::vector<std::string> meshes;
    if (const char *folder = std::getenv("CRN_ANATOMY")) options.data = folder;
    CLI::App app{"Vessel trees of inscribed spheres, from a mesh and a few points, or from the "
                 "mesh alone",
                 "centreline"};
    app.footer(examples);
    app.require_subcommand(1);
    add_making(app, options);
    add_using(app, options);
    crn::patient::add_patient(app, scene, meshes);
    app.set_version_flag("--version", crn::version_of("centreline"));
    if (const std::optional<int> code = crn::parse_command_line(app, argc, argv)) return *code;
    crn::bake::Progress::catch_interrupts();
    try {
        return run(app.get_subcommands().front()->get_name(), options, scene, meshes);
    } catch (const crn::UsageError &error) {
        crn::say(stderr, "centreline: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "centreline: %s\n", error.what());
    }
    return 1;
}
