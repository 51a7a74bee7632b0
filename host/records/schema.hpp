// Defines the tables of records, in SQL that SQLite and PostgreSQL both understand (docs/records.md lists the
// tables).
#pragma once
#include <string>
#include <vector>

namespace crn
{

// The entry i of the list of migrations has the statements that lead from version i to i + 1. A published
// migration never changes; a change of the tables is a new migration.
const std::vector<std::string> &schema_migrations();

} // namespace crn
