// Writes a folder of pictures, and the page that shows them.
#pragma once
#include "tools/lab/ct/pictures.hpp"

namespace crn::ct
{

class Page
{
  public:
    // Makes the folder. Throws Fault.
    explicit Page(const std::filesystem::path &folder);
    const std::filesystem::path &folder() const { return folder_; }

    // Saves the picture under this name, and adds it to the page with a line of text. Throws OutputError.
    void show(const Picture &picture, const std::string &name, const std::string &what);
    // Adds to the page a link with this name to another page.
    void link(const std::string &to, const std::string &name);
    // Writes index.html with everything shown so far. Throws OutputError.
    void write(const std::string &head, const std::string &facts) const;

  private:
    std::filesystem::path folder_;
    std::string figures_, links_;
};

} // namespace crn::ct
