// Stores records of sessions and trainees in a database, and reads them. All SQL statements are the same for
// SQLite and PostgreSQL. Every function that writes is one transaction: after a crash either all or nothing
// of its data is stored.
//   RecordStore store = open_store(default_records_place());
//   store.save(record);
#pragma once
#include "host/records/database.hpp"
#include "host/records/record.hpp"
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct SessionFilter {
    std::string trainee; // pseudonym; empty: all
    std::string case_id; // empty: all
    std::string id;      // of one session; empty: all
};

struct RecordingFile {
    std::string path, sha256;
};

// Holds a trainee, with the other columns that the list of trainees shows.
struct TraineeLine {
    Trainee trainee;
    std::string name; // empty: none
    std::int64_t sessions = 0;
    std::string last_at; // begin of the newest session; empty: none
};

struct Station {
    std::string id, name, created_at;
};

class RecordStore
{
  public:
    // Receives an open database and migrates it to the newest version. Throws RecordsError.
    explicit RecordStore(std::unique_ptr<Database> database);

    // Stores the session with all of its parts, and puts it into the outbox (the list of sessions to send to
    // the server). If the session's trainee is unknown, the trainee is created. Returns the id of the
    // session. If the database already has a session with this id, nothing changes. Throws RecordsError.
    std::string save(SessionRecord record);
    // Returns the sessions by starting time, oldest first, with scores; `with_details` also reads parts,
    // metrics and events.
    std::vector<SessionRecord> sessions(const SessionFilter &filter, bool with_details = true);
    // Returns the session whose id begins with `id`. Throws RecordsError if no session or more than one
    // session has such an id.
    SessionRecord session(const std::string &id);

    std::vector<TraineeLine> trainees();
    // Throws RecordsError if this trainee does not exist; the message suggests a similar pseudonym.
    Trainee trainee(const std::string &pseudonym);
    // Returns the trainee with this pseudonym, who is created if no such trainee exists. Throws RecordsError
    // if the pseudonym belonged to somebody who was renamed or erased.
    Trainee add_trainee(const std::string &pseudonym);
    // Changes cohort, is_expert and keep_until of the trainee with this id.
    void change(const Trainee &trainee);
    void rename(const std::string &pseudonym, const std::string &new_pseudonym);
    // Names are kept only in a station's own file; an empty name deletes the stored name.
    void set_name(const std::string &pseudonym, const std::string &name);
    std::string name(const std::string &pseudonym); // empty: none

    std::vector<RecordingFile> recordings(const std::string &pseudonym);
    // Deletes the trainee, the name, and all sessions, and overwrites their bytes. Returns the number of
    // sessions. The id of the trainee stays in the table `erasure`, so that no other station brings the
    // sessions back.
    std::int64_t erase(const std::string &pseudonym);
    std::vector<Trainee> expired(const std::string &today); // whose keep_until is before this date

    Station own_station(); // created with the first session
    std::vector<std::string> faults() { return database_->faults(); }
    std::string place() const { return database_->place(); }
    bool is_server() const { return database_->is_server(); }
    Database &database() { return *database_; }

    // The following functions are for the outbox (outbox.hpp).
    struct Waiting {
        std::string session_id, last_error;
        std::int64_t attempts = 0;
    };
    std::vector<Waiting> outbox();
    void sent(const std::string &session_id);
    void not_sent(const std::string &session_id, const std::string &why);
    // Stores a session of another station. Returns false if the session was already stored. Throws
    // RecordsError (refused) if the trainee was erased after the session began.
    bool take(const SessionRecord &record, const Trainee &trainee, const Station &station);
    void take_trainee(const Trainee &trainee); // the change with the later changed_at counts
    Station station(const std::string &id);
    struct Erasure {
        std::string trainee_id, erased_at;
        bool is_shipped = false;
    };
    std::vector<Erasure> erasures();
    // Deletes the trainee with this id, if the trainee was created before `erasure.erased_at`, and stores the
    // erasure. Returns the number of deleted sessions.
    std::int64_t take_erasure(const Erasure &erasure);
    void shipped_erasure(const std::string &trainee_id);

  private:
    std::unique_ptr<Database> database_;

    std::optional<Trainee> find_trainee(const char *column, const std::string &value);
    Trainee add_within(const std::string &pseudonym, bool is_expert);
    Station own_station_within();
    bool insert(const SessionRecord &record, const std::string &trainee_id);
    void insert_parts(const SessionRecord &record);
    void read_details(std::vector<SessionRecord> &sessions, const SessionFilter &filter);
    std::int64_t delete_trainee(const std::string &trainee_id);
};

// Returns the file or server of the records: that in COURNAND_RECORDS, or else
// $XDG_DATA_HOME/cournand/records.db, or else the same path below ~/.local/share. Throws RecordsError if none
// of the variables that lead to the records is set.
std::string default_records_place();
// Returns the station's own file, even if COURNAND_RECORDS names a server.
std::string own_records_file();
bool is_server_url(const std::string &place); // postgresql://... or postgres://...
// Opens a file or a server that stores records. If the folder of the station's own file does not exist, the
// function creates it. Throws RecordsError.
RecordStore open_store(const std::string &place);

} // namespace crn
