#include "hil_tests/soak/catalogue.hpp"
#include "host/model/bodies.hpp"
#include "host/model/units.hpp"
#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace soak
{

namespace
{

namespace fs = std::filesystem;

constexpr int depth_beyond_root_mm = 40;      // as far as the closed end of the tree
constexpr int depth_beyond_coronary_mm = 180; // along the arteries of the heart
constexpr int depth_limit_mm = 1000;

double length_mm(const crn::VesselBranch &branch, std::size_t last_point)
{
    double sum_m = 0;
    for (std::size_t i = 0; i + 1 <= last_point && i + 1 < branch.points_m.size(); i++)
        sum_m += (branch.points_m[i + 1] - branch.points_m[i]).norm();
    return sum_m * 1e3;
}

// Returns how deep tools may go, measured from the introducer sheath against the blood flow. The allowed
// depth is the distance to the point at which blood enters the tree of vessels, plus an allowance beyond that
// point.
int depth_of(const SoakScene &scene)
{
    const crn::VesselTree &tree = scene.vessels;
    const crn_wire_entry &entry = scene.file.entry;
    if (tree.branches.empty()) return SoakScene{}.depth_max_mm;
    const Eigen::Vector3d place_m = Eigen::Vector3d(crn::units::metres(entry.position_x_m_q30),
                                                    crn::units::metres(entry.position_y_m_q30),
                                                    crn::units::metres(entry.position_z_m_q30));
    std::size_t branch = 0, point = 0;
    double nearest_m = 1e9;
    for (std::size_t b = 0; b < tree.branches.size(); b++)
        for (std::size_t i = 0; i < tree.branches[b].points_m.size(); i++) {
            const double away_m = (tree.branches[b].points_m[i] - place_m).norm();
            if (away_m >= nearest_m) continue;
            nearest_m = away_m;
            branch = b;
            point = i;
        }
    double sum_mm = scene.has_branch("LAD") ? depth_beyond_coronary_mm : depth_beyond_root_mm;
    for (int b = static_cast<int>(branch); b >= 0;) {
        const crn::VesselBranch &one = tree.branches[static_cast<std::size_t>(b)];
        sum_mm += length_mm(one, point);
        point = one.parent_point;
        b = one.parent;
    }
    return std::min(static_cast<int>(sum_mm), depth_limit_mm);
}

SoakScene read_soak_scene(const std::string &path)
{
    SoakScene scene;
    scene.path = path;
    scene.file = crn::read_scene(path);
    if (path.empty()) return scene;
    crn::Bodies bodies;
    std::string error;
    const fs::path beside = fs::path(path).replace_extension(".bodies");
    if (fs::exists(beside) && !crn::read_bodies(beside.string(), bodies, error))
        throw std::runtime_error(error);
    scene.vessels = std::move(bodies.vessels);
    scene.motion = crn::read_motion(path, error);
    if (!error.empty()) throw std::runtime_error(error);
    scene.stations = crn::read_lesion_stations(path, error);
    if (!error.empty()) throw std::runtime_error(error);
    scene.depth_max_mm = depth_of(scene);
    return scene;
}

std::vector<std::string> toml_files(const std::string &folder)
{
    std::vector<std::string> paths;
    std::error_code error;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == ".toml") paths.push_back(entry.path().string());
    if (error) throw std::runtime_error(folder + ": cannot be read: " + error.message());
    std::sort(paths.begin(), paths.end());
    return paths;
}

SoakTool read_soak_tool(const std::string &path)
{
    SoakTool tool{path, crn::read_instrument(path), 0, 1e9};
    const crn_wire_instrument &table = tool.instrument.table;
    for (std::uint16_t i = 0; i < table.knots_count; i++) {
        tool.thickest_mm = std::max(tool.thickest_mm, table.knots[i].radius_outer_um * 2e-3);
        tool.tightest_mm = std::min(tool.tightest_mm, table.knots[i].radius_inner_um * 2e-3);
    }
    return tool;
}

// Adds every valid set of nested instruments whose inner instruments are those of `set`. The core's own rule
// (crn_check_tools) decides which sets are valid.
void add_sets(const std::vector<SoakTool> &tools, const std::vector<std::size_t> &set,
              std::vector<std::vector<std::size_t>> &sets)
{
    sets.push_back(set);
    if (set.size() == CRN_WIRE_TOOL_MAX) return;
    const bool has_balloon =
        std::any_of(set.begin(), set.end(), [&](std::size_t k) { return tools[k].has_balloon(); });
    for (std::size_t next = 0; next < tools.size(); next++) {
        if (tools[next].tightest_mm < tools[set.back()].thickest_mm) continue;
        if (has_balloon && tools[next].has_balloon()) continue;
        std::vector<std::size_t> longer = set;
        longer.push_back(next);
        add_sets(tools, longer, sets);
    }
}

template <typename Row>
const Row &find(const std::vector<Row> &rows, const std::string &path, const char *kind)
{
    for (const Row &row : rows)
        if (row.path == path) return row;
    throw std::runtime_error(path + ": is no " + kind + " that sessions are drawn from");
}

} // namespace

bool SoakScene::has_branch(const std::string &name) const
{
    return std::any_of(vessels.branches.begin(), vessels.branches.end(),
                       [&](const crn::VesselBranch &branch) { return branch.name == name; });
}

const SoakScene &Catalogue::scene(const std::string &path) const
{
    return find(scenes, path, "scene");
}

const SoakTool &Catalogue::tool(const std::string &path) const
{
    return find(tools, path, "instrument");
}

const SoakStent &Catalogue::stent(const std::string &path) const
{
    return find(stents, path, "stent");
}

Catalogue read_catalogue(const std::vector<std::string> &scene_paths, const std::string &tool_folder,
                         const std::string &stent_folder)
{
    Catalogue catalogue;
    for (const std::string &path : scene_paths) catalogue.scenes.push_back(read_soak_scene(path));
    for (const std::string &path : toml_files(tool_folder)) catalogue.tools.push_back(read_soak_tool(path));
    for (const std::string &path : toml_files(stent_folder))
        catalogue.stents.push_back({path, crn::read_stent(path)});
    for (std::size_t k = 0; k < catalogue.tools.size(); k++) add_sets(catalogue.tools, {k}, catalogue.sets);
    return catalogue;
}

} // namespace soak
