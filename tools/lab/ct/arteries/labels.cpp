#include "tools/lab/ct/arteries/labels.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "tools/lab/ct/arteries/body.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

std::vector<std::string> fields_of(std::string line)
{
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> fields(1);
    for (const char c : line) {
        if (c == ',' || c == ';' || c == '\t')
            fields.emplace_back();
        else if (c != '"')
            fields.back() += c;
    }
    return fields;
}

std::optional<int> whole(const std::string &text)
{
    int value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
    return value;
}

std::optional<std::size_t> column_of(const std::vector<std::string> &header,
                                     const std::vector<std::string> &names)
{
    for (const std::string &name : names)
        for (std::size_t i = 0; i < header.size(); ++i)
            if (header[i] == name) return i;
    return std::nullopt;
}

std::string text_of_table(const fs::path &file)
{
    std::string text;
    try {
        text = read_text_file(file.string());
    } catch (const FileError &error) {
        throw Fault(std::string(error.what()) + ": give the table of the labels' names");
    }
    if (text.find('\0') != std::string::npos)
        throw Fault(file.string() +
                    ": is no text in UTF-8, or in UTF-16: export the table again as CSV in UTF-8");
    if (text.rfind("\xef\xbb\xbf", 0) == 0) text.erase(0, 3); // spreadsheets write this mark
    return text;
}

void check_same_grid(const Volume &map, const Volume &scan)
{
    const auto last = [](const Volume &of) {
        return of.lps(Eigen::Vector3d(of.size[0] - 1, of.size[1] - 1, of.size[2] - 1));
    };
    const double apart_mm =
        std::max((map.lps({0, 0, 0}) - scan.lps({0, 0, 0})).norm(), (last(map) - last(scan)).norm());
    if (map.size == scan.size && apart_mm <= 0.5) return;
    throw Fault(
        map.name +
        formatted(
            ": the label map has %d x %d x %d voxels, the scan %d x %d x %d, and their corners are %.1f "
            "mm apart: segment this scan itself, and export both with the same grid",
            map.size[0], map.size[1], map.size[2], scan.size[0], scan.size[1], scan.size[2], apart_mm));
}

} // namespace

bool is_artery(const std::string &name)
{
    if (name.find("pulmonary") != std::string::npos) return false;
    return name == "aorta" || name == "brachiocephalic_trunk" || name == "coronary_arteries" ||
           name.find("artery") != std::string::npos;
}

bool may_hold_contrast(const std::string &name)
{
    for (const char *part : {"heart", "atri", "ventricle", "pulmonary", "vein", "vena"})
        if (name.find(part) != std::string::npos) return true;
    return is_artery(name);
}

NamesTable read_names(const fs::path &file)
{
    std::istringstream text(text_of_table(file));
    std::string line;
    NamesTable names;
    std::optional<std::size_t> number_at, name_at;
    for (int row = 1; std::getline(text, line); ++row) {
        std::vector<std::string> fields = fields_of(line);
        if (fields.size() == 1 && line.find(' ') != std::string::npos) { // "52 aorta"
            std::istringstream words(line);
            fields.assign(2, "");
            words >> fields[0] >> fields[1];
        }
        if (fields.size() < 2) continue;
        if (!number_at) {
            number_at = column_of(fields, {"id", "value", "label", "index"});
            name_at = column_of(fields, {"structure", "name"});
            if (number_at && name_at) continue;
            number_at = whole(fields[0]) ? 0 : 1;
            name_at = 1 - *number_at;
        }
        if (std::max(*number_at, *name_at) >= fields.size()) continue;
        const std::optional<int> number = whole(fields[*number_at]);
        const std::string place = file.string() + ": line " + std::to_string(row) + ": ";
        if (!number || *number < 0 || *number > 65535)
            throw Fault(place + "'" + fields[*number_at] +
                        "' is no number of a label, 1 to 65535: mend the line, or give another table");
        if (*number == 0) continue; // the background
        const auto [at, is_new] = names.try_emplace(*number, fields[*name_at]);
        if (!is_new && at->second != fields[*name_at])
            throw Fault(place + "label " + fields[*number_at] +
                        " is there twice, with two names: keep one line");
    }
    if (names.empty())
        throw Fault(file.string() + ": no names: write lines with a number and a name, such as '52,aorta'");
    return names;
}

namespace
{

// Numbers the structures that are present 1, 2, ..., so that every file of labels can hold them.
void renumber(const std::set<int> &present, LabelMap &labels)
{
    std::map<int, int> number_of;
    NamesTable names;
    for (const int number : present) {
        if (number == 0) continue;
        const int next = static_cast<int>(number_of.size()) + 1;
        number_of[number] = next;
        names[next] = labels.names[number];
    }
    for (float &value : labels.volume.hu)
        if (value != 0.0f) value = static_cast<float>(number_of[static_cast<int>(value)]);
    labels.names = std::move(names);
}

} // namespace

LabelMap read_labels(const fs::path &map, const fs::path &table, const Volume &scan)
{
    LabelMap labels{along_patient_axes(read_volume(map)), read_names(table)};
    check_same_grid(labels.volume, scan);
    std::set<int> present;
    for (const float value : labels.volume.hu) {
        if (value != std::round(value))
            throw Fault(map.string() +
                        formatted(": has the value %g, which is no whole number: export the labels, not "
                                  "probabilities or a resampled picture",
                                  static_cast<double>(value)));
        present.insert(static_cast<int>(value));
    }
    bool has_aorta = false;
    for (const int number : present) {
        if (number == 0) continue;
        if (!labels.names.count(number))
            throw Fault(map.string() + ": label " + std::to_string(number) + " has no name in " +
                        table.string() + ": give the table of the program's version that made the map");
        has_aorta = has_aorta || labels.names[number] == "aorta";
    }
    if (!has_aorta)
        throw Fault(map.string() + ": no structure is named 'aorta' in " + table.string() +
                    ": segment the arteries, or give the table with TotalSegmentator's names");
    renumber(present, labels);
    return labels;
}

} // namespace crn::ct
