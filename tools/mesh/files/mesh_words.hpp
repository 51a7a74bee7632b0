// Splits the text of a mesh file into words and numbers, and counts the lines for error messages.
#pragma once
#include "tools/mesh/fault.hpp"
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace crn::bake
{

inline bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

// Converts a word to a number; the whole word must be a number. The words "nan" and "inf" count as numbers,
// so callers that need finite values must check for them. Returns false if the word is not a number.
inline bool is_number(std::string_view word, double &value)
{
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return !word.empty() && end == word.data() + word.size() &&
           (error == std::errc() || error == std::errc::result_out_of_range);
}

inline bool is_whole(std::string_view word, std::int64_t &value)
{
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return !word.empty() && error == std::errc() && end == word.data() + word.size();
}

inline std::string shown(std::string_view word)
{
    std::string plain = "'";
    for (const char c : word.substr(0, 40)) plain += c >= ' ' && c <= '~' ? c : '?';
    return plain + "'";
}

// Reads a text word by word or line by line.
class Words
{
  public:
    Words(std::string_view text, const std::string &file, std::size_t line = 1)
        : text_(text), file_(file), line_(line)
    {
    }

    // Returns the next word, or an empty word at the end of the text.
    std::string_view word()
    {
        skip_blanks();
        const std::size_t begin = at_;
        while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }
    // Returns the remaining text of the present line, without the end of line; sets `is_line` to false after
    // the last line.
    std::string_view rest_of_line(bool &is_line)
    {
        is_line = at_ < text_.size();
        const std::size_t begin = at_, end = std::min(text_.find('\n', at_), text_.size());
        at_ = std::min(end + 1, text_.size());
        if (end < text_.size()) ++line_;
        std::string_view line = text_.substr(begin, end - begin);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }
    void skip_blanks()
    {
        for (; at_ < text_.size() && is_blank(text_[at_]); ++at_) line_ += text_[at_] == '\n';
    }
    std::size_t at() const { return at_; }
    std::size_t line() const { return line_; }

    [[noreturn]] void fail(const std::string &what) const { fail_at(line_, what); }
    [[noreturn]] void fail_at(std::size_t line, const std::string &what) const
    {
        throw Fault(file_ + ":" + std::to_string(line) + ": cannot be read: " + what);
    }

  private:
    std::string_view text_;
    const std::string &file_;
    std::size_t at_ = 0, line_;
};

} // namespace crn::bake
