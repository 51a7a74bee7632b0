// Checks a TOML text before it is parsed.
#define TOML_IMPLEMENTATION
#include "host/base/toml.hpp"

namespace crn
{

namespace
{

class Look
{
  public:
    explicit Look(std::string_view text) : text_(text) {}

    void through()
    {
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '"' || c == '\'')
                skip_string(c);
            else if (c == '#')
                skip_to_line_end();
            else
                take(c);
        }
    }

  private:
    void take(char c)
    {
        if (c == '.' && ++dots_ >= toml_key_names_max)
            fail("a key of over " + std::to_string(toml_key_names_max) +
                 " names with dots between them: shorten it");
        if (c == '=' || c == ',' || c == '\n' || c == '[' || c == ']' || c == '{' || c == '}') dots_ = 0;
        if ((c == '[' || c == '{') && ++depth_ > toml_brackets_max)
            fail("over " + std::to_string(toml_brackets_max) +
                 " brackets within each other: no text of ours needs them");
        if ((c == ']' || c == '}') && depth_ > 0) --depth_;
        if (c == '\n') ++line_, line_begin_ = at_ + 1;
        ++at_;
    }

    // A TOML string on one line ends with the quotation mark with which it begins. A TOML string over several
    // lines ends with three quotes, and up to two more quotes before these three belong to the string.
    void skip_string(char quote)
    {
        const std::string three(3, quote);
        const bool is_long = text_.substr(at_, 3) == three;
        at_ += is_long ? 3 : 1;
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '\\' && quote == '"' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n') {
                at_ += 2;
            } else if (is_long && text_.substr(at_, 3) == three) {
                at_ += 3;
                for (int more = 0; more < 2 && at_ < text_.size() && text_[at_] == quote; ++more) ++at_;
                return;
            } else if (!is_long && (c == quote || c == '\n')) {
                at_ += c == quote;
                return;
            } else {
                if (c == '\n') ++line_, line_begin_ = at_ + 1;
                ++at_;
            }
        }
    }

    void skip_to_line_end()
    {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    }

    [[noreturn]] void fail(const std::string &what) const
    {
        throw TomlError(line_, static_cast<int>(at_ - line_begin_) + 1, what);
    }

    std::string_view text_;
    std::size_t at_ = 0, line_begin_ = 0;
    int line_ = 1, dots_ = 0, depth_ = 0;
};

} // namespace

void check_toml(std::string_view text)
{
    if (text.size() > toml_bytes_max)
        throw TomlError(0, 0,
                        "has " + std::to_string(text.size() >> 20) + " MiB, over " +
                            std::to_string(toml_bytes_max >> 20) + ": give a text, not data");
    Look(text).through();
}

toml::table parse_toml(std::string_view text, const std::string &file)
{
    check_toml(text);
    try {
        return toml::parse(text, file);
    } catch (const toml::parse_error &error) {
        throw TomlError(static_cast<int>(error.source().begin.line),
                        static_cast<int>(error.source().begin.column), std::string(error.description()));
    }
}

} // namespace crn
