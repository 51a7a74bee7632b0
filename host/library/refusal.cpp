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

thread_local char failure_text[text_bytes] = "";

cournand_status keep(cournand_status status, const char *text) noexcept
{
    std::size_t count = std::min(std::strlen(text), text_bytes - 1);
    while (count > 0 && (static_cast<unsigned char>(text[count]) & 0xc0u) == 0x80u) // cut between characters
        count--;
    std::memcpy(failure_text, text, count);
    failure_text[count] = '\0';
    return status;
}

} // namespace

const char *last_text() noexcept
{
    return failure_text;
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
