// The record of one session states who played which case, with which result. The window and the command line
// fill these plain structs; the code in host/records knows neither cases nor the assessment
// (docs/records.md).
#pragma once
#include "host/base/fault.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Describes why records could not be read or written; the error's text names the file or server and the
// remedy.
struct RecordsError : Fault {
    enum class Cause {
        refused,     // the record, the file or the request is wrong; to repeat the request does not help
        no_space,    // the disk is full, or a quota is used up; earlier records are unchanged
        busy,        // another program held the file for longer than ten seconds
        damaged,     // the file is not a whole SQLite file, or not one of this program
        newer,       // the records were written by a newer program
        unreachable, // there is no connection to the server, or it broke; repeating the request is harmless
    };
    RecordsError(Cause cause_, const std::string &text) : Fault(text), cause(cause_) {}
    Cause cause;
};

struct ScorePart {
    std::string name;
    double points = 0.0, of = 0.0; // `of`: the most points of this part
};

struct SessionMetric {
    std::string name; // with its unit as its last word, such as "fluoroscopy_min"
    double value = 0.0;
    std::string unit; // may be empty
};

// An event of severity 0 is a note, such as the beginning of a phase. Events of severity 1 to 5 are errors;
// severity 5 is life-threatening.
inline constexpr int severity_max = 5;
struct SessionEvent {
    std::uint64_t tick = 0; // 1 ms each
    std::string kind;       // such as "moved_without_xray"
    int severity = 0;
    std::string text; // may be empty
};

struct SessionScore {
    double total = 0.0, of = 100.0;
    std::vector<ScorePart> parts;
};

struct SessionRecord {
    std::string id;         // UUID in small letters; empty: RecordStore::save makes a UUIDv7
    std::string trainee;    // pseudonym, 1 to 64 bytes
    bool by_expert = false; // the trainee is an expert, whose runs serve as examples
    std::string station;    // UUID of the station; empty: RecordStore::save enters its own
    std::string case_id, case_version, core_version, program_version; // the last three may be empty
    std::string started_at;                                           // UTC, "2026-11-24T20:14:57.123Z"
    double duration_s = 0.0;
    std::uint64_t seed = 0;
    std::string recording_path, recording_sha256; // empty: none; 64 hexadecimal digits
    std::string state_hash;                       // of the last tick; may be empty
    std::optional<bool> passed;                   // empty: the case does not say
    std::optional<SessionScore> score;            // empty: no score
    std::vector<SessionMetric> metrics;           // each name once
    std::vector<SessionEvent> events;             // in the order of their ticks

    // Returns the value of a metric. The metric "score" is the total score in percent, and the metric
    // "errors" is the number of events with a severity above 0. The function returns no value if the session
    // does not have the metric.
    std::optional<double> metric(const std::string &name) const;
};

// Describes a person as the centre knows the person: without a name.
struct Trainee {
    std::string id;        // UUID, made from the first pseudonym
    std::string pseudonym; // of the present
    std::string cohort;    // such as "2026 fellows"; may be empty
    bool is_expert = false;
    std::string keep_until; // date "2027-12-31"; empty: no limit
    std::string created_at; // UTC
    std::string changed_at; // UTC; empty: cohort, is_expert, keep_until and pseudonym were never changed
};

// Throws RecordsError (refused) if a value is invalid: texts must be UTF-8 without control characters,
// numbers must be finite, and the names of metrics and parts must be unique.
void check_record(const SessionRecord &record);
// Throws RecordsError (refused) if `pseudonym` is not a permitted pseudonym.
void check_pseudonym(const std::string &pseudonym);

} // namespace crn
