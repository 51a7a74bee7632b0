#include "tools/patient/options.hpp"
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"

#include <cstdio>

namespace crn::patient
{

void add_scene_options(CLI::App &command, SceneOptions &options)
{
    SceneWish &wish = options.wish;
    command.add_option("-o,--output", options.folder, "Folder of the scene")
        ->type_name("FOLDER")
        ->group("Outputs")
        ->required();
    command
        .add_option("--solid-mm", wish.lumen.solid_mm,
                    "Voxel in which parts become one; 0: by the vessels' size")
        ->check(CLI::Range(0.0, 2.0))
        ->capture_default_str();
    command.add_option("--bridge-mm", wish.lumen.bridge_mm, "Gaps between parts that are bridged")
        ->check(CLI::Range(0.0, 30.0))
        ->capture_default_str();
    command.add_option("--shortest-mm", wish.shortest_mm, "Branches that are kept")
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
    command.add_option("--inlet", options.inlet_mm, "x y z in the scene, mm: where the blood comes in")
        ->expected(3);
    command
        .add_option("--entry", options.entry_mm,
                    "x y z in the scene, mm: instruments enter at the end nearest to it")
        ->expected(3);
    command.add_option("--branches", wish.names, "Named by: auto, aorta, parts or numbers")
        ->check(one_of({"auto", "aorta", "parts", "numbers"}))
        ->capture_default_str();
    command.add_option("--name", wish.name, "Of the scene")->capture_default_str();
    command
        .add_option("--body", wish.bodies,
                    "A body for the picture, like cortical_bone:pelvis.stl; repeatable")
        ->type_name("MATERIAL:FILE");
    command.add_flag("!--no-bodies", wish.has_bodies, "No tissue and no blood in the picture");
}

void add_mesh_options(CLI::App &command, SceneOptions &options)
{
    SceneWish &wish = options.wish;
    command.add_option("--part", wish.parts.parts,
                       "Only this part of the files; may end in *, may be repeated");
    command.add_option("--unit", wish.parts.unit, "Of the meshes: m, cm, mm or um; else found")
        ->check(one_of({"m", "cm", "mm", "um"}));
    command.add_option(
        "--axes", wish.parts.axes,
        "lps, ras, or the file's axes that are left, head and front, like +x,+z,-y; else found");
    command.add_option("--walls", wish.lumen.walls, "auto; lumen: meshes are lumens; wall: they are walls")
        ->check(one_of({"auto", "lumen", "wall"}))
        ->capture_default_str();
}

SceneWish wish_of(const SceneOptions &options)
{
    check_output_folder({"--output", options.folder});
    SceneWish wish = options.wish;
    wish.folder = options.folder;
    const auto place_of = [](const std::vector<double> &numbers) -> std::optional<Eigen::Vector3d> {
        if (numbers.size() != 3) return std::nullopt;
        return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
    };
    wish.lumen.inlet_mm = place_of(options.inlet_mm);
    wish.entry_mm = place_of(options.entry_mm);
    return wish;
}

void make_and_tell(const std::function<void(Choices &, bake::Progress &)> &make, const SceneWish &wish)
{
    Choices choices;
    bake::Progress progress;
    try {
        make(choices, progress);
    } catch (...) {
        std::fputs(choices.text("").c_str(), stdout);
        throw;
    }
    std::fputs(choices.text("").c_str(), stdout);
    const std::string folder = wish.folder.string();
    std::printf(
        "written %s: patient.scene, patient.bodies, practice.session\n"
        "next: cournand run %s/practice.session, or cournand view --scene %s/patient.scene --tool j_wire\n",
        folder.c_str(), folder.c_str(), folder.c_str());
}

} // namespace crn::patient
