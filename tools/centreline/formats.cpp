// Reads and writes files, lines, words and numbers for all formats of centrelines.
#include "tools/centreline/formats.hpp"
#include "host/base/guarded_read.hpp"
#include "host/base/pending_file.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace crn::centreline
{
namespace
{

constexpr std::size_t name_bytes_max = 63;

bool ends_with(const std::filesystem::path &file, const std::string &ending)
{
    std::string name = file.filename().string();
    for (char &c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return name.size() > ending.size() &&
           name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

[[noreturn]] void refuse_ending(const std::filesystem::path &file)
{
    throw Fault(file.string() + ": is no centreline by its name: use .csv, .mrk.json, .vtp or .obj");
}

std::string content_of(const std::filesystem::path &file)
{
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        throw Fault(file.string() + ": is no readable file: check the name");
    const auto bytes = std::filesystem::file_size(file, error);
    if (error || bytes > file_bytes_max)
        throw Fault(file.string() + ": cannot be read, or is larger than 256 MiB");
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    if (!in) throw Fault(file.string() + ": cannot be read: check the file's permissions");
    return out.str();
}

void send(Outbox &out, const Tree &tree)
{
    out.value<std::uint64_t>(tree.branches.size());
    for (const Branch &branch : tree.branches) {
        out.text(branch.name);
        out.value(branch.parent);
        out.value<std::uint64_t>(branch.parent_sphere);
        out.value<std::uint64_t>(branch.spheres.size());
        for (const Sphere &s : branch.spheres)
            out.value(std::array<double, 6>{s.centre_mm.x(), s.centre_mm.y(), s.centre_mm.z(), s.radius_mm,
                                            s.speed_mm_s, s.is_manual ? 1.0 : 0.0});
    }
}

Tree receive(Inbox &in)
{
    Tree tree;
    tree.branches.resize(in.size(branches_max));
    std::uint64_t left = spheres_max;
    for (Branch &branch : tree.branches) {
        branch.name = in.text(256);
        branch.parent = in.value<int>();
        branch.parent_sphere = in.value<std::uint64_t>();
        for (const auto &s : in.list<std::array<double, 6>>(left))
            branch.spheres.push_back({{s[0], s[1], s[2]}, s[3], s[4], s[5] != 0});
        left -= branch.spheres.size();
    }
    return tree;
}

Tree read_tree_apart(const std::filesystem::path &file)
{
    constexpr double growth = 64; // bytes of a parser's node per letter of JSON or XML
    const std::string name = file.string();
    Tree tree;
    try {
        const std::uint64_t bytes = regular_file_bytes(name, file_bytes_max);
        read_apart(
            name, read_limits(bytes, growth),
            [&](Outbox &out) {
                const std::string text = content_of(file);
                send(out, ends_with(file, ".vtp") ? read_polydata(text, name) : read_markups(text, name));
            },
            [&](Inbox &in) { tree = receive(in); });
    } catch (const GuardedReadError &error) {
        throw Fault(error.what());
    }
    check_tree(tree, name);
    return tree;
}

} // namespace

Tree read_tree(const std::filesystem::path &file, bool needs_radii)
{
    const std::string name = file.string();
    // Libraries parse the JSON and XML formats; this project reads the .csv and .obj formats line by line.
    if (ends_with(file, ".json") || ends_with(file, ".vtp")) return read_tree_apart(file);
    if (ends_with(file, ".csv")) return read_csv(content_of(file), name);
    if (ends_with(file, ".obj")) return read_polyline(content_of(file), name, needs_radii);
    refuse_ending(file);
}

void write_tree(const std::filesystem::path &file, const Tree &tree)
{
    check_tree(tree, file.string());
    std::string text;
    if (ends_with(file, ".json"))
        text = markups_text(tree);
    else if (ends_with(file, ".vtp"))
        text = polydata_text(tree);
    else if (ends_with(file, ".csv"))
        text = csv_text(tree);
    else if (ends_with(file, ".obj"))
        text = polyline_text(tree);
    else
        refuse_ending(file);
    write_whole_file(file.string(), text);
}

std::vector<TextLine> lines_of(std::string_view text)
{
    std::vector<TextLine> lines;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line = text.substr(at, end - at);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        lines.push_back({line, lines.size() + 1});
        at = end + 1;
    }
    return lines;
}

std::vector<std::string_view> words_of(std::string_view line)
{
    constexpr std::string_view blanks = " \t\r\n";
    std::vector<std::string_view> words;
    for (std::size_t at = line.find_first_not_of(blanks); at != line.npos;) {
        const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
        words.push_back(line.substr(at, end - at));
        at = line.find_first_not_of(blanks, end);
    }
    return words;
}

double number_of(std::string_view word)
{
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    double value = NAN;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() ? value : NAN;
}

std::string plain_name(const std::string &name)
{
    std::string plain;
    for (char c : name.substr(0, name_bytes_max)) {
        const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                              std::string_view(" _-.()").find(c) != std::string_view::npos;
        plain += is_plain ? c : '_';
    }
    return plain;
}

} // namespace crn::centreline
