#include "host/records/database.hpp"
#include "host/records/schema.hpp"

namespace crn
{

std::int64_t whole_of(const SqlValue &value)
{
    if (const auto *whole = std::get_if<std::int64_t>(&value)) return *whole;
    if (const auto *number = std::get_if<double>(&value)) return static_cast<std::int64_t>(*number);
    return 0;
}

double number_of(const SqlValue &value)
{
    if (const auto *whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto *number = std::get_if<double>(&value)) return *number;
    return 0.0;
}

std::string text_of(const SqlValue &value)
{
    const auto *text = std::get_if<std::string>(&value);
    return text ? *text : std::string();
}

bool is_null(const SqlValue &value)
{
    return std::holds_alternative<std::monostate>(value);
}

void migrate(Database &database)
{
    migrate(database, schema_migrations());
}

void migrate(Database &database, const std::vector<std::string> &migrations)
{
    const int newest = static_cast<int>(migrations.size());
    const auto check = [&](int found) {
        if (found > newest)
            throw RecordsError(RecordsError::Cause::newer,
                               database.place() + ": these records are of version " + std::to_string(found) +
                                   ", and this program reads versions up to " + std::to_string(newest) +
                                   "; update Cournand, or name another file by --records");
        return found;
    };
    int found = check(database.version());
    if (found == newest) return;
    if (found > 0) database.back_up("before_version_" + std::to_string(newest));
    while (found < newest) {
        Transaction transaction(database);
        database.lock("schema");
        found = check(database.version()); // another program may have migrated in the meantime
        if (found < newest) {
            database.run_all(migrations[static_cast<std::size_t>(found)]);
            database.set_version(++found);
        }
        transaction.commit();
    }
}

} // namespace crn
