// Writes the figures of a session as JSON.
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/effects/lesion_figures.hpp"
#include "host/report/figures/report_angioplasty.hpp"
#include "host/report/figures/report_complications.hpp"
#include "host/report/figures/score.hpp"
#include "host/session/run.hpp"
#include <cmath>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

const char *name_of(RunKind kind)
{
    return kind == RunKind::fluoro ? "fluoroscopy" : kind == RunKind::cine ? "cine" : "dsa";
}

nlohmann::ordered_json dose_report(const Dose &dose)
{
    return {{"pulses", dose.pulses},
            {"beam_s", dose.beam_ticks * 1e-3},
            {"reference_air_kerma_mGy", dose.air_kerma_uGy * 1e-3},
            {"kap_Gy_cm2", dose.kap_Gy_cm2}};
}

// Reports the X-ray dose in total and for every press of a pedal, and the stored runs.
nlohmann::ordered_json room_report(const Room &room)
{
    nlohmann::ordered_json report;
    const DoseMeter &dose = room.dose();
    report["total"] = dose_report(dose.total());
    report["fluoroscopy_min"] = dose.fluoro_ticks() / 60e3;
    report["dose_alerts_passed"] = dose.alerts_passed();
    report["fluoroscopy_reminders_passed"] = dose.fluoro_reminders();
    report["irradiations"] = nlohmann::ordered_json::array();
    for (const Irradiation &one : dose.irradiations()) {
        nlohmann::ordered_json entry = {{"kind", name_of(one.kind)},
                                        {"run", one.run},
                                        {"begin_s", one.tick_begin * 1e-3},
                                        {"end_s", one.tick_end * 1e-3},
                                        {"pulses_per_s", one.pulses_per_s},
                                        {"primary_deg", one.carm.primary_deg},
                                        {"secondary_deg", one.carm.secondary_deg},
                                        {"sid_cm", one.carm.source_detector_m * 100.0},
                                        {"field_cm", one.carm.field_m * 100.0},
                                        {"tube_voltage_kV", one.tube_voltage_kV},
                                        {"tube_current_mA", one.tube_current_mA},
                                        {"pulse_ms", one.pulse_ms}};
        entry.update(dose_report(one.dose));
        report["irradiations"].push_back(entry);
    }
    report["runs"] = nlohmann::ordered_json::array();
    for (const RoomRun &run : room.runs())
        report["runs"].push_back(
            {{"number", run.number}, {"kind", name_of(run.kind)}, {"frames", run.frames}});
    return report;
}

// Reports how much iodine each vessel branch received, as a fraction of all the iodine that was injected.
nlohmann::ordered_json branches_report(const PatientContrast &contrast)
{
    nlohmann::ordered_json report = nlohmann::ordered_json::array();
    const double injected_mg = contrast.flow().budget().injected_mg;
    const std::vector<double> received_mg = contrast.flow().received_mg();
    for (std::size_t b = 0; b < received_mg.size(); b++)
        report.push_back({{"name", contrast.vessels().branches[b].name},
                          {"received_mg", received_mg[b]},
                          {"share_pct", injected_mg > 0.0 ? 100.0 * received_mg[b] / injected_mg : 0.0}});
    return report;
}

// Reports the position of a tool's tip in the vessels, or null if the position is not known.
nlohmann::ordered_json tip_report(const std::vector<TipPlace> &tips, std::size_t tool)
{
    if (tool >= tips.size() || !tips[tool].is_known) return {};
    const TipPlace &tip = tips[tool];
    return {{"branch", tip.vessel},
            {"along_mm", tip.place.along_m * 1e3},
            {"inside_mm", tip.inside_m * 1e3},
            {"position_mm", {tip.at_m.x() * 1e3, tip.at_m.y() * 1e3, tip.at_m.z() * 1e3}}};
}

// Adds to the report the vessels into which the script steered a tool, and the script's expectations with
// their results.
void report_goals(nlohmann::ordered_json &report, const RunResult &result)
{
    report["steered"] = nlohmann::ordered_json::array();
    for (const SteeringResult &steered : result.steered)
        report["steered"].push_back({{"line", steered.line},
                                     {"tool", steered.tool + 1},
                                     {"branch", steered.vessel},
                                     {"tries", steered.tries},
                                     {"seconds", steered.ticks * 1e-3},
                                     {"reached", steered.is_reached}});
    report["expected"] = nlohmann::ordered_json::array();
    for (const ExpectationResult &expected : result.expected)
        report["expected"].push_back({{"line", expected.line},
                                      {"at_s", expected.tick * 1e-3},
                                      {"text", expected.text},
                                      {"held", expected.is_held},
                                      {"found", expected.found}});
    report["failures"] = result.failures;
}

// Reports where the injected iodine is at the end of the session.
nlohmann::ordered_json contrast_report(const PatientContrast &contrast)
{
    const ContrastFlow &flow = contrast.flow();
    const IodineBudget &budget = flow.budget();
    const DistalIodine distal = flow.distal().iodine();
    const double lost_mg = budget.injected_mg - flow.held_mg() - flow.distal().held_mg() - distal.gone_mg -
                           budget.reflux_mg - budget.leaked_mg;
    const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };
    return {{"injected_ml", contrast.injected_ml()},
            {"iodine_injected_mg", budget.injected_mg},
            {"iodine_in_vessels_mg", flow.held_mg()},
            {"iodine_out_mg", budget.out_mg},
            {"iodine_reflux_mg", budget.reflux_mg},
            {"iodine_small_vessels_mg", distal.small_mg},
            {"iodine_beds_mg", distal.beds_mg},
            {"iodine_veins_mg", distal.veins_mg},
            {"iodine_gone_mg", distal.gone_mg},
            {"iodine_leaked_mg", budget.leaked_mg},
            {"iodine_error", ratio(std::fabs(lost_mg), budget.injected_mg)},
            {"branches", branches_report(contrast)},
            {"cells", flow.cells().size()}};
}

nlohmann::ordered_json lesion_report(const LesionFigures &f)
{
    return {{"minimum_diameter_mm", f.minimum_diameter_mm},
            {"reference_diameter_mm", f.reference_diameter_mm},
            {"stenosis_diameter_pct", f.diameter_percent()},
            {"stenosis_area_pct", f.area_percent()},
            {"rest_flow_ml_min", f.rest_flow_ml_s * 60.0},
            {"rest_drop_mmHg", f.rest_drop_mmHg},
            {"hyperaemic_flow_ml_min", f.hyperaemic_flow_ml_s * 60.0},
            {"hyperaemic_drop_mmHg", f.hyperaemic_drop_mmHg},
            {"ffr", f.ffr},
            {"ffr_flow", f.is_coronary ? "hyperaemic" : "resting"}};
}

// Reports for each lesion how narrow it is, and its effect on the blood flow at rest and in hyperaemia.
// Reports the values for the lesion as it is in the scene file and, under "after", the values at the end of
// the session.
nlohmann::ordered_json lesions_report(const PatientContrast &contrast)
{
    nlohmann::ordered_json report = nlohmann::ordered_json::array();
    const double viscosity_mPa_s = ContrastSettings{}.viscosity_mPa_s;
    const VesselTree opened = contrast.opened_vessels();
    const std::vector<LesionFigures> before = lesion_figures(contrast.vessels(), viscosity_mPa_s),
                                     after = lesion_figures(contrast.vessels(), viscosity_mPa_s, &opened);
    for (std::size_t i = 0; i < before.size(); ++i) {
        nlohmann::ordered_json entry = {
            {"name", before[i].name}, {"branch", before[i].branch}, {"length_mm", before[i].length_mm}};
        entry.update(lesion_report(before[i]));
        entry["after"] = lesion_report(after[i]);
        report.push_back(entry);
    }
    return report;
}

// It is null where contacts cannot be read: on a rig in FREE_RUN.
nlohmann::ordered_json contact_report(const ContactFigures &contacts)
{
    if (!contacts.is_known) return {};
    nlohmann::ordered_json time = nlohmann::ordered_json::array(), force = time;
    for (const ContactSample &sample : contacts.series) {
        time.push_back(sample.tick * 1e-3);
        force.push_back(sample.force_N);
    }
    return {{"impulse_N_s", contacts.impulse_N_s},
            {"force_max_N", contacts.force_max_N},
            {"time_s", time},
            {"force_N", force}};
}

// Reports on the hand that a script moves: the largest force and torque that its grip can hold, and how far
// the tool slipped in the grip.
nlohmann::ordered_json grip_report(const GripFigures &grip)
{
    nlohmann::ordered_json first;
    if (grip.first_tick) first = *grip.first_tick;
    return {{"force_limit_N", HandGrip::force_limit_N},
            {"torque_limit_mN_m", HandGrip::torque_limit_mN_m},
            {"slipped_mm", grip.slipped_mm},
            {"slipped_deg", grip.slipped_deg},
            {"first_slip_tick", first}};
}

// Reports the pressure that the catheter measured, or null if no catheter could measure one.
nlohmann::ordered_json catheter_pressure_report(const Patient &patient)
{
    const CatheterPressure &pressure = patient.catheter_pressure();
    if (pressure.tool_name().empty()) return {};
    const auto seconds_of = [](const std::vector<std::uint32_t> &ticks) {
        nlohmann::ordered_json seconds = nlohmann::ordered_json::array();
        for (const std::uint32_t tick : ticks) seconds.push_back(tick * 1e-3);
        return seconds;
    };
    return {{"tool", pressure.tool_name()},
            {"damped_s", pressure.damped_ticks() * 1e-3},
            {"injected_while_damped_at_s", seconds_of(patient.damped_injections())},
            {"injected_unaspirated_at_s", seconds_of(patient.catheter_air().injections())}};
}

} // namespace

nlohmann::ordered_json report_of(const RunResult &result, const std::string &scene,
                                 const std::vector<Instrument> &tools, const std::string &session,
                                 Patient &patient)
{
    const PatientContrast &contrast = patient.contrast();
    const SessionFigures &figures = result.figures;
    const std::string hash = hex_text(result.hash);
    nlohmann::ordered_json report;
    report["scene"] = scene;
    report["session"] = session;
    report["ticks"] = figures.ticks;
    report["hash"] = hash;
    report["penetration_max_mm"] = figures.penetration_max_m * 1e3;
    report["penetration_max_tick"] = figures.penetration_max_tick;
    report["length_error_max_pct"] = figures.strain_max * 1e2;
    report["length_error_max_tick"] = figures.strain_max_tick;
    report["range"] = range_report(figures.range.left());
    report["contacts_max"] = figures.contact_count_max;
    report["tip"] = tip_report(result.tips, 0);        // of the innermost tool
    report["tools"] = nlohmann::ordered_json::array(); // from the innermost to the outermost
    for (std::size_t k = 0; k < tools.size(); k++) {
        const ToolFigures tool = k < figures.tools.size() ? figures.tools[k] : ToolFigures{};
        const GripFigures grip = k < result.grips.size() ? result.grips[k] : GripFigures{};
        report["tools"].push_back({{"name", tools[k].name},
                                   {"inserted_mm", tool.inserted_m * 1e3},
                                   {"inserted_max_mm", tool.inserted_max_m * 1e3},
                                   {"handle_force_max_N", tool.axial_max_N},
                                   {"handle_torque_max_mN_m", tool.torque_max_N_m * 1e3},
                                   {"grip", grip_report(grip)},
                                   {"tip", tip_report(result.tips, k)}});
    }
    const HeartFigures &heart = figures.heart;
    report["heart"] = {{"beats", heart.monitor.beats()},
                       {"premature_beats", heart.monitor.premature_beats()},
                       {"last_rate_per_min", heart.monitor.rate_per_min()},
                       {"aortic_pressure_max_mmHg", heart.pressure_max_mmHg},
                       {"aortic_pressure_min_mmHg", heart.pressure_min_mmHg}};
    report["catheter_pressure"] = catheter_pressure_report(patient);
    report["room"] = room_report(patient.room());
    report["contrast"] = contrast.was_used() ? contrast_report(contrast) : nlohmann::ordered_json();
    report["lesions"] = lesions_report(contrast);
    report["balloon"] = balloon_report(figures.balloon, patient.table());
    report["stents"] = stents_report(patient.stents());
    report["contact"] = contact_report(result.contacts);
    if (result.contacts.wall_way_max_m + result.contacts.wall_widened_max_m > 0.0)
        report["walls"] = {{"way_max_mm", result.contacts.wall_way_max_m * 1e3},
                           {"way_max_tick", result.contacts.wall_way_max_tick},
                           {"widened_max_mm", result.contacts.wall_widened_max_m * 1e3}};
    report["complications"] = complications_report(patient);
    report["interrupted"] = result.was_interrupted;
    report["script_lines_given_up"] = result.given_up_lines;
    report["refused"] = nlohmann::ordered_json::array();
    for (const Refusal &refusal : patient.refusals())
        report["refused"].push_back({{"at_s", refusal.tick * 1e-3}, {"why", refusal.why}});
    report_goals(report, result);
    report["faults"] = nlohmann::ordered_json::array();
    for (std::uint16_t i = 0; i < result.faults.entries_count; i++) {
        const crn_wire_fault_entry &fault = result.faults.entries[i];
        report["faults"].push_back({{"name", crn_wire_fault_name(fault.code)},
                                    {"tick_first", fault.tick_first},
                                    {"count", fault.count},
                                    {"text", crn_wire_fault_text(fault.code)}});
    }
    report["score"] = score_of(report);
    return report;
}

nlohmann::ordered_json timing_of(const RunResult &result, const Patient &patient)
{
    const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };
    const ContrastCost &cost = patient.contrast().cost();
    return {{"ticks", result.figures.ticks},
            {"wall_clock_s", result.seconds},
            {"realtime_factor", ratio(result.figures.ticks * 1e-3, result.seconds)},
            {"contrast_steps", cost.steps},
            {"contrast_frames", cost.frames},
            {"contrast_step_us", ratio(cost.step_s * 1e6, static_cast<double>(cost.steps))},
            {"contrast_frame_ms", ratio(cost.frame_s * 1e3, static_cast<double>(cost.frames))},
            {"contrast_share_of_wall_clock", ratio(cost.step_s + cost.frame_s, result.seconds)}};
}

std::string report_text(const nlohmann::ordered_json &report)
{
    return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_report(const std::string &path, const nlohmann::ordered_json &report)
{
    write_whole_file(path, report_text(report));
}

} // namespace crn
