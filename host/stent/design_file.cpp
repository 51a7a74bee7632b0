// Reads stent files (TOML, docs/stent.md).
#include "host/base/toml_reader.hpp"
#include "host/stent/design.hpp"

namespace crn
{

StentDesign read_stent(const std::string &path)
{
    const TomlTable root = read_toml(path, {"a stent", "a stent's file (docs/stent.md)"});
    std::vector<std::string> known = {"format", "name", "description", "sources", "connection", "material"};
    for (const StentNumber &row : stent_numbers()) known.push_back(row.key);
    for (const StentCount &row : stent_counts()) known.push_back(row.key);
    root.check_keys(known);
    root.check_format(1);
    root.read_sources();
    StentDesign stent;
    stent.name = root.words("name");
    stent.description = root.words("description");
    stent.material = root.words("material");
    const std::string connection = root["connection"].one_of({"offset", "facing"});
    stent.connection = connection == "facing" ? StentConnection::facing : StentConnection::offset;
    for (const StentCount &row : stent_counts())
        stent.*row.value = root.whole(row.key, {double(row.low), double(row.high)});
    for (const StentNumber &row : stent_numbers())
        stent.*row.value = root.sourced(row.key, {row.low, row.high}) / row.per_file;
    if (const StentFault fault = stent_fault(stent); !fault.key.empty()) root[fault.key].fail(fault.text);
    root.check_sources_used();
    return stent;
}

} // namespace crn
