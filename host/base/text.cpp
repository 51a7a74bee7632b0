#include "host/base/text.hpp"
#include "host/base/terminal.hpp"
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <numeric>
#include <sys/stat.h>

namespace crn
{

namespace
{

std::string place(const std::string &file, int line, int column, const std::string &text)
{
    std::string result = file;
    if (line > 0) result += ":" + std::to_string(line);
    if (line > 0 && column > 0) result += ":" + std::to_string(column);
    return printable_lines(result + ": " + text);
}

// Returns the least number of edits that turn one word into the other: a letter is left out, added, replaced
// or exchanged with its neighbour.
std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> above, row(b.size() + 1), below(b.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 0; i < a.size(); i++) {
        below[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); j++) {
            const std::size_t replaced = row[j] + (a[i] == b[j] ? 0 : 1);
            below[j + 1] = std::min({below[j] + 1, row[j + 1] + 1, replaced});
            if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j])
                below[j + 1] = std::min(below[j + 1], above[j - 1] + 1);
        }
        above = row;
        row.swap(below);
    }
    return row.back();
}

} // namespace

FileError::FileError(const std::string &file_, int line_, int column_, const std::string &text)
    : Fault(place(file_, line_, column_, text)), file(file_), line(line_), column(column_)
{
}

std::string suggestion(std::string_view word, const std::vector<std::string> &candidates)
{
    const std::string *best = nullptr;
    std::size_t best_cost = 6; // twice the distance, and 1 more for a word of another length
    std::string known;
    for (const std::string &candidate : candidates) {
        const std::size_t distance = edit_distance(word.substr(0, 40), candidate);
        const std::size_t cost = 2 * distance + (word.size() == candidate.size() ? 0 : 1);
        if (cost < best_cost && distance < candidate.size()) {
            best_cost = cost;
            best = &candidate;
        }
        known += (known.empty() ? "" : ", ") + candidate;
    }
    return best ? ", did you mean '" + *best + "'?" : "; known: " + known;
}

std::vector<unsigned char> read_binary_file(const std::string &path)
{
    struct stat info;
    if (stat(path.c_str(), &info) != 0)
        throw FileError(path, 0, 0, std::string("cannot open: ") + std::strerror(errno));
    if (!S_ISREG(info.st_mode)) throw FileError(path, 0, 0, "is not a regular file");
    if (info.st_size > (off_t{1} << 32)) throw FileError(path, 0, 0, "is larger than 4 GiB");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw FileError(path, 0, 0, std::string("cannot open: ") + std::strerror(errno));
    std::vector<unsigned char> bytes(static_cast<std::size_t>(info.st_size));
    stream.read(reinterpret_cast<char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (stream.gcount() != static_cast<std::streamsize>(bytes.size()))
        throw FileError(path, 0, 0, "cannot read to its end");
    return bytes;
}

std::string read_text_file(const std::string &path)
{
    const std::vector<unsigned char> bytes = read_binary_file(path);
    return {bytes.begin(), bytes.end()};
}

} // namespace crn
