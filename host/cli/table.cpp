#include "host/cli/table.hpp"
#include <algorithm>

namespace crn
{

namespace
{

constexpr char range_word[] = " in [";

std::vector<const CLI::Option *> options_where(const CLI::App &app, bool (*is_wanted)(const CLI::Option &))
{
    return app.get_options([is_wanted](const CLI::Option *option) {
        return !option->get_group().empty() && is_wanted(*option);
    });
}

// "{a,b}" -> a, b
std::vector<std::string> listed(const std::string &text)
{
    std::vector<std::string> words;
    for (std::size_t at = 1; at < text.size();) {
        const std::size_t end = std::min(text.find_first_of(",}", at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return words;
}

// "FLOAT in [0 - 360]" -> "0 to 360"
std::string range_of(const std::string &text)
{
    const std::size_t begin = text.find(range_word);
    if (begin == text.npos || text.back() != ']') return "";
    std::string range = text.substr(begin + sizeof range_word - 1);
    range.pop_back();
    const std::size_t middle = range.find(" - ");
    return middle == range.npos ? range : range.substr(0, middle) + " to " + range.substr(middle + 3);
}

} // namespace

std::vector<const CLI::App *> commands_of(const CLI::App &app)
{
    return app.get_subcommands([](const CLI::App *command) { return !command->get_group().empty(); });
}

std::vector<const CLI::Option *> shown_options(const CLI::App &app)
{
    return options_where(app, [](const CLI::Option &option) { return option.nonpositional(); });
}

std::vector<const CLI::Option *> arguments_of(const CLI::App &app)
{
    return options_where(app, [](const CLI::Option &option) { return option.get_positional(); });
}

std::string whole_name(const CLI::App &app)
{
    return (app.get_parent() ? whole_name(*app.get_parent()) + " " : "") + app.get_name();
}

ValueText value_text(const CLI::Option &option)
{
    ValueText value;
    if (option.get_items_expected_max() == 0) return value;
    const std::string whole = option.get_type_name();
    const std::size_t colon = std::min(whole.find(':'), whole.size());
    value.type = whole.substr(0, colon);
    for (const char *number : {"INT", "UINT", "FLOAT"})
        if (value.type == number) value.type = "N";
    const std::string rest = colon < whole.size() ? whole.substr(colon + 1) : "";
    value.range = range_of(rest);
    if (!rest.starts_with('{')) return value;
    value.choices = listed(rest);
    value.type.clear();
    for (const std::string &choice : value.choices) value.type += (value.type.empty() ? "" : "|") + choice;
    return value;
}

std::string whole_description(const CLI::Option &option)
{
    const ValueText value = value_text(option);
    std::string more = value.range;
    if (!value.type.empty() && !option.get_default_str().empty())
        more += (more.empty() ? "default " : "; default ") + option.get_default_str();
    if (option.get_required()) more += more.empty() ? "required" : "; required";
    return option.get_description() + (more.empty() ? "" : " (" + more + ")");
}

std::string option_usage(const CLI::Option &option)
{
    const ValueText value = value_text(option);
    if (!option.nonpositional()) {
        const bool is_list = option.get_items_expected_max() >= CLI::detail::expected_max_vector_size;
        return option.get_name(true) + (is_list ? "..." : "");
    }
    std::string usage = option.get_name(false, true);
    if (const std::size_t bang = usage.find('{'); bang != usage.npos && value.type.empty())
        usage.erase(bang); // the value that the flag sets
    return usage + (value.type.empty() ? "" : " " + value.type);
}

} // namespace crn
