#include "host/model/instrument_toml.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace crn::instrument_file
{

bool Sources::use(const std::string &key)
{
    const auto entry = entries_.find(key);
    if (entry == entries_.end()) return false;
    entry->second.is_used = true;
    return true;
}

std::vector<std::string> Sources::keys() const
{
    std::vector<std::string> keys;
    for (const auto &[key, entry] : entries_) keys.push_back(key);
    return keys;
}

const toml::node *Sources::unused(std::string &key) const
{
    for (const auto &[name, entry] : entries_) {
        if (entry.is_used) continue;
        key = name;
        return entry.node;
    }
    return nullptr;
}

Place Place::inside(const std::string &more) const
{
    return {file, sources, where.empty() ? more : where + ", " + more};
}

void fail(const Place &place, const toml::node *node, const std::string &text)
{
    const int line = node ? static_cast<int>(node->source().begin.line) : 0;
    const int column = node ? static_cast<int>(node->source().begin.column) : 0;
    throw FileError(place.file, line, column, (place.where.empty() ? "" : place.where + ": ") + text);
}

std::string number(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

std::string in_quotes(const std::string &key)
{
    return "'" + key + "'";
}

void check_keys(const Place &place, const toml::table &table, const std::vector<std::string> &known)
{
    for (const auto &[key, node] : table) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            fail(place, &node, "unknown key " + in_quotes(name) + suggestion(name, known));
        }
    }
}

const toml::node &require(const Place &place, const toml::table &table, const std::string &key)
{
    const toml::node *node = table.get(key);
    if (!node) fail(place, &table, in_quotes(key) + " is missing");
    return *node;
}

const toml::table &require_table(const Place &place, const toml::table &table, const std::string &key)
{
    const toml::node &node = require(place, table, key);
    const toml::table *inner = node.as_table();
    if (!inner) fail(place, &node, in_quotes(key) + " must be a table: [" + key + "]");
    return *inner;
}

std::vector<const toml::table *> tables_of(const Place &place, const toml::table &table,
                                           const std::string &key)
{
    std::vector<const toml::table *> tables;
    const toml::node *node = table.get(key);
    if (!node) return tables;
    const toml::array *list = node->as_array();
    if (!list) fail(place, node, in_quotes(key) + " must be written as [[" + key + "]]");
    for (const toml::node &item : *list) {
        if (!item.as_table()) fail(place, &item, in_quotes(key) + " must be written as [[" + key + "]]");
        tables.push_back(item.as_table());
    }
    return tables;
}

double to_number(const Place &place, const toml::node &node, const std::string &key)
{
    const std::optional<double> value = node.value<double>();
    if (!value || !std::isfinite(*value)) fail(place, &node, in_quotes(key) + " is not a finite number");
    return *value;
}

std::string to_text(const Place &place, const toml::node &node, const std::string &key)
{
    const std::optional<std::string> value = node.value_exact<std::string>();
    if (!value || value->empty()) fail(place, &node, in_quotes(key) + " is not a text");
    return *value;
}

void check_bounds(const Place &place, const toml::node &node, const std::string &key, double value,
                  Bounds bounds)
{
    if (value < bounds.low || value > bounds.high) {
        fail(place, &node,
             in_quotes(key) + " = " + number(value) + " is outside " + number(bounds.low) + " .. " +
                 number(bounds.high));
    }
}

void check_source(const Place &place, const toml::table &table)
{
    const toml::node &node = require(place, table, "source");
    const std::string text = to_text(place, node, "source");
    if (text[0] != '@') return;
    const std::string key = text.substr(1, text.find(':') - 1);
    if (!place.sources.use(key)) {
        fail(place, &node,
             "there is no " + in_quotes(key) + " in [sources]" + suggestion(key, place.sources.keys()));
    }
}

Range sourced(const Place &place, const toml::node &node, const std::string &key, Bounds bounds)
{
    const toml::table *entry = node.as_table();
    if (!entry) {
        fail(place, &node,
             in_quotes(key) +
                 " must be { value = ..., source = \"...\" } or { from = ..., to = ..., source = \"...\" }");
    }
    const Place inner = place.inside(in_quotes(key));
    check_keys(inner, *entry, {"value", "from", "to", "source"});
    check_source(inner, *entry);
    const bool is_constant = entry->contains("value");
    if (is_constant && (entry->contains("from") || entry->contains("to"))) {
        fail(inner, &node, "has both 'value' and 'from'/'to'");
    }
    Range range;
    range.from = to_number(inner, require(inner, *entry, is_constant ? "value" : "from"), key);
    range.to = is_constant ? range.from : to_number(inner, require(inner, *entry, "to"), key);
    check_bounds(place, node, key, range.from, bounds);
    check_bounds(place, node, key, range.to, bounds);
    return range;
}

double sourced_value(const Place &place, const toml::table &table, const std::string &key, Bounds bounds)
{
    const toml::node &node = require(place, table, key);
    const Range range = sourced(place, node, key, bounds);
    if (!range.is_constant()) fail(place, &node, in_quotes(key) + " must be one value");
    return range.from;
}

} // namespace crn::instrument_file
