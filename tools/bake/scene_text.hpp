// Reads the text of a scene (TOML) and checks the text key by key (docs/scene.md).
#pragma once
#include "tools/mesh/fault.hpp"

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace crn::bake
{

// Holds the values that convert coordinates of a file to millimetres in the patient. The conversions apply in
// this order: axes, unit, scale, rotation, offset.
struct Placement {
    std::string unit; // "mm"; empty for centrelines, whose files state their unit
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    Eigen::Vector3d scale = Eigen::Vector3d::Ones(); // along left, head, anterior
    Eigen::Matrix3d rotation =
        Eigen::Matrix3d::Identity(); // about the patient's axes through the file's origin
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();

    // `unit_mm` is the number of millimetres per unit of the file.
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
    Eigen::AlignedBox3d
        pieces_mm;            // pieces are kept when the centre of their box lies in this one; empty: all
    double pieces_min_mm = 0; // and only pieces whose box is at least this long across
    Placement placement;
    Cap cap = Cap::none;
};

struct LumenText {
    MeshText mesh;                                  // when `centrelines` is empty
    std::vector<std::filesystem::path> centrelines; // resolved
    double surface_mm = 0.75;
    double solid_mm = 0; // mesh only: voxel in which parts that overlap become one lumen; 0: the mesh stays
    double tolerance_mm = 0.12;
    int level_max = 1;
    double inside_mm = 2.5;
    double outside_mm = 1.5;
};

// Names the centrelines from which the tree of vessels with flowing blood is made (branches.hpp). A branch is
// named after its file, without ".mrk.json".
struct TreeText {
    std::vector<std::filesystem::path> centrelines; // resolved; empty: no tree
    bool is_of_lumen =
        false; // no [tree] was given: the tree is that of the lumen's centrelines, if they join
    Placement placement;
    std::string inlet; // name of the branch at whose end blood enters; empty: the widest end
    bool inlet_is_last = false;
    std::map<std::string, double> flow_ml_min; // mean flow out of that branch
    std::vector<std::string> left_coronary, right_coronary;
    std::filesystem::path small; // table of vessels that are picture and flow only; empty: none
};

// Names the mesh files that show the frames of a lumen that moves (docs/heart.md).
struct MotionText {
    std::filesystem::path frames;                 // folder of 24 meshes; empty: the lumen does not move
    std::filesystem::path inhaled;                // the first frame at the end of inspiration, or empty
    std::filesystem::path guides, inhaled_guides; // the same for other surfaces that move along; empty: none
    double spacing_mm = 7.8;                      // largest spacing of the beat's lattice
    double breath_spacing_mm = 15.7;              // and of the breath's lattice, which is smoother
    double end_systole = 11; // the frame in which the aortic valve closes: 393 of 857 ms at 70 /min
};

// How the walls of vessels give way to the tools (docs/walls.md).
struct WallLawText {
    double bed_kPa = 30;                   // force per length and way; 0: the vessel does not move aside
    double distensibility_per_kPa = 0.012; // relative growth of the cross-section; 0: it does not widen
    double relax_ms = 150;
    double carry_mm = 10;
    double way_max_mm = 12, widen_max_mm = 0.5;
};

struct WallBranchText {
    std::string place; // file, line and table, for messages
    std::vector<std::string> names;
    WallLawText law;
};

struct WallsText {
    bool is_given = false;
    WallLawText everywhere;
    std::vector<WallBranchText> branches;
};

struct EntryText {
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    std::filesystem::path centreline; // when it is given, position and direction follow from it
    bool from_last = true;
    double distance_mm = 8.0;
    double inserted_mm = 0.0; // start length; 0: bake finds one
};

// Before a body's mesh is written, the program `bake` applies the following steps to the mesh in this order.
// A step whose length is 0 is skipped.
struct FormText {
    double solid_mm = 0;           // voxel of the level set from which the surface is made anew
    double close_mm = 0;           // hollows and gaps up to twice as wide are filled
    Eigen::AlignedBox3d clip_mm;   // only what lies in this box is kept; empty: everything
    std::vector<std::string> less; // bodies earlier in the text that are cut out of this one ...
    double gap_mm = 0.5;           // ... with this gap around them
    double error_mm =
        0; // permitted error of the decimation: no point of either surface is farther from the other
    double shell_mm = 0; // thickness of the cortical shell: what lies deeper is a body of its own ...
    std::string marrow;  // ... made of this material
};

struct BodyText {
    std::string name, material, inside;
    bool is_lumen = false;
    bool moves = false;     // moves with the lumen
    bool is_marrow = false; // made from the body it lies inside, form.shell_mm deep
    bool trabeculae = true; // whether its spongy bone shows its texture
    MeshText mesh;
    std::filesystem::path inhaled; // the same mesh after a full breath; empty: breath does not move it
    FormText form;

    bool is_trabecular() const;
};

// Describes a stretch of a branch that is narrowed by plaque (lesion.hpp).
struct LesionText {
    std::string name, branch;
    double at_mm = 0; // its middle, from the branch's ostium
    double length_mm = 0;
    double stenosis_percent = 0; // of the diameter
    double eccentricity = 0;     // 0: plaque all round; 1: all plaque on one side
    double plaque_deg =
        0; // where plaque is thickest: from the front of the vessel, right-handed about the flow
    double calcified_deg = 0; // arc of calcium about that place; 0: none
    std::string inside;       // the body in which the calcium lies
    double yield_kPa = 0;     // pressure on the wall at which the plaque begins to yield
    double full_kPa = 0;      // additional pressure that opens it completely
    double recoil = 0;        // share of the displacement that springs back
};

struct SceneText {
    std::filesystem::path file;
    std::string name, source;
    LumenText lumen;
    TreeText tree;
    EntryText entry;
    MotionText motion;
    WallsText walls;
    std::vector<LesionText> lesions;
    std::vector<BodyText> bodies;
};

// A path in the scene's text may begin with a prefix that stands for one of the following two folders.
struct Folders {
    std::filesystem::path data;    // "data:", anatomy that does not ship
    std::filesystem::path shipped; // "shipped:", the meshes that `anatomy` has made
};

// Reads and checks the text. Throws Fault "FILE:LINE: key ...".
SceneText read_scene_text(const std::filesystem::path &file, const Folders &folders);

} // namespace crn::bake
