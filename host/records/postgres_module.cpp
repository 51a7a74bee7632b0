// Opens the library records_postgres.so, which holds everything that knows PostgreSQL.
#include "host/base/terminal.hpp"
#include "host/records/database.hpp"
#include <dlfcn.h>
#include <filesystem>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr int folders_up = 6; // build/test/host/records/tests is four below the build
const char *const library_name = "records_postgres.so";

// The folder lib/cournand of an installed program is beside bin, and the folder lib of a build is above the
// build's programs.
std::string library_path()
{
    std::error_code failed;
    fs::path folder = fs::read_symlink("/proc/self/exe", failed).parent_path();
    for (int up = 0; up < folders_up && folder.has_relative_path(); up++) {
        folder = folder.parent_path();
        for (const char *below : {"lib/cournand", "lib"})
            if (fs::exists(folder / below / library_name, failed))
                return (folder / below / library_name).string();
    }
    return "";
}

using Open = Database *(const char *url);

Open *open_function()
{
    const std::string path = library_path();
    if (path.empty())
        throw RecordsError(RecordsError::Cause::refused,
                           std::string(library_name) +
                               " was not found beside this program, so no server can be used; "
                               "build or install Cournand again");
    void *library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    void *function = library ? ::dlsym(library, "crn_open_postgres") : nullptr;
    if (!function)
        throw RecordsError(RecordsError::Cause::refused,
                           printable(::dlerror()) +
                               "; install libpqxx (Debian: apt-get install libpqxx-6.4)");
    return reinterpret_cast<Open *>(function);
}

} // namespace

// The library stays open, because exceptions that it throws have their types in it.
std::unique_ptr<Database> open_postgres(const std::string &url)
{
    static Open *const open = open_function();
    return std::unique_ptr<Database>(open(url.c_str()));
}

} // namespace crn
