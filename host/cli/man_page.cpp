// Makes man pages from the table of commands and options: see generate.hpp. The pages use the macros of
// man(7), which groff and mandoc both format.
#include "host/base/version.hpp"
#include "host/cli/generate.hpp"
#include "host/cli/table.hpp"
#include <cctype>
#include <set>

namespace crn
{

namespace
{

// Makes a text safe for roff: no backslash or dash keeps its special meaning, and no line is read as a
// request.
std::string roff(const std::string &text)
{
    std::string safe;
    for (const char letter : text) {
        if ((letter == '.' || letter == '\'') && (safe.empty() || safe.back() == '\n')) safe += "\\&";
        if (letter == '\\')
            safe += "\\e";
        else if (letter == '-')
            safe += "\\-";
        else
            safe += letter;
    }
    return safe;
}

std::string dashed(const CLI::App &app)
{
    std::string name = whole_name(app);
    for (char &letter : name)
        if (letter == ' ') letter = '-';
    return name;
}

std::string upper(std::string text)
{
    for (char &letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    return text;
}

std::string entry(const std::string &name, const std::string &text)
{
    return ".TP\n.B " + roff(name) + "\n" + roff(text) + "\n";
}

std::string synopsis(const CLI::App &app)
{
    std::string text = ".B " + roff(whole_name(app)) + "\n[options]";
    for (const CLI::Option *argument : arguments_of(app)) {
        const std::string usage = roff(option_usage(*argument));
        text += argument->get_required() ? " " + usage : " [" + usage + "]";
    }
    if (!commands_of(app).empty()) text += app.get_require_subcommand_min() > 0 ? " command" : " [command]";
    return ".SH SYNOPSIS\n" + text + "\n";
}

std::string commands_part(const CLI::App &app)
{
    std::string text;
    for (const CLI::App *command : commands_of(app))
        text += entry(dashed(*command) + "(1)", command->get_description());
    return text.empty() ? "" : ".SH COMMANDS\n" + text;
}

std::string arguments_part(const CLI::App &app)
{
    std::string text;
    for (const CLI::Option *argument : arguments_of(app))
        text += entry(argument->get_name(true), whole_description(*argument));
    return text.empty() ? "" : ".SH ARGUMENTS\n" + text;
}

std::string options_part(const CLI::App &app)
{
    std::string text;
    for (const std::string &group : app.get_groups()) {
        std::string part;
        for (const CLI::Option *option : shown_options(app))
            if (option->get_group() == group)
                part += entry(option_usage(*option), whole_description(*option));
        if (part.empty()) continue;
        text += (group == "Options" ? "" : ".SS " + roff(group) + "\n") + part;
    }
    return text.empty() ? "" : ".SH OPTIONS\n" + text;
}

// The footer of a help text begins with "Examples:".
std::string examples_part(const CLI::App &app)
{
    const std::string footer = app.get_footer(), title = "Examples:\n";
    if (!footer.starts_with(title)) return "";
    std::string lines = roff(footer.substr(title.size()));
    while (!lines.empty() && lines.back() == '\n') lines.pop_back();
    return ".SH EXAMPLES\n.nf\n" + lines + "\n.fi\n";
}

std::string see_also(const CLI::App &app)
{
    if (!app.get_parent()) return "";
    return ".SH SEE ALSO\n.BR " + roff(dashed(*app.get_parent())) + " (1)\n";
}

} // namespace

std::string man_file(const CLI::App &app)
{
    return dashed(app) + ".1";
}

std::string man_page(const CLI::App &app)
{
    const std::string description = app.get_description();
    return ".TH " + roff(upper(dashed(app))) +
           " 1 " CRN_VERSION_DATE " \"Cournand " CRN_VERSION "\" \"User Commands\"\n.SH NAME\n" +
           roff(dashed(app)) + " \\- " + roff(description) + "\n" + synopsis(app) + commands_part(app) +
           arguments_part(app) + options_part(app) + ".SH EXIT STATUS\n" +
           entry("0", "The command is done.") +
           entry("1", "The command has failed; the message states the cause and the remedy.") +
           entry("2", "The command line is wrong.") +
           entry("3", "The physics of a session left its valid range.") + examples_part(app) + see_also(app);
}

} // namespace crn
