// Carries out the commands of `cournand records`.
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/command/cli_records.hpp"
#include "host/records/exchange.hpp"
#include "host/records/identity.hpp"
#include "host/records/outbox.hpp"
#include "host/rig/rig.hpp"
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

constexpr std::size_t id_letters = 13; // of a UUIDv7: all of its time

void print_json(const Json &json)
{
    std::printf("%s\n", json.dump(2).c_str());
}

std::string score_text(const SessionRecord &session)
{
    const auto score = session.metric("score");
    return score ? decimals_text(*score, 0) + " %" : "-";
}

void print_sessions(const std::vector<SessionRecord> &sessions)
{
    say(stdout, "%-13s  %-16s  %-16s  %-20s  %7s  %6s  %6s\n", "session", "begun (UTC)", "trainee", "case",
        "time", "score", "errors");
    for (const SessionRecord &session : sessions)
        say(stdout, "%-13s  %-16s  %-16s  %-20s  %7s  %6s  %6.0f\n", session.id.substr(0, id_letters).c_str(),
            (session.started_at.substr(0, 10) + " " + session.started_at.substr(11, 5)).c_str(),
            session.trainee.c_str(), session.case_id.c_str(), clock_text(session.duration_s).c_str(),
            score_text(session).c_str(), session.metric("errors").value_or(0.0));
    say(stdout, "%zu session%s\n", sessions.size(), sessions.size() == 1 ? "" : "s");
}

Json json_of_trainee(const TraineeLine &line)
{
    return {{"trainee", line.trainee.pseudonym},
            {"name", line.name},
            {"group", line.trainee.cohort},
            {"is_expert", line.trainee.is_expert},
            {"keep_until", line.trainee.keep_until},
            {"created_at", line.trainee.created_at},
            {"sessions", line.sessions},
            {"last_at", line.last_at}};
}

void print_trainees(const std::vector<TraineeLine> &lines)
{
    say(stdout, "%-16s  %-20s  %-16s  %8s  %-10s  %s\n", "trainee", "name", "group", "sessions", "last",
        "keep until");
    for (const TraineeLine &line : lines)
        say(stdout, "%-16s  %-20s  %-16s  %8lld  %-10s  %s%s\n", line.trainee.pseudonym.c_str(),
            line.name.empty() ? "-" : line.name.c_str(),
            line.trainee.cohort.empty() ? "-" : line.trainee.cohort.c_str(),
            static_cast<long long>(line.sessions),
            line.last_at.empty() ? "-" : line.last_at.substr(0, 10).c_str(),
            line.trainee.keep_until.empty() ? "-" : line.trainee.keep_until.c_str(),
            line.trainee.is_expert ? "  expert" : "");
}

// A reader of a long list should learn of duties too; the notice does not disturb a program that reads JSON.
void print_expired(RecordStore &store)
{
    const std::vector<Trainee> expired = store.expired(utc_now().substr(0, 10));
    if (!expired.empty())
        say(stderr,
            "%zu trainee%s past the keep-until date: `cournand records erase --expired` erases the data\n",
            expired.size(), expired.size() == 1 ? " is" : "s are");
}

int list(RecordStore &store, const RecordsOptions &options)
{
    if (options.lists_trainees) {
        const std::vector<TraineeLine> lines = store.trainees();
        if (options.json) {
            Json json = Json::array();
            for (const TraineeLine &line : lines) json.push_back(json_of_trainee(line));
            print_json(json);
        } else
            print_trainees(lines);
    } else {
        if (!options.trainee.empty()) store.trainee(options.trainee);
        const std::vector<SessionRecord> sessions = store.sessions({options.trainee, options.case_id, ""});
        if (options.json)
            print_json(json_of(sessions));
        else
            print_sessions(sessions);
    }
    print_expired(store);
    return 0;
}

void print_session(const SessionRecord &session)
{
    say(stdout, "session    %s\ntrainee    %s\ncase       %s %s\nbegun      %s\ntime       %s\n",
        session.id.c_str(), session.trainee.c_str(), session.case_id.c_str(), session.case_version.c_str(),
        session.started_at.c_str(), clock_text(session.duration_s).c_str());
    say(stdout, "program    %s, core %s, seed %llu\nrecording  %s\n", session.program_version.c_str(),
        session.core_version.c_str(), static_cast<unsigned long long>(session.seed),
        session.recording_path.empty() ? "-" : session.recording_path.c_str());
    if (session.passed) say(stdout, "passed     %s\n", *session.passed ? "yes" : "no");
    if (session.score) {
        say(stdout, "score      %s of %s\n", trimmed_text(session.score->total, 2).c_str(),
            trimmed_text(session.score->of, 2).c_str());
        for (const ScorePart &part : session.score->parts)
            say(stdout, "  %-32s %8s of %s\n", part.name.c_str(), trimmed_text(part.points, 2).c_str(),
                trimmed_text(part.of, 2).c_str());
    }
    if (!session.metrics.empty()) say(stdout, "metrics\n");
    for (const SessionMetric &metric : session.metrics)
        say(stdout, "  %-32s %8s %s\n", metric.name.c_str(), number_text(metric.value, 4).c_str(),
            metric.unit.c_str());
    if (!session.events.empty()) say(stdout, "events\n");
    for (const SessionEvent &event : session.events)
        say(stdout, "  %8s  %-6s  %-28s %s\n", clock_text(static_cast<double>(event.tick) / 1000.0).c_str(),
            event.severity == 0 ? "note" : ("err " + std::to_string(event.severity)).c_str(),
            event.kind.c_str(), event.text.c_str());
}

// A pseudonym may look like the beginning of a UUID, so the program first looks for a trainee with this
// pseudonym.
int show(RecordStore &store, const RecordsOptions &options)
{
    for (const TraineeLine &line : store.trainees()) {
        if (line.trainee.pseudonym != options.what) continue;
        const std::vector<SessionRecord> sessions = store.sessions({options.what, "", ""});
        if (options.json) {
            Json json = json_of_trainee(line);
            json["records"] = json_of(sessions)["sessions"];
            print_json(json);
        } else {
            print_trainees({line});
            print_sessions(sessions);
        }
        return 0;
    }
    const bool is_id = options.what.find_first_not_of("0123456789abcdef-") == options.what.npos;
    if (!is_id) store.trainee(options.what); // throws, with a suggestion
    const SessionRecord session = store.session(options.what);
    if (options.json)
        print_json(json_of(session));
    else
        print_session(session);
    return 0;
}

int export_sessions(RecordStore &store, const RecordsOptions &options)
{
    if (!options.home_page.empty() && options.format != "xapi")
        throw UsageError("--home-page belongs to --format xapi");
    if (!options.home_page.empty() && options.home_page.find("://") == std::string::npos)
        throw UsageError("--home-page '" + options.home_page +
                         "' is not an address, such as https://hospital.example");
    if (!options.trainee.empty()) store.trainee(options.trainee);
    if (!options.output.empty())
        check_outputs({{"--records", store.place()}}, {{"--output", options.output}});
    const std::vector<SessionRecord> sessions = store.sessions({options.trainee, options.case_id, ""});
    std::string text;
    if (options.format == "csv") text = csv_of(sessions);
    if (options.format == "json") text = json_of(sessions).dump(2) + "\n";
    if (options.format == "xapi")
        text = xapi_of(sessions, options.home_page.empty() ? records_home_page : options.home_page).dump(2) +
               "\n";
    if (options.output.empty()) {
        std::fwrite(text.data(), 1, text.size(), stdout);
        if (std::fflush(stdout) != 0) throw OutputError("standard output", errno);
        return 0;
    }
    write_whole_file(options.output, text);
    say(stdout, "written %s: %zu session%s\n", options.output.c_str(), sessions.size(),
        sessions.size() == 1 ? "" : "s");
    return 0;
}

int import_sessions(RecordStore &store, const RecordsOptions &options)
{
    std::vector<SessionRecord> records;
    for (const std::string &file : options.files)
        for (SessionRecord &record : records_of_json(read_text_file(file), file))
            records.push_back(std::move(record));
    std::size_t known = 0;
    for (SessionRecord &record : records) {
        // If a session has no id, the program makes an id from its contents, because otherwise each import
        // would store the session again.
        if (record.id.empty())
            record.id =
                uuid_of_name("import", record.trainee + "\n" + record.case_id + "\n" + record.started_at);
        record.station
            .clear(); // a station that this file does not know; the importing station answers for it
        known += !store.sessions({"", "", record.id}, false).empty();
        store.save(record);
    }
    say(stdout, "%zu session%s imported, %zu known already\n", records.size() - known,
        records.size() - known == 1 ? "" : "s", known);
    return 0;
}

int change_trainee(RecordStore &store, const RecordsOptions &options)
{
    Trainee trainee = store.add_trainee(options.what);
    const bool has_cohort = !options.cohort.empty() || options.no_cohort,
               has_date = !options.keep_until.empty() || options.no_keep_until,
               has_role = options.is_expert || options.is_no_expert;
    if (has_cohort) trainee.cohort = options.cohort;
    if (has_date) trainee.keep_until = options.keep_until;
    if (has_role) trainee.is_expert = options.is_expert;
    if (has_cohort || has_date || has_role) store.change(trainee);
    if (!options.name.empty() || options.no_name) store.set_name(options.what, options.name);
    for (const TraineeLine &line : store.trainees())
        if (line.trainee.pseudonym == options.what) print_trainees({line});
    return 0;
}

// Deletes a recording only if it is a regular file of this user and its contents are those of the session.
std::string delete_recording(const RecordingFile &recording)
{
    struct stat status;
    if (::lstat(recording.path.c_str(), &status) != 0) return "was deleted earlier";
    if (!S_ISREG(status.st_mode)) return "kept: it is not a file";
    if (status.st_uid != ::geteuid()) return "kept: it belongs to another user, who has to delete it";
    if (!recording.sha256.empty() && sha256_of_file(recording.path) != recording.sha256)
        return "kept: its contents are no longer those of the session";
    if (::unlink(recording.path.c_str()) != 0) return std::string("kept: ") + std::strerror(errno);
    return "deleted";
}

bool erase_one(RecordStore &store, const RecordsOptions &options, const std::string &pseudonym)
{
    const RigTalk talk = console_talk();
    const std::vector<RecordingFile> recordings = store.recordings(pseudonym);
    const std::size_t sessions = store.sessions({pseudonym, "", ""}, false).size();
    if (!options.yes) {
        say(stdout, "%s: %zu session%s and %zu recording%s. There is no way back.\n", pseudonym.c_str(),
            sessions, sessions == 1 ? "" : "s", recordings.size(), recordings.size() == 1 ? "" : "s");
        if (talk.ask("Type the pseudonym to erase the data:") != pseudonym)
            throw RecordsError(RecordsError::Cause::refused, "that is not the pseudonym; nothing was erased");
    }
    bool deletes = options.with_recordings;
    if (!recordings.empty() && !deletes && !options.keeps_recordings)
        deletes = talk.ask("Delete the recordings too? [yes/no]") == "yes";
    store.erase(pseudonym);
    say(stdout, "erased %s: %zu session%s\n", pseudonym.c_str(), sessions, sessions == 1 ? "" : "s");
    bool is_whole = true;
    for (const RecordingFile &recording : recordings) {
        const std::string outcome = deletes ? delete_recording(recording) : "kept";
        is_whole = is_whole && (!deletes || !outcome.starts_with("kept"));
        say(stdout, "  %s: %s\n", recording.path.c_str(), outcome.c_str());
    }
    return is_whole;
}

int erase(RecordStore &store, const RecordsOptions &options)
{
    if (options.what.empty() && !options.expired) throw UsageError("erase: name a trainee, or --expired");
    std::vector<std::string> pseudonyms;
    if (options.expired)
        for (const Trainee &trainee : store.expired(utc_now().substr(0, 10)))
            pseudonyms.push_back(trainee.pseudonym);
    else
        pseudonyms.push_back(store.trainee(options.what).pseudonym);
    // If no person is at the terminal, the command line must answer both questions: whether to erase, and
    // whether to delete recordings.
    if (!::isatty(STDIN_FILENO) && options.yes && !options.with_recordings && !options.keeps_recordings)
        for (const std::string &pseudonym : pseudonyms)
            if (!store.recordings(pseudonym).empty())
                throw UsageError("erase: say --recordings or --keep-recordings, because " + pseudonym +
                                 " has recordings");
    bool is_whole = true;
    for (const std::string &pseudonym : pseudonyms)
        is_whole = erase_one(store, options, pseudonym) && is_whole;
    if (pseudonyms.empty()) say(stdout, "no trainee is past the keep-until date\n");
    return is_whole ? 0 : 1;
}

int check(RecordStore &store, const RecordsOptions &options)
{
    const std::vector<std::string> faults = store.faults();
    Json recordings = Json::array();
    std::size_t sessions = 0, changed = 0;
    for (const SessionRecord &session : store.sessions({}, false)) {
        sessions++;
        if (session.recording_path.empty() || session.recording_sha256.empty()) continue;
        const auto hash = sha256_of_file(session.recording_path);
        if (hash == session.recording_sha256) continue;
        changed++;
        recordings.push_back({{"session", session.id},
                              {"recording", session.recording_path},
                              {"state", hash ? "changed" : "missing"}});
    }
    if (options.json)
        print_json({{"records", store.place()},
                    {"sessions", sessions},
                    {"faults", faults},
                    {"recordings", recordings},
                    {"waiting", store.outbox().size()}});
    else {
        for (const std::string &fault : faults) say(stdout, "damage: %s\n", fault.c_str());
        for (const Json &one : recordings)
            say(stdout, "%s: the recording is %s\n", one["recording"].get<std::string>().c_str(),
                one["state"].get<std::string>().c_str());
        say(stdout, "%s: %zu sessions, %zu faults, %zu recordings missing or changed\n",
            store.place().c_str(), sessions, faults.size(), changed);
    }
    return faults.empty() ? 0 : 1;
}

int ship_sessions(const RecordsOptions &options)
{
    const std::string to = options.to.empty() ? default_records_place() : options.to;
    if (!is_server_url(to))
        throw UsageError("ship: name the server by --to or COURNAND_RECORDS, such as "
                         "postgresql://station@server/cournand");
    if (is_server_url(options.place))
        throw UsageError("ship: --records is this station's own file; the server is named by --to");
    RecordStore station = open_store(options.place.empty() ? own_records_file() : options.place);
    const Shipment shipment = ship_to(station, to);
    const std::size_t waiting = station.outbox().size();
    if (options.json)
        print_json({{"sent", shipment.sent},
                    {"known", shipment.known},
                    {"erased_here", shipment.erased_here},
                    {"waiting", waiting},
                    {"refused", shipment.refused}});
    else {
        for (const std::string &line : shipment.refused) say(stderr, "%s\n", line.c_str());
        say(stdout, "%zu sent, %zu known there already, %zu waiting\n", shipment.sent, shipment.known,
            waiting);
        if (shipment.erased_here > 0)
            say(stdout, "%lld sessions were erased here, because the centre erased their trainees\n",
                static_cast<long long>(shipment.erased_here));
    }
    return waiting == 0 && shipment.refused.empty() ? 0 : 1;
}

} // namespace

std::string clock_text(double seconds)
{
    const long long whole = std::llround(seconds);
    return formatted("%lld:%02lld", whole / 60, whole % 60);
}

int command_records(const RecordsOptions &options)
{
    if (options.command == "ship") return ship_sessions(options);
    RecordStore store = open_store(options.place.empty() ? default_records_place() : options.place);
    if (options.command == "list") return list(store, options);
    if (options.command == "show") return show(store, options);
    if (options.command == "export") return export_sessions(store, options);
    if (options.command == "import") return import_sessions(store, options);
    if (options.command == "trainee") return change_trainee(store, options);
    if (options.command == "erase") return erase(store, options);
    if (options.command == "check") return check(store, options);
    if (options.command == "curve") return command_records_curve(store, options);
    if (options.command == "cohort") return command_records_cohort(store, options);
    store.rename(options.what, options.new_name);
    say(stdout, "%s is now %s\n", options.what.c_str(), options.new_name.c_str());
    return 0;
}

} // namespace crn
