// toml++, for texts that anyone may have written. Its assertions are meant for its own developers, but some fail on texts that it
// then refuses properly (a lone '['), and would end the program.
// May include: nothing of ours. Called by: whoever reads TOML, which is read by parse_toml alone.
//
// toml++ goes one call deeper for each table within a table, and so does every walk through what it read: a header of 400,000
// dotted names ends the program. So a text is looked through first. With at most 32 names in a key and 32 brackets within each
// other no table lies deeper than 32 + 33 * 32, about 1,100: a hundred times less than the stack holds. The size bounds the memory.
#pragma once
#define TOML_ASSERT(expr) static_cast<void>(0)
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <toml++/toml.h>

namespace seld
{

inline constexpr std::size_t toml_bytes_max = std::size_t{4} << 20; // the largest honest text has 11 kB
inline constexpr int toml_key_names_max = 32, toml_brackets_max = 32;

// What is wrong with a text, without the file's name. line 0: the whole file.
struct TomlError : std::runtime_error {
    TomlError(int line_, int column_, const std::string &text)
        : std::runtime_error(text), line(line_), column(column_)
    {
    }
    int line, column;
};

// Throws TomlError. `file` is what the nodes' places name.
toml::table parse_toml(std::string_view text, const std::string &file);

// The first half of it: size, names of a key, brackets within brackets. Throws TomlError.
void check_toml(std::string_view text);

} // namespace seld
