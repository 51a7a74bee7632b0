#include "host/base/toml_reader.hpp"
#include "host/base/format.hpp"
#include "host/base/toml.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

namespace crn
{

struct TomlDocument {
    struct Source {
        const toml::node *node;
        bool is_used = false;
    };
    std::string file;
    toml::table root;
    std::map<std::string, Source> sources;
};

namespace
{

std::string text_of(NumberRange range, const char *between)
{
    return formatted("%g%s%g", range.low, between, range.high);
}

[[noreturn]] void fail_at(const TomlDocument &document, const toml::node *node, const std::string &where,
                          const std::string &what)
{
    const int line = node ? static_cast<int>(node->source().begin.line) : 0;
    const int column = node ? static_cast<int>(node->source().begin.column) : 0;
    throw FileError(document.file, line, column, (where.empty() ? "" : where + ": ") + what);
}

std::string read_within_limit(const std::string &file, const TomlKind &kind)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw FileError(file, 0, 0, std::string("no such file: give ") + kind.when_none);
    if (std::filesystem::file_size(file, ignored) > toml_bytes_max)
        throw FileError(
            file, 0, 0,
            formatted("over %zu MiB, so hardly %s%s", toml_bytes_max >> 20, kind.what, kind.when_huge));
    return read_text_file(file);
}

} // namespace

std::string in_quotes(const std::string &key)
{
    return "'" + key + "'";
}

TomlTable read_toml(const std::string &file, const TomlKind &kind)
{
    const auto document = std::make_shared<TomlDocument>();
    document->file = file;
    document->root = read_toml_tree(file, kind);
    return {document, &document->root, ""};
}

toml::table read_toml_tree(const std::string &file, const TomlKind &kind)
{
    const std::string text = read_within_limit(file, kind);
    try {
        return parse_toml(text, file);
    } catch (const TomlError &error) {
        throw FileError(file, error.line, error.column, error.what());
    }
}

// --- a value ---

TomlValue::TomlValue(const TomlTable &table, std::string key, const toml::node *node)
    : document_(table.document_), outer_(table.table_), node_(node), where_(table.where_),
      key_(std::move(key))
{
}

bool TomlValue::is_text() const
{
    return node_ && node_->is_string();
}

bool TomlValue::is_truth() const
{
    return node_ && node_->is_boolean();
}

bool TomlValue::is_list() const
{
    return node_ && node_->is_array();
}

bool TomlValue::is_table() const
{
    return node_ && node_->is_table();
}

int TomlValue::line() const
{
    return node_ ? static_cast<int>(node_->source().begin.line) : 0;
}

int TomlValue::column() const
{
    return node_ ? static_cast<int>(node_->source().begin.column) : 0;
}

void TomlValue::fail(const std::string &what) const
{
    fail_at(*document_, node_ ? node_ : outer_, where_, what);
}

void TomlValue::fail_key(const std::string &what) const
{
    fail(in_quotes(key_) + " " + what);
}

void TomlValue::require(const std::string &remedy) const
{
    if (!node_) fail_key("is missing" + remedy);
}

double TomlValue::number() const
{
    require();
    const std::optional<double> value = node_->value<double>();
    if (!value || !std::isfinite(*value)) fail_key("is not a finite number");
    return *value;
}

double TomlValue::number(NumberRange range) const
{
    require(": give a number from " + text_of(range, " to "));
    const std::optional<double> value = node_->value<double>();
    if (!value || !std::isfinite(*value))
        fail_key("is not a finite number: give one from " + text_of(range, " to "));
    if (!range.contains(*value)) fail_key(formatted("= %g is outside ", *value) + text_of(range, " .. "));
    return *value;
}

int TomlValue::whole(NumberRange range) const
{
    const double value = number(range);
    if (value != std::floor(value)) fail_key("is not a whole number");
    return static_cast<int>(value);
}

std::array<double, 3> TomlValue::three(double limit) const
{
    require(": give three numbers, like [1.0, 0.0, 0.0]");
    const toml::array *array = node_->as_array();
    std::array<double, 3> values{};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<double> value =
            array && array->size() == 3 ? array->get(k)->value<double>() : std::nullopt;
        if (!value || !(std::abs(*value) <= limit))
            fail_key(
                formatted("must be three numbers from -%.0f to %.0f, like [1.0, 0.0, 0.0]", limit, limit));
        values[k] = *value;
    }
    return values;
}

bool TomlValue::truth() const
{
    require(": give true or false");
    if (!node_->is_boolean()) fail_key("must be true or false");
    return node_->value<bool>().value();
}

std::string TomlValue::text() const
{
    require();
    const std::optional<std::string> value = node_->value_exact<std::string>();
    if (!value) fail_key("is not a text: put it in quotes");
    return *value;
}

std::string TomlValue::text(std::size_t bytes_max) const
{
    const std::string value = text();
    if (value.size() > bytes_max) fail_key(formatted("is longer than %zu bytes: shorten it", bytes_max));
    for (const unsigned char c : value)
        if (c < 0x20 || c == 0x7f) fail_key("holds a control character: remove it");
    return value;
}

std::string TomlValue::words() const
{
    const std::string value = text();
    if (value.empty()) fail_key("is empty: give a text");
    return value;
}

std::string TomlValue::one_of(const std::vector<std::string> &candidates) const
{
    const std::string value = text();
    if (std::find(candidates.begin(), candidates.end(), value) == candidates.end())
        fail_key("is " + in_quotes(value) + suggestion(value, candidates));
    return value;
}

std::vector<std::string> TomlValue::texts() const
{
    if (is_text()) return {words()};
    require();
    std::vector<std::string> texts;
    if (const toml::array *array = node_->as_array())
        for (const toml::node &node : *array) texts.push_back(node.value_exact<std::string>().value_or(""));
    if (texts.empty() || std::find(texts.begin(), texts.end(), "") != texts.end())
        fail_key("must be a list of names in quotes");
    return texts;
}

std::vector<TomlValue> TomlValue::list() const
{
    require();
    const toml::array *array = node_->as_array();
    if (!array) fail_key("must be a list");
    std::vector<TomlValue> values;
    for (const toml::node &node : *array) {
        values.push_back(*this);
        values.back().node_ = &node;
    }
    return values;
}

TomlTable TomlValue::table() const
{
    require(": add the table [" + key_ + "]");
    const toml::table *inner = node_->as_table();
    if (!inner) fail_key("must be a table: [" + key_ + "]");
    return {document_, inner, where_};
}

std::vector<TomlTable> TomlValue::tables() const
{
    require(": add tables [[" + key_ + "]]");
    if (!is_list()) fail_key("must be written as [[" + key_ + "]]");
    std::vector<TomlTable> tables;
    for (const TomlValue &item : list()) {
        if (!item.is_table()) item.fail_key("must be written as [[" + key_ + "]]");
        tables.push_back(item.table());
    }
    return tables;
}

// --- a table ---

TomlTable::TomlTable(std::shared_ptr<TomlDocument> document, const toml::table *table, std::string where)
    : document_(std::move(document)), table_(table), where_(std::move(where))
{
}

void TomlTable::check_keys(const std::vector<std::string> &known) const
{
    for (const TomlValue &value : values())
        if (std::find(known.begin(), known.end(), value.key()) == known.end())
            value.fail("unknown key " + in_quotes(value.key()) + suggestion(value.key(), known));
}

void TomlTable::check_format(int wanted) const
{
    const TomlValue format = (*this)["format"];
    format.require(formatted(": this program reads format = %d", wanted));
    if (format.node_->value<std::int64_t>() != wanted)
        format.fail_key(formatted("must be %d; this file is of another version", wanted));
}

bool TomlTable::has(const std::string &key) const
{
    return table_->contains(key);
}

TomlValue TomlTable::operator[](const std::string &key) const
{
    return {*this, key, table_->get(key)};
}

std::vector<TomlValue> TomlTable::values() const
{
    std::vector<TomlValue> values;
    for (const auto &[key, node] : *table_) values.push_back({*this, std::string(key.str()), &node});
    return values;
}

double TomlTable::number(const std::string &key, NumberRange range, double standard) const
{
    return has(key) ? number(key, range) : standard;
}

std::string TomlTable::text(const std::string &key, std::size_t bytes_max, const std::string &standard) const
{
    return has(key) ? (*this)[key].text(bytes_max) : standard;
}

TomlTable TomlTable::table(const std::string &key) const
{
    return (*this)[key].table();
}

std::vector<TomlTable> TomlTable::tables(const std::string &key) const
{
    return has(key) ? (*this)[key].tables() : std::vector<TomlTable>{};
}

TomlTable TomlTable::inside(const std::string &more) const
{
    return {document_, table_, where_.empty() ? more : where_ + ", " + more};
}

TomlTable TomlTable::in_place_of(const TomlTable &other) const
{
    return {document_, table_, other.where_};
}

void TomlTable::fail(const std::string &what) const
{
    fail_at(*document_, table_, where_, what);
}

void TomlTable::fail_file(const std::string &what) const
{
    fail_at(*document_, nullptr, "", what);
}

const std::string &TomlTable::file() const
{
    return document_->file;
}

// --- sources ---

void TomlTable::read_sources() const
{
    if (!has("sources")) return;
    for (const TomlValue &value : table("sources").inside("sources").values()) {
        value.words();
        document_->sources.insert({value.key(), {value.node_, false}});
    }
}

void TomlTable::check_sources_used() const
{
    for (const auto &[key, source] : document_->sources)
        if (!source.is_used)
            fail_at(*document_, source.node, where_, "no value names the source " + in_quotes(key));
}

void TomlTable::check_source() const
{
    const TomlValue value = (*this)["source"];
    const std::string text = value.words();
    if (text[0] != '@') return;
    const std::string key = text.substr(1, text.find(':') - 1);
    const auto found = document_->sources.find(key);
    if (found != document_->sources.end()) {
        found->second.is_used = true;
        return;
    }
    std::vector<std::string> known;
    for (const auto &[name, source] : document_->sources) known.push_back(name);
    value.fail("there is no " + in_quotes(key) + " in [sources]" + suggestion(key, known));
}

std::string TomlTable::source_text() const
{
    check_source();
    const std::string text = words("source");
    if (text[0] != '@') return text;
    const std::size_t colon = text.find(':');
    const std::string key = text.substr(1, colon - 1);
    const std::string of_key = document_->sources.at(key).node->value_exact<std::string>().value_or("");
    return of_key + (colon == std::string::npos ? "" : text.substr(colon));
}

TomlRange TomlTable::sourced_range(const std::string &key, NumberRange range) const
{
    const TomlValue value = (*this)[key];
    value.require();
    if (!value.is_table())
        value.fail_key(
            "must be { value = ..., source = \"...\" } or { from = ..., to = ..., source = \"...\" }");
    const TomlTable inner = value.table().inside(in_quotes(key));
    inner.check_keys({"value", "from", "to", "source"});
    inner.check_source();
    if (inner.has("value") && (inner.has("from") || inner.has("to")))
        value.fail_key("has both 'value' and 'from'/'to'");
    const auto number = [&](const char *part) {
        const double given = inner[part].number();
        if (!range.contains(given))
            value.fail_key(formatted("= %g is outside ", given) + text_of(range, " .. "));
        return given;
    };
    if (!inner.has("value")) return {number("from"), number("to")};
    const double constant = number("value");
    return {constant, constant};
}

double TomlTable::sourced(const std::string &key, NumberRange range) const
{
    const TomlRange values = sourced_range(key, range);
    if (!values.is_constant()) (*this)[key].fail_key("must be one value");
    return values.from;
}

} // namespace crn
