// The catalogue contains everything from which random sessions are made: baked scenes with their vessels, all
// shipped instruments and stents, and the sets of instruments that fit into each other. The catalogue is read
// only once; the simulated device and the observers of a session take their data from it.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/lesion_opening.hpp"
#include "host/model/motion.hpp"
#include "host/model/vessel_tree.hpp"
#include "host/session/scene_file.hpp"
#include "host/stent/design.hpp"
#include <optional>
#include <string>
#include <vector>

namespace soak
{

struct SoakScene {
    std::string path; // empty: free space
    crn::SceneFile file;
    crn::VesselTree vessels;
    std::optional<crn::Motion> motion;
    std::vector<crn::LesionStations> stations;
    int depth_max_mm = 300; // from the sheath to the root of the tree and a little further

    bool has_branch(const std::string &name) const;
};

struct SoakTool {
    std::string path;
    crn::Instrument instrument;
    double thickest_mm = 0, tightest_mm = 0; // outer and inner diameter

    bool has_balloon() const { return instrument.table.balloon_count > 0; }
    int length_mm() const { return static_cast<int>(instrument.length_m * 1e3); }
};

struct SoakStent {
    std::string path;
    crn::StentDesign design;
};

struct Catalogue {
    std::vector<SoakScene> scenes;
    std::vector<SoakTool> tools;
    std::vector<SoakStent> stents;
    // Every set holds 1 to 3 indices into `tools`; the innermost tool comes first. In a set, every tool fits
    // into the lumen of the next tool, and at most one tool has a balloon.
    std::vector<std::vector<std::size_t>> sets;

    const SoakScene &scene(const std::string &path) const; // throws std::runtime_error
    const SoakTool &tool(const std::string &path) const;
    const SoakStent &stent(const std::string &path) const;
};

// Reads all .toml files of all the folders, in the order of the file names. Throws FileError,
// std::runtime_error.
Catalogue read_catalogue(const std::vector<std::string> &scene_paths, const std::string &tool_folder,
                         const std::string &stent_folder);

} // namespace soak
