// Finds and opens the file or the server on which the records are stored.
#include "host/base/terminal.hpp"
#include "host/base/user_folders.hpp"
#include "host/records/store.hpp"
#include <cstdlib>
#include <filesystem>
#include <sys/stat.h>

namespace crn
{

namespace fs = std::filesystem;

std::string own_records_file()
{
    if (const char *place = std::getenv("COURNAND_RECORDS"); place && *place && !is_server_url(place))
        return place;
    const fs::path folder = data_folder();
    if (folder.empty())
        throw RecordsError(
            RecordsError::Cause::refused,
            "neither HOME nor XDG_DATA_HOME is set, so the records have no place; name a file by "
            "--records or COURNAND_RECORDS");
    return (folder / "records.db").string();
}

std::string default_records_place()
{
    const char *place = std::getenv("COURNAND_RECORDS");
    return place && *place ? std::string(place) : own_records_file();
}

bool is_server_url(const std::string &place)
{
    return place.starts_with("postgresql://") || place.starts_with("postgres://");
}

RecordStore open_store(const std::string &place)
{
    if (is_server_url(place)) return RecordStore(open_postgres(place));
    if (place.find("://") != place.npos)
        throw RecordsError(RecordsError::Cause::refused,
                           printable(place) + ": records are in an SQLite file, or at a URL that begins with "
                                              "postgresql://");
    std::error_code failed;
    if (place == (data_folder() / "records.db").string() && !fs::exists(place, failed)) {
        fs::create_directories(data_folder(), failed);
        // Only the user may read the folder, because the file of records may contain names of trainees.
        if (!failed) ::chmod(data_folder().c_str(), 0700);
        if (failed)
            throw RecordsError(RecordsError::Cause::refused,
                               printable(data_folder().string()) + ": this folder cannot be created: " +
                                   failed.message() + "; name a file by --records");
    }
    return RecordStore(open_sqlite(place));
}

} // namespace crn
