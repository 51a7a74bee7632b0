// The figures of instruments as text, JSON, a table for docs/instruments.md and a picture.
#pragma once
#include "host/model/instrument.hpp"
#include "host/picture/picture.hpp"
#include <string>
#include <vector>

namespace crn
{

// One instrument of a list, with its other presets for comparison.
struct ListedInstrument {
    std::string file; // without preset
    Instrument instrument;
    std::vector<Instrument> others; // the file's other presets
};

inline constexpr char shipped_instruments[] =
    "shared/examples/instruments"; // no std::string: other globals are made of it

// Files, each maybe with ":preset", and folders (every .toml in them, by name) -> instruments. Empty: the
// shipped folder. A `preset` that is not empty is taken where no other one is named, and files of a folder
// that do not have it are left out. Throws FileError.
std::vector<ListedInstrument> list_instruments(const std::vector<std::string> &paths,
                                               const std::string &preset);

std::string instruments_text(const std::vector<ListedInstrument> &list);
std::string instruments_json(const std::vector<ListedInstrument> &list);

// The table between the two marks in docs/instruments.md, without the marks.
std::string instruments_markdown(const std::vector<ListedInstrument> &list);
inline const std::string table_begin = "<!-- table of instruments: written by `make docs` -->\n";
inline const std::string table_end = "<!-- end of the table -->\n";
// Puts the table into a document between its marks. Throws FileError when the marks are missing or it cannot
// be written.
void write_instruments_table(const std::string &path, const std::vector<ListedInstrument> &list);

// One row an instrument: its figures, EI and GJ against the distance from the tip, the tip and the whole
// unloaded shape.
Image instruments_picture(const std::vector<ListedInstrument> &list);

// EI or GJ at an arc length from the tip, N m^2, by the linear rule of the core.
enum class Stiffness { bend, twist };
double stiffness_at(const Instrument &instrument, Stiffness which, double arc_m);

} // namespace crn
