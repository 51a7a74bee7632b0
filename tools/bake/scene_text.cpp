// Reads the text of a scene. Every error message names the file, the line and the key at fault.
#include "tools/bake/scene_text.hpp"
#include "host/base/number_text.hpp"
#include "host/base/toml_reader.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/mesh/lesion_ranges.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

namespace crn::bake
{
namespace
{

// Holds one table of the scene's text, and the folders in which the files named by the text may lie.
struct Table : TomlTable {
    Table(const TomlTable &table, const Folders &folders_) : TomlTable(table), folders(folders_) {}
    const Folders &folders;

    Eigen::Vector3d vector(const char *key) const { return vector((*this)[key]); }
    static Eigen::Vector3d vector(const TomlValue &value) { return Eigen::Vector3d(value.three(1e6).data()); }

    // Reads a key that gives two opposite corners of a box, and returns the box; the box is empty if the
    // scene's text lacks the key.
    Eigen::AlignedBox3d box(const char *key) const
    {
        const TomlValue value = (*this)[key];
        if (!value) return {};
        if (!value.is_list() || value.list().size() != 2)
            value.fail_key("must be two corners, like [[-50, 0, -50], [50, 90, 50]]");
        const std::vector<TomlValue> corners = value.list();
        const Eigen::AlignedBox3d box(vector(corners[0]), vector(corners[1]));
        if ((box.sizes().array() <= 0).any()) value.fail_key("must name the lower corner first");
        return box;
    }

    // Reads a value of the scene's text that is either a string or a list of strings.
    std::vector<std::string> texts(const char *key) const
    {
        return has(key) ? (*this)[key].texts() : std::vector<std::string>{};
    }

    std::filesystem::path resolve(const TomlValue &value) const
    {
        std::string advice;
        const std::filesystem::path path = locate(value, advice);
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored))
            value.fail_key("names " + path.string() + ", which is no readable file" + advice);
        return path;
    }

    std::filesystem::path resolve_folder(const TomlValue &value) const
    {
        std::string advice;
        const std::filesystem::path path = locate(value, advice);
        std::error_code ignored;
        if (!std::filesystem::is_directory(path, ignored))
            value.fail_key("names " + path.string() + ", which is no folder" + advice);
        return path;
    }

  private:
    std::filesystem::path locate(const TomlValue &value, std::string &advice) const
    {
        const std::string written = value.words();
        if (written.rfind("data:", 0) == 0) {
            advice = ": give the data's folder with --data";
            return folders.data / written.substr(5);
        }
        if (written.rfind("shipped:", 0) == 0) {
            advice = ": make it with `anatomy aorta -o FOLDER`, and give that folder with --shipped";
            return folders.shipped / written.substr(8);
        }
        return std::filesystem::path(file()).parent_path() / written;
    }
};

Eigen::Matrix3d axes_of(const Table &t)
{
    const TomlValue axes = t["axes"];
    if (!axes) return Eigen::Matrix3d::Identity();
    const std::vector<TomlValue> words = axes.is_list() ? axes.list() : std::vector<TomlValue>{};
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    static const std::string letters = "xyz";
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string word = words.size() == 3 && words[k].is_text() ? words[k].text() : "";
        const std::size_t axis = word.size() == 2 ? letters.find(word[1]) : std::string::npos;
        if (axis == std::string::npos || (word[0] != '+' && word[0] != '-'))
            axes.fail_key(
                "must name the file axes of left, head and anterior, like [\"+x\", \"+y\", \"+z\"]");
        matrix(static_cast<int>(k), static_cast<int>(axis)) = word[0] == '+' ? 1.0 : -1.0;
    }
    if (std::abs(matrix.determinant()) < 0.5)
        axes.fail_key("uses a file axis twice: name each of x, y, z once");
    if (matrix.determinant() < 0)
        axes.fail_key("would mirror the patient: check the signs against a place whose side is known");
    return matrix;
}

Eigen::Vector3d scale_of(const Table &t)
{
    const NumberRange range = {1e-3, 1e3};
    if (!t["scale"].is_list()) return Eigen::Vector3d::Constant(t.number("scale", range, 1.0));
    const Eigen::Vector3d scale = t.vector("scale");
    if (!range.contains(scale.minCoeff()) || !range.contains(scale.maxCoeff()))
        t["scale"].fail_key("must be a number, or three for left, head and anterior, from 0.001 to 1000");
    return scale;
}

// Rotates first about the axis to the patient's left, then about the axis to the head, then about the axis to
// the front. Each rotation is right-handed.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d &deg)
{
    constexpr double rad_per_deg = 3.14159265358979323846 / 180;
    return (Eigen::AngleAxisd(deg.z() * rad_per_deg, Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(deg.y() * rad_per_deg, Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(deg.x() * rad_per_deg, Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
}

Cap cap_of(const Table &t)
{
    const TomlValue cap = t["cap"];
    if (!cap) return Cap::none;
    if (cap.is_text() && cap.text() == "any") return Cap::any;
    if (!cap.is_truth()) cap.fail_key("must be true, false or \"any\"");
    return cap.truth() ? Cap::flat : Cap::none;
}

Placement placement_of(const Table &t)
{
    Placement placement;
    if (t.has("unit")) placement.unit = t["unit"].one_of({"m", "cm", "mm", "um"});
    placement.axes = axes_of(t);
    placement.scale = scale_of(t);
    if (t.has("rotate_deg")) placement.rotation = rotation_of(t.vector("rotate_deg"));
    if (t.has("offset_mm")) placement.offset_mm = t.vector("offset_mm");
    return placement;
}

MeshText mesh_of(const Table &t)
{
    MeshText mesh;
    mesh.placement = placement_of(t);
    mesh.file = t.resolve(t["mesh"]);
    mesh.cap = cap_of(t);
    mesh.parts = t.texts("parts");
    mesh.pieces_mm = t.box("pieces_mm");
    mesh.pieces_min_mm = t.number("pieces_min_mm", {0, 1000}, 0);
    if (mesh.placement.unit.empty()) t["mesh"].fail_key("needs its unit: add unit = \"mm\" (or m, cm, um)");
    return mesh;
}

std::vector<std::filesystem::path> centrelines_of(const Table &t)
{
    std::vector<std::filesystem::path> files;
    const TomlValue lines = t["centrelines"];
    if (!lines.is_list() || lines.list().empty()) lines.fail_key("must be a list of file names");
    for (const TomlValue &line : lines.list()) files.push_back(t.resolve(line));
    return files;
}

// Returns true if the key `key` of the scene's text selects the last point of a centreline, and false if it
// selects the first point.
bool is_last(const Table &t, const char *key, const char *standard)
{
    return (t.has(key) ? t[key].one_of({"first", "last"}) : standard) == "last";
}

LumenText lumen_of(const Table &t)
{
    t.check_keys({"mesh", "unit", "centrelines", "parts", "surface_mm", "solid_mm", "axes", "scale",
                  "rotate_deg", "offset_mm", "cap", "tolerance_mm", "level_max", "inside_mm", "outside_mm"});
    LumenText lumen;
    if (t.has("mesh") == t.has("centrelines")) t.fail("needs either mesh or centrelines");
    lumen.surface_mm = t.number("surface_mm", {0.1, 2}, lumen.surface_mm);
    lumen.tolerance_mm = t.number("tolerance_mm", {0.005, 1}, lumen.tolerance_mm);
    lumen.level_max = t.has("level_max") ? t.whole("level_max", {0, 2}) : lumen.level_max;
    lumen.inside_mm = t.number("inside_mm", {1, 3.5}, lumen.inside_mm);
    lumen.outside_mm = t.number("outside_mm", {1, 3.5}, lumen.outside_mm);
    if (t.has("mesh")) {
        lumen.mesh = mesh_of(t);
        lumen.solid_mm = t.number("solid_mm", {0.1, 2}, 0);
        return lumen;
    }
    if (t.has("solid_mm"))
        t["solid_mm"].fail_key("belongs to a mesh: the voxel of a lumen made of centrelines is surface_mm");
    if (t.has("unit")) t["unit"].fail_key("belongs to a mesh: centreline files state their own");
    lumen.mesh.placement = placement_of(t);
    lumen.centrelines = centrelines_of(t);
    return lumen;
}

TreeText tree_of(const Table &t)
{
    t.check_keys({"centrelines", "axes", "scale", "rotate_deg", "offset_mm", "inlet", "inlet_end",
                  "flow_ml_min", "left_coronary", "right_coronary", "small"});
    TreeText tree;
    tree.centrelines = centrelines_of(t);
    tree.placement = placement_of(t);
    tree.inlet = t.text("inlet", CRN_SCENE_BRANCH_NAME_BYTES - 1, "");
    tree.inlet_is_last = is_last(t, "inlet_end", "first");
    tree.left_coronary = t.texts("left_coronary");
    tree.right_coronary = t.texts("right_coronary");
    if (t.has("small")) tree.small = t.resolve(t["small"]);
    if (!t.has("flow_ml_min")) return tree;
    if (!t["flow_ml_min"].is_table())
        t["flow_ml_min"].fail_key("must be a table, like { right_renal_artery = 500 }");
    for (const TomlValue &value : t.table("flow_ml_min").values()) {
        const double flow = value.number();
        if (!(flow > 0.0 && flow <= 20000.0))
            value.fail("flow_ml_min of '" + value.key() + "' must be above 0, at most 20000");
        tree.flow_ml_min[value.key()] = flow;
    }
    return tree;
}

EntryText entry_of(const Table &t)
{
    t.check_keys({"position_mm", "direction", "centreline", "end", "distance_mm", "inserted_mm"});
    EntryText entry;
    if (t.has("inserted_mm"))
        entry.inserted_mm = t.number("inserted_mm", {0.001, int{CRN_SCENE_ENTRY_START_MAX_um} * 1e-3}, 0.0);
    if (const TomlValue line = t["centreline"]) {
        if (t.has("position_mm") || t.has("direction"))
            line.fail("takes either centreline or position_mm and direction, not both");
        entry.centreline = t.resolve(line);
        entry.distance_mm = t.number("distance_mm", {0, 1000}, entry.distance_mm);
        entry.from_last = is_last(t, "end", "last");
        return entry;
    }
    entry.position_mm = t.vector("position_mm");
    entry.direction = t.vector("direction");
    if (entry.direction.norm() < 1e-6) t["direction"].fail_key("has no length");
    entry.direction.normalize();
    return entry;
}

MotionText motion_of(const Table &t, const LumenText &lumen)
{
    t.check_keys(
        {"frames", "inhaled", "guides", "inhaled_guides", "spacing_mm", "breath_spacing_mm", "end_systole"});
    MotionText motion;
    const TomlValue frames = t["frames"];
    if (!frames) t.fail("needs frames, the folder of the 24 meshes");
    motion.frames = t.resolve_folder(frames);
    if (t.has("inhaled")) motion.inhaled = t.resolve(t["inhaled"]);
    if (t.has("guides")) motion.guides = t.resolve_folder(t["guides"]);
    if (t.has("inhaled_guides")) motion.inhaled_guides = t.resolve(t["inhaled_guides"]);
    if (!motion.inhaled_guides.empty() && (motion.guides.empty() || motion.inhaled.empty()))
        frames.fail("has inhaled_guides: give guides and inhaled as well");
    motion.spacing_mm = t.number("spacing_mm", {0.98, 15.7}, motion.spacing_mm);
    motion.breath_spacing_mm = t.number("breath_spacing_mm", {0.98, 15.7}, motion.breath_spacing_mm);
    motion.end_systole = t.number("end_systole", {4, 18}, motion.end_systole);
    if (lumen.solid_mm > 0)
        frames.fail(
            "moves the lumen's own triangles, but [lumen] solid_mm makes others: give a mesh of one piece");
    if (lumen.mesh.file.empty())
        frames.fail("moves a lumen that is made of centrelines: give [lumen] a mesh, the first frame");
    return motion;
}

FormText form_of(const Table &t)
{
    FormText form;
    form.solid_mm = t.number("solid_mm", {0.2, 10}, 0);
    form.error_mm = t.number("error_mm", {0.01, 10}, 0);
    form.shell_mm = t.number("shell_mm", {0.2, 20}, 0);
    form.gap_mm = t.number("gap_mm", {0, 20}, form.gap_mm);
    form.less = t.texts("less");
    form.close_mm = t.number("close_mm", {0.2, 50}, 0);
    form.clip_mm = t.box("clip_mm");
    form.marrow = t.text("marrow", CRN_SCENE_MATERIAL_BYTES - 1, "trabecular_bone");
    const bool needs_solid =
        !form.less.empty() || form.shell_mm > 0 || form.close_mm > 0 || !form.clip_mm.isEmpty();
    if (form.solid_mm == 0 && needs_solid)
        t.fail("needs solid_mm, the voxel in which close_mm, clip_mm, less and shell_mm are made: about "
               "0.8 for bones");
    return form;
}

BodyText body_of(const Table &t, bool scene_moves)
{
    t.check_keys({"name",     "mesh",     "parts",    "pieces_mm", "pieces_min_mm", "unit",
                  "material", "inside",   "axes",     "scale",     "rotate_deg",    "offset_mm",
                  "cap",      "solid_mm", "close_mm", "clip_mm",   "less",          "gap_mm",
                  "error_mm", "shell_mm", "marrow",   "moves",     "inhaled",       "trabeculae"});
    BodyText body;
    body.name = t.text("name", CRN_SCENE_BODY_NAME_BYTES - 1, "");
    body.material = t.text("material", CRN_SCENE_MATERIAL_BYTES - 1, "");
    body.inside = t.text("inside", CRN_SCENE_BODY_NAME_BYTES - 1, "");
    if (body.name.empty()) t.fail("needs a name");
    if (body.material.empty()) t.fail("'" + body.name + "' needs a material");
    if (!t.has("mesh")) t.fail("'" + body.name + "' needs a mesh");
    body.is_lumen = t.text("mesh", 4096, "") == "lumen";
    if (!body.is_lumen) body.mesh = mesh_of(t);
    body.form = form_of(t);
    if (t.has("moves")) body.moves = t["moves"].truth();
    if (t.has("trabeculae")) body.trabeculae = t["trabeculae"].truth();
    if (body.moves && !scene_moves)
        t["moves"].fail("'" + body.name + "' moves, but the scene has no [motion]");
    if (!t.has("inhaled")) return body;
    body.inhaled = t.resolve(t["inhaled"]);
    if (body.moves)
        t["inhaled"].fail("'" + body.name +
                          "' has inhaled and moves with [motion], which has its own breath: "
                          "give one of the two");
    if (body.is_lumen || body.form.solid_mm > 0 || body.form.error_mm > 0)
        t["inhaled"].fail("'" + body.name +
                          "' has inhaled, so its mesh must stay as it is: give a mesh file, and neither "
                          "solid_mm nor error_mm");
    return body;
}

LesionText lesion_of(const Table &t)
{
    t.check_keys({"name", "branch", "at_mm", "length_mm", "stenosis_percent", "eccentricity", "plaque_deg",
                  "calcified_deg", "inside", "yield_kPa", "full_kPa", "recoil"});
    LesionText lesion;
    lesion.name = t["name"].text(CRN_SCENE_BODY_NAME_BYTES - 1 - 8); // "_calcium" must fit behind the name
    lesion.branch = t["branch"].text(CRN_SCENE_BRANCH_NAME_BYTES - 1);
    lesion.at_mm = t.number("at_mm", lesion_at_mm);
    lesion.length_mm = t.number("length_mm", lesion_length_mm);
    lesion.stenosis_percent = t.number("stenosis_percent", lesion_stenosis_percent);
    lesion.eccentricity = t.number("eccentricity", lesion_eccentricity, 0);
    lesion.plaque_deg = t.number("plaque_deg", lesion_plaque_deg, 0);
    lesion.calcified_deg = t.number("calcified_deg", lesion_calcified_deg, 0);
    lesion.inside = t.text("inside", CRN_SCENE_BODY_NAME_BYTES - 1, "");
    lesion.yield_kPa = t.number("yield_kPa", {1, 4000}, 300 + 2 * lesion.calcified_deg);
    lesion.full_kPa = t.number("full_kPa", {1, 4000}, 300);
    lesion.recoil = t.number("recoil", {0, 1}, 0.35);
    if (lesion.name.empty()) t["name"].fail("needs a name that is not empty");
    if (!lesion.inside.empty() && lesion.calcified_deg == 0)
        t["inside"].fail_key("says where calcium lies: give calcified_deg as well");
    return lesion;
}

double zero_or(const Table &t, const char *key, NumberRange range, double usual)
{
    const TomlValue value = t[key];
    return !value ? usual : value.number() == 0 ? 0 : value.number(range);
}

WallLawText wall_law_of(const Table &t, const WallLawText &usual)
{
    WallLawText law;
    law.bed_kPa = zero_or(t, "bed_kPa", {1, 10000}, usual.bed_kPa);
    law.distensibility_per_kPa =
        zero_or(t, "distensibility_per_kPa", {0.0004, 0.4}, usual.distensibility_per_kPa);
    law.relax_ms =
        t.number("relax_ms", {CRN_SCENE_WALL_RELAX_MIN_ms, CRN_SCENE_WALL_RELAX_MAX_ms}, usual.relax_ms);
    law.carry_mm = t.number("carry_mm", {0, int{CRN_SCENE_WALL_CARRY_MAX_um} * 1e-3}, usual.carry_mm);
    law.way_max_mm = t.number("way_max_mm", {0, int{CRN_SCENE_WALL_WAY_MAX_um} * 1e-3}, usual.way_max_mm);
    law.widen_max_mm =
        t.number("widen_max_mm", {0, int{CRN_SCENE_WALL_WIDEN_MAX_um} * 1e-3}, usual.widen_max_mm);
    return law;
}

// The field describes the wall up to `outside_mm` beyond it, and in bricks of the finest level only within
// four voxels. A tool on a wall that has widened needs 0.4 mm more, for the depth of its contact.
void check_widening(const Table &t, const WallLawText &law, const LumenText &lumen)
{
    constexpr double band_mm[] = {3.9, 1.9, 0.97}, depth_mm = 0.4;
    const double most_mm = std::min(lumen.outside_mm, band_mm[lumen.level_max]) - depth_mm;
    if (law.widen_max_mm <= most_mm + 1e-9 || law.distensibility_per_kPa == 0) return;
    t.fail("'widen_max_mm' = " + trimmed_text(law.widen_max_mm, 3) + " leaves the distance field: at most " +
           trimmed_text(most_mm, 2) + " with outside_mm = " + trimmed_text(lumen.outside_mm, 2) +
           " and level_max = " + std::to_string(lumen.level_max) + " of [lumen]");
}

WallsText walls_of(const Table &t, const LumenText &lumen)
{
    t.check_keys({"bed_kPa", "distensibility_per_kPa", "relax_ms", "carry_mm", "way_max_mm", "widen_max_mm",
                  "branch"});
    WallsText walls;
    walls.is_given = true;
    walls.everywhere = wall_law_of(t, {});
    check_widening(t, walls.everywhere, lumen);
    for (const TomlTable &row : t.tables("branch")) {
        const Table branch(row.inside("[[walls.branch]]"), t.folders);
        branch.check_keys({"names", "bed_kPa", "distensibility_per_kPa", "relax_ms", "carry_mm", "way_max_mm",
                           "widen_max_mm"});
        WallBranchText text;
        text.place = t.file() + ":" + std::to_string(branch["names"].line()) + ": [[walls.branch]]: ";
        text.names = branch.texts("names");
        if (text.names.empty())
            branch.fail("needs names = [\"lad\", \"renal_*\"], the branches that it is for");
        text.law = wall_law_of(branch, walls.everywhere);
        check_widening(branch, text.law, lumen);
        walls.branches.push_back(std::move(text));
    }
    return walls;
}

void check_lesions(const SceneText &scene)
{
    std::set<std::string> names, bodies;
    for (const BodyText &body : scene.bodies) bodies.insert(body.name);
    for (const LesionText &lesion : scene.lesions) {
        if (!names.insert(lesion.name).second)
            throw Fault(scene.file.string() + ": two lesions are called '" + lesion.name + "': rename one");
        if (!lesion.inside.empty() && !bodies.count(lesion.inside))
            throw Fault(scene.file.string() + ": the calcium of lesion '" + lesion.name + "' lies inside '" +
                        lesion.inside + "', which is no body: correct `inside`");
        if (bodies.count(lesion.name + "_calcium"))
            throw Fault(scene.file.string() + ": a body is called '" + lesion.name + "_calcium' as lesion '" +
                        lesion.name + "' will call its own: rename one");
    }
    if (scene.lesions.size() > CRN_SCENE_LESION_MAX)
        throw Fault(scene.file.string() + ": more than " + std::to_string(int{CRN_SCENE_LESION_MAX}) +
                    " lesions: leave some out");
    const auto calcified = static_cast<std::size_t>(
        std::count_if(scene.lesions.begin(), scene.lesions.end(),
                      [](const LesionText &lesion) { return lesion.calcified_deg > 0; }));
    if (scene.bodies.size() + calcified > CRN_SCENE_BODY_MAX)
        throw Fault(scene.file.string() + ": " + std::to_string(scene.bodies.size()) +
                    " bodies and the calcium of " + std::to_string(calcified) + " lesions are more than " +
                    std::to_string(CRN_SCENE_BODY_MAX) + ": join some bodies, or leave out calcified_deg");
}

// Adds a marrow body inside every body that has a shell; the marrow directly follows that body in the list.
void add_marrows(SceneText &scene)
{
    std::vector<BodyText> all;
    for (const BodyText &body : scene.bodies) {
        all.push_back(body);
        if (body.form.shell_mm == 0) continue;
        BodyText marrow;
        marrow.name = body.name + "_marrow";
        marrow.material = body.form.marrow;
        marrow.inside = body.name;
        marrow.is_marrow = true;
        marrow.moves = body.moves;
        marrow.trabeculae = body.trabeculae;
        marrow.form.solid_mm = body.form.solid_mm;
        marrow.form.error_mm = body.form.error_mm;
        marrow.form.shell_mm = body.form.shell_mm;
        if (marrow.name.size() >= CRN_SCENE_BODY_NAME_BYTES)
            throw Fault(scene.file.string() + ": the name '" + marrow.name +
                        "' is too long: shorten that of '" + body.name + "'");
        all.push_back(marrow);
    }
    scene.bodies = std::move(all);
}

void check_bodies(const SceneText &scene)
{
    std::set<std::string> names;
    for (const BodyText &body : scene.bodies) {
        for (const std::string &other : body.form.less)
            if (!names.count(other))
                throw Fault(scene.file.string() + ": body '" + body.name + "' is less '" + other +
                            "', which is no body above it: write that one first");
        if (!names.insert(body.name).second)
            throw Fault(scene.file.string() + ": two bodies are called '" + body.name + "': rename one");
    }
    for (const BodyText &body : scene.bodies)
        if (!body.inside.empty() && (!names.count(body.inside) || body.inside == body.name))
            throw Fault(scene.file.string() + ": body '" + body.name + "' lies inside '" + body.inside +
                        "', which is no other body: correct `inside`");
    if (scene.bodies.size() > CRN_SCENE_BODY_MAX)
        throw Fault(scene.file.string() + ": more than " + std::to_string(CRN_SCENE_BODY_MAX) +
                    " bodies: join some");
}

} // namespace

// The names of spongy bone are those of host/xray/paths/materials.cpp.
bool BodyText::is_trabecular() const
{
    const std::set<std::string> spongy = {"bone_spongy", "trabecular_bone", "spongy", "marrow"};
    return trabeculae && (spongy.count(material) != 0 || material.starts_with("spongy_"));
}

SceneText read_scene_text(const std::filesystem::path &file, const Folders &folders)
{
    SceneText scene;
    scene.file = file;
    const TomlTable root = read_toml(file.string(), {"a scene text", "the scene's TOML text (docs/scene.md)",
                                                     ": give the TOML file, not a mesh"});
    const auto table = [&](const char *key) {
        return Table(root.table(key).inside("[" + std::string(key) + "]"), folders);
    };
    root.check_keys({"scene", "lumen", "tree", "entry", "motion", "walls", "lesion", "body"});
    const Table head = table("scene");
    head.check_keys({"name", "source"});
    scene.name = head.text("name", CRN_SCENE_NAME_BYTES - 1, "");
    scene.source = head.text("source", CRN_SCENE_SOURCE_BYTES - 1, "");
    if (scene.name.empty()) head.fail("needs a name");
    scene.lumen = lumen_of(table("lumen"));
    if (root.has("tree")) {
        scene.tree = tree_of(table("tree"));
    } else {
        scene.tree.centrelines = scene.lumen.centrelines;
        scene.tree.placement = scene.lumen.mesh.placement;
        scene.tree.is_of_lumen = true;
    }
    scene.entry = entry_of(table("entry"));
    if (root.has("motion")) scene.motion = motion_of(table("motion"), scene.lumen);
    if (root.has("walls")) scene.walls = walls_of(table("walls"), scene.lumen);
    for (const TomlTable &body : root.tables("body"))
        scene.bodies.push_back(body_of({body.inside("[[body]]"), folders}, root.has("motion")));
    for (const TomlTable &lesion : root.tables("lesion"))
        scene.lesions.push_back(lesion_of({lesion.inside("[[lesion]]"), folders}));
    add_marrows(scene);
    check_bodies(scene);
    check_lesions(scene);
    return scene;
}

} // namespace crn::bake
