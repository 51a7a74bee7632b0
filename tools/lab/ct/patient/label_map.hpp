// Makes a scene of a label map alone, without a scan.
#pragma once
#include "tools/lab/ct/arteries/labels.hpp"
#include "tools/patient/scene_folder.hpp"

namespace crn::ct
{

struct LabelWish {
    std::filesystem::path map, table; // table: empty if the map has one label, or all are vessels
    std::vector<int> labels;          // numbers of the vessels; empty: the arteries by their names, or all
};

// The vessels of a label map: their labels only, each with a name that is an artery's for is_artery().
struct VesselLabels {
    LabelMap map;
    std::map<int, std::string> names; // as a branch is named
};

// Reads the map and chooses its vessels. Throws Fault if a value is no whole number, or no label is a vessel.
VesselLabels read_vessel_labels(const LabelWish &wish, patient::Choices &choices);

// The surface of the labelled voxels, smoothed by about a voxel, in the scene's axes.
bake::Mesh surface_of_labels(const VesselLabels &labels);

// Makes the whole folder.
void make_label_scene(const LabelWish &labels, const patient::SceneWish &wish, patient::Choices &choices,
                      bake::Progress &progress);

} // namespace crn::ct
