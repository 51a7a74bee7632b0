// Reads sessions and trainees from a store; the number of SQL statements is four, however many sessions are
// read.
#include "host/base/terminal.hpp"
#include "host/records/store.hpp"
#include <map>

namespace crn
{

namespace
{

// The SQL statement contains only the conditions that apply, so that the databases can use their indexes.
std::string joined(const SessionFilter &filter, std::vector<SqlValue> &values)
{
    std::string text = " JOIN trainee t ON t.id = s.trainee_id ";
    const auto add = [&](const char *column, const std::string &value) {
        if (value.empty()) return;
        values.push_back(value);
        text += (values.size() == 1 ? "WHERE " : "AND ") + std::string(column) + " = $" +
                std::to_string(values.size()) + " ";
    };
    add("t.pseudonym", filter.trainee);
    add("s.case_id", filter.case_id);
    add("s.id", filter.id);
    return text;
}

const char *const session_columns =
    "s.id, t.pseudonym, t.is_expert, s.station_id, s.case_id, s.case_version, s.core_version, "
    "s.program_version, "
    "s.started_at, s.duration_s, s.seed, s.recording_path, s.recording_sha256, s.state_hash, s.passed, "
    "s.score_total, s.score_of";

SessionRecord session_of(const SqlRow &row)
{
    SessionRecord record;
    record.id = text_of(row.at(0));
    record.trainee = text_of(row.at(1));
    record.by_expert = whole_of(row.at(2)) != 0;
    record.station = text_of(row.at(3));
    record.case_id = text_of(row.at(4));
    record.case_version = text_of(row.at(5));
    record.core_version = text_of(row.at(6));
    record.program_version = text_of(row.at(7));
    record.started_at = text_of(row.at(8));
    record.duration_s = number_of(row.at(9));
    record.seed = std::strtoull(text_of(row.at(10)).c_str(), nullptr, 10);
    record.recording_path = text_of(row.at(11));
    record.recording_sha256 = text_of(row.at(12));
    record.state_hash = text_of(row.at(13));
    if (!is_null(row.at(14))) record.passed = whole_of(row.at(14)) != 0;
    if (!is_null(row.at(15))) record.score = SessionScore{number_of(row.at(15)), number_of(row.at(16)), {}};
    return record;
}

} // namespace

std::vector<SessionRecord> RecordStore::sessions(const SessionFilter &filter, bool with_details)
{
    std::vector<SessionRecord> found;
    std::vector<SqlValue> values;
    const std::string statement = std::string("SELECT ") + session_columns + " FROM session s" +
                                  joined(filter, values) + "ORDER BY s.started_at, s.id";
    for (const SqlRow &row : database_->run(statement, values).rows) found.push_back(session_of(row));
    if (with_details && !found.empty()) read_details(found, filter);
    return found;
}

void RecordStore::read_details(std::vector<SessionRecord> &sessions, const SessionFilter &filter)
{
    std::map<std::string, SessionRecord *> by_id;
    for (SessionRecord &session : sessions) by_id[session.id] = &session;
    const auto read = [&](const std::string &table, const std::string &columns, const auto &add) {
        std::vector<SqlValue> values;
        const std::string statement = "SELECT s.id, " + columns + " FROM " + table +
                                      " d JOIN session s ON s.id = d.session_id" + joined(filter, values) +
                                      "ORDER BY s.id, d.place";
        const SqlResult found = database_->run(statement, values);
        for (const SqlRow &row : found.rows)
            if (const auto place = by_id.find(text_of(row.at(0))); place != by_id.end())
                add(*place->second, row);
    };
    read("score_part", "d.name, d.points, d.points_of", [](SessionRecord &session, const SqlRow &row) {
        if (session.score)
            session.score->parts.push_back({text_of(row.at(1)), number_of(row.at(2)), number_of(row.at(3))});
    });
    read("metric", "d.name, d.value, d.unit", [](SessionRecord &session, const SqlRow &row) {
        session.metrics.push_back({text_of(row.at(1)), number_of(row.at(2)), text_of(row.at(3))});
    });
    read("event", "d.tick, d.kind, d.severity, d.words", [](SessionRecord &session, const SqlRow &row) {
        session.events.push_back({static_cast<std::uint64_t>(whole_of(row.at(1))), text_of(row.at(2)),
                                  static_cast<int>(whole_of(row.at(3))), text_of(row.at(4))});
    });
}

SessionRecord RecordStore::session(const std::string &id)
{
    const SqlResult found = database_->run(
        "SELECT id FROM session WHERE substr(id, 1, length($1)) = $1 ORDER BY id LIMIT 2", {id});
    if (found.rows.empty())
        throw RecordsError(RecordsError::Cause::refused, place() + ": there is no session '" + printable(id) +
                                                             "'; `cournand records list` prints their ids");
    if (found.rows.size() > 1)
        throw RecordsError(RecordsError::Cause::refused, place() + ": more than one session begins with '" +
                                                             printable(id) + "'; give more digits of its id");
    std::vector<SessionRecord> whole = sessions({"", "", text_of(found.rows[0].at(0))});
    if (!whole.empty()) return std::move(whole.front());
    throw RecordsError(RecordsError::Cause::refused,
                       place() + ": the session '" + printable(id) + "' was deleted a moment ago");
}

std::vector<TraineeLine> RecordStore::trainees()
{
    std::vector<TraineeLine> lines;
    const SqlResult found = database_->run(
        "SELECT t.id, t.pseudonym, t.cohort, t.is_expert, t.keep_until, t.created_at, t.changed_at, "
        "(SELECT n.name FROM trainee_name n WHERE n.trainee_id = t.id), "
        "(SELECT count(*) FROM session s WHERE s.trainee_id = t.id), "
        "(SELECT max(s.started_at) FROM session s WHERE s.trainee_id = t.id) FROM trainee t ORDER BY "
        "t.pseudonym");
    for (const SqlRow &row : found.rows)
        lines.push_back(
            {{text_of(row.at(0)), text_of(row.at(1)), text_of(row.at(2)), whole_of(row.at(3)) != 0,
              text_of(row.at(4)), text_of(row.at(5)), text_of(row.at(6))},
             text_of(row.at(7)),
             whole_of(row.at(8)),
             text_of(row.at(9))});
    return lines;
}

} // namespace crn
