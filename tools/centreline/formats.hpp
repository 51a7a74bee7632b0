// Reads and writes trees as files: 3D Slicer's .mrk.json, VMTK's .vtp, and our .csv and .obj.
// docs/centreline.md lists their fields.
#pragma once
#include "tools/centreline/tree.hpp"

#include <filesystem>
#include <string>

namespace crn::centreline
{

constexpr std::size_t file_bytes_max = std::size_t{256} << 20;

// Reads a tree; the extension of the name selects the format. If the file does not say where a branch begins,
// the branch becomes a root (see `joined`). Throws Fault naming file, line or element, field and remedy. If
// `needs_radii` is false, an .obj without radii is accepted, and its spheres get a radius of 1 um.
Tree read_tree(const std::filesystem::path &file, bool needs_radii = true);

// Writes a tree; the extension of the name selects the format. The file appears under its name only when it
// is complete. Throws Fault or crn::OutputError.
void write_tree(const std::filesystem::path &file, const Tree &tree);

// These functions read one format each; `name` is for messages.
Tree read_markups(const std::string &text, const std::string &name);
Tree read_polydata(const std::string &text, const std::string &name);
Tree read_csv(const std::string &text, const std::string &name);
Tree read_polyline(const std::string &text, const std::string &name, bool needs_radii = true);
std::string markups_text(const Tree &tree);
std::string polydata_text(const Tree &tree);
std::string csv_text(const Tree &tree);
std::string polyline_text(const Tree &tree);

// Holds a line of a file and its number; all readers of text formats share this type.
struct TextLine {
    std::string_view text;
    std::size_t number; // from 1
};
std::vector<TextLine> lines_of(std::string_view text);
std::vector<std::string_view> words_of(std::string_view line);
// Returns the number that the whole word forms, or NaN; the result does not depend on the locale.
double number_of(std::string_view word);
// Returns a name that every format can hold: letters, digits, blanks and _-.(), at most 63 bytes.
std::string plain_name(const std::string &name);
// Lengths in files have this many decimals, so they are exact to a micrometre; zeros at their end are left
// out.
inline constexpr int file_decimals = 6;

} // namespace crn::centreline
