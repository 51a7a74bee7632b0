// Reports the injuries of vessels in a session (docs/complications.md).
#pragma once
#include "host/patient/patient.hpp"
#include <nlohmann/json_fwd.hpp>

namespace crn
{

// Returns {"is_on", "count", "perforations", "dissections", "blood_loss_ml", "around_heart_ml",
// "arterial_pressure_left_pct", "events": [{"kind", "class", "cause", "at_s", "vessel", "tool", "value",
// "limit", "unit", "force_N", "position_mm", "size_mm", ...}]}.
nlohmann::ordered_json complications_report(const Patient &patient);

} // namespace crn
