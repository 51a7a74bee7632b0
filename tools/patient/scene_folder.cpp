#include "tools/patient/scene_folder.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/bake.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/solid.hpp"
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/patient/coronary.hpp"
#include "tools/patient/naming.hpp"
#include "tools/patient/outflow.hpp"
#include "tools/patient/practice.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>

namespace crn::patient
{
namespace
{

namespace fs = std::filesystem;
using centreline::Branch;
using centreline::Sphere;
using centreline::Tree;
using Eigen::Vector3d;

constexpr double aorta_mm = 6.0; // least radius of an aorta

double whole_length_mm(const Tree &tree)
{
    double sum = 0;
    for (const Branch &branch : tree.branches) sum += centreline::length_mm(branch);
    return sum;
}

// The number of the part in whose lumen a place lies deepest.
class PartFinder
{
  public:
    explicit PartFinder(const WholeLumen &lumen)
    {
        for (const bake::Mesh &mesh : lumen.own)
            lumens_.push_back(std::make_unique<bake::TriangleTree>(mesh));
    }
    std::size_t at(const Vector3d &place_mm) const
    {
        std::size_t best = 0;
        double deepest_mm = INFINITY;
        for (std::size_t p = 0; p < lumens_.size(); ++p) {
            // The sign of a distance needs triangles that all look outwards, which parts may not have.
            const double wall_mm = std::abs(lumens_[p]->nearest(place_mm).distance_mm);
            const double mm = lumens_[p]->winding(place_mm) != 0 ? -wall_mm : wall_mm;
            if (mm < deepest_mm) deepest_mm = mm, best = p;
        }
        return best;
    }

  private:
    std::vector<std::unique_ptr<bake::TriangleTree>> lumens_;
};

using NameAt = std::function<std::string(const Vector3d &)>;

// Gives every branch the name that most of its spheres have, with a number where a name comes again. The
// spheres inside the parent have the parent's name, so they do not count.
void name_by_places(Tree &tree, const NameAt &name_at)
{
    constexpr std::size_t samples = 40;
    BranchNames used;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        Branch &branch = tree.branches[b];
        const std::size_t first = std::min(centreline::first_own_sphere(tree, b), branch.spheres.size() - 1);
        const std::size_t step = std::max<std::size_t>(1, (branch.spheres.size() - first) / samples);
        std::map<std::string, int> votes;
        for (std::size_t s = first; s < branch.spheres.size(); s += step) {
            const std::string name = name_at(branch.spheres[s].centre_mm);
            if (!name.empty()) ++votes[name];
        }
        std::string best = "vessel";
        int most = 0;
        for (const auto &[name, count] : votes)
            if (count > most) best = name, most = count;
        branch.name = used.add(best);
    }
}

void name_by_parts(Tree &tree, const std::vector<Part> &parts, const WholeLumen &lumen, Choices &choices)
{
    std::vector<std::string> names;
    for (const Part &part : parts) names.push_back(part.name);
    names = short_names(names, &choices);
    const PartFinder finder(lumen);
    name_by_places(tree, [&](const Vector3d &place_mm) { return names[finder.at(place_mm)]; });
}

void name_tree(Tree &tree, const std::vector<Part> &parts, const WholeLumen &lumen, const SceneWish &wish,
               Choices &choices)
{
    constexpr double trunk_mm = 150.0;
    std::string names = wish.names;
    std::string why = "as stated";
    const double root_mm = tree.branches.front().spheres[tree.branches.front().spheres.size() / 2].radius_mm;
    if (names == "auto" && wish.structure_at) {
        names = "parts";
        why = "of the labels in which the branches lie";
    } else if (names == "auto" && parts.size() > 1) {
        names = "parts";
        why = "of the parts in which the branches lie";
    } else if (names == "auto") {
        const bool is_aorta =
            root_mm >= aorta_mm && whole_length_mm(tree) >= trunk_mm && tree.branches.size() > 1;
        names = is_aorta ? "aorta" : "numbers";
        why = is_aorta ? formatted("the first branch has a radius of %.1f mm, so it is taken for an aorta",
                                   root_mm)
                       : "neither the parts nor the shape say what the branches are";
    }
    if (names == "aorta") {
        propose_names(tree);
    } else if (names == "parts" && wish.structure_at) {
        name_by_places(tree, wish.structure_at);
    } else if (names == "parts") {
        name_by_parts(tree, parts, lumen, choices);
    } else {
        for (std::size_t b = 0; b < tree.branches.size(); ++b)
            tree.branches[b].name = "branch_" + std::to_string(b + 1);
    }
    choices.add("names", formatted("%s, %zu branches", names.c_str(), tree.branches.size()), why,
                "--branches aorta, parts or numbers; tree.csv may be changed");
}

// Without the names of coronary arteries, no bed opens in hyperaemia.
CoronaryBranches find_coronaries(const Tree &tree, const std::vector<Part> &parts, Choices &choices)
{
    const CoronaryBranches found = coronary_branches(tree, parts.size() == 1 ? parts[0].name : "");
    const std::size_t count = found.left.size() + found.right.size();
    choices.add(
        "coronaries",
        found.is_empty() ? "none" : formatted("%zu of %zu branches", count, tree.branches.size()),
        found.is_empty()
            ? "no name is that of one: FFR of lesions is with resting flow"
            : "by their names, with their branches: FFR there is with hyperaemic flow, elsewhere with "
              "resting flow",
        "left_coronary and right_coronary of scene.toml may be changed");
    return found;
}

// Ways are found on a grid: two voxels across the thinnest part, as far as three million voxels inside and
// the box around all of them allow.
double voxel_for_tree(const WholeLumen &lumen)
{
    constexpr double voxels_max = 3e6, voxels_usual = 1e6, voxel_min_mm = 0.15, voxel_max_mm = 1.0;
    const double volume_mm3 = std::abs(bake::volume_mm3(lumen.closed));
    double wanted_mm = std::cbrt(volume_mm3 / voxels_usual);
    for (const bake::Mesh &own : lumen.own)
        wanted_mm =
            std::min(wanted_mm, std::abs(bake::volume_mm3(own)) / std::max(1e-9, bake::area_mm2(own)));
    Eigen::AlignedBox3d box;
    for (const Vector3d &v : lumen.closed.vertices_mm) box.extend(v);
    const double least_mm =
        std::cbrt(std::max(volume_mm3 / voxels_max, box.volume() / (0.8 * bake::solid_voxels_max)));
    return std::max(std::clamp(wanted_mm, voxel_min_mm, voxel_max_mm), least_mm);
}

// The lower end of the ascending aorta, if a part has its name and is in the lumen: there the blood comes
// from the heart.
std::optional<Vector3d> root_by_name(const std::vector<Part> &parts, const WholeLumen &lumen,
                                     std::string &why)
{
    constexpr double share = 0.05, near_mm = 5.0;
    const bake::TriangleTree wall(lumen.closed);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        std::string name = parts[p].name;
        for (char &c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (name.find("ascending") == name.npos || name.find("descending") != name.npos ||
            name.find("aort") == name.npos || name.find("artery") != name.npos)
            continue;
        std::vector<Vector3d> places = lumen.own[p].vertices_mm;
        if (places.empty()) continue;
        std::sort(places.begin(), places.end(),
                  [](const Vector3d &a, const Vector3d &b) { return a.y() < b.y(); });
        places.resize(
            std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(places.size()))));
        Vector3d sum = Vector3d::Zero();
        for (const Vector3d &place : places) sum += place;
        const Vector3d root = sum / static_cast<double>(places.size());
        if (wall.nearest(root).distance_mm > near_mm) continue;
        why = "the lower end of " + parts[p].name;
        return root;
    }
    return std::nullopt;
}

// Instruments that are used through a sheath need some width. Into an aorta they come from below, so among
// the ends that are wide enough, the lowest is usual. Into other vessels they come with the blood.
TreeEnd chosen_end(const Tree &tree, const SceneWish &wish, std::string &why)
{
    constexpr double wide_mm = 1.5, low_mm = 60.0;
    std::vector<TreeEnd> ends = ends_of(tree);
    if (wish.entry_mm) {
        why = "the end nearest to the stated place";
        return *std::min_element(ends.begin(), ends.end(), [&](const TreeEnd &a, const TreeEnd &b) {
            return (a.place_mm - *wish.entry_mm).norm() < (b.place_mm - *wish.entry_mm).norm();
        });
    }
    const auto widest = [](const std::vector<TreeEnd> &some) {
        return *std::max_element(some.begin(), some.end(), [](const TreeEnd &a, const TreeEnd &b) {
            return a.radius_mm < b.radius_mm;
        });
    };
    const std::vector<Sphere> &root = tree.branches.front().spheres;
    if (const double root_mm = root[root.size() / 2].radius_mm; root_mm >= wide_mm && root_mm < aorta_mm) {
        why = "the inlet: a vessel that is no aorta is entered with the blood";
        return *std::find_if(ends.begin(), ends.end(), [](const TreeEnd &end) { return end.is_root; });
    }
    std::vector<TreeEnd> wide = ends;
    std::erase_if(wide, [&](const TreeEnd &end) { return end.radius_mm < wide_mm; });
    if (wide.empty()) {
        why = "the widest end; none is 3 mm wide";
        return widest(ends);
    }
    double lowest_mm = 1e9;
    for (const TreeEnd &end : wide) lowest_mm = std::min(lowest_mm, end.place_mm.y());
    std::erase_if(wide, [&](const TreeEnd &end) { return end.place_mm.y() > lowest_mm + low_mm; });
    why = formatted("the widest of %zu ends near the feet that are 3 mm wide", wide.size());
    return widest(wide);
}

// Goes inwards from an end until there is room for a sheath's end.
Entry entry_in(const Tree &tree, const TreeEnd &end, const bake::TriangleTree &wall)
{
    constexpr double ahead_mm = 5.0;
    Entry best;
    double best_mm = -INFINITY;
    for (double inside_mm = 15.0; inside_mm <= 45.0; inside_mm += 2.5) {
        for (const double at_mm : {inside_mm, 30.0 - inside_mm}) { // then also nearer to the end
            if (at_mm < 3.0) continue;
            const Entry entry = inside_end(tree, end, at_mm);
            const double room_mm = -wall.nearest(entry.place_mm).distance_mm;
            const double ahead = -wall.nearest(entry.place_mm + ahead_mm * entry.direction).distance_mm;
            const double least_mm = std::min(room_mm, ahead + 1.0);
            if (room_mm > 1.2 && ahead > 0.3 && room_mm > 0.6 * end.radius_mm) return entry;
            if (least_mm > best_mm) best_mm = least_mm, best = entry;
        }
    }
    // A scene needs 1 mm around the sheath's end, and room ahead.
    if (best_mm < 1.05)
        throw Fault(formatted(
            "no sheath fits into the end at %s: near it, the lumen's radius is at most %.1f mm, and "
            "1.1 mm are needed: choose a wider end by --entry; an atlas that draws vessels too thin "
            "can be widened (centreline auto, then convert --radii-times)",
            bake::place_text(end.place_mm).c_str(), std::max(0.0, best_mm)));
    return best;
}

// An elliptic cylinder of tissue around the vessels: a trunk for wide vessels, less for others.
bake::Mesh tissue_around(const bake::Mesh &lumen, double widest_mm)
{
    constexpr int around = 96, along = 24;
    Eigen::AlignedBox3d box;
    for (const Vector3d &v : lumen.vertices_mm) box.extend(v);
    const bool is_trunk = widest_mm >= 6.0;
    const double margin_mm = is_trunk ? 40 : 25, beyond_mm = is_trunk ? 80 : 50;
    const Vector3d half = box.sizes() / 2;
    const double across = std::max(std::numbers::sqrt2 * half.x() + margin_mm, is_trunk ? 165.0 : 75.0);
    const double deep = std::max(std::numbers::sqrt2 * half.z() + margin_mm, is_trunk ? 105.0 : 75.0);
    const Vector3d middle = box.center();
    bake::Mesh mesh;
    mesh.name = "tissue";
    const auto ring = [&](int i) {
        return middle.y() - half.y() - beyond_mm + (2 * half.y() + 2 * beyond_mm) * i / along;
    };
    for (int i = 0; i <= along; ++i)
        for (int j = 0; j < around; ++j) {
            const double angle = 2 * std::numbers::pi * j / around;
            mesh.vertices_mm.emplace_back(middle.x() + across * std::cos(angle), ring(i),
                                          middle.z() - deep * std::sin(angle));
        }
    for (const int i : {0, along}) mesh.vertices_mm.emplace_back(middle.x(), ring(i), middle.z());
    const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * around + j % around); };
    const std::uint32_t below = (along + 1) * around, above = below + 1;
    for (int j = 0; j < around; ++j) {
        for (int i = 0; i < along; ++i) {
            mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        }
        mesh.triangles.push_back({at(0, j + 1), at(0, j), below});
        mesh.triangles.push_back({at(along, j), at(along, j + 1), above});
    }
    bake::check_closed(mesh, bake::Cap::none);
    return mesh;
}

std::string quoted(const std::string &text)
{
    std::string made;
    for (char c : text) made += c == '"' || c == '\\' ? '\'' : c;
    return "\"" + made + "\"";
}

std::string bodies_text(const SceneWish &wish, const Frame &frame)
{
    std::string text;
    if (wish.has_bodies)
        text += "\n[[body]]\nname = \"tissue\"\nmesh = \"tissue.ply\"\nunit = \"mm\"\nmaterial = "
                "\"soft_tissue\"\n"
                "\n[[body]]\nname = \"blood\"\nmesh = \"lumen\"\nmaterial = \"blood\"\ninside = \"tissue\"\n";
    int number = 0;
    for (const std::string &body : wish.bodies) {
        const std::size_t colon = body.find(':');
        if (colon == std::string::npos || colon == 0 || colon + 1 == body.size())
            throw UsageError("--body " + body + ": state it as MATERIAL:FILE, like cortical_bone:pelvis.stl");
        const std::string material = body.substr(0, colon);
        const fs::path file = body.substr(colon + 1);
        const std::string ending = file.extension().string();
        const bool is_gltf = ending == ".glb" || ending == ".gltf";
        text += formatted("\n[[body]]\nname = \"body_%d\"\nmesh = %s\nunit = \"%s\"\nmaterial = %s\n",
                          ++number, quoted(fs::absolute(file).string()).c_str(),
                          is_gltf ? "m" : frame.unit.c_str(), quoted(material).c_str());
        if (wish.has_bodies) text += "inside = \"tissue\"\nless = [\"blood\"]\n";
        text += "cap = \"any\"\nsolid_mm = 0.8\nerror_mm = 0.4\n";
        if (material == "cortical_bone" || material == "bone") text += "shell_mm = 1.2\n";
        if (!is_gltf) {
            std::string axes;
            for (std::size_t at = 0; at < frame.axes.size(); at += 3)
                axes += (at ? ", \"" : "\"") + frame.axes.substr(at, 2) + "\"";
            text += "axes = [" + axes + "]\n";
        }
        const Vector3d &offset = frame.placement.offset_mm;
        if (offset.norm() > 0)
            text += formatted("offset_mm = [%.3f, %.3f, %.3f]\n", offset.x(), offset.y(), offset.z());
    }
    return text;
}

std::string scene_text(const SceneWish &wish, const Frame &frame, const Tree &tree, const Entry &entry,
                       const Choices &choices, double thinnest_mm, const CoronaryBranches &coronaries,
                       const std::vector<Outflow> &flows)
{
    std::string text =
        "# Made by `cournand patient new --mesh`. It may be changed and baked again:\n"
        "#   bake scene.toml -o patient.scene\n"
        "# What was decided, and the option of `cournand patient new` that decides otherwise:\n" +
        choices.text("#   ");
    text += "\n[scene]\nname = " + quoted(wish.name.substr(0, CRN_SCENE_NAME_BYTES - 1)) +
            "\nsource = \"a person's own meshes, by cournand patient new\"\n";
    text += "\n[lumen]\nmesh = \"lumen.ply\"\nunit = \"mm\"\n";
    // Voxels of 0.24 mm describe arteries that are a few voxels wide; they take more memory.
    if (thinnest_mm < 1.0) text += "level_max = 2\n";
    text += "\n[tree]\ncentrelines = [\"tree.csv\"]\ninlet = \"" + tree.branches.front().name +
            "\"\ninlet_end = \"first\"\n" + coronaries.scene_text() + patient::scene_text(flows);
    text += formatted("\n[entry]\nposition_mm = [%.3f, %.3f, %.3f]\ndirection = [%.5f, %.5f, %.5f]\n",
                      entry.place_mm.x(), entry.place_mm.y(), entry.place_mm.z(), entry.direction.x(),
                      entry.direction.y(), entry.direction.z());
    return text + bodies_text(wish, frame);
}

} // namespace

void make_scene_folder(const std::vector<Part> &parts, const Frame &frame, const SceneWish &wish,
                       Choices &choices, bake::Progress &progress)
{
    std::string unused = bodies_text(wish, frame); // refuses a wrong option before the work
    WholeLumen lumen = whole_lumen(parts, wish.lumen, choices, progress);
    centreline::LumenWish voxels;
    voxels.voxel_mm = voxel_for_tree(lumen);
    const centreline::Lumen inside(lumen.surface, voxels, progress);
    centreline::AutoWish automatic;
    automatic.inlet_mm = wish.lumen.inlet_mm;
    std::string inlet_why = "as stated";
    if (!automatic.inlet_mm) {
        inlet_why = "the widest opening or end";
        automatic.inlet_mm = root_by_name(parts, lumen, inlet_why);
    }
    automatic.shortest_mm = wish.shortest_mm;
    automatic.head = Vector3d::UnitY();
    std::vector<std::string> notes;
    Tree tree = centreline::fit_automatic(inside, automatic, notes, progress);
    for (Branch &branch : tree.branches)
        for (Sphere &sphere : branch.spheres) sphere.radius_mm = std::max(sphere.radius_mm, 0.1);
    open_ends(tree);
    const Sphere &inlet = tree.branches.front().spheres.front();
    const double inlet_mm = tree.branches.front().spheres[tree.branches.front().spheres.size() / 2].radius_mm;
    choices.add("inlet",
                bake::place_text(inlet.centre_mm) + formatted(", of a vessel of radius %.1f mm", inlet_mm),
                inlet_why, "--inlet x y z");
    name_tree(tree, parts, lumen, wish, choices);
    const CoronaryBranches coronaries = find_coronaries(tree, parts, choices);
    const std::vector<Outflow> flows = outflows(tree);
    choices.add("flows", formatted("%.0f ml/min in all, out of %zu ends", 60 * sum_ml_s(flows), flows.size()),
                "by Murray's law at a wall shear rate of 500/s, at a mean speed of at most 160 mm/s, from "
                "the radius of each vessel before its cap",
                "[tree.flow_ml_min] of scene.toml may be changed");
    const bake::TriangleTree wall(lumen.closed);
    std::string why;
    const TreeEnd end = chosen_end(tree, wish, why);
    const Entry entry = entry_in(tree, end, wall);
    choices.add("entry", bake::place_text(entry.place_mm) + formatted(" in %s", entry.branch.c_str()), why,
                "--entry x y z; the start length is bake's");
    double widest_mm = 0, thinnest_mm = INFINITY;
    for (const Branch &branch : tree.branches) {
        const double radius_mm = branch.spheres[branch.spheres.size() / 2].radius_mm;
        widest_mm = std::max(widest_mm, radius_mm);
        thinnest_mm = std::min(thinnest_mm, radius_mm);
    }
    choices.add("bodies",
                wish.has_bodies ? formatted("tissue, blood%s", wish.bodies.empty() ? "" : " and those stated")
                                : "none",
                "an elliptic cylinder of soft tissue around the vessels",
                "--no-bodies, --body MATERIAL:FILE");
    const std::string session =
        practice_session(wish.folder / "patient.scene", tree, end, entry.inside_mm, choices);
    fs::create_directories(wish.folder);
    bake::write_ply(lumen.closed, wish.folder / "lumen.ply");
    centreline::write_tree(wish.folder / "tree.csv", tree);
    if (wish.has_bodies) bake::write_ply(tissue_around(lumen.closed, widest_mm), wish.folder / "tissue.ply");
    write_whole_file((wish.folder / "scene.toml").string(),
                     scene_text(wish, frame, tree, entry, choices, thinnest_mm, coronaries, flows));
    bake::Options options;
    options.scene = wish.folder / "scene.toml";
    options.output = wish.folder / "patient.scene";
    options.points = 20000;
    options.poses = 1000;
    write_whole_file((wish.folder / "bake.txt").string(), bake::bake(options, progress));
    write_whole_file((wish.folder / "practice.session").string(), session);
    for (const std::string &note : notes) choices.add("note", note, "", "");
}

} // namespace crn::patient
