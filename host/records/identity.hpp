// Provides UUIDs, SHA-256 and times in UTC for the records of sessions.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace crn
{

// Returns a UUIDv7 (RFC 9562, 5.7): 48 bits of Unix time in ms, then 74 random bits from the operating
// system. Throws RecordsError if the operating system provides no random numbers.
std::string new_uuid();
// Returns the UUIDv5 (RFC 9562, 5.5) of a name within the name space `space`, which is a UUID itself.
std::string uuid_v5(std::string_view space, std::string_view name);
// Returns the UUIDv5 of "KIND NAME" in the name space of these records: the same name gives the same UUID on
// every machine.
std::string uuid_of_name(std::string_view kind, std::string_view name);
// Returns true if the text consists of 8-4-4-4-12 hexadecimal digits with small letters.
bool is_uuid(std::string_view text);

// Returns the SHA-256 (FIPS 180-4) of the bytes as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);
// Returns the SHA-256 of the file's contents, or no value if the file cannot be read.
std::optional<std::string> sha256_of_file(const std::string &path);

// Returns the moment as "2026-11-24T20:14:57.123Z".
std::string utc_now();
std::string utc_text(std::int64_t unix_ms);
// Returns the ms since 1970 of a text in exactly the form of utc_text(), or no value for every other text.
std::optional<std::int64_t> unix_ms_of(std::string_view text);
bool is_date(std::string_view text); // "2026-11-24", a day of the calendar

} // namespace crn
