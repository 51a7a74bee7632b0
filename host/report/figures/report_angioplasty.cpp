#include "host/report/figures/report_angioplasty.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/stents.hpp"
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

Json seconds_or_null(const std::optional<std::uint32_t> &tick)
{
    return tick ? Json(*tick * 1e-3) : Json();
}

// Keeps the samples of the balloon's curves while the balloon is under pressure, and one sample before and
// after that time.
Json curves(const std::vector<BalloonSample> &series)
{
    Json time = Json::array(), pressure = time, widest = time, narrowest = time, wall = time;
    const auto has_pressure = [&](std::size_t i) { return i < series.size() && series[i].pressure_kPa > 0; };
    for (std::size_t i = 0; i < series.size(); i++) {
        if (!has_pressure(i) && !has_pressure(i + 1) && (i == 0 || !has_pressure(i - 1))) continue;
        const BalloonSample &sample = series[i];
        time.push_back(sample.tick * 1e-3);
        pressure.push_back(sample.pressure_kPa * 1e-2);
        widest.push_back(sample.diameter_max_mm);
        narrowest.push_back(sample.diameter_min_mm);
        wall.push_back(sample.wall_N);
    }
    return {{"time_s", time},
            {"pressure_bar", pressure},
            {"diameter_max_mm", widest},
            {"diameter_min_mm", narrowest},
            {"wall_force_N", wall}};
}

Json stent_report(const StentResult &stent)
{
    const StentFigures &figures = stent.figures;
    Json report = {{"name", stent.name},
                   {"diameter_mm", stent.diameter_mm},
                   {"length_mm", stent.length_mm},
                   {"stage", stent.was_taken_out ? "taken out" : stent_stage_text(stent.stage)},
                   {"is_lost", stent.stage == StentStage::stripped || stent.stage == StentStage::adrift},
                   {"loaded_s", stent.loaded_tick * 1e-3},
                   {"opened_s", seconds_or_null(stent.opened_tick)},
                   {"released_s", seconds_or_null(stent.released_tick)},
                   {"branch", stent.branch.empty() ? Json() : Json(stent.branch)}};
    if (figures.rings.empty()) return report; // it was never in the patient
    double sum_mm = 0.0;
    for (const StentRing &ring : figures.rings) sum_mm += ring.diameter_mm;
    report["apposed_pct"] = figures.apposed_share * 1e2;
    report["struts_off_the_wall"] = figures.gaps.size();
    report["inside_diameter_min_mm"] = figures.diameter_min_mm;
    report["inside_diameter_mean_mm"] = sum_mm / static_cast<double>(figures.rings.size());
    report["area_min_mm2"] = figures.area_min_mm2;
    report["length_now_mm"] = figures.length_mm;
    report["foreshortening_pct"] = figures.foreshortening * 1e2;
    report["rings_not_opened"] = figures.unopened_rings;
    report["slid_on_balloon_mm"] = stent.slip_mm;
    report["overstretch_pct"] = stent.stretch * 1e2;
    report["overlap_mm"] = stent.overlap_mm;
    report["lesions"] = Json::array();
    for (const StentResult::Lesion &lesion : stent.lesions)
        report["lesions"].push_back({{"name", lesion.name},
                                     {"stent_from_mm", lesion.coverage.from_mm},
                                     {"stent_to_mm", lesion.coverage.to_mm},
                                     {"missed_before_mm", lesion.coverage.missed_before_mm},
                                     {"missed_behind_mm", lesion.coverage.missed_behind_mm},
                                     {"geographic_miss", lesion.coverage.misses()}});
    return report;
}

struct BalloonPeak {
    Instrument tool;
    double pressure_kPa = 0.0, tick = 0.0;
    double above_kPa() const { return pressure_kPa - (tool.balloon ? tool.balloon->rated_burst_kPa : 0.0); }
};

// Returns the highest pressure of the balloon that came nearest to its rated burst pressure or exceeded it
// the most. Several balloons may be used in a session, one after the other.
std::optional<BalloonPeak> gravest_peak(const BalloonFigures &balloon, const std::vector<Instrument> &table)
{
    std::optional<BalloonPeak> gravest;
    for (const BalloonFigures::Peak &peak : balloon.peaks) {
        const std::vector<Instrument> tools = tools_on(table, line_or_table(peak.line, table.size()));
        const std::optional<std::size_t> tool = balloon_tool(tools);
        if (!tool) continue;
        const BalloonPeak found{tools[*tool], double(peak.pressure_kPa), double(peak.tick)};
        if (!gravest || found.above_kPa() > gravest->above_kPa()) gravest = found;
    }
    return gravest;
}

} // namespace

Json balloon_report(const BalloonFigures &balloon, const std::vector<Instrument> &table)
{
    const std::optional<BalloonPeak> peak = gravest_peak(balloon, table);
    if (!peak) return {};
    Json report = {{"tool", peak->tool.name},
                   {"pressure_max_bar", peak->pressure_kPa * 1e-2},
                   {"pressure_max_s", peak->tick * 1e-3},
                   {"diameter_max_mm", balloon.diameter_max_mm},
                   {"wall_force_max_N", balloon.wall_max_N},
                   {"inflations", balloon.inflations},
                   {"up_s", balloon.ticks_up * 1e-3},
                   {"up_longest_s", balloon.ticks_up_longest * 1e-3},
                   {"burst_s", seconds_or_null(balloon.burst_tick)}};
    const std::optional<BalloonLabel> &label = peak->tool.balloon;
    if (label) {
        report["nominal_bar"] = label->nominal_kPa * 1e-2;
        report["rated_burst_bar"] = label->rated_burst_kPa * 1e-2;
        report["above_rated_burst"] = peak->pressure_kPa > label->rated_burst_kPa;
    }
    report["curves"] = curves(balloon.series);
    return report;
}

Json stents_report(PatientStents *stents)
{
    Json report = Json::array();
    if (!stents) return report;
    for (const StentResult &stent : stents->results()) report.push_back(stent_report(stent));
    return report;
}

} // namespace crn
