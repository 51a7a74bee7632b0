// Makes the pictures of the review of a patient's CT: sections along the axes of the patient, each a slab
// whose brightest voxels are shown, and the outline of the lumen in them.
#pragma once
#include "host/model/ct_volume.hpp"
#include "tools/bake/mesh.hpp"
#include <vector>

namespace crn::ct
{

// Names the three sections by their normal, an axis of the patient frame (docs/frames.md).
enum class Section { sagittal, axial, coronal }; // normal x (left), y (head), z (front)

// Grey values from black to white, in Hounsfield units.
struct GreyHU {
    double black = -150, white = 450;
};

// A square picture. Radiologists' conventions hold: axial sections are seen from the feet with the front up,
// coronal ones from the front, and sagittal ones with the front at the left.
struct SectionPicture {
    Section section = Section::axial;
    int edge_px = 0;
    double mm_per_px = 1;
    Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero(); // patient frame, at the middle of the picture
    std::vector<std::uint8_t> grey;                      // [row * edge_px + column], the first row on top
    std::vector<float> depth_mm;                         // along the normal: where the brightest voxel lies

    // Converts pixels (fractions allowed, pixel centres at .5) to the patient frame and back. `place` takes
    // the depth of the pixel's brightest voxel.
    Eigen::Vector3d place(double column, double row) const;
    Eigen::Vector2d pixel(const Eigen::Vector3d &place_mm) const;
};

// The value of the voxel nearest to a place, in thousandths of that of water; outside, that of the border.
double permille_near(const CtVolume &volume, const Eigen::Vector3d &place_mm);

// Draws the section through `centre_mm`. A slab of thickness 0 mm is a single plane, interpolated between
// voxels. Outside the volume the picture is black.
SectionPicture section_of(const CtVolume &volume, Section section, const Eigen::Vector3d &centre_mm,
                          double slab_mm, const GreyHU &grey, int edge_px);

// The axes of a section's picture in the patient frame: to the right, upwards, and the normal.
struct SectionAxes {
    Eigen::Vector3d right, up, normal;
};
SectionAxes axes_of(Section section);

// Line segments in mm, in the patient frame.
using Outline = std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>;

// Returns where the surface crosses the plane that has the section's normal and lies at `at_mm` along it.
Outline outline_of(const bake::Mesh &surface, Section section, double at_mm);

} // namespace crn::ct
