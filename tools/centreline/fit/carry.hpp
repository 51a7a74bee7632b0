// The tree of one frame carried through a sequence of meshes with one topology: the same branches, the same
// spheres, in the same order.
#pragma once
#include "tools/centreline/fit/line_fit.hpp"

namespace crn::centreline
{

constexpr std::size_t frames_max = 1000;

struct Frame {
    std::string name;
    Tree tree;
    double moved_mm = 0; // farthest that a sphere lies from where it was in the first frame
    double refit_mm = 0; // farthest that the fit moved a sphere from where the wall had carried it
};

// The .obj (or .ply, .stl, .glb) files of a folder in the order of the numbers in their names. Throws Fault.
std::vector<std::filesystem::path> frames_of(const std::filesystem::path &folder);

// `files`: the frames; the tree belongs to the first. Each sphere goes with the wall around it and is then
// fitted again. Throws Fault naming the frame when its topology differs.
std::vector<Frame> carried(const Tree &tree, const std::vector<std::filesystem::path> &files,
                           const bake::MeshText &text, const LumenWish &wish, bake::Progress &progress);

} // namespace crn::centreline
