// Writes sessions as statements of the Experience API 1.0.3 (ADL, xAPI-Data.md and xAPI-Communication.md).
#include "host/base/number_text.hpp"
#include "host/records/exchange.hpp"
#include "host/records/identity.hpp"
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

// The IRIs (identifiers) of xAPI need only be unique; nothing is read from this address, because a name that
// ends with .invalid never resolves (RFC 2606).
const std::string space = std::string(records_home_page) + "/xapi/";

// The listed characters may be in an IRI without an escape (RFC 3986, 2.3).
std::string iri_part(const std::string &text)
{
    std::string part;
    for (char letter : text) {
        const bool is_plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                              (letter >= '0' && letter <= '9') || letter == '-' || letter == '_' ||
                              letter == '.' || letter == '~';
        part += is_plain ? std::string(1, letter) : "%" + hex_text(static_cast<unsigned char>(letter), 2);
    }
    return part;
}

Json verb_of(const SessionRecord &record)
{
    const std::string verb = !record.passed ? "completed" : *record.passed ? "passed" : "failed";
    return {{"id", "http://adlnet.gov/expapi/verbs/" + verb}, {"display", {{"en", verb}}}};
}

Json score_of(const SessionScore &score)
{
    Json json = {{"scaled", std::clamp(score.total / score.of, -1.0, 1.0)}, {"raw", score.total}};
    if (score.total >= 0.0) json["min"] = 0.0;
    if (score.total <= score.of) json["max"] = score.of;
    return json;
}

Json result_of(const SessionRecord &record)
{
    Json result = Json::object();
    if (record.score) result["score"] = score_of(*record.score);
    if (record.passed) result["success"] = *record.passed;
    result["completion"] = true;
    result["duration"] = "PT" + decimals_text(record.duration_s, 2) + "S";
    result["extensions"] = {{space + "errors", record.metric("errors").value_or(0.0)}};
    for (const SessionMetric &metric : record.metrics)
        result["extensions"][space + "metric/" + iri_part(metric.name)] = metric.value;
    return result;
}

} // namespace

Json xapi_of(const std::vector<SessionRecord> &records, const std::string &home_page)
{
    Json statements = Json::array();
    for (const SessionRecord &record : records) {
        const std::int64_t begin_ms = unix_ms_of(record.started_at).value_or(0);
        Json context = {
            {"registration", uuid_of_name("xapi registration", record.id)},
            {"platform", "Cournand"},
            {"extensions", {{space + "session", record.id}, {space + "station", record.station}}}};
        if (!record.case_version.empty()) context["revision"] = record.case_version;
        if (!record.program_version.empty()) context["platform"] = "Cournand " + record.program_version;
        statements.push_back(
            {{"id", uuid_of_name("xapi statement", record.id)},
             {"actor",
              {{"objectType", "Agent"}, {"account", {{"homePage", home_page}, {"name", record.trainee}}}}},
             {"verb", verb_of(record)},
             {"object",
              {{"objectType", "Activity"},
               {"id", std::string(records_home_page) + "/case/" + iri_part(record.case_id)},
               {"definition",
                {{"name", {{"en", record.case_id}}},
                 {"type", "http://adlnet.gov/expapi/activities/simulation"}}}}},
             {"result", result_of(record)},
             {"context", context},
             {"timestamp", utc_text(begin_ms + std::llround(record.duration_s * 1000.0))}});
    }
    return statements;
}

} // namespace crn
