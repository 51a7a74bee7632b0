#include "host/cases/check.hpp"
#include "host/base/number_text.hpp"
#include "host/base/toml_reader.hpp"
#include "host/model/vessel_map.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/contrast.hpp"
#include "host/patient/stents.hpp"
#include <algorithm>
#include <filesystem>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t story_bytes_min = 60, teaching_bytes_min = 60;
constexpr TomlKind lesion_kind{"a text with lesions", "a file with [[lesion]] tables (docs/lesions.md)"};

// Makes a vessel tree that has only the names of the recipe's vessels, without their shapes. If VesselMap
// will divide the scene's aorta into three vessels, it divides the aorta of this tree, too.
VesselTree tree_of_names(const std::vector<RecipeVessel> &vessels)
{
    VesselTree tree;
    for (const RecipeVessel &vessel : vessels) {
        VesselBranch branch;
        branch.name = vessel.name;
        const bool is_root = tree.branches.empty();
        branch.parent = is_root ? -1 : 0;
        branch.parent_point = vessel.name.find("left subclavian") != std::string::npos ? 2 : 1;
        const double y_m = is_root ? 0.0 : 0.1;
        for (int i = 0; i < 4; ++i) branch.points_m.emplace_back(0.1 * i, y_m * i, 0.0);
        branch.radii_m.assign(4, 0.01);
        tree.branches.push_back(branch);
    }
    return tree;
}

bool is_free(const Instrument &tool)
{
    return tool.table.knots_count == 0;
}

// Returns an empty string if the tool at a position fits into the tool around it. If the tool at a position
// does not fit, returns the reason.
std::string fit_refusal(const std::vector<Instrument> &line, std::size_t position)
{
    const auto outer = std::find_if(line.begin() + static_cast<std::ptrdiff_t>(position) + 1, line.end(),
                                    [](const Instrument &tool) { return !is_free(tool); });
    return outer == line.end() || is_free(line[position]) ? "" : nesting_refusal(line[position], *outer);
}

class Checker
{
  public:
    explicit Checker(const Case &lesson) : lesson_(lesson) {}

    std::vector<std::string> faults()
    {
        texts();
        tools();
        vessels();
        lesions();
        goals();
        script(lesson_.expert);
        script(lesson_.clumsy);
        return faults_;
    }

  private:
    void add(int line, const std::string &text) { add_in(lesson_.file, line, text); }
    void add_in(const std::string &file, int line, const std::string &text)
    {
        faults_.push_back(FileError(file, line, 0, text).what());
    }
    // Keeps the error message about a file that cannot be read.
    template <typename Read> bool can(Read read)
    {
        try {
            read();
            return true;
        } catch (const std::runtime_error &error) {
            faults_.push_back(error.what());
            return false;
        }
    }

    void texts()
    {
        if (lesson_.story.size() < story_bytes_min)
            add(0, "the story is too short: say who comes, why, and what has been done already");
        if (lesson_.teaching.size() < teaching_bytes_min)
            add(0, "the teaching text is too short: say what the case teaches, and why it matters");
        if (lesson_.hints.empty()) add(0, "there is no hint: a trainee who is stuck needs one");
    }

    void tools()
    {
        for (const std::string &path : lesson_.offered) {
            table_.emplace_back();
            can([&] { table_.back() = read_instrument(path); });
            names_.push_back(fs::path(path).stem().string());
        }
        const CaseStart &start = lesson_.start;
        line_ = tools_on(table_, start.numbers);
        for (std::size_t k = 0; k < line_.size(); ++k) {
            const std::string refusal = fit_refusal(line_, k);
            if (!refusal.empty()) add(start.line, refusal + ": choose a wider or a thinner tool");
            if (start.numbers[k] > 0 && start.inserted_um[k] > line_[k].length_m * 1e6)
                add(start.line, "'" + line_[k].name + "' is only " + number_text(line_[k].length_m * 1e3, 4) +
                                    " mm long");
        }
        stents();
    }

    // Every stent of the case must fit one of the offered balloons.
    void stents()
    {
        for (const std::string &path : lesson_.stents)
            can([&] {
                const StentDesign stent = read_stent(path);
                std::string refusal = "none of the offered devices has a balloon";
                for (const Instrument &tool : table_) {
                    if (!balloon_tool({tool})) continue;
                    refusal = mount_refusal(stent, {tool});
                    if (refusal.empty()) return;
                }
                add(lesson_.start.line, "the stent '" + stent.name + "' cannot be used: " + refusal);
            });
    }

    void vessels()
    {
        if (lesson_.recipe.kind.empty()) return; // known when the scene is made
        if (!can([&] { vessels_ = recipe_vessels(lesson_.recipe); })) return;
        map_ = VesselMap(tree_of_names(vessels_));
    }

    // Returns the length of a vessel of the recipe. Each part of a divided aorta gets the length of the whole
    // aorta.
    double length_mm(std::size_t vessel) const { return vessels_[map_.vessels()[vessel].branch].length_mm; }

    void lesions()
    {
        for (const std::string &path : lesson_.recipe.lesions) can([&] { lesions_of(path); });
    }

    void lesions_of(const std::string &path)
    {
        const TomlTable root = read_toml(path, lesion_kind);
        if (root.tables("lesion").empty()) root.fail_file("has no [[lesion]]");
        for (const TomlTable &lesion : root.tables("lesion")) {
            const std::string name = lesion.words("branch");
            const std::optional<std::size_t> vessel = map_.find(name);
            if (map_.is_empty()) return;
            if (!vessel) lesion["branch"].fail("unknown vessel '" + name + "'" + map_.suggestion(name));
            const double at_mm = lesion["at_mm"].number();
            if (at_mm > length_mm(*vessel))
                lesion["at_mm"].fail_key("= " + number_text(at_mm, 4) + " is beyond the vessel's end at " +
                                         number_text(length_mm(*vessel), 4) + " mm");
        }
    }

    void goals()
    {
        for (const CaseGoal &goal : lesson_.goals) {
            const Expectation &expected = goal.expectation;
            using Kind = Expectation::Kind;
            if (expected.tool >= lesson_.start.tools.size())
                add(goal.line, "names the " + tool_name(expected.tool) + ", but the start has only " +
                                   std::to_string(lesson_.start.tools.size()) + " of the tools");
            if (expected.kind == Kind::stenosis && lesson_.recipe.kind != "" &&
                lesson_.recipe.lesions.empty())
                add(goal.line, "asks for a stenosis, but the anatomy has no lesion: name one in 'lesions'");
            if (expected.kind == Kind::apposition && lesson_.stents.empty())
                add(goal.line, "asks for a stent's apposition, but 'stents' names none");
            if (expected.names_vessel()) place(lesson_.file, goal.line, expected);
        }
        for (const NamedVessel &named : lesson_.assessed_vessels)
            vessel(lesson_.file, named.line, named.name);
    }

    void place(const std::string &file, int line, const Expectation &expected)
    {
        vessel(file, line, expected.vessel.text);
        const std::optional<std::size_t> found = map_.find(expected.vessel.text);
        if (found && expected.kind == Expectation::Kind::tip && expected.least > length_mm(*found))
            add_in(file, line,
                   "no tip can be " + number_text(expected.least, 4) + " mm inside " + expected.vessel.text +
                       ", which is " + number_text(length_mm(*found), 4) + " mm long");
    }

    void vessel(const std::string &file, int line, const std::string &name)
    {
        if (!map_.is_empty() && !map_.find(name))
            add_in(file, line, "unknown vessel '" + name + "'" + map_.suggestion(name));
    }

    void script(const std::string &path)
    {
        Session session;
        LineNumbers numbers;
        if (!can([&] {
                session = read_session(path);
                if (session.line_names.empty()) session.line_names = line_words(lesson_.start.numbers);
                numbers = resolve_tools(session, names_);
            }))
            return;
        if (session.tools_named > line_.size())
            add_in(path, session.tools_named_line,
                   "needs " + std::to_string(session.tools_named) + " tools, but the case starts with " +
                       std::to_string(line_.size()));
        if (numbers != lesson_.start.numbers)
            add_in(path, session.line_names_line,
                   "begins with other tools than the case: leave out 'begin with', or state 'tools' of the "
                   "start");
        const Session standard;
        for (std::size_t k = 0; k < line_.size(); ++k)
            if (lesson_.start.numbers[k] > 0 && session.inserted_um[k] != lesson_.start.inserted_um[k] &&
                session.inserted_um[k] != standard.inserted_um[k])
                add_in(path, 1,
                       "begins with other inserted lengths than the case: leave out 'begin', or state "
                       "those of 'inserted_mm'");
        statements(path, session);
    }

    // Checks each statement of the script with the tools that are nested in the vessels at that statement.
    void statements(const std::string &path, const Session &session)
    {
        LineNumbers numbers = lesson_.start.numbers;
        std::vector<Instrument> line = line_;
        std::size_t loads = 0;
        double iodine_mg_per_ml = iodine_default_mg_per_ml;
        for (const Statement &statement : session.statements) {
            if (statement.exchange) line = exchange(path, statement, numbers);
            if (statement.steering) vessel(path, statement.line, statement.steering->vessel.text);
            if (statement.expectation && statement.expectation->names_vessel())
                place(path, statement.line, *statement.expectation);
            if (statement.inflation && !balloon_tool(line))
                add_in(path, statement.line, "inflates a balloon, but no tool on the line has one");
            for (const RoomCommand &command : statement.room) {
                if (command.action == RoomAction::load_stent) load_stent(path, statement.line, line, ++loads);
                if (command.action == RoomAction::contrast_strength) iodine_mg_per_ml = command.values[0];
                if (command.action != RoomAction::inject) continue;
                const std::string refusal = injection_refusal(line, command, iodine_mg_per_ml);
                if (!refusal.empty()) add_in(path, statement.line, refusal);
            }
        }
    }

    // Carries out an exchange of tools, and returns the tools that are nested in the vessels afterwards.
    std::vector<Instrument> exchange(const std::string &path, const Statement &statement,
                                     LineNumbers &numbers)
    {
        const std::size_t position = statement.exchange->position;
        if (position >= numbers.size()) return tools_on(table_, numbers); // told already
        const std::uint8_t number = statement.order->exchange.tool;
        if (number > 0 && std::find(numbers.begin(), numbers.end(), number) != numbers.end())
            add_in(path, statement.line, "'" + names_[number - 1u] + "' is on the line already");
        numbers[position] = number;
        const std::vector<Instrument> line = tools_on(table_, numbers);
        for (std::size_t k = 0; k <= position; ++k) {
            const std::string refusal = fit_refusal(line, k);
            if (!refusal.empty()) add_in(path, statement.line, refusal);
        }
        return line;
    }

    void load_stent(const std::string &path, int at, const std::vector<Instrument> &line, std::size_t loads)
    {
        if (loads > lesson_.stents.size()) return add_in(path, at, "loads more stents than 'stents' names");
        if (!balloon_tool(line)) add_in(path, at, "loads a stent, but no tool on the line has a balloon");
    }

    const Case &lesson_;
    std::vector<Instrument> table_, line_;
    std::vector<std::string> names_; // by which scripts call the tools of the table
    std::vector<RecipeVessel> vessels_;
    VesselMap map_;
    std::vector<std::string> faults_;
};

} // namespace

std::vector<std::string> case_faults(const std::string &path)
{
    try {
        const Case lesson = read_case(path);
        return Checker(lesson).faults();
    } catch (const std::runtime_error &error) {
        return {error.what()};
    }
}

} // namespace crn
