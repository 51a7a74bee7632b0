// The clicks by which a person mends the arteries that `ct patient` finds (docs/own_ct.md, "Clicks"). They
// lie in the file clicks.toml of the patient's folder. Only the user changes this file: by hand, by the
// option
// --click, or in a window.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>

namespace crn::ct
{

enum class ClickKind {
    artery, // the place is inside an artery that must be in the lumen
    cut,    // what goes through the place is no artery
    bridge, // the two nearest ends of arteries are one vessel
    entry,  // instruments enter at the end of the arteries nearest to the place
    name    // the branch nearest to the place gets the name
};
const char *kind_name(ClickKind kind);

constexpr std::size_t clicks_max = 100;
constexpr double cut_radius_mm = 3.0; // of a cut without radius_mm

struct Click {
    ClickKind kind = ClickKind::artery;
    Eigen::Vector3d at_mm = Eigen::Vector3d::Zero(); // the scene's axes
    double radius_mm = 0.0;                          // only for cut; 0: cut_radius_mm
    std::string branch;                              // only for name
    std::string where; // "FILE:LINE:COLUMN: click 2", for messages; it goes into no output
    std::string label; // "click 2", for outputs

    bool is_same(const Click &other) const;
};

bool has_artery_click(const std::vector<Click> &clicks);

// Reads the file; without a file there are no clicks. Throws FileError "FILE:LINE:COLUMN: click 2: ...".
std::vector<Click> read_clicks(const std::filesystem::path &file);
std::string clicks_text(const std::vector<Click> &clicks);
// Writes the file completely or not at all. Throws OutputError.
void write_clicks(const std::filesystem::path &file, const std::vector<Click> &clicks);

// Reads "KIND:x,y,z", "cut:x,y,z:RADIUS" or "name:x,y,z:BRANCH". Throws Fault.
Click click_of(const std::string &option);

// Reads the clicks of the file, and adds those of the options that it lacks. Throws Fault or FileError.
std::vector<Click> clicks_with(const std::filesystem::path &file, const std::vector<std::string> &options);

// Throws Fault if a click lies outside the scan or in air, or if there are more than clicks_max.
void check_clicks(const std::vector<Click> &clicks, const Volume &scan);

} // namespace crn::ct
