#include "tools/lab/ct/cta/person.hpp"
#include "tools/bake/branches.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/small_vessels.hpp"
#include <algorithm>
#include <map>

namespace crn::ct
{

namespace
{

// HU in the arterial phase at 120 kV: common figures, assumed. Organs that take up medium early are brighter.
std::int16_t hu_of(const bake::BodyText &body)
{
    static const std::map<std::string, std::int16_t> organs = {{"kidneys", 150},
                                                               {"liver", 70},
                                                               {"spleen", 120},
                                                               {"bowel", 50},
                                                               {"left_ventricle", 330},
                                                               {"left_atrium", 330},
                                                               {"aortic_root", 350},
                                                               {"right_ventricle", 200},
                                                               {"right_atrium", 200},
                                                               {"lung_left_vessels", 250},
                                                               {"lung_right_vessels", 250},
                                                               {"coronaries_left", 350},
                                                               {"coronaries_right", 350},
                                                               {"heart", 100}};
    static const std::map<std::string, std::int16_t> materials = {
        {"air", -1000},          {"lung", -850},  {"adipose", -100}, {"soft", 40},
        {"soft_tissue", 40},     {"muscle", 60},  {"blood", 50},     {"trabecular_bone", 220},
        {"cortical_bone", 1200}, {"steel", 3071}, {"polymer", 100}};
    const auto organ = organs.find(body.name);
    if (organ != organs.end()) return organ->second;
    // The CT keeps the nominal density of spongy bone, for which its figures were measured.
    const bool is_spongy = body.material.rfind("spongy_", 0) == 0;
    const auto material = materials.find(is_spongy ? "trabecular_bone" : body.material);
    if (material == materials.end())
        throw Fault(body.name + ": no HU are known of the material '" + body.material +
                    "': take a folder that `anatomy person` has made");
    return material->second;
}

// How many bodies are around a body. Calcium is painted last, because it grows into the wall of the vessels.
int depth_of(const std::map<std::string, std::string> &around, std::string name)
{
    if (name.rfind("calcium", 0) == 0) return 100;
    int depth = 0;
    for (auto found = around.find(name); found != around.end() && depth < 50;
         found = around.find(found->second))
        ++depth;
    return depth;
}

VesselTree tree_of(const bake::SceneText &text, std::size_t &with_lumen)
{
    std::vector<bake::Curve> lines;
    for (const std::filesystem::path &file : text.tree.centrelines)
        for (bake::Curve &line : bake::read_centrelines(file, text.tree.placement))
            lines.push_back(std::move(line));
    VesselTree tree = bake::join_branches(lines, text.tree);
    with_lumen = tree.branches.size();
    if (!text.tree.small.empty()) bake::read_small_vessels(text.tree.small, tree);
    // The small vessels count their parents behind the branches, where they now are.
    tree.branches.insert(tree.branches.end(), tree.small.begin(), tree.small.end());
    return tree;
}

} // namespace

Person read_person(const std::filesystem::path &folder)
{
    const bake::SceneText text = bake::read_scene_text(folder / "scene.toml", {});
    if (text.lumen.mesh.file.empty() || text.bodies.empty() || text.tree.centrelines.empty())
        throw Fault(folder.string() +
                    ": has no lumen, bodies or centrelines: give a folder that `anatomy person` has made");
    Person person;
    person.tree = tree_of(text, person.with_lumen);
    person.lumen = bake::load_mesh(text.lumen.mesh);
    std::map<std::string, std::string> around;
    for (const bake::BodyText &body : text.bodies) around[body.name] = body.inside;
    std::vector<const bake::BodyText *> ordered;
    for (const bake::BodyText &body : text.bodies) ordered.push_back(&body);
    std::stable_sort(ordered.begin(), ordered.end(), [&](const auto *a, const auto *b) {
        return depth_of(around, a->name) < depth_of(around, b->name);
    });
    for (const bake::BodyText *body : ordered) {
        PersonBody made{bake::load_mesh(body->mesh), hu_of(*body), body->moves,
                        body->name.rfind("calcium_", 0) == 0};
        if (body->name == "heart") {
            Eigen::AlignedBox3d box;
            for (const Eigen::Vector3d &vertex : made.mesh.vertices_mm) box.extend(vertex);
            person.heart_mm = box.center();
        }
        person.bodies.push_back(std::move(made));
    }
    return person;
}

std::string structure_name(const std::string &branch)
{
    if (branch == "aorta") return branch;
    if (branch == "brachiocephalic_artery") return "brachiocephalic_trunk";
    const std::string artery = "_artery";
    for (const std::string side : {"left", "right"})
        if (branch.rfind(side + "_", 0) == 0 && branch.ends_with(artery))
            return branch.substr(side.size() + 1) + "_" + side;
    static const char *const trunks[] = {"artery", "arteries"};
    for (const char *word : trunks)
        if (branch.find(word) != std::string::npos) return branch;
    // The coronary arteries have names of capitals and digits.
    if (branch.empty()) return ""; // a grown twig
    if (std::none_of(branch.begin(), branch.end(), [](char c) { return c >= 'a' && c <= 'z'; }))
        return "coronary_arteries";
    return branch + artery;
}

} // namespace crn::ct
