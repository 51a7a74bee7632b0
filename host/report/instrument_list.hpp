// Lists the figures of instruments as text, JSON, a table for docs/instruments.md and a picture.
#pragma once
#include "host/model/instrument.hpp"
#include "host/picture/picture.hpp"
#include <string>
#include <vector>

namespace crn
{

// One instrument of a list, with the file's other presets for comparison.
struct ListedInstrument {
    std::string file; // without preset
    Instrument instrument;
    std::vector<Instrument> others; // the file's other presets
};

inline constexpr char shipped_instruments[] =
    "shared/examples/instruments"; // not a std::string, since other globals are initialised from it

// Reads instruments from files, each optionally with ":preset", and from folders (every .toml in them, by
// name). An empty list means the shipped folder. A `preset` that is not empty applies where no other one is
// named; files of a folder that do not have it are left out. Throws FileError.
std::vector<ListedInstrument> list_instruments(const std::vector<std::string> &paths,
                                               const std::string &preset);

std::string instruments_text(const std::vector<ListedInstrument> &list);
std::string instruments_json(const std::vector<ListedInstrument> &list);

// Returns the table between the two marks in docs/instruments.md, without the marks.
std::string instruments_markdown(const std::vector<ListedInstrument> &list);
inline const std::string table_begin = "<!-- table of instruments: written by `make docs` -->\n";
inline const std::string table_end = "<!-- end of the table -->\n";
// Puts the table into a document between its marks. Throws FileError when the marks are missing or it cannot
// be written.
void write_instruments_table(const std::string &path, const std::vector<ListedInstrument> &list);

// Draws one row per instrument: its figures, EI and GJ against the distance from the tip, the tip and the
// whole unloaded shape.
Image instruments_picture(const std::vector<ListedInstrument> &list);

// EI or GJ at an arc length from the tip, N m^2, by the core's linear rule.
enum class Stiffness { bend, twist };
double stiffness_at(const Instrument &instrument, Stiffness which, double arc_m);

} // namespace crn
