#include "host/report/figures/report_complications.hpp"
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

Json event_of(const Injury &injury, const ComplicationLimits &limits)
{
    const bool is_hole = injury.kind == InjuryKind::perforation;
    return {{"kind", is_hole ? "perforation" : "dissection"},
            {"class", injury_class(injury, limits)},
            {"cause", injury.cause == InjuryCause::tip ? "tip" : "balloon"},
            {"at_s", injury.tick * 1e-3},
            {"vessel", injury.vessel},
            {"tool", injury.tool},
            {"value", injury.value},
            {"limit", injury.limit},
            {"unit", injury.unit()},
            {"force_N", injury.cause == InjuryCause::tip ? Json(injury.force_N) : Json()},
            {"position_mm", {injury.place_m.x() * 1e3, injury.place_m.y() * 1e3, injury.place_m.z() * 1e3}},
            {is_hole ? "hole_mm" : "flap_mm", injury.size_mm}};
}

// Adds what an injury has done to the blood and the medium since then. A wound that the flow has not taken up
// before the session's end has done nothing.
void add_wound(Json &event, const Injury &injury, const Wounds &wounds)
{
    if (injury.kind == InjuryKind::dissection) {
        event["narrowing_pct"] = 100.0 * injury.narrowing;
        event["pocket_mg_per_ml"] =
            injury.wound < wounds.flaps().size() ? wounds.flaps()[injury.wound].pocket_mg_per_ml() : 0.0;
        return;
    }
    const WallHole hole = injury.wound < wounds.holes().size() ? wounds.holes()[injury.wound] : WallHole();
    event["conductance_ml_s_per_mmHg"] = hole.ml_s_per_mmHg;
    event["blood_loss_ml"] = hole.leaked_ml;
    event["flow_ml_min_at_the_end"] = 60.0 * hole.flow_ml_s;
    event["iodine_in_tissue_mg"] = hole.iodine_mg;
    event["closed_pct"] = 100.0 * (1.0 - hole.open_share());
}

} // namespace

Json complications_report(const Patient &patient)
{
    const PatientComplications &complications = patient.complications();
    const ContrastFlow &flow = patient.contrast().flow();
    Json report = {{"is_on", complications.limits().is_on},
                   {"count", complications.injuries().size()},
                   {"perforations", complications.count(InjuryKind::perforation)},
                   {"dissections", complications.count(InjuryKind::dissection)},
                   {"blood_loss_ml", flow.wounds().leaked_ml()},
                   {"around_heart_ml", complications.lost_around_heart_ml(flow)},
                   {"arterial_pressure_left_pct", 100.0 * complications.pressure_left(flow)},
                   {"events", Json::array()}};
    for (const Injury &injury : complications.injuries()) {
        Json event = event_of(injury, complications.limits());
        add_wound(event, injury, flow.wounds());
        report["events"].push_back(event);
    }
    return report;
}

} // namespace crn
