/* Makes random variants of arteries, as different men might have them, each from a seed. The drawn trees are
   variants of the shipped aorta, in the shipped skeleton (docs/vessels.md, "Drawn anatomies"). */
#pragma once
#include "tools/anatomy/vessel_file.hpp"
#include <cstdint>
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

/* Makes the tree that belongs to a seed. Every seed has one. Throws crn::FileError if the shipped files
 * cannot be read.
 */
DrawnAorta drawn_aorta(std::uint64_t seed);

/* Returns the tree as the text of a vessel file. */
std::string vessel_file_text(const DrawnAorta &drawn);

/* Measures the arch of a tree, which may also be a tree that was not drawn. The arch is the highest part of
 * the aorta. Throws std::invalid_argument if a vessel of the arch is missing. */
ArchFigures arch_figures(const std::vector<Vessel> &vessels);

/* Returns the name of an arch type: "I", "II" or "III". */
const char *arch_type_name(ArchType type);

} // namespace anatomy
