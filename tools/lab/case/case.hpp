// One instrument in one phantom: what a scan, or the virtual scanner, leaves for the calibration. A folder
// with
//   case.toml      phantom, instrument, friction, depths, names of the files below
//   depth_N.csv    the instrument's centreline at each depth, from the mouth to the tip
//   force.csv      the hand's force during the insertion, where it was measured
// All places are in the scene's axes and in mm. docs/ct.md has the format.
//
// The protocol of an insertion is part of it: the hand feeds at `speed_mm_per_s` and turns evenly with the
// feed, from the turn of one depth to that of the next (the first depth's turn holds from the mouth on); at
// each depth it rests.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn::insertion
{

// What is wrong in a case's file: "FILE: field: what; what to do".
class CaseError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Where the insertion rests and was scanned.
struct Depth {
    std::string name;                 // "iliac bifurcation"
    double inserted_mm = 0.0;         // 0 < . <= 1000, rising from depth to depth
    double turn_deg = 0.0;            // of the hand, right-handed about the feed, -3600 .. 3600
    std::filesystem::path scan;       // volume; empty when there is none
    std::filesystem::path centreline; // depth_N.csv
};

// What the hand feels (sign: + pushes the hand back out) while this much is inserted.
struct ForceSample {
    double inserted_mm = 0.0;
    double axial_mN = 0.0;
};

// Paths are as in the file, absolute or relative to the case's folder; path_in() resolves them.
struct Case {
    std::string name;
    std::filesystem::path folder;
    std::filesystem::path instrument; // nominal instrument file, with ":preset" if it is not `physical`
    std::filesystem::path scene;      // the phantom's lumen, baked: the core reads it
    std::filesystem::path surface;    // the same as a closed mesh in mm; empty when there is none
    bool has_mouth = true; // false: the next two are not known yet (CaseParts::before_segmentation alone)
    Eigen::Vector3d mouth_mm = Eigen::Vector3d::Zero();   // where the inserter ends
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX(); // unit, into the vessel
    Eigen::Vector3d gravity_m_s2 =
        Eigen::Vector3d::Zero(); // (0, 0, -9.81) on the back; zero: weight counts for nothing
    double friction_kinetic = 0.0, friction_static = 0.0; // 0 .. 1
    double speed_mm_per_s = 0.0;                          // 1 .. 200
    std::vector<Depth> depths;                            // 1 .. 16
    std::filesystem::path force;                          // empty: no force was measured

    std::filesystem::path path_in(const std::filesystem::path &path) const;
    // The hand's turn with this much inserted.
    double turn_deg_at(double inserted_mm) const;
};

// What a case must have: all; or what is known with scans alone, to which `ct segment` adds scene, surface
// and mouth.
enum class CaseParts { all, before_segmentation };
// FOLDER/case.toml, or the file itself. Throws CaseError.
Case read_case(const std::filesystem::path &folder_or_file, CaseParts wanted = CaseParts::all);
// Writes FOLDER/case.toml. Throws crn::OutputError.
void write_case(const Case &c);
// Adds scene, surface, mouth_mm and direction where FOLDER/case.toml lacks them, and leaves the rest of its
// text as a person wrote it. Throws CaseError, crn::OutputError.
void complete_case(const Case &c);

// Ordered points in mm, header x_mm,y_mm,z_mm; further columns are passed over. At least two. Throws
// CaseError.
std::vector<Eigen::Vector3d> read_centreline(const std::filesystem::path &file);
void write_centreline(const std::filesystem::path &file, const std::vector<Eigen::Vector3d> &points_mm);

// Header inserted_mm,axial_mN; insertion never falls. Throws CaseError.
std::vector<ForceSample> read_force(const std::filesystem::path &file);
void write_force(const std::filesystem::path &file, const std::vector<ForceSample> &samples);

// Nine digits, as all files of a case have their numbers.
std::string number_text(double value);

} // namespace crn::insertion
