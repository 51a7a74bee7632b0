// Checks that vessel trees obey the rules in tree.hpp, computes distances to their branches, and splits
// trees.
#include "tools/centreline/tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace crn::centreline
{
namespace
{

constexpr double shared_sphere_mm = 0.01; // a file may round by this much

[[noreturn]] void refuse(const std::string &name, std::size_t branch, const std::string &what)
{
    throw Fault(name + ": branch " + std::to_string(branch) + " " + what);
}

void check_sphere(const Sphere &sphere, const std::string &name, std::size_t branch, std::size_t index)
{
    const std::string where = "has at sphere " + std::to_string(index) + " ";
    if (!sphere.centre_mm.allFinite() || sphere.centre_mm.cwiseAbs().maxCoeff() > coordinate_max_mm)
        refuse(name, branch, where + "a position that is no number within a kilometre: correct it");
    if (!(sphere.radius_mm > 0 && sphere.radius_mm <= radius_max_mm))
        refuse(name, branch,
               where + "a radius of " + std::to_string(sphere.radius_mm) +
                   " mm, which is not above zero and below 1 m: correct it, or check the file's unit");
    if (!std::isfinite(sphere.speed_mm_s))
        refuse(name, branch, where + "a speed that is no number: correct it");
}

void check_parent(const Tree &tree, const std::string &name, std::size_t number)
{
    const Branch &branch = tree.branches[number];
    if (branch.parent == -1) return;
    if (branch.parent < -1 || branch.parent >= static_cast<int>(number))
        refuse(name, number,
               "leaves branch " + std::to_string(branch.parent) +
                   ": a parent stands before its branches, and a root has -1");
    const std::vector<Sphere> &parent = tree.branches[branch.parent].spheres;
    if (branch.parent_sphere >= parent.size())
        refuse(name, number,
               "leaves branch " + std::to_string(branch.parent) + " at sphere " +
                   std::to_string(branch.parent_sphere) + ", but that has only " +
                   std::to_string(parent.size()) + ": correct parent_sphere");
    const double off_mm = (parent[branch.parent_sphere].centre_mm - branch.spheres[0].centre_mm).norm();
    if (off_mm > shared_sphere_mm)
        refuse(name, number,
               "begins " + std::to_string(off_mm) + " mm from sphere " +
                   std::to_string(branch.parent_sphere) + " of branch " + std::to_string(branch.parent) +
                   ": its first sphere must be that sphere");
}

} // namespace

void check_tree(const Tree &tree, const std::string &name)
{
    if (tree.branches.empty()) throw Fault(name + ": holds no branch: give a file with at least one line");
    if (tree.branches.size() > branches_max)
        throw Fault(name + ": has " + std::to_string(tree.branches.size()) + " branches, at most " +
                    std::to_string(branches_max) + " are read: split the file");
    if (sphere_count(tree) > spheres_max)
        throw Fault(name + ": has " + std::to_string(sphere_count(tree)) + " spheres, at most " +
                    std::to_string(spheres_max) + " are read: thin the points");
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &branch = tree.branches[b];
        if (branch.spheres.size() < 2)
            refuse(name, b, "has fewer than 2 spheres: add points or leave it out");
        for (std::size_t i = 0; i < branch.spheres.size(); ++i) check_sphere(branch.spheres[i], name, b, i);
        check_parent(tree, name, b);
    }
}

std::size_t sphere_count(const Tree &tree)
{
    return std::accumulate(tree.branches.begin(), tree.branches.end(), std::size_t{0},
                           [](std::size_t sum, const Branch &branch) { return sum + branch.spheres.size(); });
}

double length_mm(const Branch &branch)
{
    double sum = 0;
    for (std::size_t i = 1; i < branch.spheres.size(); ++i)
        sum += (branch.spheres[i].centre_mm - branch.spheres[i - 1].centre_mm).norm();
    return sum;
}

// For a point p, s is the coordinate along the cone's axis from a to b, and q is the distance from this axis.
// The side of the two spheres' hull is the cone that touches both spheres. If the perpendicular from p meets
// the cone's side beyond an end of the cone, the sphere at that end is nearer to p.
double tapered_capsule_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double radius_a,
                                const Eigen::Vector3d &b, double radius_b)
{
    const Eigen::Vector3d axis = b - a;
    const double length = axis.norm(), taper = radius_a - radius_b;
    if (length <= std::abs(taper)) // one sphere contains the other
        return radius_a > radius_b ? (p - a).norm() - radius_a : (p - b).norm() - radius_b;
    const double s = axis.dot(p - a) / length, sine = taper / length, cosine = std::sqrt(1 - sine * sine);
    const double q = std::sqrt(std::max(0.0, (p - a).squaredNorm() - s * s));
    const double foot = s - q * sine / cosine; // where the cone's normal through p meets the axis
    if (foot <= 0) return (p - a).norm() - radius_a;
    if (foot >= length) return (p - b).norm() - radius_b;
    return s * sine + q * cosine - radius_a;
}

HullPlace hull_place(const Branch &branch, const Eigen::Vector3d &p_mm)
{
    HullPlace best{INFINITY, 0};
    for (std::size_t i = 0; i + 1 < branch.spheres.size(); ++i) {
        const Sphere &a = branch.spheres[i], &b = branch.spheres[i + 1];
        const double distance =
            tapered_capsule_distance(p_mm, a.centre_mm, a.radius_mm, b.centre_mm, b.radius_mm);
        if (distance >= best.distance_mm) continue;
        const bool is_second =
            (p_mm - b.centre_mm).norm() - b.radius_mm < (p_mm - a.centre_mm).norm() - a.radius_mm;
        best = {distance, i + is_second};
    }
    return best;
}

LinePlace line_place(const Branch &branch, const Eigen::Vector3d &p_mm)
{
    LinePlace best{INFINITY, 0, 0};
    for (std::size_t i = 0; i + 1 < branch.spheres.size(); ++i) {
        const Sphere &a = branch.spheres[i], &b = branch.spheres[i + 1];
        const Eigen::Vector3d step = b.centre_mm - a.centre_mm;
        const double square = step.squaredNorm();
        const double t = square > 0 ? std::clamp(step.dot(p_mm - a.centre_mm) / square, 0.0, 1.0) : 0.0;
        const double distance = (a.centre_mm + t * step - p_mm).norm();
        if (distance < best.distance_mm)
            best = {distance, static_cast<double>(i) + t, a.radius_mm + t * (b.radius_mm - a.radius_mm)};
    }
    return best;
}

std::size_t first_own_sphere(const Tree &tree, std::size_t branch)
{
    const Branch &own = tree.branches[branch];
    if (own.parent < 0) return 0;
    std::size_t i = 1;
    while (i + 1 < own.spheres.size() &&
           hull_place(tree.branches[own.parent], own.spheres[i].centre_mm).distance_mm < 0)
        ++i;
    return i;
}

Tree split_at_junctions(const Tree &tree)
{
    std::vector<std::vector<std::size_t>> cuts(tree.branches.size()); // spheres at which other branches leave
    for (const Branch &branch : tree.branches)
        if (branch.parent >= 0) cuts[branch.parent].push_back(branch.parent_sphere);
    Tree split;
    // Each old branch has a list of the new branches into which it was divided. An entry holds the sphere of
    // the old branch at which the new branch ends, and the number of the new branch.
    std::vector<std::vector<std::pair<std::size_t, int>>> ends(tree.branches.size());
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &old = tree.branches[b];
        std::vector<std::size_t> &at = cuts[b];
        at.push_back(old.spheres.size() - 1);
        std::sort(at.begin(), at.end());
        at.erase(std::unique(at.begin(), at.end()), at.end());
        int parent = -1;
        if (old.parent >= 0)
            for (const auto &[sphere, made] : ends[old.parent])
                if (sphere == old.parent_sphere) parent = made;
        std::size_t first = 0;
        for (std::size_t cut : at) {
            // A cut at the first sphere of a branch makes no new branch, because no part of the old branch
            // precedes this sphere.
            if (cut == 0) {
                ends[b].push_back({0, parent});
                continue;
            }
            Branch piece{old.name, parent, 0, {old.spheres.begin() + first, old.spheres.begin() + cut + 1}};
            if (parent >= 0) piece.parent_sphere = split.branches[parent].spheres.size() - 1;
            parent = static_cast<int>(split.branches.size());
            split.branches.push_back(std::move(piece));
            ends[b].push_back({cut, parent});
            first = cut;
        }
    }
    return split;
}

} // namespace crn::centreline
