// Makes records of sessions for the tests of host/records.
#pragma once
#include "host/records/identity.hpp"
#include "host/records/record.hpp"
#include <string>

namespace crn
{

inline constexpr std::int64_t sample_begin_ms = 1795000000000; // 18 November 2026

// Makes session `number` of this trainee: trainee and number determine the session's id, and the session has
// three metrics and four events.
inline SessionRecord sample_record(const std::string &trainee, int number, double score = 70.0)
{
    SessionRecord record;
    record.id = uuid_of_name("sample", trainee + " " + std::to_string(number));
    record.trainee = trainee;
    record.case_id = "lad_pci";
    record.case_version = "1";
    record.core_version = "27";
    record.program_version = "0.9.0";
    record.started_at = utc_text(sample_begin_ms + number * std::int64_t{3600000});
    record.duration_s = 723.25 - number % 500;
    record.seed = 0xfedcba9876543210u + static_cast<std::uint64_t>(number);
    record.state_hash = "0123456789abcdef";
    record.passed = score >= 80.0;
    record.score =
        SessionScore{score, 100.0, {{"result", score / 2.0, 50.0}, {"handling", score / 2.0, 50.0}}};
    record.metrics = {{"fluoroscopy_min", 12.5 - 0.01 * (number % 500), "min"},
                      {"kap_Gy_cm2", 31.0, "Gy cm²"},
                      {"contrast_ml", 80.0, "ml"}};
    record.events = {{1000, "phase_access", 0, "sheath"},
                     {20000, "moved_without_xray", 3, "wire, 12 mm"},
                     {21000, "moved_without_xray", 3, "wire, 4 mm"},
                     {90000, "guide_deep", 4, ""}};
    return record;
}

} // namespace crn
