/* Reads vessel trees from TOML files (docs/vessels.md), which are either shipped or written by users. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <optional>

namespace anatomy
{

/* The types below hold the content of vessel files before the vessels are joined to a tree. Each part of a
 * vessel file's content stores its file and line for error messages. */
struct FilePlace {
    std::string file;
    int line = 0;
};

struct GivenVessel {
    Vessel vessel; // `bed` of a coronary artery that begins in another one is still Bed::body
    bool is_coronary = false, has_side = false, replaces = false;
    FilePlace place;
};

struct GivenEntry {
    std::string vessel;
    std::optional<double> y_mm; // height that the vessel passes at the entry
    double from_end_mm = 0;     // used without y_mm: distance from the vessel's end
    FilePlace place;
};

struct TreeDraft {
    std::string title;
    bool is_in_patient = true;
    double fillet_mm = 0;
    std::optional<double> coronary_fillet_mm;
    std::vector<GivenVessel> vessels; // coronary arteries last
    std::optional<GivenEntry> entry;
};

/* Reads a vessel file and the vessel files that this file extends. Throws crn::FileError. */
TreeDraft read_vessel_draft(const std::string &file);

/* Adds a vessel, or replaces the vessel that has the same name. Throws crn::FileError if two vessels have the
 * same name, if the vessel to be replaced does not exist, or if a vessel is listed before its parent. */
void add_vessel(TreeDraft &draft, GivenVessel given);

/* Makes the vessel tree and finds the point where the guidewire enters the tree. Throws crn::FileError when a
 * vessel does not begin inside its parent, or when the entry point is not on its vessel. `file` is the user's
 * file; error messages name this file and not the files that it extends. */
VesselTree tree_of(TreeDraft draft, const std::string &file);

/* Reads a vessel file and the vessel files that this file extends. Throws crn::FileError with a message of
 * the form "FILE:LINE:COLUMN: vessel, station: what is wrong". */
VesselTree read_vessels(const std::string &file);

/* Returns the path of the shipped vessel file `NAME`. The shipped vessel files are in
 * shared/examples/anatomies, and `make install` puts them into share/cournand/examples/anatomies. The
 * program searches for the shipped vessel files in all folders above its own; it also looks for
 * shared/examples/anatomies in the working folder. Throws std::runtime_error when the file of vessels is in
 * none of the searched folders. */
std::string shipped_vessel_file(const std::string &name);

/* Reads the shipped vessel file NAME.toml. */
VesselTree shipped_vessels(const std::string &name);

} // namespace anatomy
