// The command `ct segment` makes centrelines and surfaces from scans, and `ct check` measures how far they
// deviate from the truth.
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "tools/bake/bake.hpp"
#include "tools/lab/case/case.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/mouth.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <cstdio>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

bake::Mesh mesh_of(const fs::path &file)
{
    bake::MeshText text;
    text.file = file;
    text.placement.unit = "mm";
    return bake::load_mesh(text);
}

// Holds one insertion depth at which the phantom was scanned, and the instrument that was found in that scan.
struct SegmentedDepth {
    const insertion::Depth *depth;
    Volume volume;
    Page page;
    InstrumentLine line;
};

SegmentedDepth segment_depth(const insertion::Case &c, const insertion::Depth &depth,
                             const SegmentOptions &options, const fs::path &folder, const Report &report)
{
    const fs::path scan = c.path_in(depth.scan);
    std::printf("%s: %s\n", depth.name.c_str(), scan.string().c_str());
    SegmentedDepth result{&depth, read_volume(scan), Page(folder), {}};
    LineOptions line = options.line;
    if (c.has_mouth) {
        line.mouth_mm = c.mouth_mm;
        line.direction = c.direction;
    }
    result.line = segment_line(result.volume, line, result.page, report);
    return result;
}

// Writes the results for the part of the instrument beyond the introducer: pictures, a page, and the file
// depth_N.csv of the case.
void finish_depth(const insertion::Case &c, SegmentedDepth &found)
{
    const bool begins_at_mouth = begin_at_mouth(found.line, {c.mouth_mm, c.direction}, found.volume.name);
    if (begins_at_mouth) check_length({found.line.places(), found.depth->inserted_mm, found.volume.name});
    const std::string facts = line_facts(found.line, found.volume);
    std::fputs(facts.c_str(), stdout);
    write_line(found.line, found.volume, found.page, facts);
    insertion::write_centreline(c.path_in(found.depth->centreline), found.line.places());
}

// Returns the path of a file relative to the case's folder if the file lies in this folder, and otherwise the
// absolute path.
fs::path path_from(const fs::path &folder, const fs::path &file)
{
    const fs::path relative = fs::relative(file, folder.empty() ? fs::path(".") : folder);
    return relative.empty() || *relative.begin() == ".." ? fs::absolute(file) : relative;
}

// Converts the lumen's mesh to the scene file that the program `calibrate` and the simulator use.
void bake_lumen(const insertion::Case &c, const bake::Mesh &lumen, const fs::path &surface,
                const fs::path &scene)
{
    const double wall_mm = bake::TriangleTree(lumen).nearest(c.mouth_mm).distance_mm;
    std::string text;
    if (wall_mm > -1) {
        text =
            formatted(": the mouth at (%.1f, %.1f, %.1f) mm is %.1f mm %s the wall of the lumen that was "
                      "found, and must be 1 mm inside: mend inserted_mm of the depths in case.toml, or write "
                      "mouth_mm and direction",
                      c.mouth_mm.x(), c.mouth_mm.y(), c.mouth_mm.z(), std::abs(wall_mm),
                      wall_mm > 0 ? "outside" : "from");
        throw Fault(c.folder.string() + text);
    }
    text = formatted("[scene]\nname = \"scanned lumen\"\nsource = \"ct segment\"\n\n[lumen]\nmesh = \"%s\"\n"
                     "unit = \"mm\"\n\n[entry]\nposition_mm = [%.4f, %.4f, %.4f]\n"
                     "direction = [%.6f, %.6f, %.6f]\n",
                     surface.filename().c_str(), c.mouth_mm.x(), c.mouth_mm.y(), c.mouth_mm.z(),
                     c.direction.x(), c.direction.y(), c.direction.z());
    bake::Options options;
    options.scene = surface.parent_path() / "scene.toml";
    options.output = scene;
    options.points = 20000;
    options.poses = 1000;
    write_whole_file(options.scene.string(), text);
    bake::Progress progress;
    std::fputs(bake::bake(options, progress).c_str(), stdout);
}

// Finds the lumen of the phantom from the scans of all depths. Adds the entries that the case still lacks for
// the program `calibrate`, which are surface, scene and mouth_mm.
void finish_case(insertion::Case &c, const std::vector<SegmentedDepth> &found, const LumenOptions &options,
                 const fs::path &folder, const Report &report)
{
    std::vector<LumenScan> scans;
    LineOptions at_mouth;
    at_mouth.mouth_mm = c.mouth_mm;
    at_mouth.direction = c.direction;
    for (const SegmentedDepth &depth : found)
        scans.push_back(
            {&depth.volume, depth.line.places(), behind_mouth(at_mouth, depth.line.points.front().place_mm)});
    Page page(folder);
    const LumenSurface lumen = segment_lumen(scans, options, page, report);
    const std::string facts = lumen_facts(lumen);
    std::fputs(facts.c_str(), stdout);
    for (const SegmentedDepth &depth : found)
        page.link(depth.page.folder().filename().string() + "/index.html", depth.depth->name);
    page.write("Case " + c.name, facts);
    const fs::path surface = folder / "lumen.ply", scene = folder / "lumen.scene";
    if (c.surface.empty()) c.surface = path_from(c.folder, surface);
    if (c.scene.empty()) {
        bake_lumen(c, lumen.mesh, surface, scene);
        c.scene = path_from(c.folder, scene);
    }
    insertion::complete_case(c);
}

void segment_case(const SegmentCommand &command)
{
    insertion::Case c = insertion::read_case(command.input, insertion::CaseParts::before_segmentation);
    const fs::path folder = command.output.empty() ? c.folder / "segmentation" : command.output;
    check_output_folder({"--output", folder.string()});
    const Report report = terminal_report();
    std::vector<SegmentedDepth> found;
    for (std::size_t i = 0; i < c.depths.size(); ++i) {
        if (c.depths[i].scan.empty()) continue;
        found.push_back(segment_depth(c, c.depths[i], command.options,
                                      folder / ("depth_" + std::to_string(i + 1)), report));
        if (c.has_mouth) finish_depth(c, found.back());
    }
    if (found.empty())
        throw Fault((c.folder / "case.toml").string() +
                    ": no depth has a scan: fill in `scan`, or run ct simulate");
    if (!c.has_mouth) {
        std::vector<InsertedLine> lines;
        for (const SegmentedDepth &depth : found)
            lines.push_back({depth.line.places(), depth.depth->inserted_mm, depth.volume.name});
        const Mouth mouth = find_mouth(lines);
        c.mouth_mm = mouth.place_mm;
        c.direction = mouth.direction;
        c.has_mouth = true;
        std::printf("mouth       (%.2f, %.2f, %.2f) mm, direction (%.3f, %.3f, %.3f): so far from the tips "
                    "as is inserted\n",
                    c.mouth_mm.x(), c.mouth_mm.y(), c.mouth_mm.z(), c.direction.x(), c.direction.y(),
                    c.direction.z());
        for (SegmentedDepth &depth : found) finish_depth(c, depth);
    }
    if (command.options.wants_lumen) finish_case(c, found, command.options.lumen, folder, report);
    std::printf("%s: %zu centrelines written; pictures in %s\n", c.folder.string().c_str(), found.size(),
                folder.string().c_str());
}

bool tell(const char *what, const Apart &apart, double mean_bar_mm, double max_bar_mm)
{
    const bool is_good = apart.mean_mm <= mean_bar_mm && (max_bar_mm <= 0 || apart.max_mm <= max_bar_mm);
    std::printf("%-28s mean %.3f mm, max %.3f mm (bars %.1f%s): %s\n", what, apart.mean_mm, apart.max_mm,
                mean_bar_mm, max_bar_mm > 0 ? ", 0.6" : "", is_good ? "good" : "over the bar");
    return is_good;
}

} // namespace

void command_segment(const SegmentCommand &command)
{
    std::error_code ignored;
    if (fs::exists(command.input / "case.toml", ignored)) return segment_case(command);
    const fs::path folder = command.output.empty() ? fs::path("out/segmentation") : command.output;
    check_output_folder({"--output", folder.string()});
    segment_scan(read_volume(command.input), command.options, folder, terminal_report());
    std::printf("%s: centreline, surfaces, report and pictures\n", folder.string().c_str());
}

bool command_check(const fs::path &case_folder)
{
    const insertion::Case c = insertion::read_case(case_folder);
    bool is_good = true;
    std::size_t compared = 0;
    for (const insertion::Depth &depth : c.depths) {
        const fs::path truth = c.folder / "truth" / depth.centreline.filename();
        if (!fs::exists(truth) || !fs::exists(c.path_in(depth.centreline))) continue;
        const auto found = insertion::read_centreline(c.path_in(depth.centreline)),
                   real = insertion::read_centreline(truth);
        is_good =
            tell((depth.name + ", found to truth").c_str(), lines_apart(found, real), 0.2, 0.6) && is_good;
        is_good =
            tell((depth.name + ", truth to found").c_str(), lines_apart(real, found), 0.2, 0.6) && is_good;
        std::printf("%-28s %.3f mm apart\n", (depth.name + ", tips").c_str(),
                    lines_apart(found, real).tip_mm);
        ++compared;
    }
    const fs::path lumen = c.folder / "segmentation" / "lumen.ply";
    std::error_code ignored;
    if (fs::equivalent(c.path_in(c.surface), lumen, ignored)) {
        std::printf("lumen: not compared, since the case knows no other surface than the segmented one\n");
    } else if (!c.surface.empty() && fs::exists(lumen)) {
        const bake::Mesh found = mesh_of(lumen), real = mesh_of(c.path_in(c.surface));
        const Apart there = surfaces_apart(found, real);
        is_good = tell("lumen, found to truth", there, 0.3, 0) && is_good;
        is_good = tell("lumen, truth to found", surfaces_apart(real, found), 0.3, 0) && is_good;
        std::printf("%-28s %+.3f mm, + is outside the truth\n", "lumen, mean offset", there.offset_mm);
        ++compared;
    }
    if (compared == 0)
        throw Fault(case_folder.string() +
                    ": nothing to compare: run ct segment on a case with truth/ first");
    return is_good;
}

} // namespace crn::ct
