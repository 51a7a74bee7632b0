// Reads a TOML file written by a person, or throws a Fault that states the error.
#pragma once
#include "host/base/toml.hpp"
#include "tools/bake/fault.hpp"
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

namespace crn::bake
{

// Names this kind of text in error messages.
struct TomlKind {
    std::uintmax_t MiB_max;
    const char *what;      // "a scene text"
    const char *when_none; // the remedy when there is no such file
    const char *when_huge; // the end of the sentence about a file over the limit, or ""
};

// Throws Fault with the file, and with the line where it is not valid TOML.
inline toml::table read_toml(const std::filesystem::path &file, const TomlKind &kind)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw Fault(file.string() + ": no such file: give " + kind.when_none);
    if (std::filesystem::file_size(file, ignored) > kind.MiB_max << 20)
        throw Fault(file.string() + ": over " + std::to_string(kind.MiB_max) + " MiB, so hardly " +
                    kind.what + kind.when_huge);
    try {
        std::ostringstream text;
        text << std::ifstream(file, std::ios::binary).rdbuf();
        return parse_toml(text.str(), file.string());
    } catch (const TomlError &error) {
        throw Fault(file.string() + (error.line > 0 ? ":" + std::to_string(error.line) : "") + ": " +
                    error.what());
    }
}

} // namespace crn::bake
