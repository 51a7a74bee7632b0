#include "tools/lab/ct/segment.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/lab/ct/mouth.hpp"
#include "tools/lab/ct/surface.hpp"
#include "tools/mesh/fault.hpp"
#include "tools/mesh/pieces.hpp"
#include "tools/mesh/simplify.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double simplify_mm = 0.03;

void write_points(const InstrumentLine &line, const fs::path &file)
{
    std::string text = "x_mm,y_mm,z_mm,unsure_mm,why\n";
    std::string row;
    for (const LinePoint &point : line.points) {
        row = formatted("%.4f,%.4f,%.4f,%.3f,", point.place_mm.x(), point.place_mm.y(), point.place_mm.z(),
                        point.unsure_mm);
        text += row + point.why + "\n";
    }
    write_whole_file(file.string(), text);
}

// Writes the surface of the instrument itself. The snake (active contour) finds the instrument's surface from
// its voxels, in the same way as the lumen's surface.
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
    mesh::drop_small_pieces(mesh.vertices_mm, mesh.triangles, 0, 0.05);
    write_surface(mesh, {}, file);
}

// Returns the uncertainty of the wall at every vertex: 0.8 mm where metal hid the wall, and 0.15 mm
// elsewhere.
std::vector<float> unsure_of(const bake::Mesh &mesh, const Lumen &lumen)
{
    std::vector<float> unsure;
    for (const Vector3d &vertex : mesh.vertices_mm)
        unsure.push_back(lumen.hidden.value(lumen.hidden.voxel(vertex)) > 0.5 ? 0.8f : 0.15f);
    return unsure;
}

bake::Mesh lumen_mesh(const Lumen &lumen, std::vector<std::string> &notes)
{
    bake::Mesh mesh = surface_of(lumen.level, "lumen");
    mesh::drop_small_pieces(mesh.vertices_mm, mesh.triangles, 0, 1);
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

void write_report(const InstrumentLine &line, const Volume &volume, const fs::path &file)
{
    nlohmann::ordered_json json;
    json["scan"] = volume.name;
    json["threshold_HU"] = line.threshold_HU;
    json["blur_mm"] = {line.blur_mm, line.blur_slice_mm};
    json["notes"] = line.notes;
    json["unsure"] = nlohmann::json::array();
    double arc = 0;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        const LinePoint &point = line.points[i];
        if (i > 0) arc += (point.place_mm - line.points[i - 1].place_mm).norm();
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

// Shows slices through a point in the lumen: the scan, the speed of the snake (active contour), and its final
// contour.
void show_lumen(Page &page, const Lumen &lumen, const Vector3d &place)
{
    const Vector3d middle = lumen.level.voxel(place);
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
    for (const int axis : {1, 0}) {
        Picture whole(lumen.restored, axis, -1, lumen.fluid_HU - 100, lumen.wall_HU + 50);
        whole.outline(lumen.level, red);
        whole.caption("LUMEN");
        page.show(whole, axis == 1 ? "4_lumen_front.png" : "4_lumen_side.png",
                  "The lumen (red), seen through, over the brightest voxels without the instrument");
    }
}

std::string notes_text(const std::vector<std::string> &notes)
{
    std::string text;
    for (const std::string &note : notes) text += "note        " + note + "\n";
    return text;
}

} // namespace

InstrumentLine segment_line(const Volume &volume, LineOptions options, Page &page, const Report &report)
{
    report("instrument", 0);
    const Volume mask = find_instrument(volume, options);
    report("instrument", 1);
    InstrumentLine line = trace_instrument(volume, mask, options, report);
    line.notes.insert(line.notes.begin(), volume.notes.begin(), volume.notes.end());
    write_instrument(volume, mask, line, page.folder() / "instrument.ply");
    Picture front(volume, 1, -1, 0, options.threshold_HU);
    front.caption("SCAN, BRIGHTEST");
    page.show(front, "1_scan_front.png", "The brightest voxels of the scan, from the front");
    return line;
}

void write_line(const InstrumentLine &line, const Volume &volume, Page &page, const std::string &facts)
{
    write_points(line, page.folder() / "centreline.csv");
    write_report(line, volume, page.folder() / "report.json");
    show_line(page, volume, line);
    page.write("Scan " + volume.name, facts);
}

std::string line_facts(const InstrumentLine &line, const Volume &volume)
{
    std::string text;
    double unsure = 0, length = 0;
    std::size_t doubtful = 0;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        unsure = std::max(unsure, line.points[i].unsure_mm);
        doubtful += !line.points[i].why.empty();
        if (i > 0) length += (line.points[i].place_mm - line.points[i - 1].place_mm).norm();
    }
    text = formatted(
        "volume      %d x %d x %d voxels of %.3f x %.3f x %.3f mm\n"
        "instrument  over %.0f HU; line of %.1f mm, %zu points, %zu of them unsure (at most %.2f mm)\n"
        "            blurred by %.2f mm in the slice and %.2f mm across, on %.0f HU\n",
        volume.size[0], volume.size[1], volume.size[2], volume.spacing_mm.x(), volume.spacing_mm.y(),
        volume.spacing_mm.z(), line.threshold_HU, length, line.points.size(), doubtful, unsure, line.blur_mm,
        line.blur_slice_mm, line.around_HU);
    return text + notes_text(line.notes);
}

LumenSurface segment_lumen(const std::vector<LumenScan> &scans, const LumenOptions &options, Page &page,
                           const Report &report)
{
    LumenSurface result;
    result.lumen = find_lumen(scans, options, report);
    result.notes = result.lumen.notes;
    result.mesh = lumen_mesh(result.lumen, result.notes);
    write_surface(result.mesh, unsure_of(result.mesh, result.lumen), page.folder() / "lumen.ply");
    const std::vector<Vector3d> &line = scans.back().line;
    show_lumen(page, result.lumen, line[line.size() / 2]);
    return result;
}

std::string lumen_facts(const LumenSurface &surface)
{
    return formatted("lumen       fluid %.0f HU, wall %.0f HU, surface at %.0f HU, %zu triangles\n",
                     surface.lumen.fluid_HU, surface.lumen.wall_HU, surface.lumen.edge_HU,
                     surface.mesh.triangles.size()) +
           notes_text(surface.notes);
}

Segmentation segment_scan(const Volume &volume, const SegmentOptions &options, const fs::path &folder,
                          const Report &report)
{
    Page page(folder);
    Segmentation result;
    result.line = segment_line(volume, options.line, page, report);
    if (options.line.mouth_mm)
        begin_at_mouth(result.line, {*options.line.mouth_mm, options.line.direction}, volume.name);
    std::string facts = line_facts(result.line, volume);
    if (options.wants_lumen) {
        const LumenScan scan{&volume, result.line.places(),
                             behind_mouth(options.line, result.line.points.front().place_mm)};
        LumenSurface lumen = segment_lumen({scan}, options.lumen, page, report);
        facts += lumen_facts(lumen);
        result.lumen = std::move(lumen.mesh);
    }
    write_line(result.line, volume, page, facts);
    std::fputs(facts.c_str(), stdout);
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

// The mean distance is weighted by area, because vertices are denser where the surface bends. Every triangle
// of the surface is sampled at the points of a grid whose spacing is at most grid_mm.
Apart surfaces_apart(const bake::Mesh &surface, const bake::Mesh &reference)
{
    constexpr double grid_mm = 1.0;
    const bake::TriangleTree tree(reference);
    Apart apart;
    double area = 0;
    for (const bake::Triangle &triangle : surface.triangles) {
        const Vector3d &a = surface.vertices_mm[triangle[0]], u = surface.vertices_mm[triangle[1]] - a,
                       v = surface.vertices_mm[triangle[2]] - a;
        const int parts =
            std::clamp(static_cast<int>(std::ceil(std::max(u.norm(), v.norm()) / grid_mm)), 1, 200);
        const double share = 0.5 * u.cross(v).norm() / (parts * parts);
        // We divide a triangle into small triangles of both orientations and sample the distance at their
        // middles.
        for (int i = 0; i < parts; ++i)
            for (int j = 0; i + j < parts; ++j)
                for (const double third : {1.0 / 3, 2.0 / 3}) {
                    if (third > 0.5 && i + j + 1 >= parts) continue;
                    const Vector3d place = a + ((i + third) * u + (j + third) * v) / parts;
                    const double signed_mm = tree.nearest(place).distance_mm, away = std::abs(signed_mm);
                    apart.mean_mm += share * away;
                    apart.offset_mm += share * signed_mm;
                    area += share;
                    apart.max_mm = std::max(apart.max_mm, away);
                }
    }
    apart.mean_mm /= area;
    apart.offset_mm /= area;
    return apart;
}

} // namespace crn::ct
