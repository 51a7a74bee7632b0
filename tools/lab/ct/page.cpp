#include "tools/lab/ct/page.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "tools/mesh/fault.hpp"

namespace crn::ct
{

Page::Page(const std::filesystem::path &folder) : folder_(folder)
{
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (failure) throw Fault(folder.string() + ": the folder cannot be made: " + failure.message());
}

void Page::show(const Picture &picture, const std::string &name, const std::string &what)
{
    picture.save(folder_ / name);
    add(name, what);
}

void Page::add(const std::string &name, const std::string &what)
{
    figures_ +=
        "<figure><img src=\"" + name + "\"><figcaption>" + html_text(what) + "</figcaption></figure>\n";
}

void Page::link(const std::string &to, const std::string &name)
{
    links_ += "<li><a href=\"" + to + "\">" + html_text(name) + "</a></li>\n";
}

void Page::write(const std::string &head, const std::string &facts) const
{
    write_whole_file((folder_ / "index.html").string(),
                     "<!doctype html><meta charset=\"utf-8\"><title>" + html_text(head) +
                         "</title><style>body{font:15px sans-serif;margin:24px}"
                         "figure{display:inline-block;margin:8px;vertical-align:top}img{max-width:640px}"
                         "figcaption{max-width:640px}pre{background:#eee;padding:8px}</style>\n<h1>" +
                         html_text(head) + "</h1>\n<pre>" + html_text(facts) + "</pre>\n<ul>" + links_ +
                         "</ul>\n" + figures_);
}

} // namespace crn::ct
