// Reads a label map of organs and its table of names, as programs that segment scans write them.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include <cmath>
#include <filesystem>
#include <map>

namespace crn::ct
{

// The number of each structure, by its name as TotalSegmentator v2 writes it, such as "iliac_artery_left".
using NamesTable = std::map<int, std::string>;

// Reads a table of names: CSV with a header that names a column of numbers (id, value, label or index) and a
// column of names (structure, name); or lines with a number and a name. Throws Fault.
NamesTable read_names(const std::filesystem::path &file);

struct LabelMap {
    Volume volume; // whole numbers on the grid of the scan
    NamesTable names;

    int label(std::size_t at) const { return static_cast<int>(std::lround(volume.hu[at])); }

    // Returns the numbers of the structures whose name satisfies the rule.
    template <class Rule> std::vector<int> numbers(const Rule &rule) const
    {
        std::vector<int> found;
        for (const auto &[number, name] : names)
            if (rule(name)) found.push_back(number);
        return found;
    }
};

// The structure of what a click says is an artery, although the scan does not show it.
inline constexpr const char *bridge_name = "artery_bridge", *thread_name = "artery_thread";

// Arteries belong to the lumen of a scene. Other vessels and chambers may hold contrast medium, too.
bool is_artery(const std::string &name);
bool may_hold_contrast(const std::string &name);

// Reads the map and brings it to the scan's grid. Throws Fault if grids or numbers do not fit, or if there is
// no aorta.
LabelMap read_labels(const std::filesystem::path &map, const std::filesystem::path &table,
                     const Volume &scan);

} // namespace crn::ct
