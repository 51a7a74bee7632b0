// The step of `ct patient` that finds the arteries without a label map. It keeps its result in the patient's
// folder.
#pragma once
#include "tools/lab/ct/arteries/arteries.hpp"
#include "tools/lab/ct/arteries/steps.hpp"
#include "tools/lab/ct/page.hpp"

namespace crn::ct
{

struct Unlabelled {
    LabelMap labels;
    Eigen::Vector3d root_mm; // where the blood enters
    bool has_aorta = true;   // false: the arteries begin at a click
};

// Finds the arteries, or reads them again if nothing has changed: arteries.nii.gz, arteries.json and
// pictures.
Unlabelled unlabelled_arteries(const Volume &scan, const Mask &body, const std::vector<Click> &clicks,
                               Steps &steps, const std::string &inputs, Page &page, Findings &findings);

} // namespace crn::ct
