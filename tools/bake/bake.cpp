// Contains the steps of `bake`: it reads the scene's text, makes the lumen's surface and distance field,
// measures the field, makes the bodies, and writes the files.
#include "tools/bake/bake.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "tools/bake/bodies.hpp"
#include "tools/bake/branches.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/form.hpp"
#include "tools/bake/lesion.hpp"
#include "tools/bake/small_vessels.hpp"
#include "tools/bake/solid.hpp"

#include <cmath>
#include <optional>

namespace crn::bake
{
namespace
{

constexpr std::size_t nesting_samples = 2000; // checked vertices of each body

std::string notes_of(const Mesh &mesh)
{
    std::string text;
    for (const std::string &note : mesh.notes) text += "note: " + mesh.name + ": " + note + "\n";
    return text;
}

constexpr double start_default_mm = 20.0; // readers assume it for a scene that states no start length
constexpr double start_radius_mm = 1.335, start_step_mm = 0.25;

CurvePoint entry_of(const SceneText &text, const TriangleTree &tree)
{
    CurvePoint entry{text.entry.position_mm, text.entry.direction};
    if (!text.entry.centreline.empty())
        entry = along(read_centreline(text.entry.centreline, text.lumen.mesh.placement), text.entry.from_last,
                      text.entry.distance_mm);
    const double distance = tree.nearest(entry.position_mm).distance_mm;
    if (distance > -1.0)
        throw Fault(text.file.string() + ": [entry] lies at " + place_text(entry.position_mm) + ", " +
                    (distance > 0 ? "outside the lumen" : "within 1 mm of its wall") +
                    ": move position_mm into the vessel (or raise distance_mm)");
    if (tree.nearest(entry.position_mm + 5 * entry.direction).distance_mm > 0)
        throw Fault(text.file.string() + ": [entry] at " + place_text(entry.position_mm) +
                    " points into the wall 5 mm ahead: turn direction into the vessel");
    return entry;
}

// Finds the longest start length (the inserted length of a tool at the start), in whole millimetres up to
// `start_default_mm`, for which a straight tool of 8 F does not touch the wall. In a vessel that is too
// narrow for a tool of 8 F, the tool's radius is taken as 80 % of the distance from the entry point to the
// wall. The check of the start length uses the core's own distance function, as the device does.
double clear_start_mm(const crn_lumen &lumen, const CurvePoint &entry)
{
    const auto room_mm = [&](double mm) {
        const crn_vec3 place = to_q30(entry.position_mm + mm * entry.direction);
        return -std::ldexp(crn_lumen_distance(&lumen, &place), -30) * 1e3;
    };
    const double radius_mm = std::min(start_radius_mm, 0.8 * room_mm(0.0));
    double mm = 0.0;
    while (mm < start_default_mm && room_mm(mm + start_step_mm) >= radius_mm) mm += start_step_mm;
    return std::max(1.0, std::floor(mm));
}

// Returns the start length for the scene file, or 0 for the length that readers of the file assume by
// default.
std::uint32_t start_um(const EntryText &text, const crn_lumen &lumen, const CurvePoint &entry,
                       std::string &report)
{
    const double clear_mm = clear_start_mm(lumen, entry);
    const double mm = text.inserted_mm > 0.0 ? text.inserted_mm : clear_mm;
    report +=
        formatted_line("start             %.1f mm inserted; a straight tool of 8 F has room for %.0f mm%s",
                       mm, clear_mm, clear_mm >= start_default_mm ? " or more" : "");
    return mm == start_default_mm ? 0 : static_cast<std::uint32_t>(std::lround(mm * 1e3));
}

// Makes the vessel tree from the centrelines in the table [tree], or from the lumen's centrelines if the
// scene's text has no such table. If the lumen's centrelines do not join, the scene gets no vessel tree, and
// the report states the reason.
VesselTree tree_of(const SceneText &text, std::string &report)
try {
    if (text.tree.centrelines.empty()) return {};
    std::vector<Curve> lines;
    for (const std::filesystem::path &file : text.tree.centrelines)
        for (Curve &line : read_centrelines(file, text.tree.placement)) lines.push_back(std::move(line));
    VesselTree tree = join_branches(lines, text.tree);
    report += branches_report(tree);
    if (!text.tree.small.empty()) {
        read_small_vessels(text.tree.small, tree);
        report += formatted_line("small vessels     %zu, picture and flow only", tree.small.size());
    }
    return tree;
} catch (const Fault &fault) {
    if (!text.tree.is_of_lumen) throw Fault(text.file.string() + ": " + fault.what());
    report += "note: no contrast medium in this scene, since its centrelines make no tree: " +
              std::string(fault.what()) + "\n";
    return {};
}

std::string field_report(const Field &field, const FieldError &error)
{
    std::string text = formatted_line(
        "bricks            %u (%u of 0.977 mm, %u of 0.488 mm, %u of 0.244 mm voxels), lattice %u x %u x %u",
        field.lumen.brick_count, field.bricks_of_level[0], field.bricks_of_level[1], field.bricks_of_level[2],
        field.lumen.brick_count_xyz[0], field.lumen.brick_count_xyz[1], field.lumen.brick_count_xyz[2]);
    text += formatted_line(
        "field error       50 %% %.4f, 99 %% %.4f, 99.9 %% %.4f, largest %.4f mm at %s (%zu points "
        "within %.1f mm)",
        error.median_mm, error.percent99_mm, error.permille999_mm, error.largest.mm,
        place_text(error.largest.place_mm).c_str(), error.points, error_band_mm);
    return text;
}

std::string referee_report(const Referee &referee, std::uint64_t seed)
{
    if (referee.poses == 0) return "libccd            no capsule of 0.835 mm radius fits into this lumen\n";
    return formatted_line(
        "libccd            worst disagreement %.4f mm at %s (%zu capsules of radius %.3f and length "
        "%.0f mm, %zu "
        "touching, seed %llu)",
        referee.disagreement.mm, place_text(referee.disagreement.place_mm).c_str(), referee.poses,
        referee.radius_mm, referee.length_mm, referee.touching, static_cast<unsigned long long>(seed));
}

std::string lattice_report(const crn_lattice &lattice, std::size_t numbers)
{
    return formatted("lattice %u x %u x %u nodes, %.2f mm apart, %.2f MiB", lattice.count_xyz[0],
                     lattice.count_xyz[1], lattice.count_xyz[2],
                     std::ldexp(mm_per_q30, static_cast<int>(lattice.spacing_log2_q30)),
                     static_cast<double>(numbers) * 2 / 1048576);
}

// Returns one line of the report per frame of the motion. Each report line states how far the lumen, as the
// core moves it, deviates from the mesh of that frame.
std::string motion_report(const Motion &motion, std::size_t pose, const std::vector<FrameError> &errors)
{
    std::string text = "motion            " + lattice_report(motion.lattices.beat, motion.rows.size()) +
                       formatted_line("; pose of keyframe %zu", pose);
    if (!motion.inhaled.empty())
        text += "breath            " + lattice_report(motion.lattices.breath, motion.inhaled.size()) + "\n";
    const Steepness steepest = steepness(motion);
    text += formatted_line(
        "  steepest  %.2f of a spacing per spacing in a beat, allowed %.3f; %.2f in a breath, allowed %.3f",
        steepest.heart.mm, heart_steepness_max, steepest.breath.mm, breath_steepness_max);
    Worst small, large, along;
    for (std::size_t k = 0; k < errors.size(); ++k) {
        const FrameError &e = errors[k];
        const std::string name = k < frames_count ? "frame " + std::to_string(k) : "inhaled";
        text += formatted_line(
            "  %-9s moved lumen and moved mesh: rms %.3f, at most %.3f mm in vessels below %.1f mm radius, "
            "%.3f mm elsewhere; along the wall %.3f mm",
            name.c_str(), e.rms_mm, e.small.mm, small_vessel_mm, e.large.mm, e.along.mm);
        small.take(e.small.mm, e.small.place_mm);
        large.take(e.large.mm, e.large.place_mm);
        along.take(e.along.mm, e.along.place_mm);
    }
    text += formatted_line("  worst     %.3f mm at %s in small vessels, %.3f mm at %s elsewhere", small.mm,
                           place_text(small.place_mm).c_str(), large.mm, place_text(large.place_mm).c_str());
    if (small.mm > 0.3 || large.mm > 1.0)
        text += formatted_line(
            "warning: the moved lumen is farther from the frames than 0.3 mm in small vessels or 1 mm "
            "elsewhere: lower spacing_mm");
    return text;
}

// Returns the mesh of the lumen in the reference pose, which is the pose that the distance field describes.
Mesh posed_lumen(const SceneText &text, const Frames &frames, Progress &progress)
{
    Mesh mesh = load_mesh(text.lumen.mesh);
    mesh.vertices_mm = frames.lumen.reference_mm;
    mesh.name += ", moved to keyframe " + std::to_string(frames.pose);
    check_closed(mesh, text.lumen.mesh.cap);
    check_crossing(mesh, progress);
    return mesh;
}

// The introducer sheath does not move, so the vessel wall should not move where the sheath enters the vessel.
std::string entry_report(const Motion &motion, const Eigen::Vector3d &entry_mm)
{
    constexpr double still_mm = 0.1;
    const double way_mm = (motion.to_reference_mm(entry_mm) - entry_mm).norm();
    if (way_mm < still_mm) return "";
    return formatted_line(
        "warning: [entry] at %s lies where the vessel moves by %.1f mm, and the sheath stands still: "
        "take another place",
        place_text(entry_mm).c_str(), way_mm);
}

// Moves the vertices of the moving bodies from keyframe 0, in which the scene's text describes them, to the
// reference pose.
void to_reference(const Motion &motion, std::vector<BakedBody> &bodies)
{
    for (BakedBody &body : bodies)
        if (body.moves)
            for (Eigen::Vector3d &v : body.mesh.vertices_mm) v = motion.to_reference_mm(v);
}

VesselTree in_reference(const Motion &motion, VesselTree tree)
{
    const auto carry = [&](std::vector<Eigen::Vector3d> &points_m) {
        for (Eigen::Vector3d &point : points_m) point = 1e-3 * motion.to_reference_mm(1e3 * point);
    };
    for (VesselBranch &branch : tree.branches) carry(branch.points_m);
    for (VesselBranch &vessel : tree.small) carry(vessel.points_m);
    for (VesselLesion &lesion : tree.lesions) carry(lesion.healthy_points_m);
    return tree;
}

std::filesystem::path bodies_file(const std::filesystem::path &scene)
{
    std::filesystem::path file = scene;
    return file.replace_extension(".bodies");
}

// Checks, before any file is written, that all input files can be read and that no output file is also an
// input file.
void check_files(const SceneText &text, const Options &options)
{
    std::vector<NamedPath> inputs = {{"SCENE", options.scene.string()},
                                     {"the entry", text.entry.centreline.string()}};
    inputs.push_back({"the lumen", text.lumen.centrelines.empty() ? text.lumen.mesh.file.string() : ""});
    for (const std::filesystem::path &file : text.lumen.centrelines)
        inputs.push_back({"the lumen", file.string()});
    for (const std::filesystem::path &file : text.tree.centrelines)
        inputs.push_back({"the tree", file.string()});
    inputs.push_back({"the small vessels", text.tree.small.string()});
    for (const BodyText &body : text.bodies) {
        if (!body.is_lumen && !body.is_marrow)
            inputs.push_back({"body '" + body.name + "'", body.mesh.file.string()});
        inputs.push_back({"body '" + body.name + "', inhaled", body.inhaled.string()});
    }
    check_outputs(inputs, {{"--output", options.output.string()},
                           {"the bodies of --output", bodies_file(options.output).string()},
                           {"--surface", options.surface.string()}});
}

} // namespace

Mesh solid_lumen(const LumenText &text, std::string &report)
{
    Mesh mesh = load_mesh(text.mesh);
    cap_openings(mesh, text.mesh.cap);
    report += notes_of(mesh);
    Mesh solid = offset_surface(mesh, text.solid_mm, 0);
    // A part that is open only has a thin shell in the level set, and a vessel thinner than a voxel has
    // nothing.
    const double before_mm3 = std::abs(volume_mm3(mesh)), after_mm3 = volume_mm3(solid);
    report += formatted_line("solid             the lumen: %.1f -> %.1f ml in voxels of %.2f mm",
                             before_mm3 / 1000, after_mm3 / 1000, text.solid_mm);
    return solid;
}

Mesh lumen_surface(const SceneText &text, std::string &report, Progress &progress)
{
    Mesh mesh;
    std::vector<Curve> lines;
    if (text.lumen.centrelines.empty()) {
        mesh = text.lumen.solid_mm > 0 ? solid_lumen(text.lumen, report) : load_mesh(text.lumen.mesh);
    } else {
        for (const std::filesystem::path &file : text.lumen.centrelines)
            for (Curve &line : read_centrelines(file, text.lumen.mesh.placement))
                lines.push_back(std::move(line));
        mesh = surface_of(lines, text.lumen.surface_mm, progress);
    }
    check_closed(mesh, text.lumen.mesh.cap);
    check_crossing(mesh, progress);
    report += notes_of(mesh);
    if (!lines.empty()) report += narrowing_warning(mesh, lines, text.lumen.surface_mm);
    return mesh;
}

// Writes the scene file, and also the body file unless `picture` is empty, as for a scene without bodies and
// without a vessel tree.
static std::string write_outputs(const Options &options, const Bytes &scene, const Bytes &picture,
                                 std::size_t body_count)
{
    const std::filesystem::path beside = bodies_file(options.output);
    std::string report;
    if (!picture.empty()) {
        write_both(options.output, scene, beside, picture);
        report += formatted_line("written           %s, %zu bytes, %zu bodies", beside.c_str(),
                                 picture.size(), body_count);
    } else {
        write_whole(options.output, scene);
        if (std::filesystem::exists(beside))
            report +=
                formatted_line("note              %s is of another scene: this one has no bodies, remove it",
                               beside.c_str());
    }
    return report + formatted_line("written           %s, %zu bytes", options.output.c_str(), scene.size());
}

std::string bake(const Options &options, Progress &progress)
{
    const SceneText text = read_scene_text(options.scene, options.folders);
    check_files(text, options);
    std::string report = formatted_line("scene             %s", text.name.c_str());
    Mesh surface = lumen_surface(text, report, progress);
    VesselTree vessels = tree_of(text, report);
    place_lesions(vessels, text.lesions);
    narrow(surface, vessels);
    if (!vessels.lesions.empty()) check_crossing(surface, progress);
    const TriangleTree tree(surface);
    report += formatted_line("surface           %zu triangles, %.1f cm2, %.1f ml", surface.triangles.size(),
                             area_mm2(surface) / 100, volume_mm3(surface) / 1000);
    const Worst narrowest = smallest_radius(tree, 20000);
    report += formatted_line("smallest lumen    radius %.2f mm at %s", narrowest.mm,
                             place_text(narrowest.place_mm).c_str());
    report += lesions_report(vessels, tree);
    const CurvePoint entry = entry_of(text, tree);
    report += formatted_line("entry             %s, direction (%.3f, %.3f, %.3f)",
                             place_text(entry.position_mm).c_str(), entry.direction.x(), entry.direction.y(),
                             entry.direction.z());

    std::optional<Frames> frames;
    std::optional<Motion> motion;
    if (!text.motion.frames.empty()) {
        frames = load_frames(text.motion, text.lumen);
        motion = fit_motion(*frames, {text.motion.spacing_mm, text.motion.breath_spacing_mm}, progress);
    }
    const VesselTree posed_vessels = motion ? in_reference(*motion, vessels) : vessels;
    Mesh posed = frames ? posed_lumen(text, *frames, progress) : surface;
    std::vector<bool> narrowed; // the frames' own vertices come first, since refinement appends vertices
    if (frames && !posed_vessels.lesions.empty()) {
        narrowed = narrow(posed, posed_vessels);
        check_crossing(posed, progress);
    }
    const TriangleTree posed_tree(posed);
    const FieldText wanted{text.lumen.tolerance_mm, text.lumen.inside_mm, text.lumen.outside_mm,
                           text.lumen.level_max, fine_regions(posed_vessels)};
    Field field = make_field(posed_tree, wanted, progress);
    std::string moved;
    if (frames) {
        moved = motion_report(*motion, frames->pose,
                              measure_motion(field.view(), motion->view(), *frames, narrowed));
        moved += entry_report(*motion, entry.position_mm);
    }
    const std::uint32_t start = start_um(text.entry, *field.view(), entry, report);
    const Bytes scene = scene_bytes(text, entry.position_mm, entry.direction, field,
                                    motion ? &*motion : nullptr, &posed_vessels, start);
    report +=
        field_report(field, measure_field(field.view(), posed_tree, options.points, options.seed, progress));
    report += referee_report(measure_contact(field.view(), posed_tree, options.poses, options.seed, progress),
                             options.seed);
    report += moved;

    std::vector<BakedBody> bodies = make_bodies(text, surface, vessels, report, progress);
    report += nesting_report(bodies, nesting_samples);
    report += breath_report(bodies, nesting_samples);
    if (motion) to_reference(*motion, bodies);
    Bytes picture;
    const bool has_picture = !bodies.empty() || !posed_vessels.branches.empty();
    if (has_picture) picture = bodies_bytes(text, bodies, posed_vessels, scene);
    if (!options.surface.empty()) write_ply(surface, options.surface);
    report += write_outputs(options, scene, picture, bodies.size());
    return report;
}

} // namespace crn::bake
