// Checks a patient's scan, separates the body from the table, and makes the CT of a scene.
#pragma once
#include "host/model/ct_volume.hpp"
#include "tools/lab/ct/arteries/labels.hpp"
#include "tools/lab/ct/arteries/mask.hpp"

namespace crn::ct
{

// What a person has to know about a scan. `facts` are figures, `assumed` what the program took for granted,
// and `check` what a person must look at.
struct Findings {
    std::vector<std::string> facts, assumed, check;
};

// Orders the voxels from the patient's right to the left, from the front to the back and from the feet to the
// head, whatever their order in the file. Throws Fault if the axes are not along the patient's, or the slices
// are not axial.
Volume along_patient_axes(Volume volume);

// Throws Fault if the volume is no CT of a patient that a scene can be made of: values that are no HU,
// another modality, slices too far apart, too short a stretch of the body. Notes metal.
void check_scan(const Volume &scan, Findings &findings);

// Counts places from the middle of the scan if it lies far from its origin, as scans of a long table do.
void recentre(Volume &scan, Findings &findings);

// Returns the mask of the body: the largest piece of tissue with all that it encloses.
Mask body_of(const Volume &scan);

// The voxels of the structures with these numbers.
Mask mask_of(const LabelMap &labels, const std::vector<int> &numbers);

// Attenuation of the vessels in the scan, measured in the aorta. Throws Fault where the scan has no contrast
// medium, unless `is_without_contrast`.
struct Contrast {
    double mean_HU = 0, noise_HU = 0;
};
Contrast contrast_in(const Volume &scan, const LabelMap &labels, Findings &findings);
// The same where there is no aorta: from the voxels whose neighbours are arteries, too.
Contrast contrast_in_arteries(const Volume &scan, const LabelMap &labels, Findings &findings);

// Makes the CT for the picture, from a scan along the patient's axes: outside the body there is air, and
// contrast medium in vessels and heart is replaced by blood. Calcium stays.
CtVolume picture_volume(const Volume &scan, const Mask &body, const LabelMap &labels,
                        const Contrast &contrast, Findings &findings);

} // namespace crn::ct
