#include "host/cases/case.hpp"
#include "host/base/toml_reader.hpp"
#include "host/cases/measures.hpp"
#include <algorithm>
#include <filesystem>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr TomlKind case_kind{"a case", "the name or the file of a case (cournand case list)"};
constexpr std::size_t title_bytes_max = 80, text_bytes_max = 4000, name_bytes_max = 80;
constexpr NumberRange order_range{0, 999}, ages_years{0, 120}, lengths_mm{0, 1600}, marks_range{0, 1000},
    values_range{-1e6, 1e6};

// Returns a text for people. Line ends of the file become spaces, so that the file may break its lines
// anywhere.
std::string story_of(const TomlTable &table, const std::string &key)
{
    std::string text = table.words(key), joined;
    if (text.size() > text_bytes_max) table[key].fail_key("is longer than 4000 bytes");
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool is_paragraph = text[i] == '\n' && i + 1 < text.size() && text[i + 1] == '\n';
        if (is_paragraph) {
            joined += "\n\n";
            ++i;
        } else if (text[i] == '\n') {
            joined += ' ';
        } else {
            joined += text[i];
        }
    }
    joined.erase(joined.find_last_not_of(" \n") + 1);
    return joined;
}

// Returns the path to which a word of a case file refers. The word is the name of a file that comes with the
// program, the name of a user's own file, or a path from the folder of the case file.
std::string path_of(const TomlValue &value, const std::string &word, const ExampleKind &kind,
                    const fs::path &folder)
{
    const std::string file = word.substr(0, word.find_last_of(':')), preset = word.substr(file.size());
    try {
        if (file.find_first_of("/.") == file.npos) return example_path(kind, file) + preset;
    } catch (const std::runtime_error &error) {
        value.fail(error.what());
    }
    std::error_code failure;
    const fs::path path = folder / file;
    if (!fs::is_regular_file(path, failure)) value.fail("there is no file '" + path.string() + "'");
    return path.string() + preset;
}

std::vector<std::string> paths_of(const TomlTable &table, const std::string &key, const ExampleKind &kind,
                                  const fs::path &folder, std::size_t most)
{
    std::vector<std::string> paths;
    if (!table.has(key)) return paths;
    for (const TomlValue &value : table[key].list())
        paths.push_back(path_of(value, value.words(), kind, folder));
    if (paths.size() > most) table[key].fail_key("names more than " + std::to_string(most));
    return paths;
}

CasePatient read_patient(const TomlTable &table)
{
    table.check_keys({"invented", "name", "sex", "age_years", "indication", "history"});
    if (!table["invented"].truth())
        table["invented"].fail_key("must be true: a case never holds the data of a real person");
    CasePatient patient;
    patient.name = table["name"].text(name_bytes_max);
    patient.sex = table["sex"].one_of({"female", "male"});
    patient.age_years = table.whole("age_years", ages_years);
    patient.indication = story_of(table, "indication");
    if (table.has("history")) patient.history = story_of(table, "history");
    return patient;
}

Recipe read_recipe(const TomlTable &table, const fs::path &folder)
{
    table.check_keys({"kind", "vessels", "lesions", "scene"});
    Recipe recipe;
    if (table.has("scene")) {
        recipe.line = table["scene"].line();
        if (table.has("kind") || table.has("vessels") || table.has("lesions"))
            table["scene"].fail_key("is a whole scene: leave out kind, vessels and lesions");
        const ExampleKind scene_files{"scenes", "scene", ".scene"};
        recipe.scene = path_of(table["scene"], table.words("scene"), scene_files, folder);
        return recipe;
    }
    recipe.line = table["kind"].line();
    recipe.kind = table["kind"].one_of(recipe_kinds());
    if (table.has("vessels"))
        recipe.vessels = path_of(table["vessels"], table.words("vessels"), anatomy_files, folder);
    recipe.lesions = paths_of(table, "lesions", lesion_files, folder, 4);
    return recipe;
}

// If a statement in the list has a mistake, the error message names the line of that statement.
std::vector<Statement> read_room(const TomlTable &table, CaseStart &start)
{
    std::string text;
    if (!table.has("room")) return {};
    for (const TomlValue &value : table["room"].list()) {
        const std::string words = value.words();
        start.room_words.push_back(words);
        try {
            const Session one = parse_session(words, table.file());
            if (one.statements.size() != 1 || one.statements[0].room.empty())
                value.fail("'" + words + "' is no statement for the X-ray room (docs/session.md)");
        } catch (const FileError &error) {
            const std::string message = error.what(), at = table.file() + ":";
            if (message.starts_with(at) && !message.starts_with(at + "1:")) throw;
            value.fail(message.starts_with(at) ? message.substr(message.find(": ") + 2) : message);
        }
        text += words + "\n";
    }
    return parse_session(text, table.file()).statements;
}

// Returns the number of the named tool in the list of offered tools; a tool that is offered twice can be
// named twice.
std::uint8_t number_of(const std::string &path, const std::vector<std::string> &offered,
                       const LineNumbers &taken)
{
    for (std::size_t i = 0; i < offered.size(); ++i) {
        const auto number = static_cast<std::uint8_t>(i + 1);
        if (offered[i] == path && std::find(taken.begin(), taken.end(), number) == taken.end()) return number;
    }
    return 0;
}

void read_line(const TomlTable &table, const fs::path &folder, const std::vector<std::string> &offered,
               CaseStart &start)
{
    bool has_tool = false;
    for (const TomlValue &value : table["tools"].list()) {
        const std::string word = value.words();
        const bool is_free = word == free_position;
        start.tools.push_back(is_free ? "" : path_of(value, word, instrument_files, folder));
        start.numbers.push_back(is_free ? 0 : number_of(start.tools.back(), offered, start.numbers));
        if (!is_free && start.numbers.back() == 0)
            value.fail("'" + word + "' at position " + std::to_string(start.tools.size()) +
                       " is not among the offered devices, or is there only once: add it to 'offered'");
        has_tool = has_tool || !is_free;
    }
    if (start.tools.size() > session_tools_max)
        table["tools"].fail_key("names more than " + std::to_string(session_tools_max) + " positions");
    if (!has_tool)
        table["tools"].fail_key("names no tool: one to three, the innermost first, with 'nothing' where a "
                                "position is free");
}

CaseStart read_start(const TomlTable &table, const fs::path &folder, const std::vector<std::string> &offered)
{
    table.check_keys({"tools", "inserted_mm", "room"});
    CaseStart start;
    start.line = table["tools"].line();
    read_line(table, folder, offered, start);
    for (const TomlValue &value : table["inserted_mm"].list())
        start.inserted_um.push_back(static_cast<std::uint32_t>(value.number(lengths_mm) * 1e3 + 0.5));
    if (start.inserted_um.size() != start.tools.size())
        table["inserted_mm"].fail_key("has " + std::to_string(start.inserted_um.size()) + " lengths for " +
                                      std::to_string(start.tools.size()) + " tools");
    for (std::size_t k = 0; k < start.tools.size(); ++k)
        if (start.tools[k].empty() && start.inserted_um[k] != 0)
            table["inserted_mm"].fail_key("has a length for position " + std::to_string(k + 1) +
                                          ", which is free: write 0 there");
    start.room = read_room(table, start);
    return start;
}

Expectation read_expectation(const TomlValue &value)
{
    const std::string words = value.words(), file = "";
    const int line = value.line();
    std::vector<Token> tokens = split_line(words);
    try {
        LineParser parser(file, line, std::move(tokens));
        if (parser.accept("expect")) value.fail_key("is written without the word 'expect'");
        return parse_expectation(parser, {});
    } catch (const FileError &error) { // the parser does not know the column in this file
        const std::string message = error.what();
        const std::string from = ":" + std::to_string(line) + ":";
        if (!message.starts_with(from)) throw;
        value.fail(message.substr(message.find(": ") + 2));
    }
}

CaseGoal read_goal(const TomlTable &table)
{
    table.check_keys({"text", "expect", "when", "marks"});
    CaseGoal goal;
    goal.line = table["expect"].line();
    goal.text = table.words("text");
    goal.expectation = read_expectation(table["expect"]);
    goal.is_once = table.has("when") && table["when"].one_of({"end", "once"}) == "once";
    goal.marks = table.number("marks", marks_range, case_marks_standard);
    using Kind = Expectation::Kind;
    const Kind kind = goal.expectation.kind;
    if (goal.is_once && kind != Kind::tip && kind != Kind::inserted && kind != Kind::turned)
        table["when"].fail(
            "only a goal about a tip, an inserted length or a turn can be reached 'once'; the others "
            "are judged at the end");
    return goal;
}

CaseLimit read_limit(const TomlTable &table)
{
    table.check_keys({"measure", "full_marks_at", "no_marks_at", "marks"});
    CaseLimit limit;
    limit.line = table["measure"].line();
    limit.measure = table["measure"].one_of(measure_names());
    limit.full_at = table.number("full_marks_at", values_range);
    limit.none_at = table.number("no_marks_at", values_range);
    if (limit.full_at == limit.none_at)
        table["no_marks_at"].fail_key("equals 'full_marks_at': between the two the marks fall in proportion");
    limit.marks = table.number("marks", marks_range, case_marks_standard);
    return limit;
}

std::string script_of(const TomlTable &table, const std::string &key, const fs::path &folder)
{
    return path_of(table[key], table.words(key), session_files, folder);
}

void read_texts(const TomlTable &root, Case &lesson)
{
    lesson.title = root["title"].text(title_bytes_max);
    lesson.order = root.has("order") ? root.whole("order", order_range) : lesson.order;
    lesson.aim = story_of(root, "aim");
    lesson.story = story_of(root, "story");
    lesson.teaching = story_of(root, "teaching");
    lesson.hints = root["hints"].texts();
    lesson.patient = read_patient(root.table("patient"));
}

void read_assessed(const TomlTable &root, Case &lesson)
{
    lesson.has_assessment = root.has("assessment");
    if (!lesson.has_assessment || !root.table("assessment").has("vessels")) return;
    for (const TomlValue &value : root.table("assessment").table("vessels").values()) {
        const std::vector<std::string> names =
            value.key() == "way" ? value.texts() : std::vector<std::string>{value.words()};
        for (const std::string &name : names) lesson.assessed_vessels.push_back({name, value.line()});
    }
}

} // namespace

Case read_case(const std::string &path)
{
    const TomlTable root = read_toml(path, case_kind);
    root.check_format(1);
    root.check_keys({"format", "title", "order", "aim", "story", "teaching", "hints", "patient", "anatomy",
                     "devices", "start", "goal", "limit", "scripts", "picture", "assessment"});
    Case lesson;
    lesson.file = path;
    lesson.name = fs::path(path).stem().string();
    const fs::path folder = fs::path(path).parent_path();
    read_texts(root, lesson);
    lesson.recipe = read_recipe(root.table("anatomy"), folder);
    const TomlTable devices = root.table("devices");
    devices.check_keys({"offered", "stents"});
    lesson.offered = paths_of(devices, "offered", instrument_files, folder, case_tools_max);
    lesson.stents = paths_of(devices, "stents", stent_files, folder, 8);
    lesson.start = read_start(root.table("start"), folder, lesson.offered);
    for (const TomlTable &table : root.tables("goal")) lesson.goals.push_back(read_goal(table));
    if (lesson.goals.empty()) root.fail("no [[goal]] states what must be true");
    for (const TomlTable &table : root.tables("limit")) lesson.limits.push_back(read_limit(table));
    const TomlTable scripts = root.table("scripts");
    scripts.check_keys({"expert", "clumsy"});
    lesson.expert = script_of(scripts, "expert", folder);
    lesson.clumsy = script_of(scripts, "clumsy", folder);
    read_assessed(root, lesson);
    std::error_code failure;
    const fs::path picture = folder / (root.has("picture") ? root.words("picture") : lesson.name + ".png");
    if (fs::is_regular_file(picture, failure))
        lesson.picture = picture.string();
    else if (root.has("picture"))
        root["picture"].fail("there is no file '" + picture.string() + "'");
    return lesson;
}

std::vector<std::string> case_paths()
{
    std::vector<std::string> paths, names;
    std::error_code failure;
    for (const fs::path &folder : example_folders(case_files)) {
        std::vector<std::string> here;
        for (const auto &entry : fs::directory_iterator(folder, failure))
            if (entry.path().extension() == case_files.ending) here.push_back(entry.path().string());
        std::sort(here.begin(), here.end());
        for (const std::string &path : here) {
            const std::string name = fs::path(path).stem().string();
            if (std::find(names.begin(), names.end(), name) != names.end()) continue;
            names.push_back(name);
            paths.push_back(path);
        }
    }
    return paths;
}

std::vector<std::string> line_words(const LineNumbers &numbers)
{
    std::vector<std::string> words;
    for (const std::uint8_t number : numbers)
        words.push_back(number == 0 ? std::string(free_position) : std::to_string(int{number}));
    return words;
}

Session case_session(const Case &lesson, const std::string &script)
{
    Session session = read_session(script);
    std::copy(lesson.start.inserted_um.begin(), lesson.start.inserted_um.end(), session.inserted_um);
    session.line_names = line_words(lesson.start.numbers);
    session.statements.insert(session.statements.begin(), lesson.start.room.begin(), lesson.start.room.end());
    return session;
}

} // namespace crn
