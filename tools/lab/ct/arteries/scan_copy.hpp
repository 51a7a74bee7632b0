// Keeps a copy of the scan, and of its label map, in the patient's folder: only voxels and grid. With this
// copy the patient can be mended and made again without the files of the hospital (docs/own_ct.md).
#pragma once
#include "host/model/ct_volume.hpp"
#include "tools/lab/ct/arteries/labels.hpp"
#include "tools/lab/ct/arteries/steps.hpp"
#include <optional>

namespace crn::ct
{

// Converts a scan along the patient's axes to the form of X.ct, with whole numbers from -1000 to 7191 HU, and
// back.
CtVolume ct_of(const Volume &scan);
Volume volume_of(const CtVolume &ct);

// Whether the file is such a copy, by its name.
bool is_copy(const std::filesystem::path &file);

struct ScanCopy {
    Volume scan;                    // as the copy holds it
    std::vector<std::string> notes; // of the reading of the original
};
// Reads the copy, and the notes beside it. Throws Fault.
ScanCopy read_copy(const std::filesystem::path &file);
// Writes the copy into the folder, unless it is there, and returns the scan as the copy holds it. Throws
// Fault if the folder has clicks for another scan.
Volume keep_copy(const Volume &scan, const std::filesystem::path &folder, Steps &steps);

// The label map of the folder, with its table; empty: none was given.
struct LabelFiles {
    std::filesystem::path map, names;
};
std::optional<LabelFiles> kept_labels(const std::filesystem::path &folder);
// Writes the copy of the map that was read from the file `map`, unless that is the copy itself.
void keep_labels(const LabelMap &labels, const std::filesystem::path &map,
                 const std::filesystem::path &folder);
void forget_labels(const std::filesystem::path &folder);

} // namespace crn::ct
