// Writes a folder of pictures, and an HTML page that shows these pictures.
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

    // Saves the picture under the given name, and adds the picture to the page with a line of text. Throws
    // OutputError.
    void show(const Picture &picture, const std::string &name, const std::string &what);
    // Adds a picture that lies in the folder already.
    void add(const std::string &name, const std::string &what);
    // Adds a link to another page; `name` is the text of the link.
    void link(const std::string &to, const std::string &name);
    // Writes index.html with all pictures and links that have been added so far. Throws OutputError.
    void write(const std::string &head, const std::string &facts) const;

  private:
    std::filesystem::path folder_;
    std::string figures_, links_;
};

} // namespace crn::ct
