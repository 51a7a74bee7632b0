// The wall vertices near a sphere of the tree determine an affine motion from frame to frame. The sphere
// follows the affine motion of the wall and is then centred in the vessel again.
#include "tools/centreline/fit/carry.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr double wall_share = 1.6; // vertices up to this many radii away carry a sphere
constexpr std::size_t vertices_wanted = 48;
constexpr double refit_share = 0.3; // largest displacement of a sphere by the fit, in radii

// Returns those vertices of the vessel's wall that lie around one sphere of the tree.
std::vector<std::uint32_t> carriers_of(const bake::Mesh &mesh, const Sphere &sphere)
{
    std::vector<std::pair<double, std::uint32_t>> near;
    for (double reach = wall_share * sphere.radius_mm; near.size() < 8; reach *= 1.5) {
        near.clear();
        for (std::uint32_t v = 0; v < mesh.vertices_mm.size(); ++v) {
            const double distance = (mesh.vertices_mm[v] - sphere.centre_mm).norm();
            if (distance < reach) near.emplace_back(distance, v);
        }
        if (near.size() >= mesh.vertices_mm.size()) break;
    }
    std::sort(near.begin(), near.end());
    // The code selects the vertices so that the sides of the vessel have equal weight, even if one side has
    // more vertices.
    std::vector<std::uint32_t> chosen;
    const std::size_t step = std::max<std::size_t>(1, near.size() / vertices_wanted);
    for (std::size_t i = 0; i < near.size(); i += step) chosen.push_back(near[i].second);
    return chosen;
}

// Fits the displacements u of the wall vertices x by u = t + A (x - mean), by least squares, with a
// translation t and a matrix A. The matrix A is regularised towards 0, because vertices in one plane or on
// one line do not determine A completely.
Eigen::Vector3d carried_to(const Eigen::Vector3d &p, double radius_mm,
                           const std::vector<std::uint32_t> &carriers, const bake::Mesh &from,
                           const bake::Mesh &to)
{
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), move = mean;
    for (std::uint32_t v : carriers) {
        mean += from.vertices_mm[v];
        move += to.vertices_mm[v] - from.vertices_mm[v];
    }
    mean /= static_cast<double>(carriers.size());
    move /= static_cast<double>(carriers.size());
    Eigen::Matrix3d spread =
        Eigen::Matrix3d::Identity() * (0.02 * radius_mm * radius_mm * static_cast<double>(carriers.size()));
    Eigen::Matrix3d mixed = Eigen::Matrix3d::Zero();
    for (std::uint32_t v : carriers) {
        const Eigen::Vector3d x = from.vertices_mm[v] - mean;
        const Eigen::Vector3d u = to.vertices_mm[v] - from.vertices_mm[v] - move;
        spread += x * x.transpose();
        mixed += u * x.transpose();
    }
    return p + move + mixed * spread.inverse() * (p - mean);
}

void check_topology(const bake::Mesh &first, const bake::Mesh &frame)
{
    if (frame.vertices_mm.size() != first.vertices_mm.size())
        throw Fault(frame.name + ": has " + std::to_string(frame.vertices_mm.size()) + " vertices, " +
                    first.name + " has " + std::to_string(first.vertices_mm.size()) +
                    ": all frames need one topology, export them from one mesh");
    for (std::size_t t = 0; t < first.triangles.size(); ++t)
        if (t >= frame.triangles.size() || frame.triangles[t] != first.triangles[t])
            throw Fault(frame.name + ": its triangle " + std::to_string(t) +
                        " joins other vertices than that of " + first.name +
                        ": all frames need one topology, export them from one mesh");
    if (frame.triangles.size() != first.triangles.size())
        throw Fault(frame.name + ": has " + std::to_string(frame.triangles.size()) + " triangles, " +
                    first.name + " has " + std::to_string(first.triangles.size()) +
                    ": all frames need one topology");
}

Eigen::Vector3d direction_of(const Branch &branch, std::size_t i)
{
    const Eigen::Vector3d way = branch.spheres[std::min(i + 1, branch.spheres.size() - 1)].centre_mm -
                                branch.spheres[i > 0 ? i - 1 : 0].centre_mm;
    return way.norm() > 0 ? way.normalized() : Eigen::Vector3d::UnitZ();
}

// Moves the spheres, which have followed the wall, to the middle of the vessel and measures their radii.
// Returns the largest displacement of a sphere.
double refit(const Lumen &lumen, Tree &tree)
{
    double farthest = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        Branch &branch = tree.branches[b];
        const Branch before = branch;
        const std::size_t own = std::max<std::size_t>(first_own_sphere(tree, b), branch.parent >= 0 ? 1 : 0);
        std::vector<Eigen::Vector3d> step(branch.spheres.size(), Eigen::Vector3d::Zero());
        for (std::size_t i = own; i < branch.spheres.size(); ++i) {
            const Eigen::Vector3d &p = before.spheres[i].centre_mm;
            step[i] = centred(lumen, p, direction_of(before, i), refit_share * lumen.radius_mm(p)) - p;
        }
        for (std::size_t i = 0; i < branch.spheres.size(); ++i) {
            Sphere &sphere = branch.spheres[i];
            if (i == 0 && branch.parent >= 0) {
                sphere = tree.branches[branch.parent].spheres[branch.parent_sphere];
                continue;
            }
            // Neighbouring spheres move by similar amounts, so the spheres keep their order along the branch.
            const bool is_inner = i > own && i + 1 < branch.spheres.size();
            const Eigen::Vector3d move =
                is_inner ? Eigen::Vector3d(0.25 * step[i - 1] + 0.5 * step[i] + 0.25 * step[i + 1]) : step[i];
            sphere.centre_mm += move;
            sphere.radius_mm = std::max(lumen.radius_mm(sphere.centre_mm), 1e-3);
            farthest = std::max(farthest, move.norm());
        }
    }
    return farthest;
}

} // namespace

std::vector<std::filesystem::path> frames_of(const std::filesystem::path &folder)
{
    std::error_code error;
    std::vector<std::filesystem::path> files;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string ending = entry->path().extension().string();
        if (ending == ".obj" || ending == ".ply" || ending == ".stl" || ending == ".glb")
            files.push_back(entry->path());
    }
    if (error)
        throw Fault(folder.string() + ": cannot be read: " + error.message() + ": give a folder of frames");
    if (files.size() < 2 || files.size() > frames_max)
        throw Fault(folder.string() + ": holds " + std::to_string(files.size()) + " meshes, 2 to " +
                    std::to_string(frames_max) + " are needed: one .obj per frame");
    const auto number = [](const std::filesystem::path &file) {
        const std::string stem = file.stem().string();
        std::size_t begin = stem.size();
        while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1]))) --begin;
        const std::string digits = stem.substr(begin).substr(0, 9);
        return digits.empty() ? -1L : std::stol(digits);
    };
    std::sort(files.begin(), files.end(), [&](const auto &a, const auto &b) {
        return number(a) != number(b) ? number(a) < number(b) : a < b;
    });
    return files;
}

std::vector<Frame> carried(const Tree &tree, const std::vector<std::filesystem::path> &files,
                           const bake::MeshText &text, const LumenWish &wish, bake::Progress &progress)
{
    bake::MeshText one = text;
    one.file = files.front();
    LumenWish wall_only = wish;
    wall_only.with_voxels = false;
    const bake::Mesh first = bake::load_mesh(one);
    std::vector<std::vector<std::vector<std::uint32_t>>> carriers;
    for (const Branch &branch : tree.branches) {
        carriers.emplace_back();
        for (const Sphere &sphere : branch.spheres) carriers.back().push_back(carriers_of(first, sphere));
    }
    std::vector<Frame> frames{{files.front().string(), tree}};
    for (std::size_t n = 1; n < files.size(); ++n) {
        one.file = files[n];
        const bake::Mesh mesh = bake::load_mesh(one);
        check_topology(first, mesh);
        Frame frame{files[n].string(), tree};
        for (std::size_t b = 0; b < tree.branches.size(); ++b)
            for (std::size_t i = 0; i < tree.branches[b].spheres.size(); ++i) {
                Sphere &sphere = frame.tree.branches[b].spheres[i];
                sphere.centre_mm =
                    carried_to(sphere.centre_mm, sphere.radius_mm, carriers[b][i], first, mesh);
            }
        const Lumen lumen(mesh, wall_only, progress);
        frame.refit_mm = refit(lumen, frame.tree);
        for (std::size_t b = 0; b < tree.branches.size(); ++b)
            for (std::size_t i = 0; i < tree.branches[b].spheres.size(); ++i)
                frame.moved_mm = std::max(frame.moved_mm, (frame.tree.branches[b].spheres[i].centre_mm -
                                                           tree.branches[b].spheres[i].centre_mm)
                                                              .norm());
        frames.push_back(std::move(frame));
        progress.stage("carrying the tree", files.size());
        progress.step(n + 1);
    }
    progress.finish();
    return frames;
}

} // namespace crn::centreline
