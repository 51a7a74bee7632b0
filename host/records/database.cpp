#include "host/records/database.hpp"
#include "host/records/schema.hpp"

namespace crn
{

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
