#include "host/model/vessel_map.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <cctype>
#include <cmath>

namespace crn
{
namespace
{

// Converts a vessel's name to small letters and a standard spelling. Any run of spaces, underscores and
// hyphens becomes one space, and "artery" or "ostium" at the end is removed.
std::string plain(std::string_view name)
{
    std::string text;
    for (char c : name) {
        const bool is_gap = c == ' ' || c == '_' || c == '-' || c == '\t';
        if (is_gap && (text.empty() || text.back() == ' ')) continue;
        text += is_gap ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    for (const std::string_view ending : {" ", " ostium", " artery"})
        if (text.size() > ending.size() && text.ends_with(ending)) text.resize(text.size() - ending.size());
    return text;
}

// Lists pairs of names: the long name of a vessel that cardiologists use, and the vessel's name in our files.
constexpr std::pair<const char *, const char *> long_names[] = {
    {"left main", "lm"},
    {"left main coronary", "lm"},
    {"left coronary", "lm"},
    {"left anterior descending", "lad"},
    {"left circumflex", "lcx"},
    {"circumflex", "lcx"},
    {"right coronary", "rca"},
    {"first diagonal", "d1"},
    {"second diagonal", "d2"},
    {"first marginal", "om1"},
    {"second marginal", "om2"},
    {"acute marginal", "am"},
    {"posterior descending", "pda"},
    {"posterolateral", "pl"},
};

std::string shown(std::string name)
{
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

std::vector<double> arcs_of(const VesselBranch &branch)
{
    std::vector<double> arcs_m = {0.0};
    for (std::size_t i = 1; i < branch.points_m.size(); ++i)
        arcs_m.push_back(arcs_m.back() + (branch.points_m[i] - branch.points_m[i - 1]).norm());
    return arcs_m;
}

std::int64_t um(double m)
{
    return std::llround(m * 1e6);
}

// Holds the positions along the root vessel, in metres, where the brachiocephalic and the left subclavian
// artery leave it.
struct Arch {
    double begin_m = 0.0, end_m = 0.0;
};
std::optional<Arch> arch_of(const VesselTree &tree, const std::vector<double> &root_arcs_m)
{
    Arch arch;
    for (const VesselBranch &branch : tree.branches) {
        if (branch.parent != 0) continue;
        const std::string name = plain(branch.name);
        const double at_m = root_arcs_m[branch.parent_point];
        if (name.find("brachiocephalic") != std::string::npos || name.find("innominate") != std::string::npos)
            arch.begin_m = at_m;
        if (name.find("left subclavian") != std::string::npos) arch.end_m = at_m;
    }
    if (arch.begin_m > 0.0 && arch.end_m > arch.begin_m && arch.end_m < root_arcs_m.back()) return arch;
    return {};
}

} // namespace

VesselMap::VesselMap(const VesselTree &tree) : branches_(tree.branches)
{
    for (std::size_t b = 0; b < branches_.size(); ++b) {
        arcs_m_.push_back(arcs_of(branches_[b]));
        starts_m_.push_back(vessel_start_m(tree, b));
        add_branch(tree, b);
    }
}

void VesselMap::add_branch(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = branches_[index];
    MappedVessel vessel{shown(branch.name), index, starts_m_[index], arcs_m_[index].back(), -1, 0.0};
    if (branch.parent >= 0) {
        const auto parent = static_cast<std::size_t>(branch.parent);
        const double leaves_m = arcs_m_[parent][branch.parent_point];
        const std::size_t from = vessel_of(parent, leaves_m);
        vessel.parent = static_cast<int>(from);
        vessel.parent_along_m = leaves_m - vessels_[from].from_m;
    }
    const std::optional<Arch> arch = index == 0 ? arch_of(tree, arcs_m_[0]) : std::optional<Arch>();
    if (!arch) {
        vessels_.push_back(vessel);
        return;
    }
    const double arch_length_m = arch->end_m - arch->begin_m;
    vessels_.push_back({"ascending aorta", index, 0.0, arch->begin_m, -1, 0.0});
    vessels_.push_back({"aortic arch", index, arch->begin_m, arch->end_m, 0, arch->begin_m});
    vessels_.push_back({"descending aorta", index, arch->end_m, vessel.to_m, 1, arch_length_m});
}

std::vector<std::string> VesselMap::names() const
{
    std::vector<std::string> names;
    for (const MappedVessel &vessel : vessels_) names.push_back(vessel.name);
    return names;
}

std::optional<std::size_t> VesselMap::find(std::string_view name) const
{
    std::string wanted = plain(name);
    for (int round = 0; round < 2; ++round) {
        for (std::size_t i = 0; i < vessels_.size(); ++i)
            if (plain(vessels_[i].name) == wanted) return i;
        for (const auto &[spoken, file] : long_names)
            if (wanted == spoken) wanted = file;
    }
    return {};
}

std::string VesselMap::suggestion(std::string_view name) const
{
    return crn::suggestion(shown(std::string(name)), names());
}

std::size_t VesselMap::vessel_of(std::size_t branch, double arc_m) const
{
    std::size_t found = 0;
    for (std::size_t i = 0; i < vessels_.size(); ++i) {
        if (vessels_[i].branch != branch) continue;
        found = i;
        if (arc_m <= vessels_[i].to_m) break;
    }
    return found;
}

// A point inside the lumen of the parent vessel belongs to the parent, even if a branch begins there.
VesselPlace VesselMap::at(const Eigen::Vector3d &reference_m) const
{
    VesselPlace best;
    best.radii = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < branches_.size(); ++b) {
        const VesselFoot foot = vessel_foot(branches_[b], reference_m);
        if (foot.radii >= best.radii) continue;
        const std::vector<double> &arcs_m = arcs_m_[b];
        const double piece_m =
            foot.point + 1 < arcs_m.size() ? arcs_m[foot.point + 1] - arcs_m[foot.point] : 0.0;
        const double arc_m = arcs_m[foot.point] + foot.share * piece_m;
        if (branches_[b].parent >= 0 && arc_m < starts_m_[b]) continue;
        const std::size_t vessel = vessel_of(b, arc_m);
        best = {vessel, std::max(arc_m - vessels_[vessel].from_m, 0.0), foot.radii};
    }
    return best;
}

// Returns the vessels from the root of the tree to a position, each with the distance along it to the next
// vessel's origin.
std::vector<VesselPlace> VesselMap::from_root(const VesselPlace &place) const
{
    std::vector<VesselPlace> steps = {place};
    while (vessels_[steps.back().vessel].parent >= 0) {
        const MappedVessel &vessel = vessels_[steps.back().vessel];
        steps.push_back({static_cast<std::size_t>(vessel.parent), vessel.parent_along_m, 0.0});
    }
    std::reverse(steps.begin(), steps.end());
    return steps;
}

double VesselMap::distance_m(const VesselPlace &from, const VesselPlace &to) const
{
    const std::vector<VesselPlace> a = from_root(from), b = from_root(to);
    std::size_t common = 0;
    while (common + 1 < std::min(a.size(), b.size()) && a[common + 1].vessel == b[common + 1].vessel)
        ++common;
    double sum_m = std::fabs(a[common].along_m - b[common].along_m);
    for (std::size_t i = common + 1; i < a.size(); ++i) sum_m += a[i].along_m;
    for (std::size_t i = common + 1; i < b.size(); ++i) sum_m += b[i].along_m;
    return sum_m;
}

VesselPlace VesselMap::mouth(std::size_t goal, const VesselPlace &start) const
{
    for (const VesselPlace &step : from_root(start))
        if (step.vessel == goal) return {goal, step.along_m, 0.0};
    return {goal, 0.0, 0.0};
}

double VesselMap::inside_m(const VesselPlace &place, const VesselPlace &start) const
{
    return distance_m(mouth(place.vessel, start), place);
}

// In a tree, a detour from the route to a point and back is twice as long as the distance between the route
// and that point.
VesselWay VesselMap::way(const VesselPlace &place, const VesselPlace &start, std::size_t goal) const
{
    if (place.vessel == goal) return {0, 0, um(inside_m(place, start))};
    const VesselPlace end = mouth(goal, start);
    const double to_end_m = distance_m(place, end);
    const double astray_m = 0.5 * (distance_m(start, place) + to_end_m - distance_m(start, end));
    return {um(to_end_m - astray_m), um(astray_m), 0};
}

double VesselMap::mouth_radius_m(const VesselPlace &start, std::size_t goal) const
{
    const VesselPlace place = mouth(goal, start);
    const MappedVessel &vessel = vessels_[goal];
    const std::vector<double> &arcs_m = arcs_m_[vessel.branch];
    const double arc_m = vessel.from_m + place.along_m;
    const auto after = std::lower_bound(arcs_m.begin(), arcs_m.end(), arc_m);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(after - arcs_m.begin()), arcs_m.size() - 1);
    return branches_[vessel.branch].radii_m[i];
}

} // namespace crn
