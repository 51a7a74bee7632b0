// Carries out `cournand records curve` and `cournand records cohort`.
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/command/cli_records.hpp"
#include "host/records/learning_page.hpp"
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

// Returns the sessions of the case in the order of their begin. If the case is not known, throws a
// RecordsError with a suggestion.
std::vector<SessionRecord> sessions_of_case(RecordStore &store, const std::string &case_id)
{
    std::vector<SessionRecord> sessions = store.sessions({"", case_id, ""});
    if (!sessions.empty()) return sessions;
    std::set<std::string> cases;
    for (const SessionRecord &session : store.sessions({}, false)) cases.insert(session.case_id);
    throw RecordsError(RecordsError::Cause::refused,
                       store.place() + ": there is no session of the case '" + printable(case_id) + "'" +
                           (cases.empty() ? "; there are no sessions yet"
                                          : suggestion(case_id, {cases.begin(), cases.end()})));
}

std::vector<std::string> metrics_of(const RecordsOptions &options, const std::vector<SessionRecord> &sessions)
{
    if (options.metrics.empty()) return {"score", "errors", "duration_s"};
    std::set<std::string> known{"score", "errors", "duration_s"};
    for (const SessionRecord &session : sessions)
        for (const SessionMetric &metric : session.metrics) known.insert(metric.name);
    for (const std::string &metric : options.metrics)
        if (!known.count(metric))
            throw RecordsError(RecordsError::Cause::refused,
                               "no session of this case has the metric '" + printable(metric) + "'" +
                                   suggestion(metric, {known.begin(), known.end()}));
    return options.metrics;
}

// Returns the pseudonyms of the trainees in a group; an empty group means all trainees.
std::set<std::string> members_of(RecordStore &store, const std::string &group)
{
    std::set<std::string> members;
    for (const TraineeLine &line : store.trainees())
        if (!line.trainee.is_expert && (group.empty() || line.trainee.cohort == group))
            members.insert(line.trainee.pseudonym);
    return members;
}

Json json_of_others(const LearningCurve &curve)
{
    Json json = {
        {"metric", curve.metric}, {"unit", curve.unit}, {"expert", Json()}, {"cohort", Json::array()}};
    if (curve.expert)
        json["expert"] = {{"sessions", curve.expert->sessions},
                          {"low", curve.expert->low},
                          {"median", curve.expert->median},
                          {"high", curve.expert->high}};
    for (const CohortStep &step : curve.cohort)
        json["cohort"].push_back({{"session", step.attempt},
                                  {"people", step.people},
                                  {"quartile_low", step.low},
                                  {"median", step.median},
                                  {"quartile_high", step.high}});
    return json;
}

Json json_of_curve(const LearningCurve &curve)
{
    Json json = json_of_others(curve);
    json["sessions"] = Json::array();
    for (const LearningPoint &point : curve.points)
        json["sessions"].push_back(
            {{"session", point.session_id}, {"started_at", point.started_at}, {"value", point.value}});
    json["fit"] = Json();
    if (curve.fit)
        json["fit"] = {{"plateau", curve.fit->plateau},
                       {"gain", curve.fit->gain},
                       {"scale_sessions", curve.fit->scale_sessions},
                       {"value", curve.fit->value},
                       {"low", curve.fit->low},
                       {"high", curve.fit->high}};
    return json;
}

Json json_of_cusum(const Cusum &cusum)
{
    Json json = {{"rate_good", cusum.settings.rate_good},
                 {"rate_bad", cusum.settings.rate_bad},
                 {"success", cusum.success},
                 {"failure", cusum.failure},
                 {"learning_limit", cusum.learning_limit},
                 {"relapse_limit", cusum.relapse_limit},
                 {"learning", cusum.learning},
                 {"relapse", cusum.relapse},
                 {"relapses", cusum.relapses}};
    json["competent_at"] = cusum.competent_at ? Json(*cusum.competent_at + 1) : Json();
    return json;
}

void print_curve(const LearningCurve &curve)
{
    say(stdout, "%s%s\n", curve.metric.c_str(), curve.unit.empty() ? "" : (" (" + curve.unit + ")").c_str());
    say(stdout, "  %7s  %-10s  %10s  %10s  %23s  %10s\n", "session", "date", "value", "fitted", "95 % band",
        "cohort");
    for (std::size_t i = 0; i < curve.points.size(); i++)
        say(stdout, "  %7zu  %-10s  %10s  %10s  %10s .. %9s  %10s\n", i + 1,
            curve.points[i].started_at.substr(0, 10).c_str(), number_text(curve.points[i].value, 4).c_str(),
            curve.fit ? number_text(curve.fit->value[i], 4).c_str() : "-",
            curve.fit ? number_text(curve.fit->low[i], 4).c_str() : "-",
            curve.fit ? number_text(curve.fit->high[i], 4).c_str() : "-",
            i < curve.cohort.size() ? number_text(curve.cohort[i].median, 4).c_str() : "-");
    if (curve.expert)
        say(stdout, "  experts: median %s, %s .. %s, %zu sessions\n",
            number_text(curve.expert->median, 4).c_str(), number_text(curve.expert->low, 4).c_str(),
            number_text(curve.expert->high, 4).c_str(), curve.expert->sessions);
}

void print_cusum(const Cusum &cusum)
{
    if (cusum.learning.empty()) return;
    say(stdout, "CUSUM: %s of %s to be competent", number_text(cusum.learning.back(), 3).c_str(),
        number_text(cusum.learning_limit, 3).c_str());
    if (cusum.competent_at) say(stdout, "; competent since session %zu", *cusum.competent_at + 1);
    for (std::size_t relapse : cusum.relapses) say(stdout, "; relapse at session %zu", relapse + 1);
    say(stdout, "\n");
}

} // namespace

int command_records_curve(RecordStore &store, const RecordsOptions &options)
{
    if (options.rate_good >= options.rate_bad) throw UsageError("--rate-good must be below --rate-bad");
    check_outputs({{"--records", store.is_server() ? "" : store.place()}}, {{"--html", options.html}});
    const Trainee trainee = store.trainee(options.what);
    const std::vector<SessionRecord> sessions = sessions_of_case(store, options.case_id);
    const std::vector<std::string> metrics = metrics_of(options, sessions);
    TraineePage page{options.what, options.case_id, {}, {}, {}, options.pass_score};
    const std::set<std::string> members = members_of(store, trainee.cohort);
    for (const std::string &metric : metrics)
        page.curves.push_back(learning_curve(sessions, options.what, metric, members));
    std::vector<bool> passed;
    for (const SessionRecord &session : sessions) {
        if (session.trainee != options.what) continue;
        page.sessions.push_back(session);
        if (const auto one = is_passed(session, options.pass_score)) passed.push_back(*one);
    }
    if (page.sessions.empty())
        throw RecordsError(RecordsError::Cause::refused,
                           options.what + " has no session of the case '" + options.case_id + "'");
    CusumSettings settings;
    settings.rate_good = options.rate_good;
    settings.rate_bad = options.rate_bad;
    page.cusum = cusum_of(passed, settings);
    if (!options.html.empty()) write_whole_file(options.html, trainee_page(page));
    if (options.json) {
        Json json = {{"trainee", options.what}, {"case", options.case_id}, {"curves", Json::array()}};
        for (const LearningCurve &curve : page.curves) json["curves"].push_back(json_of_curve(curve));
        json["cusum"] = json_of_cusum(page.cusum);
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    for (const LearningCurve &curve : page.curves) print_curve(curve);
    print_cusum(page.cusum);
    if (!options.html.empty()) say(stdout, "written %s\n", options.html.c_str());
    return 0;
}

int command_records_cohort(RecordStore &store, const RecordsOptions &options)
{
    check_outputs({{"--records", store.is_server() ? "" : store.place()}}, {{"--html", options.html}});
    const std::vector<SessionRecord> sessions = sessions_of_case(store, options.case_id);
    const std::vector<std::string> metrics = metrics_of(options, sessions);
    const std::set<std::string> members = members_of(store, options.cohort);
    CohortPage page{options.case_id, options.cohort, 0, 0, {}};
    std::set<std::string> people;
    for (const SessionRecord &session : sessions)
        if (members.count(session.trainee)) people.insert(session.trainee), page.sessions++;
    page.people = people.size();
    if (people.size() < cohort_people_min)
        throw RecordsError(RecordsError::Cause::refused,
                           "only " + std::to_string(people.size()) + " people have played the case '" +
                               options.case_id + "'; a cohort has at least " +
                               std::to_string(cohort_people_min) + ", so that nobody can be recognised");
    for (const std::string &metric : metrics) page.curves.push_back(cohort_curve(sessions, metric, members));
    if (!options.html.empty()) write_whole_file(options.html, cohort_page(page));
    if (options.json) {
        Json json = {{"case", options.case_id},
                     {"group", options.cohort},
                     {"people", page.people},
                     {"sessions", page.sessions},
                     {"curves", Json::array()}};
        for (const LearningCurve &curve : page.curves) json["curves"].push_back(json_of_others(curve));
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    say(stdout, "%zu people, %zu sessions\n", page.people, page.sessions);
    for (const LearningCurve &curve : page.curves) {
        say(stdout, "%s\n  %7s  %6s  %14s  %10s  %14s\n", curve.metric.c_str(), "session", "people",
            "lower quartile", "median", "upper quartile");
        for (const CohortStep &step : curve.cohort)
            say(stdout, "  %7zu  %6zu  %14s  %10s  %14s\n", step.attempt, step.people,
                number_text(step.low, 4).c_str(), number_text(step.median, 4).c_str(),
                number_text(step.high, 4).c_str());
    }
    if (!options.html.empty()) say(stdout, "written %s\n", options.html.c_str());
    return 0;
}

} // namespace crn
