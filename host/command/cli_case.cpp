// cournand case
#include "host/command/cli_case.hpp"
#include "firmware/core/core.h"
#include "host/base/command_values.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/base/user_folders.hpp"
#include "host/cases/check.hpp"
#include "host/cases/programs.hpp"
#include "host/command/cli.hpp"
#include "host/command/cli_assess.hpp"
#include "host/command/names.hpp"
#include "host/command/start.hpp"
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// --- list ---

struct Listed {
    std::vector<Case> cases;
    std::vector<std::string> faults; // of files that cannot be read
};

Listed all_cases()
{
    Listed listed;
    for (const std::string &path : case_paths()) try {
            listed.cases.push_back(read_case(path));
        } catch (const std::runtime_error &error) {
            listed.faults.push_back(error.what());
        }
    std::stable_sort(listed.cases.begin(), listed.cases.end(),
                     [](const Case &a, const Case &b) { return a.order < b.order; });
    return listed;
}

// The key of a recipe depends on the programs that make scenes. If the programs that make scenes are missing,
// no recipe counts as ready.
bool is_ready(const Case &lesson)
{
    try {
        return is_scene_ready(lesson.recipe);
    } catch (const std::runtime_error &) {
        return false;
    }
}

Json entry_of(const Case &lesson)
{
    Json goals = Json::array();
    for (const CaseGoal &goal : lesson.goals) goals.push_back(goal.text);
    return {{"name", lesson.name},
            {"title", lesson.title},
            {"file", lesson.file},
            {"aim", lesson.aim},
            {"story", lesson.story},
            {"goals", goals},
            {"picture", lesson.picture.empty() ? Json() : Json(lesson.picture)},
            {"scene_is_ready", is_ready(lesson)}};
}

int call_play(const Case &lesson, const std::string &script, std::vector<std::string> more);

// Plays the expert's script of every case and makes the case's picture from it.
int make_cards(const Listed &listed, const std::string &folder)
{
    fs::create_directories(folder);
    int code = 0;
    for (const Case &lesson : listed.cases) {
        const std::string file = (fs::path(folder) / (lesson.name + ".png")).string();
        if (call_play(lesson, "expert", {"--size", "256", "--card", file}) >= 2 || is_interrupted()) code = 1;
        std::printf("written               %s\n", printable(file).c_str());
        if (is_interrupted()) break;
    }
    return code;
}

int list_cases(const CaseOptions &options)
{
    const Listed listed = all_cases();
    for (const std::string &fault : listed.faults) say(stderr, "cournand: %s\n", fault.c_str());
    if (!options.cards.empty()) return make_cards(listed, options.cards);
    if (options.as_json) {
        Json list = Json::array();
        for (const Case &lesson : listed.cases) list.push_back(entry_of(lesson));
        std::printf("%s\n", list.dump(2).c_str());
        return listed.faults.empty() ? 0 : 1;
    }
    for (const Case &lesson : listed.cases)
        std::printf("%-20s %-52s %s\n", printable(lesson.name).c_str(), printable(lesson.title).c_str(),
                    is_ready(lesson) ? "ready" : "made when first played");
    if (listed.cases.empty()) std::printf("There is no case; `cournand case new NAME` writes one.\n");
    return listed.faults.empty() ? 0 : 1;
}

// --- play ---

int play_in_window(const Case &lesson, const CaseOptions &options, const RunWindow &run_window)
{
    if (!run_window || !has_display())
        throw UsageError("case play: there is no display for a window: `cournand case play " + lesson.name +
                         " --script expert` plays without one");
    WindowOptions window;
    window.lesson = std::make_shared<const Case>(lesson);
    window.shows_help = false;
    window.record = options.record;
    window.json = options.json;
    window.score = options.score;
    window.pictures.size = options.size;
    return run_window(window);
}

std::string script_path(const Case &lesson, const std::string &script)
{
    if (script == "expert") return lesson.expert;
    if (script == "clumsy") return lesson.clumsy;
    return named_path(session_files, script);
}

int play(const CaseOptions &options, const RunWindow &run_window)
{
    const Case lesson = read_case(named_path(case_files, options.name));
    if (options.script.empty()) return play_in_window(lesson, options, run_window);
    RunOptions run;
    run.session = script_path(lesson, options.script);
    run.record = options.record;
    run.json = options.json;
    run.score = options.score;
    run.pictures.png_path = options.png;
    run.card = options.card;
    run.pictures.mp4_path = options.mp4;
    run.pictures.size = options.size;
    run.quiet = options.quiet;
    run.tools = lesson.offered; // the table; the start names those on the line
    run.stents = lesson.stents;
    run.lesson = &lesson;
    run.scene = prepare_told_scene(lesson.recipe, "case " + lesson.name, options.quiet).scene;
    return command_run(run);
}

// Computes the marks of a recorded session for a case, for example of a session that a user played in the GUI
// window.
int score(const CaseOptions &options)
{
    const Case lesson = read_case(named_path(case_files, options.name));
    ReplayOptions replay;
    replay.recording = options.recording;
    replay.json = options.json;
    replay.lesson = &lesson;
    return command_replay(replay);
}

// Plays a case in a separate process, so that a crash becomes a result like any other. Returns the exit code.
int call_play(const Case &lesson, const std::string &script, std::vector<std::string> more)
{
    std::error_code failure;
    const std::string self = fs::read_symlink("/proc/self/exe", failure).string();
    std::vector<std::string> words = {self, "case", "play", lesson.file, "--quiet", "--script", script};
    words.insert(words.end(), more.begin(), more.end());
    watch_for_interrupt();
    return run_program(words, [] { return !is_interrupted(); }).code;
}

// --- new ---

fs::path own_cases()
{
    if (!data_folder().empty()) return data_folder() / case_files.folder;
    throw UsageError("there is no folder for your cases: set HOME or XDG_DATA_HOME, or give --folder");
}

int make_new(const CaseOptions &options)
{
    const bool is_good =
        !options.name.empty() && std::all_of(options.name.begin(), options.name.end(), [](char c) {
            return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        });
    if (!is_good)
        throw UsageError("case new: the name '" + options.name +
                         "' may have small letters, digits and _ only");
    const fs::path folder = options.folder.empty() ? own_cases() : fs::path(options.folder);
    std::error_code failure;
    fs::create_directories(folder, failure);
    std::vector<NamedText> files = template_scripts(options.name);
    files.insert(files.begin(), {options.name + case_files.ending, case_template(options.name)});
    for (const NamedText &file : files)
        if (fs::exists(folder / file.name, failure))
            throw std::runtime_error((folder / file.name).string() + " exists already: choose another name");
    FileSet set;
    for (const NamedText &file : files) set.add((folder / file.name).string(), file.text);
    set.commit();
    for (const NamedText &file : files)
        std::printf("written               %s\n", printable((folder / file.name).string()).c_str());
    std::printf("Change these files, then: cournand case check %s\n",
                printable(options.folder.empty() ? options.name : (folder / files[0].name).string()).c_str());
    return 0;
}

// --- check ---

struct Played {
    double score = 0.0;
    bool is_reached = false;
    std::string fault; // empty: it was played
};

Played played(const Case &lesson, const std::string &script)
{
    const fs::path file = fs::temp_directory_path() / formatted("cournand_case_%d.json", int{::getpid()});
    Played result;
    const int code = call_play(lesson, script, {"--json", file.string()});
    std::error_code failure;
    if (fs::exists(file, failure)) {
        const Json report = Json::parse(read_text_file(file.string()));
        result.score = report.at("case").at("score").get<double>();
        result.is_reached = report.at("case").at("is_reached").get<bool>();
        fs::remove(file, failure);
    } else {
        result.fault =
            formatted("it ended with exit code %d and without a report: cournand case play %s --script %s",
                      code, lesson.name.c_str(), script.c_str());
    }
    return result;
}

struct Bars {
    Played expert, clumsy;
    std::vector<std::string> faults; // a message for every bar that is not kept
};

Bars play_both(const Case &lesson)
{
    Bars bars{played(lesson, "expert"), played(lesson, "clumsy"), {}};
    const Played &expert = bars.expert, &clumsy = bars.clumsy;
    const auto add = [&](const std::string &script, const std::string &text) {
        bars.faults.push_back(FileError(script, 0, 0, text).what());
    };
    if (!expert.fault.empty()) add(lesson.expert, expert.fault);
    if (!clumsy.fault.empty()) add(lesson.clumsy, clumsy.fault);
    if (expert.fault.empty() && !expert.is_reached)
        add(lesson.expert, "the expert does not reach every goal");
    if (expert.fault.empty() && expert.score < case_expert_least)
        add(lesson.expert, formatted("the expert's score is %.1f, and must be at least %.0f", expert.score,
                                     case_expert_least));
    if (clumsy.fault.empty() && clumsy.score > case_clumsy_most)
        add(lesson.clumsy, formatted("the clumsy script's score is %.1f, and must be at most %.0f",
                                     clumsy.score, case_clumsy_most));
    return bars;
}

// Replaces the table of cases that stands between two marks in docs/cases.md.
void write_table(const std::string &path, const std::string &rows)
{
    const std::string begin = "<!-- table of cases: written by `make docs-cases` -->\n",
                      end = "<!-- end of the table -->\n";
    std::string text = read_text_file(path);
    const std::size_t from = text.find(begin), to = text.find(end);
    if (from == text.npos || to == text.npos || to < from)
        throw FileError(path, 0, 0, "has no table of cases between its two marks");
    text.replace(from + begin.size(), to - from - begin.size(),
                 "| case | aim | expert | clumsy |\n|---|---|---|---|\n" + rows +
                     formatted("\nThe scores were measured with core %d.\n", int{CRN_CORE_VERSION}));
    write_whole_file(path, text);
}

// Reads the plan of the table [assessment], with its conditions, weights, limits and sources.
void check_assessment(const Case &lesson, std::vector<std::string> &faults)
{
    if (!lesson.has_assessment) return;
    try {
        read_case_plan(lesson, false);
    } catch (const std::runtime_error &error) {
        faults.emplace_back(error.what());
    }
}

bool check_one(const std::string &path, bool plays, std::string &rows)
{
    std::vector<std::string> faults = case_faults(path);
    if (faults.empty()) check_assessment(read_case(path), faults);
    std::string said = path + ": good";
    if (faults.empty() && plays) {
        const Case lesson = read_case(path);
        const Bars bars = play_both(lesson);
        faults = bars.faults;
        said = formatted("%-20s expert %5.1f   clumsy %5.1f", lesson.name.c_str(), bars.expert.score,
                         bars.clumsy.score);
        rows += "| `" + lesson.name + "` | " + lesson.aim +
                formatted(" | %.0f | %.0f |\n", bars.expert.score, bars.clumsy.score);
    } else if (!faults.empty()) {
        said.clear();
    }
    if (is_interrupted()) throw std::runtime_error("interrupted");
    for (const std::string &fault : faults) say(stderr, "%s\n", fault.c_str());
    if (!said.empty()) say(stdout, "%s\n", said.c_str());
    std::fflush(stdout);
    return faults.empty();
}

int check(const CaseOptions &options)
{
    std::vector<std::string> paths;
    for (const std::string &name : options.names) paths.push_back(named_path(case_files, name));
    if (options.checks_all)
        for (const Case &lesson : all_cases().cases) paths.push_back(lesson.file);
    if (paths.empty()) throw UsageError("case check: name a case or a file, or give --all");
    if (!options.table.empty() && !options.plays) throw UsageError("case check: --table needs --play");
    bool is_good = !options.checks_all || all_cases().faults.empty();
    if (options.checks_all)
        for (const std::string &fault : all_cases().faults) say(stderr, "%s\n", fault.c_str());
    std::string rows;
    for (const std::string &path : paths) is_good = check_one(path, options.plays, rows) && is_good;
    if (!options.table.empty()) write_table(options.table, rows);
    return is_good ? 0 : 1;
}

// --- the command line ---

CLI::Option *add_name(CLI::App &command, std::string &name)
{
    return command.add_option("case", name, "Name of a case, or its file")->required();
}

void add_play(CLI::App &app, CaseOptions &options)
{
    CLI::App *command = app.add_subcommand("play", "Play a case: by hand in the window, or by a script");
    add_name(*command, options.name);
    command->add_option("--script", options.script,
                        "Without a window: expert, clumsy, or the name or file of a session script");
    command->add_option("--record", options.record, "Write a recording");
    command->add_option("--json", options.json,
                        "Write the figures of the session, with the marks of the case");
    command->add_option("--score", options.score,
                        "Write what the angioplasty is worth, as one HTML page (docs/score.md)");
    command->add_option("--png", options.png, "With a script: write the last picture");
    command->add_option("--card", options.card, "With a script: write the picture of the case's card");
    command->add_option("--mp4", options.mp4, "With a script: write a film");
    command->add_option("--size", options.size, "Pixels along each edge of the X-ray")
        ->capture_default_str()
        ->check(CLI::Range(64, 2048));
    command->add_flag("--quiet", options.quiet, "No progress line");
    command->footer("Examples:\n  cournand case play first_push\n"
                    "  cournand case play first_push --script expert --mp4 out/first_push.mp4");
}

} // namespace

void add_case(CLI::App &app, CaseOptions &options)
{
    CLI::App *command = app.add_subcommand("case", "Exercises with a story, goals and marks (docs/cases.md)");
    command->require_subcommand(1);
    CLI::App *list =
        command->add_subcommand("list", "All cases: your own, and those that come with the program");
    list->add_flag("--json", options.as_json, "As JSON, with story, goals and picture");
    list->add_option("--cards", options.cards,
                     "Instead: play the expert of every case, and write a "
                     "picture of each into this folder");
    list->footer("Examples:\n  cournand case list\n  cournand case list --json");
    add_play(*command, options);
    CLI::App *scored = command->add_subcommand("score", "Give the marks of a case to a recorded session");
    add_name(*scored, options.name);
    scored->add_option("recording", options.recording, "Recording of the window, of play or of run")
        ->required();
    scored->add_option("--json", options.json,
                       "Write the figures of the session, with the marks of the case");
    scored->footer("Examples:\n  cournand case score first_push out/mine.rec");
    CLI::App *made = command->add_subcommand("new", "Write a commented case for you to change");
    add_name(*made, options.name);
    made->add_option("--folder", options.folder, "Where; without: your own folder of cases");
    made->footer("Examples:\n  cournand case new my_case");
    CLI::App *checked = command->add_subcommand("check", "Find every mistake in a case");
    checked->add_option("case", options.names, "Names or files of cases");
    checked->add_flag("--all", options.checks_all, "All cases");
    checked->add_flag(
        "--play", options.plays,
        "Also play both scripts: the expert must get 90 of 100 marks, the clumsy one at most 60");
    checked->add_option("--table", options.table,
                        "With --play: renew the table in a document (docs/cases.md)");
    checked->footer("Examples:\n  cournand case check my_case\n  cournand case check --all");
    command->footer("Examples:\n  cournand case list\n  cournand case play first_push\n"
                    "  cournand case new my_case\n  cournand case check my_case --play");
}

int command_case(const CLI::App &app, const CaseOptions &options, const RunWindow &run_window)
{
    const CLI::App *command = app.get_subcommand("case");
    if (command->got_subcommand("list")) return list_cases(options);
    if (command->got_subcommand("play")) return play(options, run_window);
    if (command->got_subcommand("score")) return score(options);
    if (command->got_subcommand("new")) return make_new(options);
    return check(options);
}

} // namespace crn
