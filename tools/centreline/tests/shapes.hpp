// Makes meshes of vessels whose centrelines are known.
#pragma once
#include "tools/bake/centreline.hpp"
#include "tools/centreline/tests/trees.hpp"

#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>

namespace crn::centreline::tests
{

constexpr double turn = 2 * 3.14159265358979323846;

// Makes an open tube along the y axis (if bend_mm is 0), or along an arc that begins in the direction of the
// y axis and bends towards +x.
inline bake::Mesh tube_mesh(double radius_mm, double length_mm, double bend_mm, int along, int around)
{
    bake::Mesh mesh;
    mesh.name = "tube";
    for (int i = 0; i <= along; ++i)
        for (int j = 0; j < around; ++j) {
            const double s = length_mm * i / along, angle = turn * j / around;
            const double u = radius_mm * std::cos(angle), z = -radius_mm * std::sin(angle);
            if (bend_mm == 0)
                mesh.vertices_mm.emplace_back(u, s, z);
            else
                mesh.vertices_mm.emplace_back(bend_mm - (bend_mm - u) * std::cos(s / bend_mm),
                                              (bend_mm - u) * std::sin(s / bend_mm), z);
        }
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const auto v = [&](int a, int b) { return static_cast<std::uint32_t>(a * around + b % around); };
            mesh.triangles.push_back({v(i, j), v(i + 1, j), v(i + 1, j + 1)});
            mesh.triangles.push_back({v(i, j), v(i + 1, j + 1), v(i, j + 1)});
        }
    return mesh;
}

inline double tube_off_mm(const Eigen::Vector3d &p, double bend_mm)
{
    if (bend_mm == 0) return std::hypot(p.x(), p.z());
    return std::hypot(std::hypot(p.x() - bend_mm, p.y()) - bend_mm, p.z());
}

// Makes a trunk of radius 3 mm along y up to the origin. From the origin two vessels of radius 2.4 mm bend to
// either side with a bend radius of 30 mm.
constexpr double fork_trunk_mm = 3.0, fork_branch_mm = 2.4, fork_bend_mm = 30, fork_angle = 1.0;

inline std::vector<Branch> fork_lines()
{
    std::vector<Branch> lines(3);
    for (int i = 0; i <= 40; ++i) {
        lines[0].spheres.push_back({{0, -20.0 + 0.5 * i, 0}, fork_trunk_mm});
        for (int k : {1, 2}) {
            const double side = k == 1 ? 1 : -1, angle = fork_angle * i / 40;
            lines[k].spheres.push_back(
                {{side * fork_bend_mm * (1 - std::cos(angle)), fork_bend_mm * std::sin(angle), 0},
                 fork_branch_mm});
        }
    }
    return lines;
}

inline bake::Mesh fork_mesh(double voxel_mm)
{
    bake::Progress progress;
    return bake::surface_of(fork_lines(), voxel_mm, progress);
}

// Holds a point's distance from the true centrelines, and the true vessel radius at this point.
struct Truth {
    double off_mm, radius_mm;
    double other_mm; // distance to the wall of the nearest other vessel; below 0 the spheres of both overlap
};
inline Truth fork_truth(const Eigen::Vector3d &p)
{
    const double trunk = std::hypot(p.x(), p.z(), std::max(0.0, p.y()));
    const auto arc = [&](double side) {
        const Eigen::Vector3d q(side * p.x(), p.y(), p.z());
        if (q.y() < 0) return q.norm();
        return std::hypot(std::hypot(q.x() - fork_bend_mm, q.y()) - fork_bend_mm, q.z());
    };
    const double left = arc(1), right = arc(-1);
    if (p.y() < 0) return {trunk, fork_trunk_mm, std::min(left, right) - fork_branch_mm};
    return {std::min(left, right), fork_branch_mm,
            std::min(std::max(left, right) - fork_branch_mm, trunk - fork_trunk_mm)};
}

struct Folder {
    std::filesystem::path path;
    Folder()
    {
        char name[] = "/tmp/centreline_test_XXXXXX";
        path = mkdtemp(name);
    }
    ~Folder() { std::filesystem::remove_all(path); }
};

inline void write_obj(const std::filesystem::path &file, const bake::Mesh &mesh)
{
    std::ofstream out(file);
    out.precision(9);
    for (const Eigen::Vector3d &v : mesh.vertices_mm)
        out << "v " << v.x() << " " << v.y() << " " << v.z() << "\n";
    for (const bake::Triangle &t : mesh.triangles)
        out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
}

} // namespace crn::centreline::tests
