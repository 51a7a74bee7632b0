// Reads stent files (TOML, docs/stent.md).
#include "host/base/text.hpp"
#include "host/model/instrument_toml.hpp"
#include "host/stent/design.hpp"

namespace crn
{

namespace
{

using namespace instrument_file;

const std::vector<std::string> others = {"format",  "name",       "description",
                                         "sources", "connection", "material"};

int count_of(const Place &place, const toml::table &table, const std::string &key, int low, int high)
{
    const toml::node &node = require(place, table, key);
    const std::optional<std::int64_t> value = node.value_exact<std::int64_t>();
    if (!value) fail(place, &node, in_quotes(key) + " is not a whole number");
    check_bounds(place, node, key, static_cast<double>(*value), {double(low), double(high)});
    return static_cast<int>(*value);
}

toml::table parse(const std::string &path)
{
    try {
        return parse_toml(read_text_file(path), path);
    } catch (const TomlError &error) {
        throw FileError(path, error.line, error.column, error.what());
    }
}

void read_sources(const Place &place, const toml::table &root)
{
    for (const auto &[key, node] : require_table(place, root, "sources")) {
        to_text(place, node, std::string(key.str()));
        place.sources.add(std::string(key.str()), node);
    }
}

} // namespace

StentDesign read_stent(const std::string &path)
{
    const toml::table root = parse(path);
    Sources sources;
    const Place place{path, sources, ""};
    std::vector<std::string> known = others;
    for (const StentNumber &row : stent_numbers()) known.push_back(row.key);
    for (const StentCount &row : stent_counts()) known.push_back(row.key);
    check_keys(place, root, known);
    if (count_of(place, root, "format", 1, 1000) != 1)
        fail(place, root.get("format"), "'format' is not 1, the only one that this program reads");
    read_sources(place, root);
    StentDesign stent;
    stent.name = to_text(place, require(place, root, "name"), "name");
    stent.description = to_text(place, require(place, root, "description"), "description");
    stent.material = to_text(place, require(place, root, "material"), "material");
    const toml::node &joined = require(place, root, "connection");
    const std::string connection = to_text(place, joined, "connection");
    if (connection != "offset" && connection != "facing")
        fail(place, &joined, "'connection' is " + in_quotes(connection) + ", neither 'offset' nor 'facing'");
    stent.connection = connection == "facing" ? StentConnection::facing : StentConnection::offset;
    for (const StentCount &row : stent_counts())
        stent.*row.value = count_of(place, root, row.key, row.low, row.high);
    for (const StentNumber &row : stent_numbers())
        stent.*row.value = sourced_value(place, root, row.key, {row.low, row.high}) / row.per_file;
    if (const StentFault fault = stent_fault(stent); !fault.key.empty())
        fail(place, root.get(fault.key), fault.text);
    std::string unused;
    if (const toml::node *node = sources.unused(unused))
        fail(place, node, "nothing names the source " + in_quotes(unused));
    return stent;
}

} // namespace crn
