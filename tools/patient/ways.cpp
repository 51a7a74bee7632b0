#include "tools/patient/ways.hpp"
#include "tools/mesh/median.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace crn::patient
{
namespace
{

using centreline::Branch;
using centreline::Tree;

using Vertex = std::pair<std::size_t, std::size_t>; // branch, sphere

// From one sphere of a branch to the next one, or back.
struct Step {
    std::size_t branch, from, to;
};

class Walker
{
  public:
    explicit Walker(const Tree &tree) : tree_(tree)
    {
        for (std::size_t b = 0; b < tree.branches.size(); ++b) {
            first_own_.push_back(std::min(centreline::first_own_sphere(tree, b), last(b)));
            if (tree.branches[b].parent >= 0) leaving_[joint({b, 0})].push_back(b);
        }
    }
    std::vector<WayPlace> from_end(const TreeEnd &end, double inside_mm) const
    {
        std::vector<WayPlace> found;
        const Vertex begin = joint({end.branch, end.is_root ? 0 : last(end.branch)});
        struct Arrival {
            Step step;
            double mm; // at the step's beginning
        };
        std::vector<Arrival> open;
        for (const Step &step : likely_steps(begin, nullptr)) open.push_back({step, -inside_mm});
        while (!open.empty()) {
            const auto [step, mm] = open.back();
            open.pop_back();
            const std::vector<centreline::Sphere> &spheres = tree_.branches[step.branch].spheres;
            const double now_mm = mm + (spheres[step.to].centre_mm - spheres[step.from].centre_mm).norm();
            const bool is_own = step.to >= first_own_[step.branch];
            if (now_mm >= 0)
                found.push_back({step.branch, step.to, now_mm, is_own ? spheres[step.to].radius_mm : INFINITY,
                                 spheres[step.to].centre_mm});
            for (const Step &next : likely_steps(joint({step.branch, step.to}), &step))
                open.push_back({next, now_mm});
        }
        return found;
    }

  private:
    std::size_t last(std::size_t branch) const { return tree_.branches[branch].spheres.size() - 1; }
    // A branch's first sphere is one of its parent's.
    Vertex joint(Vertex at) const
    {
        while (at.second == 0 && tree_.branches[at.first].parent >= 0)
            at = {static_cast<std::size_t>(tree_.branches[at.first].parent),
                  tree_.branches[at.first].parent_sphere};
        return at;
    }
    // The median radius of the next 15 mm of this branch.
    double width_mm(const Step &step) const
    {
        constexpr double ahead_mm = 15.0;
        const std::vector<centreline::Sphere> &spheres = tree_.branches[step.branch].spheres;
        const bool is_down = step.to > step.from;
        std::vector<double> radii;
        double passed_mm = 0.0;
        for (std::size_t i = step.to;; i += is_down ? 1 : -1) {
            if (i >= first_own_[step.branch]) radii.push_back(spheres[i].radius_mm);
            if (i == (is_down ? last(step.branch) : 0) || passed_mm > ahead_mm) break;
            const double next_mm = (spheres[is_down ? i + 1 : i - 1].centre_mm - spheres[i].centre_mm).norm();
            if (i >= first_own_[step.branch]) passed_mm += next_mm;
        }
        return radii.empty() ? spheres[step.to].radius_mm : mesh::median(radii);
    }
    std::vector<Step> likely_steps(const Vertex &at, const Step *came) const
    {
        constexpr double likely_share = 0.6;
        std::vector<Step> steps;
        const auto [branch, sphere] = at;
        if (sphere < last(branch)) steps.push_back({branch, sphere, sphere + 1});
        if (sphere > 0) steps.push_back({branch, sphere, sphere - 1});
        if (const auto found = leaving_.find(at); found != leaving_.end())
            for (const std::size_t child : found->second) steps.push_back({child, 0, 1});
        std::erase_if(steps, [&](const Step &step) {
            return came && step.branch == came->branch && step.to == came->from;
        });
        if (steps.size() < 2) return steps; // no junction
        double widest_mm = 0.0;
        for (const Step &step : steps) widest_mm = std::max(widest_mm, width_mm(step));
        std::erase_if(steps, [&](const Step &step) { return width_mm(step) < likely_share * widest_mm; });
        return steps;
    }

    const Tree &tree_;
    std::vector<std::size_t> first_own_;
    std::map<Vertex, std::vector<std::size_t>> leaving_; // branches by the sphere that they leave
};

void add_downstream(const Tree &tree, std::size_t branch, std::size_t first, double reach_mm,
                    Eigen::AlignedBox3d &box)
{
    const std::vector<centreline::Sphere> &spheres = tree.branches[branch].spheres;
    for (std::size_t i = first;; ++i) {
        box.extend(spheres[i].centre_mm);
        for (std::size_t child = branch + 1; child < tree.branches.size(); ++child)
            if (tree.branches[child].parent == static_cast<int>(branch) &&
                tree.branches[child].parent_sphere == i)
                add_downstream(tree, child, 0, reach_mm, box);
        if (i + 1 == spheres.size()) return;
        reach_mm -= (spheres[i + 1].centre_mm - spheres[i].centre_mm).norm();
        if (reach_mm < 0) return;
    }
}

} // namespace

std::vector<WayPlace> ways_from(const Tree &tree, const TreeEnd &end, double inside_mm)
{
    return Walker(tree).from_end(end, inside_mm);
}

const WayPlace *narrowest(const std::vector<WayPlace> &ways, double to_mm)
{
    const WayPlace *least = nullptr;
    for (const WayPlace &one : ways)
        if (one.from_entry_mm <= to_mm && std::isfinite(one.radius_mm) &&
            (!least || one.radius_mm < least->radius_mm))
            least = &one;
    return least;
}

double wide_up_to_mm(const std::vector<WayPlace> &ways, double radius_mm)
{
    double least_mm = INFINITY;
    for (const WayPlace &one : ways)
        if (one.radius_mm < radius_mm) least_mm = std::min(least_mm, one.from_entry_mm);
    return least_mm;
}

Eigen::AlignedBox3d shown_from(const Tree &tree, const std::vector<WayPlace> &ways, double least_mm,
                               double most_mm, double reach_mm)
{
    double farthest_mm = 0.0; // the ways may end before
    for (const WayPlace &one : ways) farthest_mm = std::max(farthest_mm, one.from_entry_mm);
    least_mm = std::min(least_mm, farthest_mm);
    Eigen::AlignedBox3d box;
    for (const WayPlace &one : ways)
        if (one.from_entry_mm >= least_mm && one.from_entry_mm <= most_mm)
            add_downstream(tree, one.branch, one.sphere, reach_mm, box);
    return box;
}

} // namespace crn::patient
