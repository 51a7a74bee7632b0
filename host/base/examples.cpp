#include "host/base/examples.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr int folders_up = 4; // build/san/bin is three below the repository

fs::path own_folder()
{
    const char *data = std::getenv("XDG_DATA_HOME"), *home = std::getenv("HOME");
    if (data && fs::path(data).is_absolute()) return fs::path(data) / "cournand";
    return home && *home ? fs::path(home) / ".local/share/cournand" : fs::path();
}

} // namespace

std::vector<fs::path> shipped_folders(const ExampleKind &kind)
{
    std::error_code failure;
    std::vector<fs::path> places;
    fs::path folder = fs::read_symlink("/proc/self/exe", failure).parent_path();
    for (int up = 0; up < folders_up && folder.has_relative_path(); ++up) {
        folder = folder.parent_path();
        places.push_back(folder / "share/cournand/examples" / kind.folder);
        places.push_back(folder / "shared/examples" / kind.folder);
    }
    places.push_back(fs::path("shared/examples") / kind.folder);
    std::erase_if(places, [&](const fs::path &place) { return !fs::is_directory(place, failure); });
    return places;
}

std::vector<fs::path> example_folders(const ExampleKind &kind)
{
    std::error_code failure;
    std::vector<fs::path> folders = shipped_folders(kind);
    const fs::path own = own_folder();
    if (!own.empty() && fs::is_directory(own / kind.folder, failure))
        folders.insert(folders.begin(), own / kind.folder);
    return folders;
}

std::string example_path(const ExampleKind &kind, const std::string &name)
{
    const std::vector<fs::path> folders = example_folders(kind);
    std::error_code failure;
    std::vector<std::string> others;
    for (const fs::path &folder : folders) {
        const fs::path path = folder / (name + kind.ending);
        if (fs::is_regular_file(path, failure)) return path.string();
        for (const auto &entry : fs::directory_iterator(folder, failure))
            if (entry.path().extension() == kind.ending) others.push_back(entry.path().stem().string());
    }
    const std::string singular = kind.singular;
    if (others.empty())
        throw std::runtime_error(
            "there is no " + singular + " '" + name + "', because no such file is in a folder of " +
            kind.folder +
            " is found: run the program in the repository, install it by make install, or "
            "give the path of a file");
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    throw std::runtime_error("there is no " + singular + " '" + name + "'" + suggestion(name, others));
}

std::string named_path(const ExampleKind &kind, const std::string &word)
{
    std::error_code failure;
    const bool is_path = word.empty() || word.find_first_of("/.") != word.npos || fs::exists(word, failure);
    return is_path ? word : example_path(kind, word);
}

} // namespace crn
