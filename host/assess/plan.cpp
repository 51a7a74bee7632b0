#include "host/assess/plan.hpp"
#include <algorithm>
#include <stdexcept>

namespace crn
{

namespace
{

constexpr int plan_format = 1;
constexpr std::size_t title_bytes_max = 120, text_bytes_max = 600;
const std::vector<std::string> severities = {"moderate", "serious", "life-threatening"};

Condition read_condition(const TomlTable &table, const std::string &key)
{
    const TomlValue value = table[key];
    const std::string text = value.text(text_bytes_max);
    return Condition::parse(text, table.file(), value.line(), value.column() + 1);
}

PlanPhase read_phase(const TomlTable &outer)
{
    PlanPhase phase;
    phase.name = outer.words("name");
    const TomlTable table = outer.inside("phase '" + phase.name + "'");
    table.check_keys({"name", "title", "begin", "end", "weight", "step"});
    phase.title = table.text("title", title_bytes_max, phase.name);
    if (table.has("begin")) phase.begin = read_condition(table, "begin");
    phase.end = read_condition(table, "end");
    phase.weight = table.number("weight", {0.0, 100.0}, 1.0);
    for (const TomlTable &one : table.tables("step")) {
        one.check_keys({"title", "done", "weight"});
        phase.steps.push_back(
            {one.words("title"), read_condition(one, "done"), one.number("weight", {0.0, 100.0}, 1.0)});
    }
    return phase;
}

PlanError read_error(const TomlTable &outer)
{
    PlanError error;
    error.name = outer.words("name");
    const TomlTable table = outer.inside("error '" + error.name + "'");
    table.check_keys(
        {"name", "title", "advice", "when", "severity", "for_s", "again_s", "at_most", "source"});
    error.title = table.text("title", title_bytes_max, error.name);
    error.advice = table.text("advice", text_bytes_max, "");
    error.when = read_condition(table, "when");
    const std::string severity = table["severity"].one_of(severities);
    error.severity = severity == severities[0]   ? Severity::moderate
                     : severity == severities[1] ? Severity::serious
                                                 : Severity::life_threatening;
    error.for_s = table.number("for_s", {0.0, 3600.0}, 0.0);
    error.again_s = table.number("again_s", {0.0, 3600.0}, 2.0);
    if (table.has("at_most")) error.at_most = table.whole("at_most", {1.0, 100.0});
    error.source = table.source_text();
    return error;
}

void read_score(const TomlTable &table, PlanScore &score)
{
    table.check_keys(
        {"errors", "phases", "result", "burden", "error_marks", "life_threatening_cap_pct", "source"});
    const NumberRange weight{0.0, 1000.0};
    score.errors = table.number("errors", weight, score.errors);
    score.phases = table.number("phases", weight, score.phases);
    score.result = table.number("result", weight, score.result);
    score.burden = table.number("burden", weight, score.burden);
    if (!(score.errors + score.phases + score.result + score.burden > 0.0))
        table.fail("all parts of the score weigh 0: give one a weight");
    score.error_marks = table.number("error_marks", {1.0, 1000.0}, score.error_marks);
    if (table.has("life_threatening_cap_pct"))
        score.life_threatening_cap_pct = table.number("life_threatening_cap_pct", {0.0, 100.0});
    table.check_source();
}

void read_limit(const TomlTable &outer, ScoreLimits &limits)
{
    const std::string name = outer["name"].one_of(score_metric_names());
    const TomlTable table = outer.inside("metric '" + name + "'");
    table.check_keys({"name", "all", "none", "weight", "source"});
    ScoreLimit limit;
    limit.full_at = table.number("all", {-1e6, 1e6});
    limit.none_at = table.number("none", {-1e6, 1e6});
    if (limit.full_at == limit.none_at) table.fail("'all' and 'none' are equal: give two limits");
    if (table.has("weight")) limit.weight = table.number("weight", {0.0, 1000.0});
    table.check_source();
    limits[name] = limit;
}

void read_vessels(const TomlTable &table, PlanVessels &vessels)
{
    for (const TomlValue &value : table.values()) {
        if (value.key() == "way") {
            vessels.way = value.texts();
            vessels.line = value.line();
            vessels.file = table.file();
        } else {
            vessels.names[value.key()] = value.words();
        }
    }
}

// Adds an entry, or replaces the entry that has the same name.
template <typename Entry> void put(std::vector<Entry> &entries, Entry entry)
{
    for (Entry &one : entries)
        if (one.name == entry.name) {
            one = std::move(entry);
            return;
        }
    entries.push_back(std::move(entry));
}

template <typename Entry> void check_names(const std::vector<Entry> &entries, const TomlTable &table)
{
    for (std::size_t i = 0; i < entries.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (entries[i].name == entries[j].name)
                table.fail("two entries are named '" + entries[i].name + "': rename one");
}

void add(const TomlTable &table, AssessPlan &plan)
{
    if (table.has("vessels")) read_vessels(table.table("vessels"), plan.vessels);
    if (table.has("score")) read_score(table.table("score"), plan.score);
    std::vector<PlanPhase> phases;
    for (const TomlTable &one : table.tables("phase")) phases.push_back(read_phase(one));
    check_names(phases, table);
    if (!phases.empty()) plan.phases = std::move(phases); // their order matters, so they are not mixed
    std::vector<PlanError> errors;
    for (const TomlTable &one : table.tables("error")) errors.push_back(read_error(one));
    check_names(errors, table);
    for (PlanError &error : errors) put(plan.errors, std::move(error));
    for (const TomlTable &one : table.tables("metric")) read_limit(one, plan.limits);
}

} // namespace

std::string severity_text(Severity severity)
{
    return severities[static_cast<std::size_t>(severity) - static_cast<std::size_t>(Severity::moderate)];
}

namespace
{

AssessPlan read_plan_at(const std::string &path, int depth);

// Reads the plan that this table extends; the plan is empty if the table extends none.
AssessPlan base_of(const TomlTable &table, int depth)
{
    if (!table.has("plan")) return {};
    if (depth > 3) table["plan"].fail("plans build on each other more than three times, or on themselves");
    std::string path;
    try {
        path = named_path(plan_files, table.words("plan"));
    } catch (const FileError &) {
        throw;
    } catch (const std::runtime_error &error) {
        table["plan"].fail(error.what());
    }
    return read_plan_at(path, depth + 1);
}

AssessPlan read_plan_at(const std::string &path, int depth)
{
    const TomlTable root = read_toml(path, {"an assessment plan", "an assessment plan (docs/assessment.md)"});
    root.check_format(plan_format);
    root.check_keys(
        {"format", "name", "title", "plan", "sources", "vessels", "score", "phase", "error", "metric"});
    root.read_sources();
    AssessPlan plan = base_of(root, depth);
    plan.file = path;
    plan.name = root.words("name");
    plan.title = root.text("title", title_bytes_max, plan.name);
    add(root, plan);
    root.check_sources_used();
    if (plan.phases.empty() && plan.errors.empty())
        root.fail_file("the plan has neither phases nor errors: add [[phase]] or [[error]]");
    return plan;
}

} // namespace

AssessPlan read_plan(const std::string &path)
{
    return read_plan_at(path, 0);
}

AssessPlan read_plan(const TomlTable &table)
{
    table.check_keys({"plan", "title", "vessels", "score", "phase", "error", "metric"});
    AssessPlan plan = base_of(table, 0);
    plan.file = table.file();
    if (plan.name.empty()) plan.name = "assessment";
    plan.title = table.text("title", title_bytes_max, plan.title.empty() ? plan.name : plan.title);
    add(table, plan);
    return plan;
}

void set_vessel(AssessPlan &plan, const std::string &word)
{
    const std::size_t at = word.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == word.size())
        throw std::runtime_error("--vessel '" + word + "': write NAME=VESSEL, such as target=LAD");
    plan.vessels.names[word.substr(0, at)] = word.substr(at + 1);
}

AssessPlan standard_plan(bool has_balloon)
{
    return read_plan(example_path(plan_files, has_balloon ? "angioplasty" : "navigation"));
}

} // namespace crn
