// Reads one line of a session script: words, numbers with units, and choices. If the line has a mistake, the
// error message gives the mistake's position and suggests a correction.
#pragma once
#include "host/base/text.hpp"
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

struct Token {
    std::string text;
    int column = 0;
};

struct Unit {
    const char *name;
    double factor;
};

inline const std::vector<Unit> length_units = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}};
inline const std::vector<Unit> speed_units = {{"mm/s", 1e-3}, {"cm/s", 1e-2}, {"m/s", 1.0}};
inline const std::vector<Unit> angle_units = {{"deg", 1.0}, {"°", 1.0}, {"turn", 360.0}, {"turns", 360.0}};
inline const std::vector<Unit> turn_speed_units = {
    {"deg/s", 1.0}, {"°/s", 1.0}, {"turn/s", 360.0}, {"turns/s", 360.0}};
inline const std::vector<Unit> time_units = {{"s", 1.0}, {"ms", 1e-3}, {"min", 60.0}};

// Splits a line into tokens, which are words and numbers. The text "90deg" gives two tokens, commas count as
// spaces, and a '#' ends the line.
std::vector<Token> split_line(std::string_view line);

// Reads one line of a script word by word, and remembers the position of the next word.
class LineParser
{
  public:
    LineParser(const std::string &file, int line, std::vector<Token> tokens)
        : file_(file), line_(line), tokens_(std::move(tokens))
    {
    }

    bool is_at_end() const { return position_ == tokens_.size(); }
    const std::string &peek() const { return is_at_end() ? nothing_ : tokens_[position_].text; }

    [[noreturn]] void fail(const std::string &text) const { throw FileError(file_, line_, column(), text); }

    // Returns the column of the next word, or the column of the line's end if no word is left.
    int column() const
    {
        if (tokens_.empty()) return 1;
        const Token &last = tokens_.back();
        return is_at_end() ? last.column + static_cast<int>(last.text.size()) : tokens_[position_].column;
    }
    int line() const { return line_; }
    void skip() { position_ += is_at_end() ? 0 : 1; }

    std::string found() const { return is_at_end() ? "the line ends" : "found '" + peek() + "'"; }

    bool accept(std::string_view word)
    {
        if (peek() != word) return false;
        position_++;
        return true;
    }

    void expect(std::string_view word)
    {
        if (!accept(word)) fail("expected '" + std::string(word) + "', " + found());
    }

    std::string choice(const std::string &what, const std::vector<std::string> &words)
    {
        for (const std::string &word : words) {
            if (accept(word)) return word;
        }
        fail(is_at_end() ? "expected " + what + ", the line ends"
                         : "unknown " + what + " '" + peek() + "'" + suggestion(peek(), words));
    }

    // Reads the next word up to the next blank or comma, even if it begins with a number.
    std::string name()
    {
        std::string text = peek();
        int end = column() + static_cast<int>(text.size());
        for (skip(); !is_at_end() && column() == end; skip()) {
            text += peek();
            end = column() + static_cast<int>(peek().size());
        }
        return text;
    }

    double number(const std::string &what)
    {
        double value = 0.0;
        const std::string &text = peek();
        const char *begin = text.c_str() + (text.starts_with('+') ? 1 : 0);
        const auto [end, error] = std::from_chars(begin, text.c_str() + text.size(), value);
        if (text.empty() || error != std::errc() || end != text.c_str() + text.size() ||
            !std::isfinite(value)) {
            fail("expected " + what + " (a number), " + found());
        }
        position_++;
        return value;
    }

    // Reads a number with its unit, and returns the number converted to the base unit; the number must lie
    // within low .. high.
    double quantity(const std::string &what, const std::vector<Unit> &units, double low, double high)
    {
        const std::size_t begin = position_;
        const double value = number(what);
        std::vector<std::string> names;
        for (const Unit &unit : units) names.push_back(unit.name);
        const std::string name = choice("unit of " + what, names);
        double result = value;
        for (const Unit &unit : units) {
            if (name == unit.name) result = value * unit.factor;
        }
        if (!(result >= low && result <= high)) {
            position_ = begin;
            fail(what + " is out of range");
        }
        return result;
    }

  private:
    const std::string &file_;
    int line_;
    std::vector<Token> tokens_;
    std::size_t position_ = 0;
    const std::string nothing_;
};

} // namespace crn
