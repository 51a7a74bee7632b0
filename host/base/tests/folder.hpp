// Makes a folder for one test, and removes it afterwards.
#pragma once
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace crn::tests
{

struct Folder {
    explicit Folder(const std::string &name)
    {
        path = (std::filesystem::temp_directory_path() / ("cournand-" + name + "-XXXXXX")).string();
        if (!mkdtemp(path.data())) throw std::runtime_error("no folder " + path);
    }
    ~Folder() { std::filesystem::remove_all(path); }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;
    std::string file(const std::string &name) const { return path + "/" + name; }
    std::size_t count() const
    {
        std::size_t files = 0;
        for (const auto &entry : std::filesystem::directory_iterator(path)) files += entry.exists();
        return files;
    }
    std::string path;
};

} // namespace crn::tests
