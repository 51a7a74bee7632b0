// Converts records to text for other programs: JSON (which `cournand records import` reads again), CSV for a
// spreadsheet, and xAPI statements for a learning record store (docs/records.md).
#pragma once
#include "host/records/record.hpp"
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

inline constexpr int records_format = 1;

nlohmann::ordered_json json_of(const SessionRecord &record);
// {"format": 1, "sessions": [...]}
nlohmann::ordered_json json_of(const std::vector<SessionRecord> &records);
// Reads what json_of() wrote. `file` is the name of the source in error messages. Throws RecordsError
// (refused).
std::vector<SessionRecord> records_of_json(const std::string &text, const std::string &file);

// Returns one line per session with a column for each metric that occurs, as CSV (RFC 4180) in UTF-8. A text
// that a spreadsheet would take for a formula gets an apostrophe at its beginning.
std::string csv_of(const std::vector<SessionRecord> &records);

// Returns one xAPI 1.0.3 statement per session. The parts of a statement are actor (account of the pseudonym
// at `home_page`), verb (passed, failed or completed), object (the case) and result (score, success,
// completion, duration, metrics as extensions). The ids of the xAPI statements follow from the session's id,
// so that a record store recognises a statement that is sent again.
nlohmann::ordered_json xapi_of(const std::vector<SessionRecord> &records, const std::string &home_page);

inline constexpr const char *records_home_page = "https://cournand.invalid";

} // namespace crn
