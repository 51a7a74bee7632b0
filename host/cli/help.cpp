#include "host/cli/help.hpp"
#include "host/cli/table.hpp"
#include <memory>

namespace crn
{

namespace
{

constexpr std::size_t line_letters = 100, column = 30;

// Breaks a text into lines that are indented by `indent` blanks.
std::string wrapped(const std::string &text, std::size_t indent)
{
    std::string lines;
    std::size_t length = indent;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const bool is_first = length == indent;
        if (!is_first && length + 1 + end - at > line_letters) {
            lines += "\n" + std::string(indent, ' ');
            length = indent;
        } else if (!is_first) {
            lines += ' ';
            ++length;
        }
        lines += text.substr(at, end - at);
        length += end - at;
        at = end + 1;
    }
    return lines;
}

std::string row(const std::string &name, const std::string &text)
{
    std::string line = "  " + name;
    if (line.size() + 2 > column)
        line += "\n" + std::string(column, ' ');
    else
        line.resize(column, ' ');
    return line + wrapped(text, column) + "\n";
}

class HelpFormat : public CLI::Formatter
{
  public:
    HelpFormat()
    {
        label("Positionals", "Arguments");
        label("SUBCOMMAND", "COMMAND");
    }
    std::string make_help(const CLI::App *app, std::string name, CLI::AppFormatMode mode) const override
    {
        std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
        for (std::size_t at = text.find("\n\n\n"); at != text.npos; at = text.find("\n\n\n"))
            text.erase(at, 1);
        return text;
    }
    std::string make_option(const CLI::Option *option, bool is_positional) const override
    {
        return row(is_positional ? option->get_name(true) : option_usage(*option),
                   whole_description(*option));
    }
    std::string make_subcommand(const CLI::App *command) const override
    {
        return row(command->get_name(), command->get_description());
    }
    std::string make_description(const CLI::App *app) const override
    {
        return wrapped(CLI::Formatter::make_description(app), 0);
    }
};

void give(CLI::App &app, const std::shared_ptr<HelpFormat> &format)
{
    app.formatter(format);
    for (CLI::App *command : app.get_subcommands({})) {
        if (command->get_group() == "Subcommands") command->group("Commands"); // the library's default
        give(*command, format);
    }
}

} // namespace

void use_help_format(CLI::App &app)
{
    give(app, std::make_shared<HelpFormat>());
}

} // namespace crn
