#include "tools/anatomy/program/making.hpp"
#include "host/base/command_values.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "tools/anatomy/heart_sequence.hpp"
#include "tools/anatomy/lesions.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/small/small_tree.hpp"
#include "tools/anatomy/small/stated.hpp"
#include "tools/anatomy/soft/breath.hpp"
#include "tools/anatomy/varied/persons.hpp"
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
void check_width(const std::string &name, double diameter_mm, double voxel_mm)
{
    if (diameter_mm >= std::sqrt(3.0) * voxel_mm) return;
    const double grid_mm = std::floor(100.0 * diameter_mm / std::sqrt(3.0)) / 100.0;
    throw std::invalid_argument("'" + name + "' is " + crn::number_text(diameter_mm, 3) +
                                " mm wide, too narrow for a grid of " + crn::number_text(voxel_mm, 3) +
                                " mm: give --lumen-mm " + crn::decimals_text(grid_mm, 2));
}

void check_grid(const VesselTree &tree, double voxel_mm)
{
    for (const Vessel &vessel : tree.vessels)
        for (const Station &station : vessel.stations)
            check_width(vessel.name, station.diameter_mm, voxel_mm);
}

void enlarge(std::vector<Vec3> &points, double factor)
{
    if (factor != 1.0)
        for (Vec3 &point : points) point *= factor;
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
        if (mesh.triangles.empty()) return; // one that may be empty
        keep(name, mesh);
        enlarge(mesh.vertices_mm, options.scale);
        write_ply(options.folder / (file_stem(name) + ".ply"), mesh,
                  "Cournand anatomy, " + name + ", millimetres");
        report_mesh(options, name, mesh, seconds);
    });
}

/* Returns the vessels that are picture and flow only, with those of the shipped patient. */
static std::vector<SmallVessel> small_vessels(VesselTree tree)
{
    if (tree.is_in_patient) add_stated_branches(tree);
    return small_vessels_of(tree);
}

static void enlarge(std::vector<SmallVessel> &vessels, double factor)
{
    for (SmallVessel &vessel : vessels)
        for (CurvePoint &point : vessel.points) {
            point.position_mm *= factor;
            point.radius_mm *= factor;
        }
}

/* Returns the request of the lumen, with the small arteries that the options count to it. */
static MeshRequest lumen_of(const Options &options, const VesselTree &tree,
                            const std::vector<SmallVessel> &small)
{
    if (options.lumen_from_mm <= 0.0) return lumen_request(tree, options.fineness);
    const double from_mm = options.lumen_from_mm / options.scale;
    const MeshRequest request = lumen_request(tree, options.fineness, wide_arteries(tree, small, from_mm));
    check_width("an artery of --lumen-from", from_mm, request.voxel_mm);
    return request;
}

void make_scene(const Options &options, const VesselTree &tree, const std::vector<Body> &bodies,
                const Keep &keep)
{
    const VesselTree written = enlarged(tree, options.scale);
    const std::string lesions = lesions_of(options, written, bodies);
    std::vector<SmallVessel> small = small_vessels(tree);
    std::vector<Body> all = {{"lumen", "", "", lumen_of(options, tree, small)}};
    check_grid(tree, all.front().request.voxel_mm);
    all.insert(all.end(), bodies.begin(), bodies.end());
    make_folder(options);
    size_t lumen = 0, total = 0;
    std::vector<Body> made; // without those that came out empty
    make_bodies(options, all, [&](const std::string &name, const Mesh &mesh) {
        (name == "lumen" ? lumen : total) += mesh.triangles.size();
        for (const Body &body : bodies)
            if (body.name == name) made.push_back(body);
        keep(name, mesh);
    });
    for (const Vessel &vessel : written.vessels)
        write_centreline(options.folder / (file_stem(vessel.name) + ".mrk.json"), vessel);
    enlarge(small, options.scale);
    const char *small_file = small.empty() ? "" : "small_vessels.csv";
    if (!small.empty())
        crn::write_whole_file((options.folder / small_file).string(), small_vessels_text(small));
    write_scene(options.folder / "scene.toml", written, made, lesions, small_file);
    std::printf(
        "%s: lumen %zu triangles, %zu bodies with %zu triangles, %zu centrelines, %zu small vessels\n",
        (options.folder / "scene.toml").string().c_str(), lumen, made.size(), total, tree.vessels.size(),
        small.size());
}

void make_breathing_scene(const Options &options, const VesselTree &tree, std::vector<Body> bodies,
                          const Person &person)
{
    const Breath breath(tree, person);
    for (Body &body : bodies) body.is_breathing = breathes(body.name);
    make_scene(options, tree, bodies, [&](const std::string &name, const Mesh &mesh) {
        if (!breathes(name)) return;
        Mesh inhaled{breath.inhaled(mesh.vertices_mm), mesh.triangles};
        enlarge(inhaled.vertices_mm, options.scale);
        write_ply(options.folder / (file_stem(name) + "_inhaled.ply"), inhaled,
                  "Cournand anatomy, " + name + " after a full breath, millimetres");
    });
}

std::vector<Body> no_bodies(const VesselTree &, const Fineness &)
{
    return {};
}

namespace
{

void print_figures(const HeartFigures &f)
{
    const auto ml = [&](const std::vector<double> &volumes) {
        const auto [least, most] = std::minmax_element(volumes.begin(), volumes.end());
        return std::pair(*most, *least);
    };
    const auto [left_most, left_least] = ml(f.left_ml);
    const auto [right_most, right_least] = ml(f.right_ml);
    std::printf("left ventricle   %5.1f ml to %5.1f ml in frame %d: ejection fraction %.1f %%\n", left_most,
                left_least, f.systole_frame, 100.0 * f.left_ejection);
    std::printf("right ventricle  %5.1f ml to %5.1f ml: ejection fraction %.1f %%\n", right_most, right_least,
                100.0 * f.right_ejection);
    std::printf("base             descends %.1f mm, turns %+.1f deg as seen from the apex\n",
                f.base_descent_mm, f.base_turn_deg);
    std::printf("apex             turns %+.1f deg: twist %.1f deg\n", f.apex_turn_deg, f.twist_deg);
    std::printf("inner wall       %.0f %% of its motion is towards one centre, which wanders %.0f mm\n",
                100.0 * f.radial_share, f.centre_path_mm);
    std::printf("map              shrinks a volume to %.2f at most: nothing folds over\n",
                f.least_volume_factor);
    for (const VesselFigures &vessel : f.vessels)
        std::printf(
            "%-16s %5.1f mm long, moves %4.1f mm, rests %3.0f ms after systole and %3.0f ms in diastole\n",
            vessel.name.c_str(), vessel.length_mm, vessel.excursion_mm, vessel.systole_rest_ms,
            vessel.diastole_rest_ms);
}

/* The frames are moved in the shipped frame and scaled afterwards. */
void enlarge(HeartSequence &sequence, double factor)
{
    for (MovingBody &body : sequence.bodies) {
        for (std::vector<Vec3> &frame : body.frames_mm) enlarge(frame, factor);
        enlarge(body.inhaled_mm, factor);
    }
    for (MovingVessel &vessel : sequence.vessels)
        for (Curve &curve : vessel.frames)
            for (CurvePoint &point : curve) {
                point.position_mm *= factor;
                point.radius_mm *= factor;
                point.arc_mm *= factor;
            }
}

} // namespace

void make_heart_scene(const Options &options, const VesselTree &tree, std::vector<Body> bodies)
{
    const bool is_whole = options.bodies && !options.heart_only;
    if (!is_whole) // the figures need the chambers
        std::erase_if(bodies, [](const Body &body) { return !is_of_heart(body.name); });
    const HeartBeat beat(tree.vessels.front());
    HeartSequence sequence;
    for (const Vessel &vessel : coronary_arteries(tree))
        sequence.vessels.push_back(moving_vessel(vessel, beat));
    const auto keep = [&](const std::string &name, const Mesh &mesh) {
        if (moves_with_heart(name)) sequence.bodies.push_back(moving_body(name, mesh, beat));
        if (name == "lumen") write_lumen_frames(options.folder / "lumen_beat", mesh, beat, options.scale);
    };
    if (options.heart_only)
        make_folder(options);
    else
        make_scene(options, tree, is_whole ? bodies : std::vector<Body>{}, keep);
    if (!is_whole) make_bodies(options, bodies, keep);
    enlarge(sequence, options.scale);
    write_sequence(options.folder / "beat", sequence);
    HeartFigures figures = heart_figures(sequence);
    figures.least_volume_factor = beat.least_volume_factor();
    crn::write_whole_file((options.folder / "heart.json").string(), figures_json(figures));
    print_figures(figures);
    std::printf("%s: %zu bodies and %zu centrelines in %d frames\n",
                (options.folder / "beat").string().c_str(), sequence.bodies.size(), sequence.vessels.size(),
                BEAT_FRAMES);
}

} // namespace anatomy
