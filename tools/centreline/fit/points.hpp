// Reads and writes start, end and bifurcation points, by which a person describes a vessel tree. The TOML
// file of the start, end and bifurcation points is also the editor's project file.
#pragma once
#include "tools/bake/mesh.hpp"

#include <filesystem>

namespace crn::centreline
{

constexpr std::size_t points_max = 2000;

enum class PointKind { start, end, bifurcation };
const char *kind_name(PointKind kind);

struct Point {
    PointKind kind = PointKind::end;
    std::string name;  // of the branch that ends here
    std::string after; // name of the preceding point on the path from the start; empty: found from the mesh
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
};

struct PointText {
    std::string mesh; // the file to which the points belong, as written; empty: none
    std::string unit = "mm";
    std::vector<Point> points;
};

// Throws Fault "FILE:LINE: ...".
PointText read_points(const std::filesystem::path &file);
std::string points_text(const PointText &text);
void write_points(const std::filesystem::path &file,
                  const PointText &text); // the file is written completely or not at all

} // namespace crn::centreline
