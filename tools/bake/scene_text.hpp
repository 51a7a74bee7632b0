// The text of a scene (TOML), read and checked key by key: docs/scene.md.
// May include: fault.hpp. Called by: bake.cpp.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace seld::bake
{

// How file coordinates become patient millimetres: axes, unit, scale, offset, in this order.
struct Placement {
    std::string unit; // "mm"; empty for centrelines, which state theirs
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    double scale = 1.0;
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();

    // `unit_mm`: millimetres per unit of the file.
    Eigen::Vector3d place(const Eigen::Vector3d &file, double unit_mm) const
    {
        return axes * file * (unit_mm * scale) + offset_mm;
    }
};

struct MeshText {
    std::filesystem::path file; // resolved
    Placement placement;
    bool cap = false;
};

struct LumenText {
    MeshText mesh;                                  // when `centrelines` is empty
    std::vector<std::filesystem::path> centrelines; // resolved
    double surface_mm = 0.75;
    double tolerance_mm = 0.12;
    int level_max = 1;
    double inside_mm = 2.5;
    double outside_mm = 1.5;
};

struct EntryText {
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    std::filesystem::path centreline; // not empty: position and direction follow from it
    bool from_last = true;
    double distance_mm = 8.0;
};

struct BodyText {
    std::string name, material, inside;
    bool is_lumen = false;
    MeshText mesh;
};

struct SceneText {
    std::filesystem::path file;
    std::string name, source;
    LumenText lumen;
    EntryText entry;
    std::vector<BodyText> bodies;
};

// Millimetres per unit, 0 for a unit nobody knows.
double millimetres_per(const std::string &unit);

// Reads and checks the text. `data` is the folder that `data:` paths begin with. Throws Fault "FILE:LINE: key ...".
SceneText read_scene_text(const std::filesystem::path &file, const std::filesystem::path &data);

} // namespace seld::bake
