/* Makes random variants of arteries, as different men might have them, each from a seed. The drawn trees are
   variants of the shipped aorta, in the shipped skeleton (docs/vessels.md, "Drawn anatomies"). */
#pragma once
#include "tools/anatomy/skeleton.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <cstdint>
#include <optional>
#include <string>

namespace anatomy
{

enum class ArchType { I, II, III };

/* Figures of an arch, which are drawn first, and then measured again on the drawn tree. */
struct ArchFigures {
    ArchType type = ArchType::I;
    double drop_widths =
        0; // from the arch's top down to the brachiocephalic origin, in widths of the left carotid
    bool has_common_trunk = false; // the left common carotid artery leaves the brachiocephalic artery
};

struct DrawnAorta {
    std::uint64_t seed = 0;
    TreeDraft draft;
    ArchFigures arch;
    double right_tortuosity =
        1; // length over distance, from the aorta's end to the introducer or to the groin
    double left_tortuosity = 1;
    double aorta_scale = 1; // its diameters, in parts of the shipped ones
    unsigned refused = 0;   // earlier attempts with this seed that broke a rule (plausible.hpp)
};

/* Diameters of a person's aorta, and of its branches in parts of the shipped ones, in the shipped frame. */
struct AortaCalibre {
    double annulus_mm = 24.0, ascending_mm = 34.1, descending_mm = 25.8, infrarenal_mm = 19.3;
    double branches = 1.0, renals = 1.0;
};

/* States what is known about the person whose aorta is drawn. Without changes, the shipped man's aorta is
 * varied. */
struct AortaWish {
    std::optional<ArchType> type;
    bool has_common_trunk = false;    // true: asked for; false: drawn
    std::optional<double> tortuosity; // of both iliac arteries: length over distance
    std::optional<AortaCalibre> calibre;
    double arch_width = 1.0; // distance of ascending and descending aorta, in parts of the shipped one
    SkeletonShape skeleton;
};

/* Makes the tree that belongs to a seed. Every seed has one without a wish. Throws crn::FileError if the
 * shipped files cannot be read, and std::runtime_error if no plausible tree has what is asked for. */
DrawnAorta drawn_aorta(std::uint64_t seed, const AortaWish &wish = {});

/* Returns the horizontal distance of the ascending and the descending aorta at the height of the pulmonary
 * artery. */
double arch_width_mm(const std::vector<Vessel> &vessels);

/* Returns the tree as the text of a vessel file. */
std::string vessel_file_text(const DrawnAorta &drawn);

/* Measures the arch of a tree, which may also be a tree that was not drawn. The arch is the highest part of
 * the aorta. Throws std::invalid_argument if a vessel of the arch is missing. */
ArchFigures arch_figures(const std::vector<Vessel> &vessels);

/* Returns the name of an arch type: "I", "II" or "III". */
const char *arch_type_name(ArchType type);

} // namespace anatomy
