// Reads the text of a scene with toml++. Every error message names file, line and key.
#include "tools/bake/scene_text.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/bake/toml_file.hpp"
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

// Holds one table of the text, with the place that error messages name.
struct Table {
    const SceneText &scene;
    const Folders &folders;
    std::string name; // "[lumen]"
    const toml::table &table;

    [[noreturn]] void fail(const toml::node *node, const std::string &what) const
    {
        const auto line = node ? node->source().begin.line : table.source().begin.line;
        throw Fault(scene.file.string() + ":" + std::to_string(line) + ": " + name + " " + what);
    }

    void only(const std::set<std::string> &keys) const
    {
        for (const auto &[key, node] : table) {
            if (keys.count(std::string(key.str()))) continue;
            std::string list;
            for (const std::string &known : keys) list += (list.empty() ? "" : ", ") + known;
            fail(&node, "has no key '" + std::string(key.str()) + "': use one of " + list);
        }
    }

    std::string text(const char *key, const std::string &standard, std::size_t bytes_max) const
    {
        const toml::node *node = table.get(key);
        if (!node) return standard;
        if (!node->is_string()) fail(node, std::string(key) + " must be a text in quotes");
        const std::string value = node->value<std::string>().value();
        if (value.size() > bytes_max)
            fail(node,
                 std::string(key) + " is longer than " + std::to_string(bytes_max) + " bytes: shorten it");
        for (unsigned char c : value)
            if (c < 0x20 || c == 0x7f) fail(node, std::string(key) + " holds a control character: remove it");
        return value;
    }
    double number(const char *key, double standard, const NumberRange &range) const
    {
        return number(key, standard, range.low, range.high);
    }

    double number(const char *key, double standard, double low, double high) const
    {
        const toml::node *node = table.get(key);
        if (!node) return standard;
        const double value = node->value<double>().value_or(NAN);
        if (!(value >= low && value <= high)) {
            char range[64];
            std::snprintf(range, sizeof range, " must be a number from %g to %g", low, high);
            fail(node, key + std::string(range));
        }
        return value;
    }

    Eigen::Vector3d vector(const char *key) const { return vector(table.get(key), key); }

    Eigen::Vector3d vector(const toml::node *node, const char *key) const
    {
        const toml::array *array = node ? node->as_array() : nullptr;
        Eigen::Vector3d value;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto component =
                array && array->size() == 3 ? array->get(k)->value<double>() : std::nullopt;
            if (!component || !std::isfinite(*component) || std::abs(*component) > 1e6)
                fail(node,
                     std::string(key) + " must be three numbers within a million, like [1.0, 0.0, 0.0]");
            value[static_cast<int>(k)] = *component;
        }
        return value;
    }

    // Returns the box between two opposite corners; the box is empty when the key is missing.
    Eigen::AlignedBox3d box(const char *key) const
    {
        const toml::node *node = table.get(key);
        if (!node) return {};
        const toml::array *array = node->as_array();
        if (!array || array->size() != 2)
            fail(node, std::string(key) + " must be two corners, like [[-50, 0, -50], [50, 90, 50]]");
        const Eigen::AlignedBox3d box(vector(array->get(0), key), vector(array->get(1), key));
        if ((box.sizes().array() <= 0).any())
            fail(node, std::string(key) + " must name the lower corner first");
        return box;
    }

    // Reads a value that is either a string or a list of strings.
    std::vector<std::string> texts(const char *key) const
    {
        const toml::node *node = table.get(key);
        if (!node) return {};
        if (node->is_string()) return {text(key, "", 255)};
        std::vector<std::string> list;
        const toml::array *array = node->as_array();
        for (std::size_t i = 0; array && i < array->size(); ++i)
            list.push_back(array->get(i)->value<std::string>().value_or(""));
        for (const std::string &word : list)
            if (word.empty()) list.clear();
        if (list.empty()) fail(node, std::string(key) + " must be a list of names in quotes");
        return list;
    }

    std::filesystem::path resolve(const toml::node *node, const char *key) const
    {
        std::string advice;
        const std::filesystem::path path = locate(node, key, advice);
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored))
            fail(node, std::string(key) + " names " + path.string() + ", which is no readable file" + advice);
        return path;
    }

    std::filesystem::path resolve_folder(const toml::node *node, const char *key) const
    {
        std::string advice;
        const std::filesystem::path path = locate(node, key, advice);
        std::error_code ignored;
        if (!std::filesystem::is_directory(path, ignored))
            fail(node, std::string(key) + " names " + path.string() + ", which is no folder" + advice);
        return path;
    }

  private:
    std::filesystem::path locate(const toml::node *node, const char *key, std::string &advice) const
    {
        const std::string written = node->value<std::string>().value_or("");
        if (written.empty()) fail(node, std::string(key) + " must be a file name in quotes");
        if (written.rfind("data:", 0) == 0) {
            advice = ": give the data's folder with --data";
            return folders.data / written.substr(5);
        }
        if (written.rfind("shipped:", 0) == 0) {
            advice = ": make it with `anatomy aorta -o FOLDER`, and give that folder with --shipped";
            return folders.shipped / written.substr(8);
        }
        return scene.file.parent_path() / written;
    }
};

Eigen::Matrix3d axes_of(const Table &t)
{
    const toml::node *node = t.table.get("axes");
    if (!node) return Eigen::Matrix3d::Identity();
    const toml::array *array = node->as_array();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
    static const std::string letters = "xyz";
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string word =
            array && array->size() == 3 ? array->get(k)->value<std::string>().value_or("") : "";
        const std::size_t axis = word.size() == 2 ? letters.find(word[1]) : std::string::npos;
        if (axis == std::string::npos || (word[0] != '+' && word[0] != '-'))
            t.fail(node,
                   "axes must name the file axes of left, head and anterior, like [\"+x\", \"+y\", \"+z\"]");
        axes(static_cast<int>(k), static_cast<int>(axis)) = word[0] == '+' ? 1.0 : -1.0;
    }
    if (std::abs(axes.determinant()) < 0.5)
        t.fail(node, "axes uses a file axis twice: name each of x, y, z once");
    if (axes.determinant() < 0)
        t.fail(node, "axes would mirror the patient: check the signs against a place whose side is known");
    return axes;
}

Eigen::Vector3d scale_of(const Table &t)
{
    const toml::node *node = t.table.get("scale");
    if (!node || !node->is_array()) return Eigen::Vector3d::Constant(t.number("scale", 1.0, 1e-3, 1e3));
    const Eigen::Vector3d scale = t.vector("scale");
    if (scale.minCoeff() < 1e-3 || scale.maxCoeff() > 1e3)
        t.fail(node, "scale must be a number, or three for left, head and anterior, from 0.001 to 1000");
    return scale;
}

// Rotates first about the axis to the left, then to the head, then to the front; each rotation is
// right-handed about its axis.
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
    const toml::node *node = t.table.get("cap");
    if (!node) return Cap::none;
    if (node->is_string() && node->value<std::string>().value() == "any") return Cap::any;
    if (!node->is_boolean()) t.fail(node, "cap must be true, false or \"any\"");
    return node->value<bool>().value() ? Cap::flat : Cap::none;
}

Placement placement_of(const Table &t)
{
    Placement placement;
    placement.unit = t.text("unit", "", 8);
    if (!placement.unit.empty() && millimetres_per(placement.unit) == 0)
        t.fail(t.table.get("unit"), "unit is '" + placement.unit + "': use m, cm, mm or um");
    placement.axes = axes_of(t);
    placement.scale = scale_of(t);
    if (t.table.contains("rotate_deg")) placement.rotation = rotation_of(t.vector("rotate_deg"));
    if (t.table.contains("offset_mm")) placement.offset_mm = t.vector("offset_mm");
    return placement;
}

MeshText mesh_of(const Table &t)
{
    MeshText mesh;
    mesh.placement = placement_of(t);
    mesh.file = t.resolve(t.table.get("mesh"), "mesh");
    mesh.cap = cap_of(t);
    mesh.parts = t.texts("parts");
    mesh.pieces_mm = t.box("pieces_mm");
    mesh.pieces_min_mm = t.number("pieces_min_mm", 0, 0, 1000);
    if (mesh.placement.unit.empty())
        t.fail(t.table.get("mesh"), "mesh needs its unit: add unit = \"mm\" (or m, cm, um)");
    return mesh;
}

std::vector<std::filesystem::path> centrelines_of(const Table &t, const toml::node *lines)
{
    std::vector<std::filesystem::path> files;
    const toml::array *array = lines->as_array();
    if (!array || array->empty()) t.fail(lines, "centrelines must be a list of file names");
    for (const toml::node &node : *array) files.push_back(t.resolve(&node, "centrelines"));
    return files;
}

LumenText lumen_of(const Table &t)
{
    t.only({"mesh", "unit", "centrelines", "parts", "surface_mm", "axes", "scale", "rotate_deg", "offset_mm",
            "cap", "tolerance_mm", "level_max", "inside_mm", "outside_mm"});
    LumenText lumen;
    const toml::node *mesh = t.table.get("mesh"), *lines = t.table.get("centrelines");
    if (!mesh == !lines) t.fail(nullptr, "needs either mesh or centrelines");
    lumen.surface_mm = t.number("surface_mm", lumen.surface_mm, 0.1, 2);
    lumen.tolerance_mm = t.number("tolerance_mm", lumen.tolerance_mm, 0.005, 1);
    lumen.level_max = static_cast<int>(t.number("level_max", lumen.level_max, 0, 2));
    lumen.inside_mm = t.number("inside_mm", lumen.inside_mm, 1, 3.5);
    lumen.outside_mm = t.number("outside_mm", lumen.outside_mm, 1, 3.5);
    if (mesh) {
        lumen.mesh = mesh_of(t);
        return lumen;
    }
    if (t.table.contains("unit"))
        t.fail(t.table.get("unit"), "unit belongs to a mesh: centreline files state their own");
    lumen.mesh.placement = placement_of(t);
    lumen.centrelines = centrelines_of(t, lines);
    return lumen;
}

TreeText tree_of(const Table &t)
{
    t.only({"centrelines", "axes", "scale", "rotate_deg", "offset_mm", "inlet", "inlet_end", "flow_ml_min",
            "left_coronary", "right_coronary"});
    TreeText tree;
    if (!t.table.contains("centrelines")) t.fail(nullptr, "needs centrelines");
    tree.centrelines = centrelines_of(t, t.table.get("centrelines"));
    tree.placement = placement_of(t);
    tree.inlet = t.text("inlet", "", CRN_SCENE_BRANCH_NAME_BYTES - 1);
    const std::string end = t.text("inlet_end", "first", 8);
    if (end != "first" && end != "last")
        t.fail(t.table.get("inlet_end"), "inlet_end must be \"first\" or \"last\"");
    tree.inlet_is_last = end == "last";
    tree.left_coronary = t.texts("left_coronary");
    tree.right_coronary = t.texts("right_coronary");
    const toml::node *flows = t.table.get("flow_ml_min");
    if (!flows) return tree;
    if (!flows->is_table()) t.fail(flows, "flow_ml_min must be a table, like { right_renal_artery = 500 }");
    for (const auto &[name, node] : *flows->as_table()) {
        const double flow = node.value<double>().value_or(NAN);
        if (!(flow > 0.0 && flow <= 20000.0))
            t.fail(&node, "flow_ml_min of '" + std::string(name.str()) + "' must be above 0, at most 20000");
        tree.flow_ml_min[std::string(name.str())] = flow;
    }
    return tree;
}

EntryText entry_of(const Table &t)
{
    t.only({"position_mm", "direction", "centreline", "end", "distance_mm"});
    EntryText entry;
    if (const toml::node *line = t.table.get("centreline")) {
        if (t.table.contains("position_mm") || t.table.contains("direction"))
            t.fail(line, "takes either centreline or position_mm and direction, not both");
        entry.centreline = t.resolve(line, "centreline");
        entry.distance_mm = t.number("distance_mm", entry.distance_mm, 0, 1000);
        const std::string end = t.text("end", "last", 8);
        if (end != "first" && end != "last") t.fail(t.table.get("end"), "end must be \"first\" or \"last\"");
        entry.from_last = end == "last";
        return entry;
    }
    entry.position_mm = t.vector("position_mm");
    entry.direction = t.vector("direction");
    if (entry.direction.norm() < 1e-6) t.fail(t.table.get("direction"), "direction has no length");
    entry.direction.normalize();
    return entry;
}

MotionText motion_of(const Table &t)
{
    t.only(
        {"frames", "inhaled", "guides", "inhaled_guides", "spacing_mm", "breath_spacing_mm", "end_systole"});
    MotionText motion;
    const toml::node *frames = t.table.get("frames");
    if (!frames) t.fail(nullptr, "needs frames, the folder of the 24 meshes");
    motion.frames = t.resolve_folder(frames, "frames");
    if (const toml::node *inhaled = t.table.get("inhaled")) motion.inhaled = t.resolve(inhaled, "inhaled");
    if (const toml::node *guides = t.table.get("guides")) motion.guides = t.resolve_folder(guides, "guides");
    if (const toml::node *inhaled = t.table.get("inhaled_guides"))
        motion.inhaled_guides = t.resolve(inhaled, "inhaled_guides");
    if (!motion.inhaled_guides.empty() && (motion.guides.empty() || motion.inhaled.empty()))
        t.fail(frames, "has inhaled_guides: give guides and inhaled as well");
    motion.spacing_mm = t.number("spacing_mm", motion.spacing_mm, 0.98, 15.7);
    motion.breath_spacing_mm = t.number("breath_spacing_mm", motion.breath_spacing_mm, 0.98, 15.7);
    motion.end_systole = t.number("end_systole", motion.end_systole, 4, 18);
    if (t.scene.lumen.mesh.file.empty())
        t.fail(frames, "moves a lumen that is made of centrelines: give [lumen] a mesh, the first frame");
    return motion;
}

FormText form_of(const Table &t)
{
    FormText form;
    form.solid_mm = t.number("solid_mm", 0, 0.2, 10);
    form.error_mm = t.number("error_mm", 0, 0.01, 10);
    form.shell_mm = t.number("shell_mm", 0, 0.2, 20);
    form.gap_mm = t.number("gap_mm", form.gap_mm, 0, 20);
    form.less = t.texts("less");
    form.close_mm = t.number("close_mm", 0, 0.2, 50);
    form.clip_mm = t.box("clip_mm");
    form.marrow = t.text("marrow", "trabecular_bone", CRN_SCENE_MATERIAL_BYTES - 1);
    const bool needs_solid =
        !form.less.empty() || form.shell_mm > 0 || form.close_mm > 0 || !form.clip_mm.isEmpty();
    if (form.solid_mm == 0 && needs_solid)
        t.fail(nullptr,
               "needs solid_mm, the voxel in which close_mm, clip_mm, less and shell_mm are made: about "
               "0.8 for bones");
    return form;
}

BodyText body_of(const Table &t)
{
    t.only({"name", "mesh",   "parts",      "pieces_mm", "pieces_min_mm", "unit",     "material", "inside",
            "axes", "scale",  "rotate_deg", "offset_mm", "cap",           "solid_mm", "close_mm", "clip_mm",
            "less", "gap_mm", "error_mm",   "shell_mm",  "marrow",        "moves"});
    BodyText body;
    body.name = t.text("name", "", CRN_SCENE_BODY_NAME_BYTES - 1);
    body.material = t.text("material", "", CRN_SCENE_MATERIAL_BYTES - 1);
    body.inside = t.text("inside", "", CRN_SCENE_BODY_NAME_BYTES - 1);
    if (body.name.empty()) t.fail(nullptr, "needs a name");
    if (body.material.empty()) t.fail(nullptr, "'" + body.name + "' needs a material");
    if (!t.table.contains("mesh")) t.fail(nullptr, "'" + body.name + "' needs a mesh");
    body.is_lumen = t.text("mesh", "", 4096) == "lumen";
    if (!body.is_lumen) body.mesh = mesh_of(t);
    body.form = form_of(t);
    if (const toml::node *moves = t.table.get("moves")) {
        if (!moves->is_boolean()) t.fail(moves, "moves must be true or false");
        body.moves = moves->value<bool>().value();
        if (body.moves && t.scene.motion.frames.empty())
            t.fail(moves, "'" + body.name + "' moves, but the scene has no [motion]");
    }
    return body;
}

LesionText lesion_of(const Table &t)
{
    t.only({"name", "branch", "at_mm", "length_mm", "stenosis_percent", "eccentricity", "plaque_deg",
            "calcified_deg", "inside", "yield_kPa", "full_kPa", "recoil"});
    for (const char *key : {"name", "branch", "at_mm", "length_mm", "stenosis_percent"})
        if (!t.table.contains(key)) t.fail(nullptr, "needs " + std::string(key));
    LesionText lesion;
    lesion.name =
        t.text("name", "", CRN_SCENE_BODY_NAME_BYTES - 1 - 8); // "_calcium" must fit behind the name
    lesion.branch = t.text("branch", "", CRN_SCENE_BRANCH_NAME_BYTES - 1);
    lesion.at_mm = t.number("at_mm", 0, lesion_at_mm);
    lesion.length_mm = t.number("length_mm", 0, lesion_length_mm);
    lesion.stenosis_percent = t.number("stenosis_percent", 0, lesion_stenosis_percent);
    lesion.eccentricity = t.number("eccentricity", 0, lesion_eccentricity);
    lesion.plaque_deg = t.number("plaque_deg", 0, lesion_plaque_deg);
    lesion.calcified_deg = t.number("calcified_deg", 0, lesion_calcified_deg);
    lesion.inside = t.text("inside", "", CRN_SCENE_BODY_NAME_BYTES - 1);
    lesion.yield_kPa = t.number("yield_kPa", 300 + 2 * lesion.calcified_deg, 1, 4000);
    lesion.full_kPa = t.number("full_kPa", 300, 1, 4000);
    lesion.recoil = t.number("recoil", 0.35, 0, 1);
    if (lesion.name.empty()) t.fail(t.table.get("name"), "needs a name that is not empty");
    if (!lesion.inside.empty() && lesion.calcified_deg == 0)
        t.fail(t.table.get("inside"), "inside says where calcium lies: give calcified_deg as well");
    return lesion;
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

// Adds a marrow body inside every body that has a shell, directly behind that body in the list.
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

const toml::table &table_of(const SceneText &scene, const toml::table &root, const char *key)
{
    const toml::node *node = root.get(key);
    if (!node || !node->is_table())
        throw Fault(scene.file.string() + ": the table [" + key +
                    "] is missing: docs/scene.md has an example");
    return *node->as_table();
}

} // namespace

SceneText read_scene_text(const std::filesystem::path &file, const Folders &folders)
{
    SceneText scene;
    scene.file = file;
    const toml::table root =
        read_toml(file, {4, "a scene text", "the scene's TOML text", ": give the TOML file, not a mesh"});
    const Table top{scene, folders, "the file", root};
    top.only({"scene", "lumen", "tree", "entry", "motion", "lesion", "body"});
    const Table head{scene, folders, "[scene]", table_of(scene, root, "scene")};
    head.only({"name", "source"});
    scene.name = head.text("name", "", CRN_SCENE_NAME_BYTES - 1);
    scene.source = head.text("source", "", CRN_SCENE_SOURCE_BYTES - 1);
    if (scene.name.empty()) head.fail(nullptr, "needs a name");
    scene.lumen = lumen_of({scene, folders, "[lumen]", table_of(scene, root, "lumen")});
    if (root.contains("tree")) {
        scene.tree = tree_of({scene, folders, "[tree]", table_of(scene, root, "tree")});
    } else {
        scene.tree.centrelines = scene.lumen.centrelines;
        scene.tree.placement = scene.lumen.mesh.placement;
        scene.tree.is_of_lumen = true;
    }
    scene.entry = entry_of({scene, folders, "[entry]", table_of(scene, root, "entry")});
    if (root.contains("motion"))
        scene.motion = motion_of({scene, folders, "[motion]", table_of(scene, root, "motion")});
    if (const toml::node *bodies = root.get("body")) {
        if (!bodies->is_array_of_tables()) top.fail(bodies, "has [body]: write [[body]]");
        for (const toml::node &node : *bodies->as_array())
            scene.bodies.push_back(body_of({scene, folders, "[[body]]", *node.as_table()}));
    }
    if (const toml::node *lesions = root.get("lesion")) {
        if (!lesions->is_array_of_tables()) top.fail(lesions, "has [lesion]: write [[lesion]]");
        for (const toml::node &node : *lesions->as_array())
            scene.lesions.push_back(lesion_of({scene, folders, "[[lesion]]", *node.as_table()}));
    }
    add_marrows(scene);
    check_bodies(scene);
    check_lesions(scene);
    return scene;
}

} // namespace crn::bake
