#include "host/records/store.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/records/identity.hpp"
#include <unistd.h>

namespace crn
{

namespace
{

const char *const trainee_columns = "id, pseudonym, cohort, is_expert, keep_until, created_at, changed_at";

Trainee trainee_of(const SqlRow &row)
{
    return {text_of(row.at(0)), text_of(row.at(1)), text_of(row.at(2)), whole_of(row.at(3)) != 0,
            text_of(row.at(4)), text_of(row.at(5)), text_of(row.at(6))};
}

std::vector<SqlValue> values_of(const Trainee &trainee)
{
    return {trainee.id,         trainee.pseudonym,  trainee.cohort,    std::int64_t{trainee.is_expert},
            trainee.keep_until, trainee.created_at, trainee.changed_at};
}

[[noreturn]] void refuse(const std::string &what)
{
    throw RecordsError(RecordsError::Cause::refused, what);
}

std::string host_name()
{
    char name[256] = {};
    if (::gethostname(name, sizeof name - 1) != 0) return "station";
    return printable(name);
}

} // namespace

RecordStore::RecordStore(std::unique_ptr<Database> database) : database_(std::move(database))
{
    migrate(*database_);
}

std::string RecordStore::save(SessionRecord record)
{
    if (record.id.empty()) record.id = new_uuid();
    check_record(record);
    Transaction transaction(*database_);
    if (record.station.empty()) record.station = own_station_within().id;
    const Trainee trainee = add_within(record.trainee, record.by_expert);
    if (insert(record, trainee.id) && !is_server())
        database_->run(
            "INSERT INTO outbox (session_id, queued_at, attempts, last_error) VALUES ($1, $2, 0, '')",
            {record.id, utc_now()});
    transaction.commit();
    return record.id;
}

bool RecordStore::take(const SessionRecord &record, const Trainee &trainee, const Station &station)
{
    check_record(record);
    Transaction transaction(*database_);
    database_->lock(trainee.id);
    const SqlResult erased =
        database_->run("SELECT erased_at FROM erasure WHERE trainee_id = $1", {trainee.id});
    if (!erased.rows.empty())
        refuse("the pseudonym '" + trainee.pseudonym + "' was erased on " + text_of(erased.rows[0].at(0)) +
               "; `cournand records rename` gives the trainee another pseudonym");
    database_->run(
        "INSERT INTO station (id, name, is_own, created_at) VALUES ($1, $2, 0, $3) ON CONFLICT DO NOTHING",
        {station.id, station.name, station.created_at});
    const bool is_new = insert(record, trainee.id);
    transaction.commit();
    return is_new;
}

void RecordStore::take_trainee(const Trainee &trainee)
{
    Transaction transaction(*database_);
    database_->lock(trainee.id);
    const bool is_erased =
        !database_->run("SELECT 1 FROM erasure WHERE trainee_id = $1", {trainee.id}).rows.empty();
    if (!is_erased)
        database_->run(
            std::string("INSERT INTO trainee (") + trainee_columns +
                ") VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT (id) DO UPDATE SET "
                "pseudonym = excluded.pseudonym, cohort = excluded.cohort, is_expert = excluded.is_expert, "
                "keep_until = excluded.keep_until, changed_at = excluded.changed_at "
                "WHERE excluded.changed_at > trainee.changed_at",
            values_of(trainee));
    transaction.commit();
}

// Returns false, and inserts nothing, if the database has a session with this id.
bool RecordStore::insert(const SessionRecord &record, const std::string &trainee_id)
{
    const auto part = [](bool is_there, double value) { return is_there ? SqlValue(value) : SqlValue(); };
    const SqlResult result = database_->run(
        "INSERT INTO session (id, trainee_id, station_id, case_id, case_version, core_version, "
        "program_version, "
        "started_at, duration_s, seed, recording_path, recording_sha256, state_hash, passed, score_total, "
        "score_of) "
        "VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16) ON CONFLICT DO "
        "NOTHING",
        {record.id, trainee_id, record.station, record.case_id, record.case_version, record.core_version,
         record.program_version, record.started_at, record.duration_s, std::to_string(record.seed),
         record.recording_path, record.recording_sha256, record.state_hash,
         record.passed ? SqlValue(std::int64_t{*record.passed}) : SqlValue(),
         part(record.score.has_value(), record.score ? record.score->total : 0.0),
         part(record.score.has_value(), record.score ? record.score->of : 0.0)});
    if (result.changed == 0) return false;
    insert_parts(record);
    return true;
}

void RecordStore::insert_parts(const SessionRecord &record)
{
    std::int64_t place = 0;
    if (record.score)
        for (const ScorePart &part : record.score->parts)
            database_->run("INSERT INTO score_part (session_id, place, name, points, points_of) "
                           "VALUES ($1, $2, $3, $4, $5)",
                           {record.id, place++, part.name, part.points, part.of});
    place = 0;
    for (const SessionMetric &metric : record.metrics)
        database_->run(
            "INSERT INTO metric (session_id, place, name, value, unit) VALUES ($1, $2, $3, $4, $5)",
            {record.id, place++, metric.name, metric.value, metric.unit});
    place = 0;
    for (const SessionEvent &event : record.events)
        database_->run("INSERT INTO event (session_id, place, tick, kind, severity, words) "
                       "VALUES ($1, $2, $3, $4, $5, $6)",
                       {record.id, place++, static_cast<std::int64_t>(event.tick), event.kind,
                        std::int64_t{event.severity}, event.text});
}

std::optional<Trainee> RecordStore::find_trainee(const char *column, const std::string &value)
{
    const SqlResult found = database_->run(
        std::string("SELECT ") + trainee_columns + " FROM trainee WHERE " + column + " = $1", {value});
    if (found.rows.empty()) return std::nullopt;
    return trainee_of(found.rows.front());
}

Trainee RecordStore::add_within(const std::string &pseudonym, bool is_expert)
{
    check_pseudonym(pseudonym);
    if (const auto found = find_trainee("pseudonym", pseudonym)) return *found;
    Trainee trainee;
    trainee.id = uuid_of_name("trainee", pseudonym);
    database_->lock(trainee.id);
    trainee.pseudonym = pseudonym;
    trainee.is_expert = is_expert;
    trainee.created_at = utc_now();
    if (find_trainee("id", trainee.id))
        refuse("'" + pseudonym +
               "' was the pseudonym of a trainee who has another one today; choose another");
    if (!database_->run("SELECT 1 FROM erasure WHERE trainee_id = $1", {trainee.id}).rows.empty())
        refuse("'" + pseudonym + "' was the pseudonym of a trainee whose data was erased; choose another");
    database_->run(std::string("INSERT INTO trainee (") + trainee_columns +
                       ") VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING",
                   values_of(trainee));
    return trainee;
}

Trainee RecordStore::add_trainee(const std::string &pseudonym)
{
    Transaction transaction(*database_);
    const Trainee trainee = add_within(pseudonym, false);
    transaction.commit();
    return trainee;
}

Trainee RecordStore::trainee(const std::string &pseudonym)
{
    if (const auto found = find_trainee("pseudonym", pseudonym)) return *found;
    std::vector<std::string> known;
    for (const SqlRow &row : database_->run("SELECT pseudonym FROM trainee ORDER BY pseudonym").rows)
        known.push_back(text_of(row.at(0)));
    refuse(place() + ": there is no trainee '" + printable(pseudonym) + "'" +
           (known.empty() ? "; there are no trainees yet" : suggestion(pseudonym, known)));
}

void RecordStore::change(const Trainee &trainee)
{
    if (!trainee.keep_until.empty() && !is_date(trainee.keep_until))
        refuse("'" + printable(trainee.keep_until) + "' is not a date, such as 2027-12-31");
    if (trainee.cohort.size() > 64 || printable(trainee.cohort) != trainee.cohort)
        refuse("the cohort '" + printable(trainee.cohort) + "' has more than 64 bytes or control characters");
    Transaction transaction(*database_);
    database_->run(
        "UPDATE trainee SET cohort = $1, is_expert = $2, keep_until = $3, changed_at = $4 WHERE id = $5",
        {trainee.cohort, std::int64_t{trainee.is_expert}, trainee.keep_until, utc_now(), trainee.id});
    transaction.commit();
}

void RecordStore::rename(const std::string &pseudonym, const std::string &new_pseudonym)
{
    check_pseudonym(new_pseudonym);
    const Trainee old = trainee(pseudonym);
    Transaction transaction(*database_);
    if (find_trainee("pseudonym", new_pseudonym))
        refuse("there is a trainee '" + new_pseudonym + "' already; choose another pseudonym");
    const std::string id = uuid_of_name("trainee", new_pseudonym);
    const bool was_erased = !database_->run("SELECT 1 FROM erasure WHERE trainee_id = $1", {id}).rows.empty();
    if (was_erased || (id != old.id && find_trainee("id", id)))
        refuse("'" + new_pseudonym + "' was the pseudonym of another trainee earlier; choose another");
    database_->run("UPDATE trainee SET pseudonym = $1, changed_at = $2 WHERE id = $3",
                   {new_pseudonym, utc_now(), old.id});
    transaction.commit();
    database_->forget_deleted(); // the old pseudonym may have been a person's name
}

void RecordStore::set_name(const std::string &pseudonym, const std::string &name)
{
    if (is_server())
        refuse(place() +
               ": names are kept only in a station's own file, never on a server; name that file by "
               "--records");
    if (name.size() > 256 || printable(name) != name)
        refuse("the name '" + printable(name) + "' has more than 256 bytes or control characters");
    const Trainee found = trainee(pseudonym);
    Transaction transaction(*database_);
    database_->run("DELETE FROM trainee_name WHERE trainee_id = $1", {found.id});
    if (!name.empty()) database_->run("INSERT INTO trainee_name VALUES ($1, $2)", {found.id, name});
    transaction.commit();
    if (name.empty()) database_->forget_deleted();
}

std::string RecordStore::name(const std::string &pseudonym)
{
    const SqlResult found =
        database_->run("SELECT name FROM trainee_name WHERE trainee_id = $1", {trainee(pseudonym).id});
    return found.rows.empty() ? "" : text_of(found.rows[0].at(0));
}

std::vector<RecordingFile> RecordStore::recordings(const std::string &pseudonym)
{
    std::vector<RecordingFile> found;
    for (const SqlRow &row : database_
                                 ->run("SELECT DISTINCT recording_path, recording_sha256 FROM session WHERE "
                                       "trainee_id = $1 AND recording_path <> '' ORDER BY recording_path",
                                       {trainee(pseudonym).id})
                                 .rows)
        found.push_back({text_of(row.at(0)), text_of(row.at(1))});
    return found;
}

// Deletes the rows in every table explicitly, so that all rows are deleted even on a connection that does not
// enforce foreign keys.
std::int64_t RecordStore::delete_trainee(const std::string &trainee_id)
{
    for (const char *table : {"score_part", "metric", "event", "outbox"})
        database_->run(std::string("DELETE FROM ") + table +
                           " WHERE session_id IN (SELECT id FROM session WHERE trainee_id = $1)",
                       {trainee_id});
    const std::int64_t count =
        database_->run("DELETE FROM session WHERE trainee_id = $1", {trainee_id}).changed;
    database_->run("DELETE FROM trainee_name WHERE trainee_id = $1", {trainee_id});
    database_->run("DELETE FROM trainee WHERE id = $1", {trainee_id});
    return count;
}

std::int64_t RecordStore::erase(const std::string &pseudonym)
{
    const Trainee found = trainee(pseudonym);
    Transaction transaction(*database_);
    database_->lock(found.id);
    const std::int64_t count = delete_trainee(found.id);
    database_->run(
        "INSERT INTO erasure (trainee_id, erased_at, is_shipped) VALUES ($1, $2, 0) ON CONFLICT DO NOTHING",
        {found.id, utc_now()});
    transaction.commit();
    database_->forget_deleted();
    return count;
}

std::vector<Trainee> RecordStore::expired(const std::string &today)
{
    std::vector<Trainee> found;
    for (const SqlRow &row :
         database_
             ->run(std::string("SELECT ") + trainee_columns +
                       " FROM trainee WHERE keep_until <> '' AND keep_until < $1 ORDER BY pseudonym",
                   {today})
             .rows)
        found.push_back(trainee_of(row));
    return found;
}

Station RecordStore::own_station_within()
{
    const SqlResult found = database_->run("SELECT id, name, created_at FROM station WHERE is_own = 1");
    if (!found.rows.empty() && !is_server())
        return {text_of(found.rows[0].at(0)), text_of(found.rows[0].at(1)), text_of(found.rows[0].at(2))};
    // For a session that is stored on a server without a station, the station is the machine that stores the
    // session.
    const Station station{is_server() ? uuid_of_name("station", host_name()) : new_uuid(), host_name(),
                          utc_now()};
    database_->run(
        "INSERT INTO station (id, name, is_own, created_at) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING",
        {station.id, station.name, std::int64_t{!is_server()}, station.created_at});
    return station;
}

Station RecordStore::own_station()
{
    Transaction transaction(*database_);
    const Station station = own_station_within();
    transaction.commit();
    return station;
}

Station RecordStore::station(const std::string &id)
{
    const SqlResult found = database_->run("SELECT id, name, created_at FROM station WHERE id = $1", {id});
    if (found.rows.empty()) refuse(place() + ": there is no station '" + printable(id) + "'");
    return {text_of(found.rows[0].at(0)), text_of(found.rows[0].at(1)), text_of(found.rows[0].at(2))};
}

std::vector<RecordStore::Waiting> RecordStore::outbox()
{
    std::vector<Waiting> waiting;
    for (const SqlRow &row :
         database_->run("SELECT session_id, last_error, attempts FROM outbox ORDER BY queued_at, session_id")
             .rows)
        waiting.push_back({text_of(row.at(0)), text_of(row.at(1)), whole_of(row.at(2))});
    return waiting;
}

void RecordStore::sent(const std::string &session_id)
{
    database_->run("DELETE FROM outbox WHERE session_id = $1", {session_id});
}

void RecordStore::not_sent(const std::string &session_id, const std::string &why)
{
    database_->run("UPDATE outbox SET attempts = attempts + 1, last_error = $1 WHERE session_id = $2",
                   {why, session_id});
}

std::vector<RecordStore::Erasure> RecordStore::erasures()
{
    std::vector<Erasure> found;
    for (const SqlRow &row :
         database_->run("SELECT trainee_id, erased_at, is_shipped FROM erasure ORDER BY trainee_id").rows)
        found.push_back({text_of(row.at(0)), text_of(row.at(1)), whole_of(row.at(2)) != 0});
    return found;
}

std::int64_t RecordStore::take_erasure(const Erasure &erasure)
{
    Transaction transaction(*database_);
    database_->lock(erasure.trainee_id);
    const auto found = find_trainee("id", erasure.trainee_id);
    const bool is_older = found && found->created_at <= erasure.erased_at;
    const std::int64_t count = is_older ? delete_trainee(erasure.trainee_id) : 0;
    if (!found || is_older)
        database_->run("INSERT INTO erasure (trainee_id, erased_at, is_shipped) VALUES ($1, $2, 1) ON "
                       "CONFLICT DO NOTHING",
                       {erasure.trainee_id, erasure.erased_at});
    transaction.commit();
    if (is_older) database_->forget_deleted();
    return count;
}

void RecordStore::shipped_erasure(const std::string &trainee_id)
{
    database_->run("UPDATE erasure SET is_shipped = 1 WHERE trainee_id = $1", {trainee_id});
}

} // namespace crn
