#include "host/live/trainee_records.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/base/user_folders.hpp"
#include "host/base/version.hpp"
#include "host/records/identity.hpp"
#include "host/records/outbox.hpp"
#include <algorithm>
#include <filesystem>
#include <set>

namespace crn
{
namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path trainee_file()
{
    return state_folder() / "trainee";
}

double number_at(const Json &report, const char *pointer)
{
    const Json::json_pointer at(pointer);
    return report.contains(at) && report[at].is_number() ? report[at].get<double>() : 0.0;
}

void add_metrics(const Json &report, SessionRecord &record)
{
    std::set<std::string> names;
    const auto add = [&](const std::string &name, const Json &value, const std::string &unit) {
        if (value.is_number() && names.insert(name).second)
            record.metrics.push_back({name, value.get<double>(), unit});
    };
    for (const Json &metric : report["assessment"]["metrics"])
        add(metric.value("name", ""), metric["value"], metric.value("unit", ""));
    add("assessment_percent", report["assessment"]["score"]["percent"], "%");
    for (const Json &limit : report["case"]["limits"])
        add("case_" + limit.value("measure", ""), limit["value"], limit.value("unit", ""));
    std::size_t tool = 0;
    for (const Json &one : report["assessment"]["tools"]) {
        const std::string before = "tool" + std::to_string(++tool) + "_";
        add(before + "hand_path_mm", one["hand_path_mm"], "mm");
        add(before + "tip_path_mm", one["tip_path_mm"], "mm");
        add(before + "submovements", one["submovements"], "");
        add(before + "sparc", one["sparc"], "");
    }
}

void add_events(const Json &assessment, SessionRecord &record)
{
    for (const Json &error : assessment["errors"])
        record.events.push_back({error["tick"].get<std::uint64_t>(), error.value("kind", ""),
                                 error.value("weight", 3), error.value("title", "")});
    for (const Json &phase : assessment["phases"])
        if (phase["begin_tick"].is_number())
            record.events.push_back({phase["begin_tick"].get<std::uint64_t>(),
                                     "phase_" + phase.value("name", ""), 0, phase.value("title", "")});
    std::stable_sort(record.events.begin(), record.events.end(),
                     [](const SessionEvent &a, const SessionEvent &b) { return a.tick < b.tick; });
}

// Gives the recording a second name (a hard link) in the data folder. If the second name cannot be made,
// returns the first name.
std::string second_name(const std::string &recording)
{
    const fs::path folder = data_folder() / "recordings", file = folder / fs::path(recording).filename();
    std::error_code failure;
    fs::create_directories(folder, failure);
    fs::create_hard_link(recording, file, failure);
    if (failure) fs::copy_file(recording, file, failure); // another disk
    return failure ? recording : file.string();
}

std::set<std::string> members_like(RecordStore &store, const std::string &trainee)
{
    std::set<std::string> members;
    const std::string cohort = store.trainee(trainee).cohort;
    for (const TraineeLine &line : store.trainees())
        if (!line.trainee.is_expert && (cohort.empty() || line.trainee.cohort == cohort))
            members.insert(line.trainee.pseudonym);
    return members;
}

} // namespace

std::string remembered_trainee()
{
    try {
        std::error_code failure;
        if (!fs::is_regular_file(trainee_file(), failure)) return "";
        std::string name = read_text_file(trainee_file().string());
        while (!name.empty() && name.back() == '\n') name.pop_back();
        check_pseudonym(name);
        return name;
    } catch (const std::exception &) {
        return ""; // a damaged file only loses the suggestion
    }
}

void remember_trainee(const std::string &trainee)
{
    try {
        std::error_code failure;
        fs::create_directories(state_folder(), failure);
        write_whole_file(trainee_file().string(), trainee + "\n");
    } catch (const std::exception &) {
    }
}

std::map<std::string, double> best_scores(const std::string &trainee)
{
    std::map<std::string, double> best;
    try {
        std::error_code failure;
        if (!fs::exists(own_records_file(), failure)) return best; // looking must not make the file
        RecordStore store = open_store(own_records_file());
        for (const SessionRecord &session :
             store.sessions({trainee.empty() ? guest_name : trainee, "", ""}, false)) {
            if (!session.score || session.score->of <= 0.0) continue;
            const double percent = 100.0 * session.score->total / session.score->of;
            const auto [found, is_new] = best.insert({session.case_id, percent});
            found->second = std::max(found->second, percent);
        }
    } catch (const std::exception &) {
        best.clear();
    }
    return best;
}

SessionRecord record_of(const PlayedCase &played, const RecordedScore &score)
{
    const Json &report = score.report, &marks = report["case"];
    SessionRecord record;
    record.trainee = played.trainee.empty() ? guest_name : played.trainee;
    record.case_id = played.lesson->name;
    record.core_version = score.core_version;
    record.program_version = version_of("cournand");
    record.started_at = played.started_at.empty() ? utc_now() : played.started_at;
    record.duration_s = score.ticks * 1e-3;
    record.recording_path = played.recording;
    record.state_hash = score.state_hash;
    record.passed = marks["is_reached"].get<bool>();
    SessionScore total;
    for (const char *list : {"goals", "limits"}) {
        std::size_t number = 0;
        for (const Json &one : marks[list])
            total.parts.push_back({(*list == 'g' ? "goal " : "limit ") + std::to_string(++number),
                                   one["points"].get<double>(), one["marks"].get<double>()});
    }
    total.total = number_at(marks, "/score");
    record.score = total;
    add_metrics(report, record);
    add_events(report["assessment"], record);
    return record;
}

StoredSession store_session(const PlayedCase &played, const RecordedScore &score)
{
    StoredSession stored;
    SessionRecord record = record_of(played, score);
    stored.trainee = record.trainee;
    try {
        RecordStore store = open_store(own_records_file());
        record.recording_path = second_name(played.recording);
        record.recording_sha256 = sha256_of_file(record.recording_path).value_or("");
        const std::string place = default_records_place();
        stored.id = save_and_ship(store, record, is_server_url(place) ? place : "", stored.note);
        stored.curve = learning_curve(store.sessions({"", record.case_id, ""}), record.trainee, "score",
                                      members_like(store, record.trainee));
    } catch (const std::exception &error) {
        if (stored.id.empty()) {
            stored.trouble = error.what();
            return stored;
        }
        // After the session has been stored, a failure only means that no learning curve is shown.
        stored.note += std::string(stored.note.empty() ? "" : " ") +
                       "The session is stored, but its curve cannot be shown: " + error.what();
    }
    return stored;
}

} // namespace crn
