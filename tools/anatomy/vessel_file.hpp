/* Reads trees of vessels from TOML files (docs/vessels.md), both those that ship and those of users. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <optional>

namespace anatomy
{

/* The content of files of vessels, before it is joined to a tree. Each part has its file and line, which
 * messages name. */
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

/* Reads the file and the files that it extends. Throws crn::FileError. */
TreeDraft read_vessel_draft(const std::string &file);

/* Adds a vessel, or replaces the one with the same name. Throws crn::FileError when a name occurs twice,
 * when there is nothing to replace, or when the parent does not come before the vessel. */
void add_vessel(TreeDraft &draft, GivenVessel given);

/* Makes the tree and finds its entry. Throws crn::FileError when a vessel does not begin inside its
 * parent, or when the entry is not on its vessel. `file` is the user's file: messages name it rather than
 * a file that it extends. */
VesselTree tree_of(const TreeDraft &draft, const std::string &file);

/* Reads the file and the files that it extends. Throws crn::FileError: "FILE:LINE:COLUMN: vessel, station:
 * what is wrong". */
VesselTree read_vessels(const std::string &file);

/* Returns the path of the file NAME among those that ship. They are in shared/examples/anatomies, and
 * `make install` puts them into share/cournand/examples/anatomies. Both are searched for in the folders
 * above the program, and the former also in the working folder. Throws std::runtime_error when the file is
 * in none of them. */
std::string shipped_vessel_file(const std::string &name);

/* Reads the file NAME.toml that ships. */
VesselTree shipped_vessels(const std::string &name);

} // namespace anatomy
