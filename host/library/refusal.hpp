// Keeps every exception inside the library: a function of the API runs its work in guarded(), which returns a
// status and keeps the text for cournand_error_text().
#pragma once
#include "host/base/text.hpp"
#include "host/library/cournand.h"
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

namespace crn::library
{

inline constexpr std::size_t text_bytes = 1024; // longer texts are cut

class Refused : public std::runtime_error
{
  public:
    Refused(cournand_status status_, const std::string &text) : std::runtime_error(text), status(status_) {}
    cournand_status status;
};

// Keeps the text of the present exception for this thread, and returns the status of this exception.
// `otherwise` is the status that is returned if the exception does not state a status. Neither throws nor
// allocates.
cournand_status note_failure(cournand_status otherwise) noexcept;
const char *last_text() noexcept;
// Returns the place in a file that the last refusal in this thread names; the file is "" if it names none.
struct ErrorPlace {
    const char *file;
    std::uint32_t line, column;
};
ErrorPlace last_place() noexcept;

// Throws Refused(COURNAND_BAD_ARGUMENT) if an argument does not meet the given condition.
inline void require(bool holds, const char *text)
{
    if (!holds) throw Refused(COURNAND_BAD_ARGUMENT, text);
}

template <class Work>
cournand_status guarded(Work work, cournand_status otherwise = COURNAND_INTERNAL) noexcept
{
    try {
        work();
        return COURNAND_OK;
    } catch (...) {
        return note_failure(otherwise);
    }
}

// Runs work that reads or writes files. An error that states no status of its own gets the status
// COURNAND_BAD_FILE.
template <class Work> auto with_files(Work work)
{
    try {
        return work();
    } catch (const Refused &) {
        throw;
    } catch (const FileError &) { // has its place
        throw;
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &error) {
        throw Refused(COURNAND_BAD_FILE, error.what());
    }
}

// Holds the size of a struct in the first version of the library; callers of that version pass this size.
// When a struct gets new members, a template specialisation keeps its first size.
template <class Struct> inline constexpr std::size_t first_bytes = sizeof(Struct);
inline constexpr std::size_t struct_bytes_max = 4096;

// Copies a struct from the caller; the struct may be from an older or a newer version of the library
// (cournand.h, "STRUCTS"). Members that an older struct does not have are set to zero.
template <class Struct> Struct read_struct(const Struct *from, const char *name)
{
    Struct own{};
    if (from == nullptr) throw Refused(COURNAND_BAD_ARGUMENT, std::string(name) + " is NULL: pass a struct");
    const std::size_t bytes = from->struct_bytes;
    if (bytes < first_bytes<Struct> || bytes > struct_bytes_max)
        throw Refused(COURNAND_BAD_ARGUMENT,
                      std::string(name) + ": struct_bytes is " + std::to_string(bytes) + ", not " +
                          std::to_string(sizeof own) + ": set it to the size of the struct");
    const auto *raw = reinterpret_cast<const unsigned char *>(from);
    for (std::size_t i = sizeof own; i < bytes; i++)
        require(raw[i] == 0,
                "a struct has members that this version of the library does not know: set them to 0");
    std::memcpy(&own, from, std::min(bytes, sizeof own));
    return own;
}

// Copies values to a struct of the caller; read_struct() must have checked the struct before.
template <class Struct> void write_struct(Struct *to, const Struct &own, const char *name)
{
    const Struct asked = read_struct(to, name);
    std::memcpy(to, &own, std::min<std::size_t>(asked.struct_bytes, sizeof own));
    to->struct_bytes = asked.struct_bytes;
}

} // namespace crn::library
