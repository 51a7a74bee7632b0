// This code reads all TOML files that people write. The reader checks that keys are known, that numbers are
// within bounds, and that texts and lists have the right form. The reader also checks that values have a
// source, such as a publication, where one is required. If a file is refused, a FileError is thrown:
// "FILE:LINE:COLUMN: place: what is wrong".
//
//   const TomlTable root = read_toml(file, {"a case", "a case's folder"});
//   root.check_keys({"name", "depth"});
//   const std::string name = root.words("name");
//   for (const TomlTable &depth : root.tables("depth")) ...
//
// Compiling the header of toml++ takes a second for each source file that includes it, so this header only
// declares the types of toml++.
#pragma once
#include "host/base/number_range.hpp"
#include "host/base/text.hpp"
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace toml
{
inline namespace v3
{
class node;
class table;
} // namespace v3
} // namespace toml

namespace crn
{

// Holds texts for the messages about a file that is absent or too large.
struct TomlKind {
    const char *what;           // "a scene text"
    const char *when_none;      // what to give instead of the absent file
    const char *when_huge = ""; // the end of the sentence about a file over toml_bytes_max
};

struct TomlDocument; // a parsed file, with its name and its sources
class TomlTable;

// Holds the value of a key in a TOML table, or records that the key is absent. If the key is absent, all
// functions throw an error, except those that only state whether a value exists and of what kind it is.
class TomlValue
{
  public:
    explicit operator bool() const { return node_ != nullptr; }
    bool is_text() const;
    bool is_truth() const;
    bool is_list() const;
    bool is_table() const;
    const std::string &key() const { return key_; }
    int line() const;   // 0: absent
    int column() const; // where the value begins; 0: absent

    double number() const; // finite
    double number(NumberRange range) const;
    int whole(NumberRange range) const; // accepts 3 and 3.0
    std::array<double, 3> three(double limit) const;
    bool truth() const;
    std::string text() const;
    std::string text(std::size_t bytes_max) const; // also refuses control characters
    std::string words() const;                     // not empty
    std::string one_of(const std::vector<std::string> &candidates) const;
    std::vector<std::string> texts() const; // a text or a list of texts, none of them empty
    std::vector<TomlValue> list() const;
    TomlTable table() const;
    std::vector<TomlTable> tables() const; // those of [[key]]

    [[noreturn]] void fail(const std::string &what) const;
    [[noreturn]] void fail_key(const std::string &what) const; // "'key' what"

  private:
    friend class TomlTable;
    std::shared_ptr<TomlDocument> document_;
    const toml::node *outer_ = nullptr, *node_ = nullptr;
    std::string where_, key_;

    TomlValue(const TomlTable &table, std::string key, const toml::node *node);
    void require(const std::string &remedy = "") const;
};

// Holds a value that changes along a part of an instrument, given by its values at the beginning and at the
// end of that part.
struct TomlRange {
    double from = 0.0, to = 0.0;
    bool is_constant() const { return from == to; }
};

class TomlTable
{
  public:
    void check_keys(const std::vector<std::string> &known) const;
    void check_format(int wanted) const; // of the key `format`
    bool has(const std::string &key) const;
    TomlValue operator[](const std::string &key) const; // may be absent
    std::vector<TomlValue> values() const;              // by their keys' alphabet

    double number(const std::string &key, NumberRange range) const { return (*this)[key].number(range); }
    double number(const std::string &key, NumberRange range, double standard) const;
    int whole(const std::string &key, NumberRange range) const { return (*this)[key].whole(range); }
    std::string words(const std::string &key) const { return (*this)[key].words(); }
    std::string text(const std::string &key, std::size_t bytes_max, const std::string &standard) const;
    TomlTable table(const std::string &key) const;
    std::vector<TomlTable> tables(const std::string &key) const; // empty where the key is absent

    // Returns this table with a more detailed description of its place in the file, such as "preset
    // 'physical', section 2". Error messages about the table contain the more detailed description of its
    // place.
    TomlTable inside(const std::string &more) const;
    TomlTable in_place_of(const TomlTable &other) const; // takes the text of the other table
    [[noreturn]] void fail(const std::string &what) const;
    [[noreturn]] void fail_file(const std::string &what) const; // without a line
    const std::string &file() const;

    // Reads values with a source, which have the form { value, source } or { from, to, source } in the file.
    // A source "@key" or "@key: more" refers to an entry of the table [sources] in the file's root table. The
    // entry to which a source refers must exist, and every entry of [sources] must be used.
    void read_sources() const;       // of the root
    void check_sources_used() const; // of the root, after everything else
    void check_source() const;       // of the key `source` in this table
    std::string source_text() const; // the checked source, with the text of the entry to which "@key" refers
    TomlRange sourced_range(const std::string &key, NumberRange range) const;
    double sourced(const std::string &key, NumberRange range) const;

  private:
    friend class TomlValue;
    friend TomlTable read_toml(const std::string &file, const TomlKind &kind);
    std::shared_ptr<TomlDocument> document_;
    const toml::table *table_ = nullptr;
    std::string where_;

    TomlTable(std::shared_ptr<TomlDocument> document, const toml::table *table, std::string where);
};

// Returns the root table of the TOML file. Throws FileError.
TomlTable read_toml(const std::string &file, const TomlKind &kind);

std::string in_quotes(const std::string &key);

} // namespace crn
