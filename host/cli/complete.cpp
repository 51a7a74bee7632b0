#include "host/cli/complete.hpp"
#include "host/base/terminal.hpp"
#include "host/cli/table.hpp"
#include <algorithm>
#include <cstdio>

namespace crn
{

namespace
{

// Follows the complete words of a command line through the table of commands and options.
class Walk
{
  public:
    explicit Walk(const CLI::App &app) : app_(&app) {}

    void take(const std::string &word)
    {
        if (waiting_) {
            waiting_ = nullptr;
        } else if (is_over_ || word.empty() || word.front() != '-') {
            take_argument(word);
        } else if (word == "--") {
            is_over_ = true;
        } else {
            const CLI::Option *option = app_->get_option_no_throw(word.substr(0, word.find('=')));
            if (!option) return;
            used_.push_back(option);
            if (word.find('=') == word.npos && !value_text(*option).type.empty()) waiting_ = option;
        }
    }
    const CLI::App &app() const { return *app_; }
    const CLI::Option *waiting() const { return waiting_; } // its value is the next word
    bool has_ended_options() const { return is_over_; }
    bool may_repeat(const CLI::Option *option) const
    {
        return option->get_items_expected_max() >= CLI::detail::expected_max_vector_size ||
               std::find(used_.begin(), used_.end(), option) == used_.end();
    }
    // Returns the argument to which the next word would belong if that word did not begin with a dash.
    const CLI::Option *next_argument() const
    {
        const std::vector<const CLI::Option *> known = arguments_of(*app_);
        if (known.empty()) return nullptr;
        if (arguments_ < known.size()) return known[arguments_];
        const bool is_list = known.back()->get_items_expected_max() >= CLI::detail::expected_max_vector_size;
        return is_list ? known.back() : nullptr;
    }

  private:
    void take_argument(const std::string &word)
    {
        for (const CLI::App *command : commands_of(*app_))
            if (!is_over_ && command->get_name() == word) {
                app_ = command;
                arguments_ = 0;
                used_.clear();
                return;
            }
        ++arguments_;
    }

    const CLI::App *app_;
    const CLI::Option *waiting_ = nullptr;
    std::vector<const CLI::Option *> used_;
    std::size_t arguments_ = 0;
    bool is_over_ = false;
};

void add_values(Completion &found, const CLI::Option &option, const NamesOfType &names)
{
    const ValueText value = value_text(option);
    for (const std::string &choice : value.choices) found.candidates.push_back({choice, ""});
    if (!value.choices.empty()) return;
    const std::vector<std::string> named = names ? names(value.type) : std::vector<std::string>{};
    for (const std::string &name : named) found.candidates.push_back({name, ""});
    if (value.type == "FOLDER")
        found.paths = PathKind::folders;
    else if (value.type == "FILE" || !named.empty())
        found.paths = PathKind::files;
}

void add_options(Completion &found, const Walk &walk)
{
    for (const CLI::Option *option : shown_options(walk.app())) {
        if (!walk.may_repeat(option)) continue;
        for (const std::string &name : option->get_lnames())
            found.candidates.push_back({"--" + name, option->get_description()});
        for (const std::string &name : option->get_snames())
            found.candidates.push_back({"-" + name, option->get_description()});
    }
}

void keep_beginning(Completion &found, const std::string &begin)
{
    std::erase_if(found.candidates, [&](const Candidate &one) { return !one.word.starts_with(begin); });
}

} // namespace

Completion completion_of(const CLI::App &app, const std::vector<std::string> &words, const NamesOfType &names)
{
    Walk walk(app);
    for (std::size_t i = 0; i + 1 < words.size(); ++i) walk.take(words[i]);
    const std::string last = words.empty() ? "" : words.back();
    Completion found;
    const std::size_t equals = last.find('=');
    if (walk.waiting()) {
        add_values(found, *walk.waiting(), names);
    } else if (last.starts_with("--") && equals != last.npos) {
        const CLI::Option *option = walk.app().get_option_no_throw(last.substr(0, equals));
        if (option) add_values(found, *option, names);
        for (Candidate &one : found.candidates) one.word.insert(0, last, 0, equals + 1);
    } else if (last.starts_with('-') && !walk.has_ended_options()) {
        add_options(found, walk);
    } else {
        for (const CLI::App *command : commands_of(walk.app()))
            found.candidates.push_back({command->get_name(), command->get_description()});
        if (walk.next_argument()) add_values(found, *walk.next_argument(), names);
    }
    keep_beginning(found, last);
    return found;
}

int complete(const CLI::App &app, const std::vector<std::string> &words, const NamesOfType &names)
{
    const Completion found = completion_of(app, {words.begin() + 1, words.end()}, names);
    for (const Candidate &one : found.candidates)
        std::printf("%s\t%s\n", printable(one.word).c_str(), printable(one.text).c_str());
    std::puts(found.paths == PathKind::files     ? ":files"
              : found.paths == PathKind::folders ? ":folders"
                                                 : ":none");
    return 0;
}

} // namespace crn
