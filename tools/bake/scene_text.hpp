// The text of a scene (TOML), read and checked key by key: docs/scene.md.
#pragma once
#include "tools/mesh/fault.hpp"

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace crn::bake
{

// How file coordinates become patient millimetres: axes, unit, scale, turn, offset, in this order.
struct Placement {
    std::string unit; // "mm"; empty for centrelines, which state theirs
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    Eigen::Vector3d scale = Eigen::Vector3d::Ones(); // along left, head, anterior
    Eigen::Matrix3d rotation =
        Eigen::Matrix3d::Identity(); // about the patient's axes through the file's origin
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();

    // `unit_mm`: millimetres per unit of the file.
    Eigen::Vector3d place(const Eigen::Vector3d &file, double unit_mm) const
    {
        return rotation * scale.cwiseProduct(axes * file * unit_mm) + offset_mm;
    }
};

enum class Cap {
    none, // an opening is a fault
    flat, // openings within 5 % of a plane are closed, others are faults
    any,  // every opening is closed
};

struct MeshText {
    std::filesystem::path file;     // resolved
    std::vector<std::string> parts; // names of nodes, may end in '*'; empty: the whole file
    Eigen::AlignedBox3d pieces_mm;  // connected pieces whose box has its middle in it are kept; empty: all
    double pieces_min_mm = 0;       // and only those whose box is as long across
    Placement placement;
    Cap cap = Cap::none;
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

// Centrelines along which blood flows (branches.hpp). A branch is called as its file, without ".mrk.json".
struct TreeText {
    std::vector<std::filesystem::path> centrelines; // resolved; empty: no tree
    bool is_of_lumen = false;                       // nothing was said: those of the lumen, if they join
    Placement placement;
    std::string inlet; // name of the branch at whose end blood enters; empty: the widest end
    bool inlet_is_last = false;
    std::map<std::string, double> flow_ml_min; // mean, out of that branch
    std::vector<std::string> left_coronary, right_coronary;
};

// Frames of a lumen that moves (docs/heart.md).
struct MotionText {
    std::filesystem::path frames;                 // folder of 24 meshes; empty: the lumen stands still
    std::filesystem::path inhaled;                // the first of them at the end of inspiration, or empty
    std::filesystem::path guides, inhaled_guides; // the same of other surfaces that move along; empty: none
    double spacing_mm = 7.8;                      // of the lattice of the beat, at most
    double breath_spacing_mm = 15.7;              // of that of breath, which is smoother
    double end_systole = 11; // frame in which the aortic valve closes: 393 of 857 ms at 70 /min
};

struct EntryText {
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    std::filesystem::path centreline; // not empty: position and direction follow from it
    bool from_last = true;
    double distance_mm = 8.0;
};

// What is made of a body's mesh before it is written, in this order. A length of 0: that step is left out.
struct FormText {
    double solid_mm = 0;           // voxel of the level set from which the surface is made anew
    double close_mm = 0;           // hollows and gaps up to twice as wide are filled
    Eigen::AlignedBox3d clip_mm;   // only what lies in it; empty: everything
    std::vector<std::string> less; // bodies further up in the text that are taken out of this one ...
    double gap_mm = 0.5;           // ... with so much around them
    double error_mm = 0;           // decimated; no point of either surface is farther from the other
    double shell_mm = 0;           // cortical shell: what lies deeper is a body of its own ...
    std::string marrow;            // ... of this material
};

struct BodyText {
    std::string name, material, inside;
    bool is_lumen = false;
    bool moves = false;     // with the lumen's motion
    bool is_marrow = false; // made from the body it lies inside, form.shell_mm deep
    MeshText mesh;
    FormText form;
};

// A stretch of a branch of the tree narrowed by plaque (lesion.hpp).
struct LesionText {
    std::string name, branch;
    double at_mm = 0; // its middle, from the branch's ostium
    double length_mm = 0;
    double stenosis_percent = 0; // of the diameter
    double eccentricity = 0;     // 0: plaque all round; 1: all of it on one side
    double plaque_deg = 0; // where it is thickest: from the front of the vessel, right-handed about the flow
    double calcified_deg = 0; // arc of calcium about that place; 0: none
    std::string inside;       // body in which the calcium lies
    double yield_kPa = 0;     // on the wall, at which it begins to give way
    double full_kPa = 0;      // and how much more opens it wholly
    double recoil = 0;        // share of the way that it springs back
};

struct SceneText {
    std::filesystem::path file;
    std::string name, source;
    LumenText lumen;
    TreeText tree;
    EntryText entry;
    MotionText motion;
    std::vector<LesionText> lesions;
    std::vector<BodyText> bodies;
};

// Folders that paths may begin with.
struct Folders {
    std::filesystem::path data;    // "data:", anatomy that does not ship
    std::filesystem::path shipped; // "shipped:", the meshes that `anatomy` made
};

// Reads and checks the text. Throws Fault "FILE:LINE: key ...".
SceneText read_scene_text(const std::filesystem::path &file, const Folders &folders);

} // namespace crn::bake
