// `ct segment` and `ct check`: files from scans, and how far they are from the truth.
#include "tools/case/case.hpp"
#include "tools/ct/commands.hpp"
#include "tools/ct/volume_io.hpp"
#include <cstdio>

namespace seld::ct
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

// Every depth's line, and the lumen of the first: there the least of it is hidden by metal.
void segment_case(const SegmentCommand &command)
{
    const insertion::Case c = insertion::read_case(command.input);
    const fs::path folder = command.output.empty() ? c.folder / "segmentation" : command.output;
    std::size_t done = 0;
    for (std::size_t i = 0; i < c.depths.size(); ++i) {
        const insertion::Depth &depth = c.depths[i];
        if (depth.scan.empty()) continue;
        SegmentOptions options = command.options;
        options.line.mouth_mm = c.mouth_mm;
        options.line.direction = c.direction;
        options.wants_lumen = command.options.wants_lumen && done == 0;
        const fs::path at = folder / ("depth_" + std::to_string(i + 1));
        std::printf("%s: %s\n", depth.name.c_str(), c.path_in(depth.scan).string().c_str());
        const Segmentation result =
            segment_scan(read_volume(c.path_in(depth.scan)), options, at, terminal_report());
        insertion::write_centreline(c.path_in(depth.centreline), result.line.places());
        if (options.wants_lumen)
            fs::copy_file(at / "lumen.ply", folder / "lumen.ply", fs::copy_options::overwrite_existing);
        ++done;
    }
    if (done == 0)
        throw Fault((c.folder / "case.toml").string() +
                    ": no depth has a scan: fill in `scan`, or run ct simulate");
    std::printf("%s: %zu centrelines written; pictures in %s\n", c.folder.string().c_str(), done,
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
    if (!c.surface.empty() && fs::exists(lumen)) {
        const bake::Mesh found = mesh_of(lumen), real = mesh_of(c.path_in(c.surface));
        is_good = tell("lumen, found to truth", surfaces_apart(found, real), 0.3, 0) && is_good;
        is_good = tell("lumen, truth to found", surfaces_apart(real, found), 0.3, 0) && is_good;
        ++compared;
    }
    if (compared == 0)
        throw Fault(case_folder.string() +
                    ": nothing to compare: run ct segment on a case with truth/ first");
    return is_good;
}

} // namespace seld::ct
