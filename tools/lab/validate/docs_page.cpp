#include "tools/lab/validate/docs_page.hpp"
#include "host/base/pending_file.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace crn::validate
{

void write_between_marks(const std::string &path, const std::string &target, const std::string &text)
{
    const std::string mark_begin = "<!-- begin: written by `make " + target + "` -->",
                      mark_end = "<!-- end -->";
    std::ifstream file(path, std::ios::binary);
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    std::size_t begin = page.find(mark_begin + "\n");
    const std::size_t end = page.find(mark_end);
    if (!file || begin == std::string::npos || end == std::string::npos || end < begin)
        throw std::runtime_error(path + ": no '" + mark_begin + "' and '" + mark_end + "' to write between");
    begin += mark_begin.size() + 1;
    write_whole_file(path, page.substr(0, begin) + text + page.substr(end));
}

} // namespace crn::validate
