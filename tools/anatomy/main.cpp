/* anatomy: makes the anatomy that ships with Seldinger. See docs/anatomy.md. */
#include "tools/anatomy/output.hpp"
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <openvdb/openvdb.h>

namespace
{

using namespace anatomy;

struct Options {
    std::filesystem::path folder;
    Fineness fineness;
    bool bodies = true, quiet = false;
};

/* Meshes one thing, says so on standard error, and writes it. */
size_t make_mesh(const Options &options, const std::string &name, const MeshRequest &request)
{
    const auto start = std::chrono::steady_clock::now();
    Mesh mesh;
    try {
        mesh = mesh_of(request);
    } catch (const std::exception &error) {
        throw std::runtime_error(name + ": " + error.what() + "; try a finer --bodies-mm or --lumen-mm");
    }
    write_ply(options.folder / (file_stem(name) + ".ply"), mesh,
              "Seldinger anatomy, " + name + ", millimetres");
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    if (!options.quiet)
        std::fprintf(stderr, "  %-20s %7zu triangles  %8.1f cm3  %5.1f s\n", name.c_str(),
                     mesh.triangles.size(), mesh_volume_mm3(mesh) * 1e-3, passed.count());
    return mesh.triangles.size();
}

int make(const Options &options, const VesselTree &tree, const std::vector<Body> &bodies)
{
    std::error_code failure;
    std::filesystem::create_directories(options.folder, failure);
    if (failure)
        throw std::runtime_error(options.folder.string() +
                                 ": the folder cannot be made: " + failure.message());
    const size_t lumen = make_mesh(options, "lumen", lumen_request(tree, options.fineness));
    for (const Vessel &vessel : tree.vessels)
        write_centreline(options.folder / (file_stem(vessel.name) + ".mrk.json"), vessel);
    size_t total = 0;
    const std::vector<Body> made = options.bodies ? bodies : std::vector<Body>{};
    for (const Body &body : made) total += make_mesh(options, body.name, body.request);
    write_scene(options.folder / "scene.toml", tree, made);
    std::printf("%s: lumen %zu triangles, %zu bodies with %zu triangles, %zu centrelines\n",
                (options.folder / "scene.toml").string().c_str(), lumen, made.size(), total,
                tree.vessels.size());
    return 0;
}

/* One line per stated diameter: where it holds and where it comes from. Tab separated, so that scripts can read it. */
int list(const VesselTree &tree)
{
    std::printf("vessel\tstation\tdiameter_mm\tx_mm\ty_mm\tz_mm\ttangent_x\ttangent_y\ttangent_z\tsource\n");
    for (const Vessel &vessel : tree.vessels) {
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

void add_making_options(CLI::App &command, Options &options)
{
    command.add_option("-o,--output", options.folder, "folder for scene.toml, meshes and centrelines")
        ->required();
    command.add_option("--lumen-mm", options.fineness.lumen_voxel_mm, "grid spacing of the lumen")
        ->check(CLI::Range(0.3, 3.0))
        ->capture_default_str();
    command
        .add_option("--body-scale", options.fineness.body_scale,
                    "multiplies the grid spacing of every body (1.1-4 mm)")
        ->check(CLI::Range(0.5, 4.0))
        ->capture_default_str();
    command.add_flag("!--no-bodies", options.bodies, "only lumen, centrelines and scene");
    command.add_flag("--quiet", options.quiet, "no progress lines");
}

} // namespace

int main(int argc, char **argv)
{
    CLI::App app{"Makes the anatomy that ships with Seldinger: closed meshes, centrelines and the scene text "
                 "for `bake`."};
    app.footer("Examples:\n"
               "  anatomy aorta -o out/aorta && bake out/aorta/scene.toml -o out/aorta.seld\n"
               "  anatomy phantom -o out/phantom\n"
               "  anatomy list            every stated diameter, its place and its source\n"
               "  anatomy list phantom");
    app.require_subcommand(1);
    Options options;
    auto *aorta = app.add_subcommand(
        "aorta", "a man's arteries from the groins to the arch, with bones, lungs and skin");
    auto *phantom = app.add_subcommand("phantom", "aorto-iliac and renal silicone phantom for benchmarks");
    auto *table = app.add_subcommand("list", "stated diameters with position and source, tab separated");
    add_making_options(*aorta, options);
    add_making_options(*phantom, options);
    std::string which = "aorta";
    table->add_option("anatomy", which, "aorta or phantom")
        ->check(CLI::IsMember({"aorta", "phantom"}))
        ->capture_default_str();
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        if (*table) return list(which == "aorta" ? aorta_tree() : phantom_tree());
        openvdb::initialize();
        if (*aorta)
            return make(options, aorta_tree(),
                        options.bodies ? patient_bodies(options.fineness) : std::vector<Body>{});
        return make(options, phantom_tree(), phantom_bodies(options.fineness));
    } catch (const std::exception &error) {
        std::fprintf(stderr, "anatomy: %s\n", error.what());
        return 1;
    }
}
