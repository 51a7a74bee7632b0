// Tests the command line that all programs share, with a small table of commands. Mistyped words get a
// suggestion, completion offers the words that may follow, and help, man pages and scripts come from the same
// table.
#include "host/base/command_values.hpp"
#include "host/cli/complete.hpp"
#include "host/cli/generate.hpp"
#include "host/cli/help.hpp"
#include "host/cli/table.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <string>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

// Makes a program with two commands, one of which has two subcommands.
struct Program {
    Program()
    {
        app.require_subcommand(1);
        CLI::App *play = app.add_subcommand("play", "Play a tune");
        play->add_option("tune,--tune", tune, "The tune")->type_name("TUNE");
        play->add_option("--speed", speed, "How fast")->capture_default_str()->check(CLI::Range(1, 9));
        play->add_option("--voice", voice, "The voice")
            ->capture_default_str()
            ->check(one_of({"flute", "viola"}));
        play->add_option("-o,--output", output, "The film")->type_name("FILE")->group("Outputs");
        play->add_option("--with", others, "Another tune")->allow_extra_args(false)->type_name("TUNE");
        play->add_flag("--loud", loud, "Loudly");
        play->footer("Examples:\n  tunes play waltz");
        CLI::App *band = app.add_subcommand("band", "The band");
        band->require_subcommand(1);
        band->add_subcommand("list", "Who plays");
        band->add_subcommand("tune", "Make it ready")
            ->add_option("--folder", output, "Where")
            ->type_name("FOLDER");
        use_help_format(app);
    }
    std::string error(std::vector<std::string> words)
    {
        std::reverse(words.begin(), words.end());
        try {
            app.parse(words);
        } catch (const CLI::ParseError &error) {
            const std::string text = unknown_word(app);
            return text.empty() ? error.what() : text;
        }
        return "";
    }
    std::string offers(const std::vector<std::string> &words) const
    {
        const Completion found = completion_of(app, words, [](const std::string &type) {
            return type == "TUNE" ? std::vector<std::string>{"waltz", "march"} : std::vector<std::string>{};
        });
        std::string text;
        for (const Candidate &one : found.candidates) text += one.word + " ";
        return text + (found.paths == PathKind::files     ? ":files"
                       : found.paths == PathKind::folders ? ":folders"
                                                          : ":none");
    }
    std::string tune, voice = "flute", output;
    std::vector<std::string> others;
    int speed = 3;
    bool loud = false;
    CLI::App app{"Plays tunes", "tunes"};
};

void expect_text(const std::string &text, const std::string &wanted)
{
    if (text.find(wanted) == text.npos) fail_msg("'%s' is not in:\n%s", wanted.c_str(), text.c_str());
}

} // namespace

static void a_mistyped_command_has_a_suggestion(void **)
{
    assert_string_equal(Program().error({"plya"}).c_str(),
                        "there is no command 'plya', did you mean 'play'?");
    assert_string_equal(Program().error({"band", "lst"}).c_str(),
                        "there is no command 'lst', did you mean 'list'?");
    assert_string_equal(Program().error({"sing"}).c_str(), "there is no command 'sing'; known: play, band");
}

static void a_mistyped_option_is_named_even_if_its_value_looks_like_an_argument(void **)
{
    assert_string_equal(Program().error({"play", "--tnue", "waltz"}).c_str(),
                        "there is no option '--tnue', did you mean '--tune'?");
    assert_string_equal(Program().error({"play", "--sped=4"}).c_str(),
                        "there is no option '--sped', did you mean '--speed'?");
    assert_string_equal(Program().error({"play", "--colour", "red"}).c_str(),
                        "there is no option '--colour'; tunes play --help lists the options");
}

static void a_word_too_many_is_named(void **)
{
    assert_string_equal(Program().error({"play", "waltz", "march"}).c_str(),
                        "'march' does not belong here; tunes play --help explains the usage");
}

static void a_mistyped_choice_has_a_suggestion(void **)
{
    expect_text(Program().error({"play", "--voice", "vioal"}), "there is no 'vioal', did you mean 'viola'?");
    expect_text(Program().error({"play", "--voice", "drum"}), "there is no 'drum'; known: flute, viola");
}

static void a_right_command_line_is_accepted(void **)
{
    Program program;
    assert_string_equal(
        program.error({"play", "waltz", "--speed", "4", "--with", "a", "--with", "b"}).c_str(), "");
    assert_string_equal(program.tune.c_str(), "waltz");
    assert_int_equal(program.others.size(), 2);
}

static void completion_offers_commands_options_and_names(void **)
{
    const Program program;
    assert_string_equal(program.offers({""}).c_str(), "play band :none");
    assert_string_equal(program.offers({"pl"}).c_str(), "play :none");
    assert_string_equal(program.offers({"band", ""}).c_str(), "list tune :none");
    assert_string_equal(program.offers({"play", ""}).c_str(), "waltz march :files");
    assert_string_equal(program.offers({"play", "--tune", "w"}).c_str(), "waltz :files");
    assert_string_equal(program.offers({"play", "--tune=w"}).c_str(), "--tune=waltz :files");
    assert_string_equal(program.offers({"play", "--voice", ""}).c_str(), "flute viola :none");
    assert_string_equal(program.offers({"play", "--output", "x"}).c_str(), ":files");
    assert_string_equal(program.offers({"band", "tune", "--folder", ""}).c_str(), ":folders");
    assert_string_equal(program.offers({"play", "--speed", ""}).c_str(), ":none");
}

static void completion_leaves_out_what_can_stand_only_once(void **)
{
    const Program program;
    assert_string_equal(program.offers({"play", "--l"}).c_str(), "--loud :none");
    assert_string_equal(program.offers({"play", "--loud", "--l"}).c_str(), ":none");
    assert_string_equal(program.offers({"play", "--with", "waltz", "--w"}).c_str(), "--with :none");
    assert_string_equal(program.offers({"play", "waltz", ""}).c_str(), ":none");
    assert_string_equal(program.offers({"play", "--", "--l"}).c_str(), ":files");
}

static void help_states_ranges_defaults_and_groups(void **)
{
    const std::string help = Program().app.get_subcommand("play")->help();
    expect_text(help, "--speed N");
    expect_text(help, "How fast (1 to 9; default 3)");
    expect_text(help, "--voice flute|viola");
    expect_text(help, "\nOutputs:\n  -o,--output FILE");
    expect_text(help, "tunes play waltz");
    for (std::size_t at = 0; at < help.size();) {
        const std::size_t end = std::min(help.find('\n', at), help.size());
        if (end - at > 100)
            fail_msg("%zu letters in one line: %s", end - at, help.substr(at, end - at).c_str());
        at = end + 1;
    }
}

static void a_man_page_has_every_option_and_no_request_in_a_text(void **)
{
    Program program;
    program.app.get_subcommand("play")->add_option("--dot", program.output, ".so is no request\\n here");
    const std::string page = man_page(*program.app.get_subcommand("play"));
    assert_string_equal(man_file(*program.app.get_subcommand("band")->get_subcommand("tune")).c_str(),
                        "tunes-band-tune.1");
    for (const char *text : {".TH TUNES\\-PLAY 1", ".SH NAME\ntunes\\-play \\- Play a tune", "\\-\\-speed N",
                             ".SS Outputs", ".SH EXAMPLES\n.nf\n  tunes play waltz\n.fi",
                             "\\&.so is no request\\en here", ".SH EXIT STATUS", ".BR tunes (1)"})
        expect_text(page, text);
}

static void every_shell_has_a_script_for_the_program(void **)
{
    for (const char *shell : {"bash", "zsh", "fish"}) {
        const std::string script = completion_script("tunes", shell);
        expect_text(script, "--complete");
        if (script.find("PROGRAM") != script.npos) fail_msg("%s", script.c_str());
    }
    assert_string_equal(completion_script("tunes", "csh").c_str(), "");
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_mistyped_command_has_a_suggestion),
        cmocka_unit_test(a_mistyped_option_is_named_even_if_its_value_looks_like_an_argument),
        cmocka_unit_test(a_word_too_many_is_named),
        cmocka_unit_test(a_mistyped_choice_has_a_suggestion),
        cmocka_unit_test(a_right_command_line_is_accepted),
        cmocka_unit_test(completion_offers_commands_options_and_names),
        cmocka_unit_test(completion_leaves_out_what_can_stand_only_once),
        cmocka_unit_test(help_states_ranges_defaults_and_groups),
        cmocka_unit_test(a_man_page_has_every_option_and_no_request_in_a_text),
        cmocka_unit_test(every_shell_has_a_script_for_the_program),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
