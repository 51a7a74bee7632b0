#include "tools/centreline/program/patient_command.hpp"
#include "host/base/output_files.hpp"

namespace crn::patient
{

void add_patient(CLI::App &app, SceneOptions &options, std::vector<std::string> &meshes)
{
    CLI::App *command =
        app.add_subcommand("patient", "A playable scene from vessel meshes: one file, or an atlas");
    command->add_option("MESH", meshes, "Surfaces of vessels: .stl, .obj, .ply, .vtp, .gltf, .glb")
        ->type_name("FILE")
        ->required();
    add_mesh_options(*command, options);
    add_scene_options(*command, options);
    command->footer("Examples:\n  centreline patient aorta.stl -o mine\n"
                    "  centreline patient atlas.glb --part 'VH_M_aortic*' -o mine\n"
                    "  cournand run mine/practice.session\n");
}

int command_patient(const SceneOptions &options, const std::vector<std::string> &meshes)
{
    std::vector<NamedPath> inputs;
    for (const std::string &mesh : meshes) inputs.push_back({"MESH", mesh});
    check_outputs(inputs, {});
    SceneWish wish = wish_of(options);
    wish.parts.files.assign(meshes.begin(), meshes.end());
    make_and_tell(
        [&](Choices &choices, bake::Progress &progress) {
            Frame frame;
            const std::vector<Part> parts = read_parts(wish.parts, choices, frame);
            make_scene_folder(parts, frame, wish, choices, progress);
        },
        wish);
    return 0;
}

} // namespace crn::patient
