#include "host/records/exchange.hpp"
#include "host/base/number_text.hpp"
#include "host/base/terminal.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

std::string cell(const std::string &text)
{
    const bool is_formula = !text.empty() && std::string("=+-@\t\r").find(text[0]) != std::string::npos;
    const std::string safe = is_formula ? "'" + text : text;
    if (safe.find_first_of(",\"\r\n") == safe.npos) return safe;
    std::string quoted = "\"";
    for (char letter : safe) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
    return quoted + "\"";
}

std::string number_cell(double value)
{
    return number_text(value, 12);
}

std::vector<std::string> metric_names(const std::vector<SessionRecord> &records)
{
    std::vector<std::string> names;
    for (const SessionRecord &record : records)
        for (const SessionMetric &metric : record.metrics)
            if (std::find(names.begin(), names.end(), metric.name) == names.end())
                names.push_back(metric.name);
    return names;
}

template <typename Value> Value optional_at(const Json &from, const char *key, Value standard)
{
    return from.contains(key) && !from[key].is_null() ? from[key].get<Value>() : standard;
}

SessionScore score_of_json(const Json &from)
{
    SessionScore score{from.at("total").get<double>(), from.at("of").get<double>(), {}};
    for (const Json &part : from.value("parts", Json::array()))
        score.parts.push_back({part.at("name").get<std::string>(), part.at("points").get<double>(),
                               part.at("of").get<double>()});
    return score;
}

SessionRecord record_of_json(const Json &from)
{
    SessionRecord record;
    record.id = optional_at<std::string>(from, "id", "");
    record.trainee = from.at("trainee").get<std::string>();
    record.by_expert = optional_at(from, "by_expert", false);
    record.station = optional_at<std::string>(from, "station", "");
    record.case_id = from.at("case").get<std::string>();
    record.case_version = optional_at<std::string>(from, "case_version", "");
    record.core_version = optional_at<std::string>(from, "core_version", "");
    record.program_version = optional_at<std::string>(from, "program_version", "");
    record.started_at = from.at("started_at").get<std::string>();
    record.duration_s = from.at("duration_s").get<double>();
    record.seed = optional_at<std::uint64_t>(from, "seed", 0);
    record.recording_path = optional_at<std::string>(from, "recording_path", "");
    record.recording_sha256 = optional_at<std::string>(from, "recording_sha256", "");
    record.state_hash = optional_at<std::string>(from, "state_hash", "");
    if (from.contains("passed") && !from["passed"].is_null()) record.passed = from["passed"].get<bool>();
    if (from.contains("score") && !from["score"].is_null()) record.score = score_of_json(from["score"]);
    for (const Json &metric : from.value("metrics", Json::array()))
        record.metrics.push_back({metric.at("name").get<std::string>(), metric.at("value").get<double>(),
                                  optional_at<std::string>(metric, "unit", "")});
    for (const Json &event : from.value("events", Json::array()))
        record.events.push_back({event.at("tick").get<std::uint64_t>(), event.at("kind").get<std::string>(),
                                 event.at("severity").get<int>(),
                                 optional_at<std::string>(event, "text", "")});
    check_record(record);
    return record;
}

} // namespace

Json json_of(const SessionRecord &record)
{
    Json json = {{"id", record.id},
                 {"trainee", record.trainee},
                 {"by_expert", record.by_expert},
                 {"station", record.station},
                 {"case", record.case_id},
                 {"case_version", record.case_version},
                 {"core_version", record.core_version},
                 {"program_version", record.program_version},
                 {"started_at", record.started_at},
                 {"duration_s", record.duration_s},
                 {"seed", record.seed},
                 {"recording_path", record.recording_path},
                 {"recording_sha256", record.recording_sha256},
                 {"state_hash", record.state_hash}};
    json["passed"] = record.passed ? Json(*record.passed) : Json();
    json["score"] = Json();
    if (record.score) {
        Json parts = Json::array();
        for (const ScorePart &part : record.score->parts)
            parts.push_back({{"name", part.name}, {"points", part.points}, {"of", part.of}});
        json["score"] = {{"total", record.score->total}, {"of", record.score->of}, {"parts", parts}};
    }
    json["metrics"] = Json::array();
    for (const SessionMetric &metric : record.metrics)
        json["metrics"].push_back({{"name", metric.name}, {"value", metric.value}, {"unit", metric.unit}});
    json["events"] = Json::array();
    for (const SessionEvent &event : record.events)
        json["events"].push_back(
            {{"tick", event.tick}, {"kind", event.kind}, {"severity", event.severity}, {"text", event.text}});
    return json;
}

Json json_of(const std::vector<SessionRecord> &records)
{
    Json json = {{"format", records_format}, {"sessions", Json::array()}};
    for (const SessionRecord &record : records) json["sessions"].push_back(json_of(record));
    return json;
}

std::vector<SessionRecord> records_of_json(const std::string &text, const std::string &file)
{
    const auto refuse_file = [&](const std::string &what) {
        return RecordsError(RecordsError::Cause::refused, printable(file) + ": " + what);
    };
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded() || !json.is_object() || !json.contains("sessions") ||
        !json["sessions"].is_array())
        throw refuse_file(
            "this is not a file of sessions; `cournand records export --format json` writes one");
    if (!json.contains("format") || json["format"] != records_format)
        throw refuse_file("the format of this file is not " + std::to_string(records_format) +
                          "; a newer program may have written it");
    std::vector<SessionRecord> records;
    for (const Json &one : json["sessions"]) {
        const std::string place = "session " + std::to_string(records.size() + 1) + ": ";
        try {
            records.push_back(record_of_json(one));
        } catch (const Json::exception &error) {
            throw refuse_file(place + printable(error.what()));
        } catch (const RecordsError &error) {
            throw refuse_file(place + error.what());
        }
    }
    return records;
}

std::string csv_of(const std::vector<SessionRecord> &records)
{
    const std::vector<std::string> names = metric_names(records);
    std::string text =
        "session,trainee,by_expert,station,case,case_version,core_version,program_version,started_at,"
        "duration_s,seed,passed,score,score_of,errors,recording_path,state_hash";
    for (const std::string &name : names) text += "," + cell("metric " + name);
    text += "\r\n";
    for (const SessionRecord &record : records) {
        const auto errors = std::count_if(record.events.begin(), record.events.end(),
                                          [](const SessionEvent &event) { return event.severity > 0; });
        const std::vector<std::string> cells{record.id,
                                             cell(record.trainee),
                                             record.by_expert ? "1" : "0",
                                             record.station,
                                             cell(record.case_id),
                                             cell(record.case_version),
                                             cell(record.core_version),
                                             cell(record.program_version),
                                             record.started_at,
                                             number_cell(record.duration_s),
                                             std::to_string(record.seed),
                                             record.passed ? (*record.passed ? "1" : "0") : "",
                                             record.score ? number_cell(record.score->total) : "",
                                             record.score ? number_cell(record.score->of) : "",
                                             std::to_string(errors),
                                             cell(record.recording_path),
                                             cell(record.state_hash)};
        for (std::size_t i = 0; i < cells.size(); i++) text += (i ? "," : "") + cells[i];
        for (const std::string &name : names) {
            const auto metric = std::find_if(record.metrics.begin(), record.metrics.end(),
                                             [&](const SessionMetric &one) { return one.name == name; });
            text += "," + (metric == record.metrics.end() ? std::string() : number_cell(metric->value));
        }
        text += "\r\n";
    }
    return text;
}

} // namespace crn
