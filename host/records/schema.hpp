// The tables of records, as one text for SQLite and PostgreSQL (docs/records.md lists them).
#pragma once
#include <string>
#include <vector>

namespace crn
{

// The entry i has the statements that lead from version i to i + 1. An entry that was published never
// changes; a change of the tables is a new entry.
const std::vector<std::string> &schema_migrations();

} // namespace crn
