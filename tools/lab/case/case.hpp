// A case describes the insertion of one instrument into one phantom. The case holds the data that a scan, or
// the virtual scanner, provides for the calibration. Its folder contains
//   case.toml      phantom, instrument, friction, depths, names of the files below
//   depth_N.csv    the instrument's centreline at each depth, from the introducer to the tip
//   force.csv      the hand's force during the insertion, where it was measured
//
// All positions in a case are in the scene's axes and in mm. The format of a case is specified in docs/ct.md.
//
// The case also states the protocol of the insertion. The hand feeds at `speed_mm_per_s`. Between two depths,
// the hand turns evenly from the angle of the first depth to the angle of the second depth. Before the first
// depth, the hand keeps the angle of the first depth. The hand stops at each depth until the instrument
// rests.
#pragma once
#include "host/base/fault.hpp"
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace crn::insertion
{

// Describes a depth at which the insertion pauses and at which the instrument was scanned.
struct Depth {
    std::string name;                 // "iliac bifurcation"
    double inserted_mm = 0.0;         // 0 < . <= 1000, rising from depth to depth
    double turn_deg = 0.0;            // turn of the hand, right-handed about the feed, -3600 .. 3600
    std::filesystem::path scan;       // volume; empty when there is none
    std::filesystem::path centreline; // depth_N.csv
};

// Holds the force on the hand at one inserted length; a positive force pushes the instrument out of the
// phantom.
struct ForceSample {
    double inserted_mm = 0.0;
    double axial_mN = 0.0;
};

// Paths are stored as written in the case's file, absolute or relative to the case's folder; path_in() makes
// them absolute.
struct Case {
    std::string name;
    std::filesystem::path folder;
    std::filesystem::path
        instrument; // nominal instrument file, followed by ":preset" unless the preset is `physical`
    std::filesystem::path scene;   // the phantom's lumen, baked, as the core reads it
    std::filesystem::path surface; // the same as a closed mesh in mm; empty when there is none
    bool has_mouth = true; // false: the next two are not known yet (only with CaseParts::before_segmentation)
    Eigen::Vector3d mouth_mm = Eigen::Vector3d::Zero();   // the distal end of the introducer
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX(); // unit, into the vessel
    Eigen::Vector3d gravity_m_s2 =
        Eigen::Vector3d::Zero(); // (0, 0, -9.81) for a patient on the back; zero: weight is ignored
    double friction_kinetic = 0.0, friction_static = 0.0; // 0 .. 1
    double speed_mm_per_s = 0.0;                          // 1 .. 200
    std::vector<Depth> depths;                            // 1 .. 16
    std::filesystem::path force;                          // empty: no force was measured

    std::filesystem::path path_in(const std::filesystem::path &path) const;
    // Returns the angle of the hand at the given inserted length.
    double turn_deg_at(double inserted_mm) const;
};

// States which parts a case must have: all parts, or only those that are known before the scans are
// segmented. The command `ct segment` later adds the missing parts, which are scene, surface and mouth_mm.
enum class CaseParts { all, before_segmentation };
// Reads FOLDER/case.toml if the argument is a folder, or else the given file. Throws Fault.
Case read_case(const std::filesystem::path &folder_or_file, CaseParts wanted = CaseParts::all);
// Writes FOLDER/case.toml. Throws crn::OutputError.
void write_case(const Case &c);
// Adds scene, surface, mouth_mm and direction to FOLDER/case.toml if that file lacks them, and leaves the
// rest of the file's text unchanged. Throws Fault, crn::OutputError.
void complete_case(const Case &c);

// Reads an ordered list of points in mm under the header x_mm,y_mm,z_mm, and ignores further columns. The
// file must contain at least two points. Throws Fault.
std::vector<Eigen::Vector3d> read_centreline(const std::filesystem::path &file);
void write_centreline(const std::filesystem::path &file, const std::vector<Eigen::Vector3d> &points_mm);

// Reads force.csv with the header inserted_mm,axial_mN; the inserted length must never decrease. Throws
// Fault.
std::vector<ForceSample> read_force(const std::filesystem::path &file);
void write_force(const std::filesystem::path &file, const std::vector<ForceSample> &samples);

// Numbers in all files of a case are written with `file_digits` significant digits.
inline constexpr int file_digits = 9;

} // namespace crn::insertion
