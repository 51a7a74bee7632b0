#include "host/cli/parse.hpp"
#include "host/base/command_values.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/cli/complete.hpp"
#include "host/cli/generate.hpp"
#include "host/cli/help.hpp"
#include "host/cli/table.hpp"
#include <cstdio>
#include <iostream>

namespace crn
{

namespace
{

constexpr int exit_usage = 2;

// Returns the command that the user has chosen, at any depth.
const CLI::App &chosen(const CLI::App &app)
{
    const CLI::App *deepest = &app;
    while (!deepest->get_subcommands().empty()) deepest = deepest->get_subcommands().back();
    return *deepest;
}

std::vector<std::string> command_names(const CLI::App &app)
{
    std::vector<std::string> names;
    for (const CLI::App *command : commands_of(app)) names.push_back(command->get_name());
    return names;
}

std::string unknown_option(const CLI::App &app, const std::string &word)
{
    const std::string name = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const CLI::Option *option : shown_options(app))
        for (const std::string &other : option->get_lnames()) known.push_back("--" + other);
    const std::string likely = suggestion(name, known);
    return "there is no option '" + name + "'" +
           (likely.starts_with(",") ? likely : "; " + whole_name(app) + " --help lists the options");
}

std::string unknown_in(const CLI::App &app)
{
    const std::vector<std::string> words = app.remaining();
    for (const std::string &word : words)
        if (word.size() > 1 && word.front() == '-' && word != "--") return unknown_option(app, word);
    if (words.empty()) return "";
    const std::vector<std::string> known = command_names(app);
    if (known.empty())
        return "'" + words.front() + "' does not belong here; " + whole_name(app) +
               " --help explains the usage";
    return "there is no command '" + words.front() + "'" + suggestion(words.front(), known);
}

std::string explanation(const CLI::App &app, const CLI::ParseError &error)
{
    const std::string unknown = unknown_word(app);
    if (!unknown.empty()) return unknown;
    const CLI::App &command = chosen(app);
    const std::vector<std::string> known = command_names(command);
    if (!known.empty() && error.get_name() == "RequiredError") {
        std::string list;
        for (const std::string &name : known) list += (list.empty() ? "" : ", ") + name;
        return "a subcommand is required: " + list;
    }
    return error.what();
}

// Returns true if the parse error only means that a help text or the version must be printed.
bool is_answer(const CLI::ParseError &error)
{
    return error.get_exit_code() == 0;
}

} // namespace

std::string unknown_word(const CLI::App &app)
{
    for (const CLI::App *command = &app;; command = command->get_subcommands().back()) {
        std::string text = unknown_in(*command);
        if (!text.empty() || command->get_subcommands().empty()) return text;
    }
}

std::optional<int> parse_command_line(CLI::App &app, int argc, char **argv, const NamesOfType &names)
{
    use_help_format(app);
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (!words.empty() && words.front() == "--generate") return generate(app, words);
    if (!words.empty() && words.front() == "--complete") return complete(app, words, names);
    refuse_empty_values(app);
    try {
        app.parse(argc, argv);
        return {};
    } catch (const CLI::ParseError &error) {
        if (is_answer(error)) return app.exit(error);
        const std::string name = whole_name(chosen(app));
        say(stderr, "%s: %s\n", name.c_str(), explanation(app, error).c_str());
        say(stderr, "`%s --help` explains the usage.\n", name.c_str());
        return exit_usage;
    }
}

} // namespace crn
