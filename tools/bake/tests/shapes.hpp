// Provides data for the tests of `bake`: meshes whose distances are known in closed form, texts of scenes,
// and folders.
#pragma once
#include "host/base/pending_file.hpp"
#include "tools/bake/bake.hpp"
#include "tools/bake/fault.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>

namespace crn::bake::tests
{

// Returns a surface whose vertices are the points `at(u, v)` on a grid of the parameters u and v. The surface
// is always closed along v, and it is also closed along u when `round_u` is set.
inline Mesh grid_mesh(int nu, int nv, bool round_u, const std::function<Eigen::Vector3d(double, double)> &at)
{
    Mesh mesh;
    mesh.name = "test mesh";
    const int rows = round_u ? nu : nu + 1;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < nv; ++j)
            mesh.vertices_mm.push_back(at(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
    for (int i = 0; i < nu; ++i)
        for (int j = 0; j < nv; ++j) {
            const auto v = [&](int a, int b) { return static_cast<std::uint32_t>(a % rows * nv + b % nv); };
            mesh.triangles.push_back({v(i, j), v(i + 1, j), v(i + 1, j + 1)});
            mesh.triangles.push_back({v(i, j), v(i + 1, j + 1), v(i, j + 1)});
        }
    return mesh;
}

constexpr double turn = 2 * 3.14159265358979323846;

// Returns a torus around the z axis, which is a tube of radius `r` bent to a circle of radius `R`.
inline Mesh torus(double R, double r, int nu, int nv)
{
    return grid_mesh(nu, nv, true, [=](double u, double v) {
        const double w = R + r * std::cos(turn * v);
        return Eigen::Vector3d(w * std::cos(turn * u), w * std::sin(turn * u), r * std::sin(turn * v));
    });
}

inline double torus_distance(const Eigen::Vector3d &p, double R, double r)
{
    return std::hypot(std::hypot(p.x(), p.y()) - R, p.z()) - r;
}

// An open tube along y.
inline Mesh tube(double radius, double length, int nu, int nv)
{
    return grid_mesh(nu, nv, false, [=](double u, double v) {
        return Eigen::Vector3d(radius * std::cos(turn * v), length * u, -radius * std::sin(turn * v));
    });
}

inline Mesh cube(double edge)
{
    Mesh mesh;
    mesh.name = "cube";
    for (int i = 0; i < 8; ++i)
        mesh.vertices_mm.emplace_back(edge * (i & 1), edge * (i >> 1 & 1), edge * (i >> 2));
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

// Makes an empty folder for one test, and removes this folder with all its contents after the test.
struct Folder {
    std::filesystem::path path;
    Folder()
    {
        char name[] = "/tmp/bake_test_XXXXXX";
        path = mkdtemp(name);
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::filesystem::path write(const std::string &name, const std::string &text) const
    {
        std::ofstream(path / name, std::ios::binary) << text;
        return path / name;
    }
    bool is_empty_but(std::size_t files) const
    {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path), {})) ==
               files;
    }
};

inline std::string scene_text_of(const std::string &mesh, const std::string &more_lumen = "",
                                 const std::string &entry = "[0, 50, 0]")
{
    return "[scene]\nname = \"test\"\n[lumen]\nmesh = \"" + mesh + "\"\nunit = \"mm\"\n" + more_lumen +
           "\n[entry]\nposition_mm = " + entry + "\ndirection = [-1, 0, 0]\n";
}

// Returns the message of the Fault that the function `work` throws, or "" when `work` throws no Fault.
inline std::string complaint(const std::function<void()> &work)
{
    try {
        work();
    } catch (const Fault &fault) {
        return fault.what();
    } catch (const OutputError &error) {
        return error.what();
    }
    return "";
}

} // namespace crn::bake::tests
