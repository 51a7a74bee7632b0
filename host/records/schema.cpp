#include "host/records/schema.hpp"

namespace crn
{

namespace
{

// SQLite and PostgreSQL both understand the types BIGINT and DOUBLE PRECISION. The seed of a session is
// stored as text, because it is an unsigned number of 64 bits. A trainee's name is in a separate table, which
// stays on the station.
const char *const first_version = R"(
CREATE TABLE station (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, is_own BIGINT NOT NULL, created_at TEXT NOT NULL);
CREATE TABLE trainee (
    id TEXT PRIMARY KEY, pseudonym TEXT NOT NULL UNIQUE, cohort TEXT NOT NULL, is_expert BIGINT NOT NULL,
    keep_until TEXT NOT NULL, created_at TEXT NOT NULL, changed_at TEXT NOT NULL);
CREATE TABLE trainee_name (
    trainee_id TEXT PRIMARY KEY REFERENCES trainee (id) ON DELETE CASCADE, name TEXT NOT NULL);
CREATE TABLE session (
    id TEXT PRIMARY KEY, trainee_id TEXT NOT NULL REFERENCES trainee (id) ON DELETE CASCADE,
    station_id TEXT NOT NULL REFERENCES station (id), case_id TEXT NOT NULL, case_version TEXT NOT NULL,
    core_version TEXT NOT NULL, program_version TEXT NOT NULL, started_at TEXT NOT NULL,
    duration_s DOUBLE PRECISION NOT NULL, seed TEXT NOT NULL, recording_path TEXT NOT NULL,
    recording_sha256 TEXT NOT NULL, state_hash TEXT NOT NULL, passed BIGINT, score_total DOUBLE PRECISION,
    score_of DOUBLE PRECISION);
CREATE INDEX session_of_trainee ON session (trainee_id, case_id, started_at);
CREATE INDEX session_of_case ON session (case_id, started_at);
CREATE TABLE score_part (
    session_id TEXT NOT NULL REFERENCES session (id) ON DELETE CASCADE, place BIGINT NOT NULL,
    name TEXT NOT NULL, points DOUBLE PRECISION NOT NULL, points_of DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (session_id, name));
CREATE TABLE metric (
    session_id TEXT NOT NULL REFERENCES session (id) ON DELETE CASCADE, place BIGINT NOT NULL,
    name TEXT NOT NULL, value DOUBLE PRECISION NOT NULL, unit TEXT NOT NULL,
    PRIMARY KEY (session_id, name));
CREATE TABLE event (
    session_id TEXT NOT NULL REFERENCES session (id) ON DELETE CASCADE, place BIGINT NOT NULL,
    tick BIGINT NOT NULL, kind TEXT NOT NULL, severity BIGINT NOT NULL, words TEXT NOT NULL,
    PRIMARY KEY (session_id, place));
CREATE TABLE outbox (
    session_id TEXT PRIMARY KEY REFERENCES session (id) ON DELETE CASCADE, queued_at TEXT NOT NULL,
    attempts BIGINT NOT NULL, last_error TEXT NOT NULL);
CREATE TABLE erasure (
    trainee_id TEXT PRIMARY KEY, erased_at TEXT NOT NULL, is_shipped BIGINT NOT NULL);
)";

} // namespace

const std::vector<std::string> &schema_migrations()
{
    static const std::vector<std::string> migrations{first_version};
    return migrations;
}

} // namespace crn
