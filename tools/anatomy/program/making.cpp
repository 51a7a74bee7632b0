#include "tools/anatomy/program/making.hpp"
#include "host/base/command_values.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/text.hpp"
#include "tools/anatomy/lesions.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace anatomy
{

VesselTree vessels_for(const std::string &kind, const Options &options)
{
    if (options.vessels.empty()) return shipped_vessels(kind);
    VesselTree tree = read_vessels(options.vessels);
    const auto refuse = [&](const std::string &what) {
        throw std::invalid_argument(options.vessels + ": " + what);
    };
    if ((kind == "aorta" || kind == "heart") && !tree.is_in_patient)
        refuse("is in the frame of a phantom: use `anatomy phantom` or `anatomy access`, or give it frame = "
               "\"patient\"");
    if (kind != "heart" && tree.coronary_count > 0)
        refuse("has coronary arteries, which beat: use `anatomy heart`");
    if (kind == "heart")
        for (const Bed bed : {Bed::left_coronary, Bed::right_coronary})
            if (std::none_of(tree.vessels.begin(), tree.vessels.end(),
                             [bed](const Vessel &vessel) { return vessel.bed == bed; }))
                refuse(bed == Bed::left_coronary
                           ? "has no [[coronary]] of the left side, which `anatomy heart` needs"
                           : "has no [[coronary]] of the right side, which `anatomy heart` needs");
    tree.made_by = kind + " --vessels " + crn::printable(options.vessels);
    return tree;
}

void make_folder(const Options &options)
{
    crn::check_output_folder({"--output", options.folder.string()});
    std::error_code failure;
    std::filesystem::create_directories(options.folder, failure);
    if (failure)
        throw std::runtime_error(options.folder.string() +
                                 ": the folder cannot be made: " + failure.message());
}

namespace
{

/* Returns the [[lesion]] tables of the scene text for all lesions on the command line. The program makes the
 * text of the lesions before the meshes, so that a mistake on the command line is reported at once and not
 * after minutes. The calcium of a lesion is a part of the body that contains the vessels. */
std::string lesions_of(const Options &options, const VesselTree &tree, const std::vector<Body> &bodies)
{
    std::vector<Lesion> lesions;
    for (const std::string &wish : options.lesions) lesions.push_back(lesion_from(wish));
    std::string inside;
    for (const Body &body : bodies)
        if (body.name == "flesh" || body.name == "wall") inside = body.name;
    return lesions_text(lesions, tree, inside);
}

/* If a sphere of the lumen is narrower than the diagonal of a grid cell, it may contain no grid point. The
 * mesh of the lumen would have a gap at a sphere without grid points. */
void check_grid(const VesselTree &tree, double voxel_mm)
{
    const double narrowest_mm = std::sqrt(3.0) * voxel_mm;
    for (const Vessel &vessel : tree.vessels)
        for (const Station &station : vessel.stations) {
            if (station.diameter_mm >= narrowest_mm) continue;
            const double grid_mm = std::floor(100.0 * station.diameter_mm / std::sqrt(3.0)) / 100.0;
            throw std::invalid_argument(
                "'" + vessel.name + "' is " + crn::number_text(station.diameter_mm, 3) +
                " mm wide, too narrow for a grid of " + crn::number_text(voxel_mm, 3) +
                " mm: give --lumen-mm " + crn::decimals_text(grid_mm, 2));
        }
}

void report_mesh(const Options &options, const std::string &name, const Mesh &mesh, double seconds)
{
    if (!options.quiet && crn::shows_progress())
        std::fprintf(stderr, "  %-20s %7zu triangles  %8.1f cm3  %5.1f s\n", name.c_str(),
                     mesh.triangles.size(), mesh_volume_mm3(mesh) * 1e-3, seconds);
}

} // namespace

void make_bodies(const Options &options, const std::vector<Body> &bodies, const Keep &keep)
{
    std::vector<std::string> names;
    std::vector<MeshRequest> requests;
    for (const Body &body : bodies) {
        names.push_back(body.name);
        requests.push_back(body.request);
    }
    make_meshes(names, requests, options.threads, [&](size_t i, Mesh &&mesh, double seconds) {
        const std::string &name = bodies[i].name;
        write_ply(options.folder / (file_stem(name) + ".ply"), mesh,
                  "Cournand anatomy, " + name + ", millimetres");
        report_mesh(options, name, mesh, seconds);
        keep(name, mesh);
    });
}

void make_scene(const Options &options, const VesselTree &tree, const std::vector<Body> &bodies,
                const Keep &keep)
{
    const std::string lesions = lesions_of(options, tree, bodies);
    std::vector<Body> all = {{"lumen", "", "", lumen_request(tree, options.fineness)}};
    check_grid(tree, all.front().request.voxel_mm);
    all.insert(all.end(), bodies.begin(), bodies.end());
    make_folder(options);
    size_t lumen = 0, total = 0;
    make_bodies(options, all, [&](const std::string &name, const Mesh &mesh) {
        (name == "lumen" ? lumen : total) += mesh.triangles.size();
        keep(name, mesh);
    });
    for (const Vessel &vessel : tree.vessels)
        write_centreline(options.folder / (file_stem(vessel.name) + ".mrk.json"), vessel);
    write_scene(options.folder / "scene.toml", tree, bodies, lesions);
    std::printf("%s: lumen %zu triangles, %zu bodies with %zu triangles, %zu centrelines\n",
                (options.folder / "scene.toml").string().c_str(), lumen, bodies.size(), total,
                tree.vessels.size());
}

std::vector<Body> no_bodies(const VesselTree &, const Fineness &)
{
    return {};
}

} // namespace anatomy
