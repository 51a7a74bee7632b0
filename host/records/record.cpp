#include "host/records/record.hpp"
#include "host/base/terminal.hpp"
#include "host/records/identity.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace crn
{

namespace
{

constexpr std::size_t words_bytes_max = 64, text_bytes_max = 4096, list_items_max = 100000;

[[noreturn]] void refuse_record(const std::string &what)
{
    throw RecordsError(RecordsError::Cause::refused, "the record of a session cannot be stored: " + what);
}

// A text is refused if printable() would change it, which means that the text has control characters or is
// not UTF-8.
void check_text(const std::string &what, const std::string &text, std::size_t bytes_max, bool may_be_empty)
{
    if (text.empty() && !may_be_empty) refuse_record(what + " is empty");
    if (text.size() > bytes_max)
        refuse_record(what + " has " + std::to_string(text.size()) + " bytes, at most " +
                      std::to_string(bytes_max) + " are possible");
    if (printable(text) != text)
        refuse_record(what + " '" + printable(text) + "' has control characters or is not UTF-8");
}

void check_number(const std::string &what, double value)
{
    if (!std::isfinite(value)) refuse_record(what + " is not a finite number");
}

void check_score(const SessionScore &score)
{
    check_number("the score", score.total);
    check_number("the most points of the score", score.of);
    if (score.of <= 0.0) refuse_record("the most points of the score are not above 0");
    std::set<std::string> names;
    for (const ScorePart &part : score.parts) {
        check_text("the name of a part of the score", part.name, words_bytes_max, false);
        check_number("the part '" + part.name + "' of the score", part.points);
        check_number("the most points of the part '" + part.name + "'", part.of);
        if (!names.insert(part.name).second) refuse_record("the score has two parts '" + part.name + "'");
    }
}

void check_events(const std::vector<SessionEvent> &events)
{
    if (events.size() > list_items_max)
        refuse_record(std::to_string(events.size()) + " events, at most " + std::to_string(list_items_max) +
                      " are possible");
    for (const SessionEvent &event : events) {
        check_text("the kind of an event", event.kind, words_bytes_max, false);
        check_text("the text of the event '" + event.kind + "'", event.text, text_bytes_max, true);
        if (event.severity < 0 || event.severity > severity_max)
            refuse_record("the event '" + event.kind + "' has the severity " +
                          std::to_string(event.severity) + ", which must be 0 to " +
                          std::to_string(severity_max));
        if (event.tick > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
            refuse_record("the tick of the event '" + event.kind + "' is too large");
    }
}

bool is_sha256(const std::string &text)
{
    return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == text.npos;
}

} // namespace

std::optional<double> SessionRecord::metric(const std::string &name) const
{
    if (name == "score")
        return score ? std::optional<double>(100.0 * score->total / score->of) : std::nullopt;
    for (const SessionMetric &one : metrics)
        if (one.name == name) return one.value;
    if (name == "errors")
        return static_cast<double>(std::count_if(
            events.begin(), events.end(), [](const SessionEvent &event) { return event.severity > 0; }));
    if (name == "duration_s") return duration_s;
    return std::nullopt;
}

void check_pseudonym(const std::string &pseudonym)
{
    check_text("the pseudonym", pseudonym, words_bytes_max, false);
    if (pseudonym.front() == '-' || pseudonym.front() == ' ' || pseudonym.back() == ' ')
        refuse_record("the pseudonym '" + pseudonym +
                      "' begins with a dash or a blank, or ends with a blank");
}

void check_record(const SessionRecord &record)
{
    check_pseudonym(record.trainee);
    if (!record.id.empty() && !is_uuid(record.id))
        refuse_record("'" + printable(record.id) + "' is not a UUID");
    if (!record.station.empty() && !is_uuid(record.station))
        refuse_record("the station '" + printable(record.station) + "' is not a UUID");
    check_text("the case", record.case_id, words_bytes_max, false);
    check_text("the version of the case", record.case_version, words_bytes_max, true);
    check_text("the version of the core", record.core_version, words_bytes_max, true);
    check_text("the version of the program", record.program_version, words_bytes_max, true);
    check_text("the hash of the state", record.state_hash, words_bytes_max, true);
    check_text("the path of the recording", record.recording_path, text_bytes_max, true);
    if (!record.recording_sha256.empty() && !is_sha256(record.recording_sha256))
        refuse_record("the hash of the recording is not SHA-256 in 64 hexadecimal digits");
    if (!unix_ms_of(record.started_at))
        refuse_record("the begin '" + printable(record.started_at) +
                      "' is not a moment in UTC, such as 2026-11-24T20:14:57.123Z");
    check_number("the duration", record.duration_s);
    if (record.duration_s < 0.0) refuse_record("the duration is negative");
    if (record.score) check_score(*record.score);
    std::set<std::string> names;
    if (record.metrics.size() > list_items_max) refuse_record("there are too many metrics");
    for (const SessionMetric &metric : record.metrics) {
        check_text("the name of a metric", metric.name, words_bytes_max, false);
        check_text("the unit of the metric '" + metric.name + "'", metric.unit, words_bytes_max, true);
        check_number("the metric '" + metric.name + "'", metric.value);
        if (metric.name == "score")
            refuse_record("a metric is called 'score', which is the name of the score itself");
        if (!names.insert(metric.name).second) refuse_record("two metrics are called '" + metric.name + "'");
    }
    check_events(record.events);
}

} // namespace crn
