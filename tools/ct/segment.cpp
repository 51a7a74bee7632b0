#include "tools/ct/segment.hpp"
#include "host/model/pending_file.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/ct/pictures.hpp"
#include "tools/ct/surface.hpp"
#include "tools/mesh/fault.hpp"
#include "tools/mesh/simplify.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace seld::ct
{

namespace
{

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double simplify_mm = 0.03;

struct Page {
    fs::path folder;
    std::string rows;

    void show(const Picture &picture, const std::string &name, const std::string &what)
    {
        picture.save(folder / name);
        rows += "<figure><img src=\"" + name + "\"><figcaption>" + what + "</figcaption></figure>\n";
    }
    void write(const std::string &head, const std::string &facts) const
    {
        write_whole_file(
            (folder / "index.html").string(),
            "<!doctype html><meta charset=\"utf-8\"><title>" + head +
                "</title><style>body{font:15px "
                "sans-serif;margin:24px}figure{display:inline-block;margin:8px;vertical-align:top}"
                "img{max-width:640px}figcaption{max-width:640px}pre{background:#eee;padding:8px}</"
                "style>\n<h1>" +
                head + "</h1>\n<pre>" + facts + "</pre>\n" + rows);
    }
};

void write_line(const InstrumentLine &line, const fs::path &file)
{
    std::string text = "x_mm,y_mm,z_mm,unsure_mm,why\n";
    char row[160];
    for (const LinePoint &point : line.points) {
        std::snprintf(row, sizeof row, "%.4f,%.4f,%.4f,%.3f,", point.place_mm.x(), point.place_mm.y(),
                      point.place_mm.z(), point.unsure_mm);
        text += row + point.why + "\n";
    }
    write_whole_file(file.string(), text);
}

// The instrument's own surface, by the same snake from its voxels.
void write_instrument(const Volume &volume, const Volume &mask, const InstrumentLine &line,
                      const fs::path &file)
{
    std::array<int, 3> low = volume.size, high = {0, 0, 0};
    for (const Vector3d &place : line.places()) {
        const Vector3d voxel = volume.voxel(place);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int at = static_cast<int>(std::lround(voxel[static_cast<Eigen::Index>(axis)]));
            low[axis] = std::clamp(at - 8, 0, low[axis]);
            high[axis] = std::clamp(at + 9, high[axis], volume.size[axis]);
        }
    }
    const Volume part = cut_out(volume, low, high), inside = cut_out(mask, low, high);
    const Volume speed = speed_of(gradient_magnitude(part, 0.5), 500, 150);
    bake::Mesh mesh =
        surface_of(evolve_snake(signed_distance(inside), speed, {0, 0.1, 0.5, 10}), "instrument");
    keep_large_pieces(mesh, 0.05);
    write_surface(mesh, {}, file);
}

// Where metal hid the wall nothing was seen of it; elsewhere the noise tells.
std::vector<float> unsure_of(const bake::Mesh &mesh, const Lumen &lumen, const std::vector<Vector3d> &line,
                             double masked_mm)
{
    const Volume near = distance_volume(lumen.level, line, masked_mm + 1);
    std::vector<float> unsure;
    for (const Vector3d &vertex : mesh.vertices_mm)
        unsure.push_back(near.value(near.voxel(vertex)) < masked_mm ? 0.8f : 0.15f);
    return unsure;
}

bake::Mesh lumen_mesh(const Lumen &lumen, std::vector<std::string> &notes)
{
    bake::Mesh mesh = surface_of(lumen.level, "lumen");
    keep_large_pieces(mesh, 1);
    const bake::Mesh whole = mesh;
    mesh::simplify(mesh.vertices_mm, mesh.triangles, simplify_mm);
    bake::Progress progress;
    try {
        bake::check_closed(mesh, bake::Cap::none);
        bake::check_crossing(mesh, progress);
    } catch (const Fault &) {
        notes.push_back("the simplified surface crossed itself: the whole one is written");
        mesh = whole;
    }
    return mesh;
}

std::string facts_of(const Segmentation &result, const Lumen &lumen, const Volume &volume)
{
    char text[600];
    double unsure = 0, length = 0;
    std::size_t doubtful = 0;
    const std::vector<LinePoint> &points = result.line.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        unsure = std::max(unsure, points[i].unsure_mm);
        doubtful += !points[i].why.empty();
        if (i > 0) length += (points[i].place_mm - points[i - 1].place_mm).norm();
    }
    std::snprintf(
        text, sizeof text,
        "volume      %d x %d x %d voxels of %.3f x %.3f x %.3f mm\n"
        "instrument  over %.0f HU; line of %.1f mm, %zu points, %zu of them unsure (at most %.2f mm)\n"
        "            blurred by %.2f mm in the slice and %.2f mm across, on %.0f HU\n"
        "lumen       fluid %.0f HU, wall %.0f HU, surface at %.0f HU, %zu triangles\n",
        volume.size[0], volume.size[1], volume.size[2], volume.spacing_mm.x(), volume.spacing_mm.y(),
        volume.spacing_mm.z(), result.line.threshold_HU, length, points.size(), doubtful, unsure,
        result.line.blur_mm, result.line.blur_slice_mm, result.line.around_HU, lumen.fluid_HU, lumen.wall_HU,
        lumen.edge_HU, result.lumen.triangles.size());
    std::string facts = text;
    for (const std::string &note : result.notes) facts += "note        " + note + "\n";
    return facts;
}

void write_report(const Segmentation &result, const Lumen &lumen, const Volume &volume, const fs::path &file)
{
    nlohmann::ordered_json json;
    json["scan"] = volume.name;
    json["threshold_HU"] = result.line.threshold_HU;
    json["blur_mm"] = {result.line.blur_mm, result.line.blur_slice_mm};
    json["fluid_HU"] = lumen.fluid_HU;
    json["wall_HU"] = lumen.wall_HU;
    json["lumen_triangles"] = result.lumen.triangles.size();
    json["notes"] = result.notes;
    json["unsure"] = nlohmann::json::array();
    double arc = 0;
    for (std::size_t i = 0; i < result.line.points.size(); ++i) {
        const LinePoint &point = result.line.points[i];
        if (i > 0) arc += (point.place_mm - result.line.points[i - 1].place_mm).norm();
        if (!point.why.empty())
            json["unsure"].push_back(
                {{"arc_mm", std::round(10 * arc) / 10},
                 {"place_mm", {point.place_mm.x(), point.place_mm.y(), point.place_mm.z()}},
                 {"unsure_mm", point.unsure_mm},
                 {"why", point.why}});
    }
    write_whole_file(file.string(), json.dump(1) + "\n");
}

void show_line(Page &page, const Volume &volume, const InstrumentLine &line)
{
    for (const int axis : {1, 0}) {
        Picture over(volume, axis, -1, 0, line.threshold_HU);
        over.line(line.places(), red, 1.4);
        for (const LinePoint &point : line.points)
            if (!point.why.empty()) over.dot(point.place_mm, yellow, 3);
        over.dot(line.points.back().place_mm, green, 5);
        over.caption("CENTRELINE");
        page.show(over, axis == 1 ? "5_line_front.png" : "5_line_side.png",
                  "The centreline (red), its tip (green), unsure places (yellow), over the brightest voxels");
    }
}

void show_lumen(Page &page, const Volume &volume, const Lumen &lumen, const InstrumentLine &line)
{
    const Vector3d middle = lumen.level.voxel(line.points[line.points.size() / 2].place_mm);
    for (const int axis : {2, 1}) {
        const int index = std::clamp(static_cast<int>(std::lround(middle[axis])), 0,
                                     lumen.level.size[static_cast<std::size_t>(axis)] - 1);
        const std::string side = axis == 2 ? "_slice.png" : "_front.png";
        Picture speed(lumen.speed, axis, index, 0, 1);
        speed.caption("SPEED");
        page.show(speed, "2_speed" + side, "The snake's speed: fast (white) on even ground, slow at edges");
        Picture level(lumen.restored, axis, index, lumen.fluid_HU - 200, lumen.wall_HU + 150);
        level.outline(lumen.first, yellow);
        level.outline(lumen.level, red);
        level.caption("SNAKE");
        page.show(level, "3_snake" + side,
                  "The instrument taken out; the snake before (yellow) and after (red)");
    }
    const Vector3d whole = volume.voxel(line.points[line.points.size() / 2].place_mm);
    Picture slice(volume, 2, std::clamp(static_cast<int>(std::lround(whole.z())), 0, volume.size[2] - 1),
                  lumen.fluid_HU - 200, lumen.wall_HU + 250);
    slice.caption("SCAN");
    page.show(slice, "1_scan_slice.png", "The scan as it is, in the slice of the line's middle");
}

} // namespace

Segmentation segment_scan(const Volume &volume, const SegmentOptions &options, const fs::path &folder,
                          const Report &report)
{
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure) throw Fault(folder.string() + ": the folder cannot be made: " + failure.message());
    Page page{folder, {}};
    Segmentation result;
    LineOptions line_options = options.line;
    report("instrument", 0);
    const Volume mask = find_instrument(volume, line_options);
    report("instrument", 1);
    result.line = trace_instrument(volume, mask, line_options, report);
    result.notes = volume.notes;
    result.notes.insert(result.notes.end(), result.line.notes.begin(), result.line.notes.end());
    write_line(result.line, folder / "centreline.csv");
    write_instrument(volume, mask, result.line, folder / "instrument.ply");
    Picture front(volume, 1, -1, 0, line_options.threshold_HU);
    front.caption("SCAN, BRIGHTEST");
    page.show(front, "1_scan_front.png", "The brightest voxels of the scan, from the front");
    Lumen lumen;
    if (options.wants_lumen) {
        // What lies behind the mouth hides the wall too, but need not be in the lumen.
        std::vector<Vector3d> behind;
        if (line_options.mouth_mm)
            behind = {result.line.points.front().place_mm,
                      result.line.points.front().place_mm - 300 * line_options.direction};
        lumen = find_lumen(volume, result.line.places(), behind, options.lumen, report);
        result.lumen = lumen_mesh(lumen, result.notes);
        write_surface(result.lumen,
                      unsure_of(result.lumen, lumen, result.line.places(), options.lumen.masked_mm),
                      folder / "lumen.ply");
        show_lumen(page, volume, lumen, result.line);
    }
    show_line(page, volume, result.line);
    write_report(result, lumen, volume, folder / "report.json");
    page.write("Scan " + volume.name, facts_of(result, lumen, volume));
    std::fputs(facts_of(result, lumen, volume).c_str(), stdout);
    return result;
}

Apart lines_apart(const std::vector<Vector3d> &line, const std::vector<Vector3d> &reference)
{
    Apart apart;
    for (const Vector3d &place : line) {
        const double away = distance_from(reference, place).distance_mm;
        apart.mean_mm += away / static_cast<double>(line.size());
        apart.max_mm = std::max(apart.max_mm, away);
    }
    apart.tip_mm = (line.back() - reference.back()).norm();
    return apart;
}

Apart surfaces_apart(const bake::Mesh &surface, const bake::Mesh &reference)
{
    const bake::TriangleTree tree(reference);
    Apart apart;
    for (const Vector3d &vertex : surface.vertices_mm) {
        const double away = std::abs(tree.nearest(vertex).distance_mm);
        apart.mean_mm += away / static_cast<double>(surface.vertices_mm.size());
        apart.max_mm = std::max(apart.max_mm, away);
    }
    return apart;
}

} // namespace seld::ct
