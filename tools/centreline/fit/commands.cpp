// Implements the commands of the program `centreline`. Each command reads files, does its work and writes
// files.
#include "tools/centreline/fit/commands.hpp"
#include "host/base/output_files.hpp"
#include "tools/bake/bake.hpp"
#include "tools/centreline/fit/axes.hpp"
#include "tools/centreline/fit/carry.hpp"
#include "tools/centreline/fit/editor.hpp"
#include "tools/centreline/fit/tree_picture.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/centreline/join.hpp"

#include <algorithm>
#include <cstdio>

namespace crn::centreline
{
namespace
{

bake::Cap cap_of(const std::string &word)
{
    return word == "any" ? bake::Cap::any : word == "flat" ? bake::Cap::flat : bake::Cap::none;
}

bake::MeshText mesh_text(const Options &options, const std::string &file)
{
    bake::MeshText text;
    text.file = file;
    text.parts = options.parts;
    text.placement.unit = options.unit;
    return text;
}

// Loads a mesh, or the lumen that a scene's text names, and transforms it to the patient's axes as the
// program `bake` does.
bake::Mesh load(const Options &options, const std::string &file, bake::Progress &progress)
{
    if (std::filesystem::path(file).extension() != ".toml") return bake::load_mesh(mesh_text(options, file));
    const bake::SceneText scene = bake::read_scene_text(file, {options.data, options.shipped});
    std::string report;
    if (scene.lumen.solid_mm > 0) return bake::solid_lumen(scene.lumen, report);
    if (scene.lumen.centrelines.empty()) return bake::load_mesh(scene.lumen.mesh);
    std::vector<Branch> lines;
    for (const std::filesystem::path &line : scene.lumen.centrelines)
        for (Branch &one : bake::read_centrelines(line, scene.lumen.mesh.placement))
            lines.push_back(std::move(one));
    return bake::surface_of(lines, scene.lumen.surface_mm, progress);
}

std::optional<Eigen::Vector3d> inlet_of(const Options &options)
{
    if (options.inlet_mm.size() != 3) return std::nullopt;
    return Eigen::Vector3d(options.inlet_mm[0], options.inlet_mm[1], options.inlet_mm[2]);
}

LumenWish lumen_wish(const Options &options)
{
    LumenWish wish;
    wish.voxel_mm = options.voxel_mm;
    wish.cap = cap_of(options.cap);
    return wish;
}

void print_notes(const std::vector<std::string> &notes)
{
    for (const std::string &note : notes) std::printf("note: %s\n", note.c_str());
}

// Prints one line per branch of the tree, with tabs between the values.
void print_tree(const Tree &tree, const std::vector<double> &flow_ml_min)
{
    std::printf("branch\tname\tparent\tspheres\tlength_mm\tradius_first_mm\tradius_last_mm\tflow_ml_"
                "min\tspeed_last_mm_s\n");
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &branch = tree.branches[b];
        const Sphere &first = branch.spheres[first_own_sphere(tree, b)], &last = branch.spheres.back();
        std::printf("%zu\t%s\t%d\t%zu\t%.1f\t%.2f\t%.2f\t%.1f\t%.0f\n", b, branch.name.c_str(), branch.parent,
                    branch.spheres.size(), length_mm(branch), first.radius_mm, last.radius_mm,
                    b < flow_ml_min.size() ? flow_ml_min[b] : 0.0, last.speed_mm_s);
    }
}

int finish(const Options &options, Tree &tree, const Lumen &lumen, const std::vector<std::string> &notes)
{
    const std::vector<double> flow = set_flow(tree, options.flow);
    write_tree(options.output, tree);
    print_tree(tree, flow);
    print_notes(lumen.notes());
    print_notes(notes);
    std::printf("written %s: %zu branches, %zu spheres, voxels of %.2f mm\n", options.output.c_str(),
                tree.branches.size(), sphere_count(tree), lumen.voxels().voxel_mm());
    return 0;
}

std::string frame_file(const std::string &folder, std::size_t number, std::size_t count)
{
    const std::string digits = std::to_string(number), widest = std::to_string(count - 1);
    return folder + "/tree_" + std::string(widest.size() - digits.size(), '0') + digits + ".csv";
}

} // namespace

int command_fit(const Options &options)
{
    check_outputs({{"MESH", options.mesh}, {"--points", options.points}}, {{"--output", options.output}});
    bake::Progress progress;
    const PointText text = read_points(options.points);
    const Lumen lumen(load(options, options.mesh, progress), lumen_wish(options), progress);
    std::vector<std::string> notes;
    Tree tree = fit_points(lumen, text.points, options.automatic.grow, notes, progress);
    return finish(options, tree, lumen, notes);
}

int command_auto(const Options &options)
{
    check_outputs({{"MESH", options.mesh}}, {{"--output", options.output}, {"--points", options.points}});
    bake::Progress progress;
    const Lumen lumen(load(options, options.mesh, progress), lumen_wish(options), progress);
    AutoWish wish = options.automatic;
    wish.inlet_mm = inlet_of(options);
    std::vector<std::string> notes;
    Tree tree = fit_automatic(lumen, wish, notes, progress);
    if (!options.points.empty()) write_points(options.points, {options.mesh, options.unit, points_of(tree)});
    return finish(options, tree, lumen, notes);
}

int command_convert(const Options &options)
{
    if (options.as_is && !options.inlet_mm.empty())
        throw UsageError(
            "convert: --as-is changes no curve, so it takes no --inlet: leave out one of the two");
    std::vector<NamedPath> inputs = {{"--radii-from", options.radii_from}};
    for (const std::string &input : options.inputs) inputs.push_back({"TREE", input});
    check_outputs(inputs, {{"--output", options.output}});
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    if (!options.axes.empty()) axes = turned_axes(options.axes);
    Tree all;
    for (const std::string &input : options.inputs) {
        Tree tree = read_tree(input, options.radii_from.empty());
        const int before = static_cast<int>(all.branches.size());
        for (Branch &branch : tree.branches) {
            if (branch.parent >= 0) branch.parent += before;
            for (Sphere &sphere : branch.spheres) sphere.centre_mm = axes * sphere.centre_mm;
            all.branches.push_back(std::move(branch));
        }
    }
    check_tree(all, options.inputs.size() == 1 ? options.inputs[0] : "the trees together");
    bake::Progress progress;
    if (!options.radii_from.empty()) {
        LumenWish wish = lumen_wish(options);
        wish.with_voxels = false;
        const Lumen lumen(load(options, options.radii_from, progress), wish, progress);
        for (Branch &branch : all.branches)
            for (Sphere &sphere : branch.spheres)
                sphere.radius_mm = std::max(1e-3, lumen.radius_mm(sphere.centre_mm));
        print_notes(lumen.notes());
    }
    for (Branch &branch : all.branches)
        for (Sphere &sphere : branch.spheres) sphere.radius_mm *= options.radii_times;
    const std::optional<Eigen::Vector3d> inlet_mm = inlet_of(options);
    std::vector<std::string> notes;
    if (!options.as_is) all = joined(all, inlet_mm ? &*inlet_mm : nullptr, &notes);
    print_notes(notes);
    if (options.split) all = split_at_junctions(all);
    write_tree(options.output, all);
    print_tree(all, {});
    std::printf("written %s: %zu branches, %zu spheres\n", options.output.c_str(), all.branches.size(),
                sphere_count(all));
    return 0;
}

int command_carry(const Options &options)
{
    bake::Progress progress;
    const std::vector<std::filesystem::path> files = frames_of(options.folder);
    std::vector<NamedPath> inputs = {{"TREE", options.tree}}, outputs;
    for (const std::filesystem::path &file : files) inputs.push_back({"FOLDER", file.string()});
    std::error_code error;
    std::filesystem::create_directories(options.output, error);
    if (error)
        throw Fault(options.output + ": the folder cannot be made: " + error.message() + ": name another");
    for (std::size_t n = 0; n < files.size(); ++n)
        outputs.push_back({"--output", frame_file(options.output, n, files.size())});
    check_outputs(inputs, outputs);
    const Tree tree = read_tree(options.tree);
    std::vector<Frame> frames = carried(tree, files, mesh_text(options, ""), lumen_wish(options), progress);
    std::printf("frame\tmesh\tmoved_mm\trefit_mm\n");
    for (std::size_t n = 0; n < frames.size(); ++n) {
        set_flow(frames[n].tree, options.flow);
        write_tree(outputs[n].path, frames[n].tree);
        std::printf("%zu\t%s\t%.2f\t%.2f\n", n, frames[n].name.c_str(), frames[n].moved_mm,
                    frames[n].refit_mm);
    }
    std::printf("written %zu trees of %zu branches and %zu spheres into %s\n", frames.size(),
                tree.branches.size(), sphere_count(tree), options.output.c_str());
    return 0;
}

int command_show(const Options &options)
{
    check_outputs({{"TREE", options.tree}, {"--mesh", options.mesh}, {"--points", options.points}},
                  {{"--output", options.output}});
    if (options.tree.empty() && !options.wireframe)
        throw UsageError("show: name a TREE, or give --wireframe to see the mesh alone");
    bake::Progress progress;
    const Tree tree = options.tree.empty() ? Tree{} : read_tree(options.tree);
    const bake::Mesh mesh = load(options, options.mesh, progress);
    std::vector<Point> points;
    if (!options.points.empty()) points = read_points(options.points).points;
    const View view = view_of(mesh, options.turn_deg, options.tilt_deg, options.size, options.size);
    TreeDrawing drawing;
    drawing.tree = &tree;
    drawing.points = points.empty() ? nullptr : &points;
    drawing.with_names = options.with_names;
    drawing.wires = options.wireframe ? &mesh : nullptr;
    const std::vector<float> glass =
        options.wireframe ? std::vector<float>(static_cast<std::size_t>(view.width) * view.height, 0.0f)
                          : glass_of(mesh, view);
    std::string error;
    if (!write_png(options.output, draw_tree(glass, view, drawing).image(), error)) throw Fault(error);
    std::printf("written %s: %zu branches, %zu spheres\n", options.output.c_str(), tree.branches.size(),
                sphere_count(tree));
    return 0;
}

int command_edit(const Options &options)
{
    check_outputs(
        {{"MESH", options.mesh}},
        {{"--project", options.project}, {"--output", options.output}, {"--screenshot", options.screenshot}});
    bake::Progress progress;
    Project project(options.project, options.mesh, options.unit);
    const Lumen lumen(load(options, options.mesh, progress), lumen_wish(options), progress);
    print_notes(lumen.notes());
    EditorWish wish;
    wish.output = options.output;
    wish.screenshot = options.screenshot;
    wish.frames = options.frames;
    wish.automatic = options.automatic;
    wish.flow = options.flow;
    return run_editor(lumen, project, wish, progress);
}

} // namespace crn::centreline
