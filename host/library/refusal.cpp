#include "host/library/refusal.hpp"
#include "host/base/text.hpp"
#include "host/link/link.hpp"
#include "host/session/recording.hpp"
#include <algorithm>
#include <new>

namespace crn::library
{

namespace
{

thread_local char failure_text[text_bytes] = "", failure_file[text_bytes] = "";
thread_local std::uint32_t failure_line = 0, failure_column = 0;

// Copies a text, and cuts it between two characters if it is too long.
void copy_text(char (&to)[text_bytes], const char *text) noexcept
{
    std::size_t count = std::strlen(text);
    if (count > text_bytes - 1)
        for (count = text_bytes - 1; count > 0 && (static_cast<unsigned char>(text[count]) & 0xc0u) == 0x80u;)
            count--;
    std::memcpy(to, text, count);
    to[count] = '\0';
}

cournand_status keep(cournand_status status, const char *text) noexcept
{
    copy_text(failure_text, text);
    failure_file[0] = '\0';
    failure_line = failure_column = 0;
    return status;
}

} // namespace

const char *last_text() noexcept
{
    return failure_text;
}

ErrorPlace last_place() noexcept
{
    return {failure_file, failure_line, failure_column};
}

cournand_status note_failure(cournand_status otherwise) noexcept
{
    try {
        throw;
    } catch (const Refused &refused) {
        return keep(refused.status, refused.what());
    } catch (const LinkError &error) {
        return keep(error.reject.code != 0 ? COURNAND_REFUSED : COURNAND_INTERNAL, error.what());
    } catch (const RecordingError &error) {
        return keep(COURNAND_BAD_FILE, error.what());
    } catch (const FileError &error) {
        keep(COURNAND_BAD_FILE, error.what());
        copy_text(failure_file, error.file.c_str());
        failure_line = static_cast<std::uint32_t>(error.line);
        failure_column = static_cast<std::uint32_t>(error.column);
        return COURNAND_BAD_FILE;
    } catch (const Fault &error) {
        return keep(COURNAND_BAD_FILE, error.what());
    } catch (const std::bad_alloc &) {
        return keep(COURNAND_NO_MEMORY, "there is not enough memory: free worlds or renderers");
    } catch (const std::exception &error) {
        return keep(otherwise, error.what());
    } catch (...) {
        return keep(COURNAND_INTERNAL, "an unknown fault: please report it");
    }
}

} // namespace crn::library
