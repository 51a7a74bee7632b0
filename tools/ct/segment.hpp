// A scan's lumen, instrument and centreline as files, with pictures of every step and a page that holds them.
// May include: everything of tools/ct. Called by: commands, tests.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/ct/centreline.hpp"
#include "tools/ct/lumen.hpp"
#include <filesystem>

namespace seld::ct
{

struct SegmentOptions {
    LineOptions line;
    LumenOptions lumen;
    bool wants_lumen = true;
};

struct Segmentation {
    InstrumentLine line;
    bake::Mesh lumen; // closed, mm, scene's axes; empty where it was not wanted
    std::vector<std::string> notes;
};

// Writes centreline.csv, lumen.ply, instrument.ply, report.json, index.html and pictures into the folder. Throws Fault.
Segmentation segment_scan(const Volume &volume, const SegmentOptions &options,
                          const std::filesystem::path &folder, const Report &report);

// How far a line is from another: nearest distances of the first's points.
struct Apart {
    double mean_mm = 0, max_mm = 0, tip_mm = 0;
};
Apart lines_apart(const std::vector<Eigen::Vector3d> &line, const std::vector<Eigen::Vector3d> &reference);
// Nearest distances of a surface's vertices from another surface.
Apart surfaces_apart(const bake::Mesh &surface, const bake::Mesh &reference);

} // namespace seld::ct
