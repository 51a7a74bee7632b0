// Reads and writes vessel trees as files of four formats: 3D Slicer's .mrk.json, VMTK's .vtp, and this
// project's .csv and .obj. The document docs/centreline.md lists the fields of each format.
#pragma once
#include "tools/centreline/tree.hpp"

#include <filesystem>
#include <string>

namespace crn::centreline
{

constexpr std::size_t file_bytes_max = std::size_t{256} << 20;

// Reads a vessel tree from a file; the extension of the file's name selects the format. If the file does not
// state from which parent a branch leaves, the branch becomes a root, which the function `joined` can join to
// a parent. Throws a Fault whose message names the file, the line or element, the field and the remedy. If
// `needs_radii` is false, the function accepts an .obj file without radii and gives its spheres a radius of 1
// um.
Tree read_tree(const std::filesystem::path &file, bool needs_radii = true);

// Writes a vessel tree to a file; the extension of the file's name selects the format. The written file gets
// its final name only when it is complete. Throws Fault or crn::OutputError.
void write_tree(const std::filesystem::path &file, const Tree &tree);

// Each of the next functions reads one format; `name` is the file's name for error messages.
Tree read_markups(const std::string &text, const std::string &name);
Tree read_polydata(const std::string &text, const std::string &name);
Tree read_csv(const std::string &text, const std::string &name);
Tree read_polyline(const std::string &text, const std::string &name, bool needs_radii = true);
std::string markups_text(const Tree &tree);
std::string polydata_text(const Tree &tree);
std::string csv_text(const Tree &tree);
std::string polyline_text(const Tree &tree);

// Holds a line of a file and the line's number; all readers of text formats use this type.
struct TextLine {
    std::string_view text;
    std::size_t number; // from 1
};
std::vector<TextLine> lines_of(std::string_view text);
std::vector<std::string_view> words_of(std::string_view line);
// Returns the number that the word represents, or NaN if the whole word is not a number; the result does not
// depend on the locale.
double number_of(std::string_view word);
// Returns a name that is valid in every format: it has at most 63 bytes and contains only letters, digits,
// blanks and _-.().
std::string plain_name(const std::string &name);
// Lengths in files are in millimetres with `file_decimals` decimals, so that rounding errors are far below a
// micrometre; trailing zeros are left out.
inline constexpr int file_decimals = 6;

} // namespace crn::centreline
