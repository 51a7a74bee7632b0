#include "tools/lab/ct/arteries/clicks.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/toml_reader.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr double far_mm = 1e4, cut_least_mm = 0.5, cut_most_mm = 50.0;
constexpr float air_HU = -300;
const std::vector<std::string> kind_words = {"artery", "cut", "bridge", "entry",
                                             "name"}; // in the enum's order

ClickKind kind_of(const std::string &word)
{
    for (std::size_t i = 0; i < kind_words.size(); ++i)
        if (kind_words[i] == word) return static_cast<ClickKind>(i);
    throw Fault("'" + word + "' is no kind of click: write artery, cut, bridge, entry or name");
}

Click click_in(const TomlTable &table)
{
    table.check_keys({"kind", "at_mm", "radius_mm", "branch"});
    Click click;
    click.kind = kind_of(table["kind"].one_of(kind_words));
    click.at_mm = Eigen::Vector3d(table["at_mm"].three(far_mm).data());
    if (table.has("radius_mm")) {
        if (click.kind != ClickKind::cut) table["radius_mm"].fail_key("is only for cuts: leave it out");
        click.radius_mm = table["radius_mm"].number({cut_least_mm, cut_most_mm});
    }
    const bool is_name = click.kind == ClickKind::name;
    if (is_name && !table.has("branch")) table.fail("'branch' is missing: write the name of the branch");
    if (!is_name && table.has("branch")) table["branch"].fail_key("is only for kind = \"name\"");
    if (is_name) {
        click.branch = table["branch"].words();
        if (click.branch != centreline::plain_name(click.branch))
            table["branch"].fail_key("may have up to 63 letters, digits, blanks and _-.()");
    }
    return click;
}

std::string place_text(const Eigen::Vector3d &at_mm)
{
    constexpr int decimals = 3;
    return trimmed_text(at_mm.x(), decimals) + ", " + trimmed_text(at_mm.y(), decimals) + ", " +
           trimmed_text(at_mm.z(), decimals);
}

std::vector<std::string> parts_of(const std::string &text, char mark)
{
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == mark)
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

} // namespace

const char *kind_name(ClickKind kind)
{
    return kind_words[static_cast<std::size_t>(kind)].c_str();
}

bool Click::is_same(const Click &other) const
{
    return clicks_text({*this}) == clicks_text({other});
}

bool has_artery_click(const std::vector<Click> &clicks)
{
    return std::any_of(clicks.begin(), clicks.end(),
                       [](const Click &click) { return click.kind == ClickKind::artery; });
}

std::vector<Click> read_clicks(const std::filesystem::path &file)
{
    std::vector<Click> clicks;
    if (!std::filesystem::exists(file)) return clicks;
    const TomlTable root =
        read_toml(file.string(), {"a text of clicks", "a text of clicks (docs/own_ct.md has one)"});
    root.check_keys({"format", "click"});
    root.check_format(1);
    for (const TomlTable &table : root.tables("click")) {
        const std::string place = "click " + std::to_string(clicks.size() + 1);
        if (clicks.size() == clicks_max)
            table.fail("there are more than " + std::to_string(clicks_max) +
                       " clicks: segment by another program, or leave some out");
        clicks.push_back(click_in(table.inside(place)));
        const TomlValue at = table["at_mm"];
        clicks.back().label = place;
        clicks.back().where = file.string() + formatted(":%d:%d: %s", at.line(), at.column(), place.c_str());
    }
    return clicks;
}

std::string clicks_text(const std::vector<Click> &clicks)
{
    std::string text = "# Clicks on the arteries of a CT (docs/own_ct.md). The axes are those of the scene.\n"
                       "format = 1\n";
    for (const Click &click : clicks) {
        text += std::string("\n[[click]]\nkind = \"") + kind_name(click.kind) + "\"\nat_mm = [" +
                place_text(click.at_mm) + "]\n";
        if (click.radius_mm > 0) text += "radius_mm = " + trimmed_text(click.radius_mm, 3) + "\n";
        if (!click.branch.empty()) text += "branch = \"" + click.branch + "\"\n";
    }
    return text;
}

void write_clicks(const std::filesystem::path &file, const std::vector<Click> &clicks)
{
    write_whole_file(file.string(), clicks_text(clicks));
}

Click click_of(const std::string &option)
{
    const std::string name = "--click " + option + ": ";
    const std::vector<std::string> parts = parts_of(option, ':');
    Click click;
    click.where = "--click " + option;
    try {
        click.kind = kind_of(parts[0]);
    } catch (const Fault &fault) {
        throw Fault(name + fault.what());
    }
    const std::vector<std::string> numbers = parts_of(parts.size() > 1 ? parts[1] : "", ',');
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double value = numbers.size() == 3 ? centreline::number_of(numbers[axis]) : NAN;
        if (!(std::fabs(value) <= far_mm))
            throw Fault(name + "the place must be three numbers in mm, such as artery:12.5,-230,4");
        click.at_mm[static_cast<Eigen::Index>(axis)] = value;
    }
    const bool is_cut = click.kind == ClickKind::cut, is_name = click.kind == ClickKind::name;
    if (parts.size() > (is_cut || is_name ? 3u : 2u))
        throw Fault(name + "there is more text than " + kind_name(click.kind) + " needs");
    if (is_cut && parts.size() == 3) {
        click.radius_mm = centreline::number_of(parts[2]);
        if (!(click.radius_mm >= cut_least_mm && click.radius_mm <= cut_most_mm))
            throw Fault(name + "the radius of a cut is 0.5 to 50 mm");
    }
    if (is_name) {
        click.branch = parts.size() == 3 ? parts[2] : "";
        if (click.branch.empty() || click.branch != centreline::plain_name(click.branch))
            throw Fault(name + "the name of a branch has 1 to 63 letters, digits, blanks and _-.(), such as "
                               "name:12,-230,4:left_renal_artery");
    }
    return click;
}

std::vector<Click> clicks_with(const std::filesystem::path &file, const std::vector<std::string> &options)
{
    std::vector<Click> clicks = read_clicks(file);
    for (const std::string &text : options) {
        Click click = click_of(text);
        click.label = "click " + std::to_string(clicks.size() + 1);
        if (std::none_of(clicks.begin(), clicks.end(), [&](const Click &c) { return c.is_same(click); }))
            clicks.push_back(click);
    }
    return clicks;
}

void check_clicks(const std::vector<Click> &clicks, const Volume &scan)
{
    if (clicks.size() > clicks_max)
        throw Fault("clicks: there are more than " + std::to_string(clicks_max) + ": leave some out");
    for (const Click &click : clicks) {
        const Eigen::Vector3d voxel = scan.voxel(click.at_mm);
        const std::string place = click.where + ": 'at_mm' (" + place_text(click.at_mm) + ") ";
        for (int axis = 0; axis < 3; ++axis)
            if (!(voxel[axis] > -0.5 && voxel[axis] < scan.size[static_cast<std::size_t>(axis)] - 0.5)) {
                const Eigen::Vector3d first = scan.scene({0, scan.size[1] - 1.0, 0}),
                                      last = scan.scene({scan.size[0] - 1.0, 0, scan.size[2] - 1.0});
                throw Fault(place + "is outside the scan, which goes from (" + place_text(first) + ") to (" +
                            place_text(last) + "): click inside it");
            }
        if (scan.value(voxel) < static_cast<double>(air_HU))
            throw Fault(place + formatted("is in air (%.0f HU): click inside the body", scan.value(voxel)));
    }
}

} // namespace crn::ct
