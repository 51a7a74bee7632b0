// Helps to read instrument files: tables with known keys, values with a source, errors with their place in
// the file.
#pragma once
#include "host/base/toml.hpp"

#include <map>
#include <string>
#include <vector>

namespace crn::instrument_file
{

// Holds a value that changes along a section, from its distal to its proximal end.
struct Range {
    double from = 0.0, to = 0.0;
    bool is_constant() const { return from == to; }
};

struct Bounds {
    double low = 0.0, high = 0.0;
};

// Holds the texts of [sources], to which values refer as "@key" or "@key: more".
class Sources
{
  public:
    void add(const std::string &key, const toml::node &node) { entries_[key] = {&node, false}; }
    bool use(const std::string &key); // false: unknown
    std::vector<std::string> keys() const;
    const toml::node *unused(std::string &key) const; // nullptr: all are used

  private:
    struct Entry {
        const toml::node *node = nullptr;
        bool is_used = false;
    };
    std::map<std::string, Entry> entries_;
};

// The place of an error. `where` is empty, or a text like "preset 'physical', section 2 'taper'".
struct Place {
    const std::string &file;
    Sources &sources;
    std::string where;
    Place inside(const std::string &more) const;
};

[[noreturn]] void fail(const Place &place, const toml::node *node, const std::string &text);
std::string number(double value);
std::string in_quotes(const std::string &key);

void check_keys(const Place &place, const toml::table &table, const std::vector<std::string> &known);
const toml::node &require(const Place &place, const toml::table &table, const std::string &key);
const toml::table &require_table(const Place &place, const toml::table &table, const std::string &key);
// Returns the tables of [[key]]; an empty list where the key is missing.
std::vector<const toml::table *> tables_of(const Place &place, const toml::table &table,
                                           const std::string &key);
double to_number(const Place &place, const toml::node &node, const std::string &key);
std::string to_text(const Place &place, const toml::node &node, const std::string &key);
void check_bounds(const Place &place, const toml::node &node, const std::string &key, double value,
                  Bounds bounds);

// Checks the text under `source`: it must not be empty, and if it begins with '@' its name must be in
// [sources].
void check_source(const Place &place, const toml::table &table);

// Reads { value, source } or { from, to, source }.
Range sourced(const Place &place, const toml::node &node, const std::string &key, Bounds bounds);
double sourced_value(const Place &place, const toml::table &table, const std::string &key, Bounds bounds);

} // namespace crn::instrument_file
