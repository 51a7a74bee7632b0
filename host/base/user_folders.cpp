#include "host/base/user_folders.hpp"
#include <cstdlib>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

fs::path folder(const char *variable, const char *below_home)
{
    const char *named = std::getenv(variable), *home = std::getenv("HOME");
    if (named && fs::path(named).is_absolute()) return fs::path(named) / "cournand";
    return home && *home ? fs::path(home) / below_home / "cournand" : fs::path();
}

} // namespace

fs::path data_folder()
{
    return folder("XDG_DATA_HOME", ".local/share");
}

fs::path state_folder()
{
    return folder("XDG_STATE_HOME", ".local/state");
}

fs::path cache_folder()
{
    return folder("XDG_CACHE_HOME", ".cache");
}

} // namespace crn
