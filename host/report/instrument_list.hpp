// Lists the properties of instruments: as text, as JSON, as the table in docs/instruments.md, and as a
// picture.
#pragma once
#include "host/model/instrument.hpp"
#include "host/picture/picture.hpp"
#include <string>
#include <vector>

namespace crn
{

// Holds one instrument of a list and, for comparison, the other presets in the instrument's file.
struct ListedInstrument {
    std::string file; // without preset
    Instrument instrument;
    std::vector<Instrument> others; // the file's other presets
};

// Reads instruments from files (a file name may end with ":preset") and from folders (all .toml files in
// them, in order of the names). If `paths` is empty, the function reads the first folder of instruments that
// come with the program (examples.hpp). If `preset` is not empty, it applies to every file for which `paths`
// names no preset. Files in a folder that do not have the requested preset are left out. Throws FileError, or
// std::runtime_error if no folder of instruments comes with the program.
std::vector<ListedInstrument> list_instruments(const std::vector<std::string> &paths,
                                               const std::string &preset);

// The first column of the text has the names by which command lines refer to instruments.
std::string instruments_text(const std::vector<ListedInstrument> &list);
std::string instruments_json(const std::vector<ListedInstrument> &list);

// Returns the table for docs/instruments.md, which stands there between two marks; the marks are not part of
// the result.
std::string instruments_markdown(const std::vector<ListedInstrument> &list);
inline const std::string table_begin = "<!-- table of instruments: written by `make docs` -->\n";
inline const std::string table_end = "<!-- end of the table -->\n";
// Replaces the table between the two marks in a document. Throws FileError when the marks are missing or the
// document cannot be written.
void write_instruments_table(const std::string &path, const std::vector<ListedInstrument> &list);

// Draws one row per instrument: its properties, the stiffnesses EI (bending) and GJ (torsion) along it, and
// the unloaded shape of the tip and of the whole instrument.
Image instruments_picture(const std::vector<ListedInstrument> &list);

// Returns the bending stiffness EI or torsional stiffness GJ in N m^2 at an arc length from the tip,
// interpolated linearly between knots as in the core.
enum class Stiffness { bend, twist };
double stiffness_at(const Instrument &instrument, Stiffness which, double arc_m);

} // namespace crn
