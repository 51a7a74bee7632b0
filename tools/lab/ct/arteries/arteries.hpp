// Finds the arteries of a CT with contrast medium without a label map, and mends those of a label map by
// clicks (docs/own_ct.md, "Arteries without a label map").
#pragma once
#include "tools/lab/ct/arteries/aorta.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include "tools/lab/ct/segment.hpp"

namespace crn::ct
{

enum : int {
    label_aorta = 1,
    label_artery = 2,
    label_heart = 3,
    label_bone = 4,
    label_bridge = 5,
    label_thread = 7, // the middle of an artery that was traced from a click
    label_organ = 6
};

// The names of these labels.
NamesTable artery_names();

struct FoundArteries {
    // Aorta, artery, bone, and wide regions behind a neck: the heart if they reach the aortic root, else an
    // organ, such as a kidney, which keeps its contrast medium in the picture.
    LabelMap labels;
    Eigen::Vector3d
        root_mm; // where the blood enters: the lower end of the ascending aorta, or the aorta's top
    Stack descending, ascending; // the latter may be empty
    bool has_aorta = true;       // false: `descending` is the disc at the first click into an artery
};

// The clicks of the kinds artery, cut and bridge are obeyed. Where there is no aorta, the arteries begin at
// the first click into one. Throws Fault where there is neither.
FoundArteries find_arteries(const Volume &scan, const Mask &body, const std::vector<Click> &clicks,
                            Findings &findings, const Report &report);

// Obeys the same clicks in the arteries of a label map.
void mend_arteries(const Volume &scan, const Mask &body, const Contrast &contrast,
                   const std::vector<Click> &clicks, LabelMap &labels, Findings &findings);

} // namespace crn::ct
