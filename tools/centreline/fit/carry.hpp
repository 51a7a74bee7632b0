// Moves the vessel tree of the first frame through a sequence of meshes that have the same triangles. In all
// frames the tree has the same branches and spheres in the same order.
#pragma once
#include "tools/centreline/fit/line_fit.hpp"

namespace crn::centreline
{

constexpr std::size_t frames_max = 1000;

struct Frame {
    std::string name;
    Tree tree;
    double moved_mm = 0; // largest distance of a sphere from its place in the first frame
    double refit_mm = 0; // largest displacement by the fit from where the wall had carried a sphere
};

// Returns the mesh files (.obj, .ply, .stl or .glb) of a folder, sorted by the numbers in their names. Throws
// Fault.
std::vector<std::filesystem::path> frames_of(const std::filesystem::path &folder);

// The argument `files` names the meshes of the sequence, and `tree` belongs to the first mesh. Each sphere of
// the tree moves with the wall around it and is then fitted to the wall again. Throws a Fault that names a
// frame whose triangles differ from those of the first frame.
std::vector<Frame> carried(const Tree &tree, const std::vector<std::filesystem::path> &files,
                           const bake::MeshText &text, const LumenWish &wish, bake::Progress &progress);

} // namespace crn::centreline
