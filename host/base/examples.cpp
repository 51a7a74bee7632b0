#include "host/base/examples.hpp"
#include "host/base/text.hpp"
#include "host/base/user_folders.hpp"
#include <algorithm>
#include <stdexcept>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr int folders_up = 4; // build/san/bin is three below the repository

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
    const fs::path own = data_folder();
    if (!own.empty() && fs::is_directory(own / kind.folder, failure))
        folders.insert(folders.begin(), own / kind.folder);
    return folders;
}

FileSearch search_file(const std::vector<fs::path> &folders, const std::string &name)
{
    std::error_code failure;
    FileSearch search;
    for (const fs::path &folder : folders) {
        if (fs::is_regular_file(folder / name, failure)) return {(folder / name).string(), {}};
        for (const auto &entry : fs::directory_iterator(folder, failure))
            search.others.push_back(entry.path().filename().string());
    }
    std::sort(search.others.begin(), search.others.end()); // two names of a folder give each file twice
    search.others.erase(std::unique(search.others.begin(), search.others.end()), search.others.end());
    return search;
}

std::vector<std::string> example_names(const ExampleKind &kind)
{
    std::vector<std::string> names;
    for (const fs::path other : search_file(example_folders(kind), "").others)
        if (other.extension() == kind.ending) names.push_back(other.stem().string());
    return names;
}

std::string example_path(const ExampleKind &kind, const std::string &name)
{
    const FileSearch search = search_file(example_folders(kind), name + kind.ending);
    if (!search.path.empty()) return search.path;
    const std::vector<std::string> others = example_names(kind);
    const std::string text = "there is no " + std::string(kind.singular) + " '" + name + "'";
    if (!others.empty()) throw std::runtime_error(text + suggestion(name, others));
    throw std::runtime_error(text + ", because no folder with " + kind.folder +
                             " is found: run the program in the repository, install it by make install, or "
                             "give the path of a file");
}

bool is_path(const std::string &word)
{
    const std::string name = word.substr(0, word.find_last_of(':'));
    std::error_code failure;
    return name.empty() || word.find_first_of("/.") != word.npos || fs::exists(name, failure);
}

std::string named_path(const ExampleKind &kind, const std::string &word)
{
    const std::string name = word.substr(0, word.find_last_of(':')), preset = word.substr(name.size());
    return is_path(word) ? word : example_path(kind, name) + preset;
}

} // namespace crn
