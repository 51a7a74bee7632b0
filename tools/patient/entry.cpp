#include "tools/patient/entry.hpp"

#include <algorithm>

namespace crn::patient
{

using Eigen::Vector3d;

std::vector<TreeEnd> ends_of(const centreline::Tree &tree)
{
    std::vector<bool> has_child(tree.branches.size(), false);
    for (const centreline::Branch &branch : tree.branches)
        if (branch.parent >= 0) has_child[static_cast<std::size_t>(branch.parent)] = true;
    std::vector<TreeEnd> ends;
    for (std::size_t i = 0; i < tree.branches.size(); ++i) {
        const std::vector<centreline::Sphere> &spheres = tree.branches[i].spheres;
        const double radius_mm = spheres[spheres.size() / 2].radius_mm;
        if (tree.branches[i].parent < 0) ends.push_back({i, true, spheres.front().centre_mm, radius_mm});
        if (!has_child[i]) ends.push_back({i, false, spheres.back().centre_mm, radius_mm});
    }
    return ends;
}

void widen_closed_ends(centreline::Tree &tree)
{
    constexpr double closing_radii = 3.0, closed_share = 0.75;
    for (const TreeEnd &end : ends_of(tree)) {
        std::vector<centreline::Sphere> &spheres = tree.branches[end.branch].spheres;
        const auto from_end = [&](std::size_t i) -> centreline::Sphere & {
            return spheres[end.is_root ? i : spheres.size() - 1 - i];
        };
        // The spheres of a side branch inside its parent are the parent's.
        const std::size_t count =
            spheres.size() - (end.is_root ? 0 : centreline::first_own_sphere(tree, end.branch));
        double passed_mm = from_end(0).radius_mm, vessel_mm = 0.0; // from the end's wall
        std::size_t closing = 0;
        for (; closing < count; ++closing) {
            if (closing > 0)
                passed_mm += (from_end(closing).centre_mm - from_end(closing - 1).centre_mm).norm();
            const double radius_mm = from_end(closing).radius_mm;
            const bool is_beyond = passed_mm >= closing_radii * radius_mm;
            vessel_mm = is_beyond ? radius_mm : std::max(vessel_mm, radius_mm);
            if (is_beyond) break;
        }
        if (from_end(0).radius_mm > closed_share * vessel_mm) continue; // open, or it becomes thin by itself
        for (std::size_t i = 0; i < closing; ++i)
            from_end(i).radius_mm = std::max(from_end(i).radius_mm, vessel_mm);
    }
}

Entry inside_end(const centreline::Tree &tree, const TreeEnd &end, double inside_mm)
{
    const centreline::Branch &branch = tree.branches[end.branch];
    std::vector<Vector3d> line; // from the end inwards
    for (const centreline::Sphere &sphere : branch.spheres) line.push_back(sphere.centre_mm);
    if (!end.is_root) std::reverse(line.begin(), line.end());
    double passed_mm = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vector3d step = line[i] - line[i - 1];
        passed_mm += step.norm();
        if (passed_mm >= inside_mm || i + 1 == line.size())
            return {line[i], step.normalized(), branch.name, passed_mm};
    }
    throw Fault("tree: the branch " + branch.name + " has a single place");
}

TreeEnd low_end(const centreline::Tree &tree)
{
    constexpr double low_mm = 60.0;
    std::vector<TreeEnd> ends = ends_of(tree);
    std::erase_if(ends, [](const TreeEnd &end) { return end.is_root; });
    if (ends.empty()) throw Fault("tree: the arteries have no end");
    double lowest_mm = 1e9;
    for (const TreeEnd &end : ends) lowest_mm = std::min(lowest_mm, end.place_mm.y());
    const TreeEnd *widest = nullptr;
    for (const TreeEnd &end : ends)
        if (end.place_mm.y() <= lowest_mm + low_mm && (!widest || end.radius_mm > widest->radius_mm))
            widest = &end;
    return *widest;
}

TreeEnd end_near(const centreline::Tree &tree, const Vector3d &place_mm)
{
    std::vector<TreeEnd> ends = ends_of(tree);
    std::erase_if(ends, [](const TreeEnd &end) { return end.is_root; });
    if (ends.empty()) throw Fault("tree: the arteries have no end");
    return *std::min_element(ends.begin(), ends.end(), [&](const TreeEnd &a, const TreeEnd &b) {
        return (a.place_mm - place_mm).norm() < (b.place_mm - place_mm).norm();
    });
}

} // namespace crn::patient
