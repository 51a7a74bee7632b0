// Tests the score of an angioplasty, which is computed from a session's report: points between two limits,
// and the score's page.
#include "host/report/figures/score.hpp"
#include "host/report/score_page.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
extern "C" {
#include <cmocka.h>
}

namespace
{

using Json = nlohmann::ordered_json;

// Makes the report of a good result: one lesion is opened, and one well-apposed stent covers all of it.
Json good_report()
{
    return Json::parse(R"({
      "scene": "a.scene", "session": "b.session", "ticks": 600000, "hash": "0123456789abcdef",
      "tools": [{"name": "wire", "inserted_max_mm": 900.0, "handle_force_max_N": 1.5, "handle_torque_max_mN_m": 0.2}],
      "room": {"fluoroscopy_min": 3.0, "total": {"kap_Gy_cm2": 12.0}},
      "contrast": {"injected_ml": 30.0},
      "contact": {"impulse_N_s": 100.0, "force_max_N": 2.0, "time_s": [0.16, 0.32], "force_N": [1.0, 2.0]},
      "lesions": [{"name": "lad_1", "branch": "LAD", "stenosis_diameter_pct": 75.0, "minimum_diameter_mm": 0.7,
                   "ffr": 0.4, "after": {"stenosis_diameter_pct": 8.0, "reference_diameter_mm": 3.0,
                                        "minimum_diameter_mm": 2.7, "ffr": 0.93}}],
      "balloon": {"burst_s": null, "curves": {"time_s": [1.0, 1.04, 1.08], "pressure_bar": [0.0, 4.0, 8.0],
                  "diameter_max_mm": [1.0, 2.9, 3.0], "diameter_min_mm": [1.0, 2.0, 2.9],
                  "wall_force_N": [0.0, 5.0, 9.0]}},
      "stents": [{"name": "3.0 x 18", "branch": "LAD", "stage": "deployed", "is_lost": false,
                  "opened_s": 1.0, "released_s": 2.0, "apposed_pct": 99.0, "overstretch_pct": 4.0,
                  "inside_diameter_min_mm": 2.85, "area_min_mm2": 6.5, "length_now_mm": 17.8,
                  "lesions": [{"name": "lad_1", "missed_before_mm": 0.0, "missed_behind_mm": 0.0}]}]})");
}

const Json &metric(const Json &score, const std::string &name)
{
    for (const Json &one : score["metrics"])
        if (one["name"] == name) return one;
    fail_msg("no metric %s", name.c_str());
    return score;
}

double points(const Json &report, const char *name)
{
    return metric(crn::score_of(report), name)["points"].get<double>();
}

void a_good_result_has_full_marks(void **)
{
    const Json score = crn::score_of(good_report());
    assert_float_equal(score["of"].get<double>(), 100.0, 1e-9);
    assert_float_equal(score["percent"].get<double>(), 100.0, 1e-9);
}

// Points change in proportion to the value between the limits: a value of 20 % is half-way from 10 to 30 %.
void marks_fall_in_proportion_between_the_limits(void **)
{
    Json report = good_report();
    report["lesions"][0]["after"]["stenosis_diameter_pct"] = 20.0;
    assert_float_equal(points(report, "residual_stenosis_pct"), 10.0, 1e-9);
    report["lesions"][0]["after"]["stenosis_diameter_pct"] = 45.0;
    assert_float_equal(points(report, "residual_stenosis_pct"), 0.0, 1e-9);
    report["stents"][0]["apposed_pct"] = 87.5; // decreases, from 95 to 80
    assert_float_equal(points(report, "apposition_pct"), 7.5, 1e-9);
}

// Every fault in the treatment must lower the points of its own metric and must not change those of the other
// metrics.
void a_fault_is_seen_by_the_metric_that_should_notice(void **)
{
    const struct {
        const char *metric;
        void (*spoil)(Json &);
    } faults[] = {
        {"stent_expansion_pct", [](Json &r) { r["stents"][0]["area_min_mm2"] = 5.0; }},
        {"apposition_pct", [](Json &r) { r["stents"][0]["apposed_pct"] = 60.0; }},
        {"geographic_miss_mm", [](Json &r) { r["stents"][0]["lesions"][0]["missed_behind_mm"] = 3.0; }},
        {"overstretch_pct", [](Json &r) { r["stents"][0]["overstretch_pct"] = 25.0; }},
        {"mishaps", [](Json &r) { r["balloon"]["burst_s"] = 12.0; }},
        {"mishaps", [](Json &r) { r["stents"][0]["is_lost"] = true; }},
        {"contrast_ml", [](Json &r) { r["contrast"]["injected_ml"] = 160.0; }},
        {"fluoroscopy_min", [](Json &r) { r["room"]["fluoroscopy_min"] = 15.0; }},
        {"kap_Gy_cm2", [](Json &r) { r["room"]["total"]["kap_Gy_cm2"] = 90.0; }},
        {"contact_impulse_N_s", [](Json &r) { r["contact"]["impulse_N_s"] = 1800.0; }},
    };
    const Json good = crn::score_of(good_report());
    for (const auto &fault : faults) {
        Json report = good_report();
        fault.spoil(report);
        const Json score = crn::score_of(report);
        for (const Json &one : score["metrics"]) {
            const Json before = metric(good, one["name"])["points"];
            if (one["name"] == fault.metric)
                assert_true(one["points"].get<double>() < before.get<double>());
            else
                assert_true(one["points"] == before);
        }
    }
}

// The stent's struts lie on the wall, but at its narrowest ring the stent has 76 % of the healthy vessel's
// area.
void a_stent_open_at_76_percent_does_not_have_full_marks(void **)
{
    Json report = good_report();
    report["stents"][0]["area_min_mm2"] = 0.76 * 7.0685835; // of a circle of 3 mm
    const Json score = crn::score_of(report);
    assert_float_equal(metric(score, "stent_expansion_pct")["value"].get<double>(), 76.0, 1e-6);
    assert_float_equal(metric(score, "stent_expansion_pct")["points"].get<double>(), 9.75, 1e-6);
    assert_float_equal(score["percent"].get<double>(), 94.75, 1e-6);
}

void a_long_session_loses_no_marks_for_its_time(void **)
{
    Json report = good_report();
    report["ticks"] = 3000000;
    assert_float_equal(crn::score_of(report)["percent"].get<double>(), 100.0, 1e-9);
}

// The plan of an assessment may state other limits and weights than the program.
void other_limits_give_other_marks(void **)
{
    crn::ScoreLimits limits;
    limits["fluoroscopy_min"] = {1.0, 5.0, 8.0}; // the session has 3 min
    const Json score = crn::score_of(good_report(), limits);
    assert_float_equal(metric(score, "fluoroscopy_min")["points"].get<double>(), 4.0, 1e-9);
    assert_float_equal(metric(score, "fluoroscopy_min")["weight"].get<double>(), 8.0, 1e-9);
    assert_float_equal(score["of"].get<double>(), 104.0, 1e-9);
}

// A metric without a value gets no points and leaves the other metrics unchanged; here the session has a
// balloon but no stent.
void what_is_not_known_is_not_judged(void **)
{
    Json report = good_report();
    report["stents"] = Json::array();
    const Json score = crn::score_of(report);
    assert_true(metric(score, "apposition_pct")["points"].is_null());
    assert_true(metric(score, "geographic_miss_mm")["value"].is_null());
    assert_float_equal(score["of"].get<double>(), 45.0, 1e-9);
    assert_float_equal(score["percent"].get<double>(), 100.0, 1e-9);
    assert_true(crn::score_of(Json::object())["percent"].is_null());
    report["lesions"] = Json::array(); // nothing to treat
    assert_true(crn::score_of(report)["percent"].is_null());
}

// One stent covers one end of a lesion and a second stent the other end, so no part of the lesion counts as
// uncovered.
void stents_cover_a_lesion_together(void **)
{
    Json report = good_report();
    report["stents"].push_back(report["stents"][0]);
    report["stents"][0]["lesions"][0]["missed_behind_mm"] = 6.0;
    report["stents"][1]["lesions"][0]["missed_before_mm"] = 5.0;
    assert_float_equal(metric(crn::score_of(report), "geographic_miss_mm")["value"].get<double>(), 0.0, 1e-9);
}

bool has(const std::string &page, const std::string &text)
{
    return page.find(text) != std::string::npos;
}

void the_page_stands_alone(void **)
{
    Json report = good_report();
    report["tools"][0]["name"] = "<b>\"wire\" & co";
    const crn::Image image{2, 2, 1, {0, 64, 128, 255}};
    const std::string page = crn::score_page(report, crn::score_of(report), {{"Run 1", image}});
    assert_true(has(page, "&lt;b&gt;&quot;wire&quot; &amp; co") && !has(page, "<b>"));
    assert_true(has(page, ">100</span> of 100"));
    assert_true(has(page, "data:image/png;base64,iVBORw0KGgo")); // a PNG's first bytes
    assert_true(has(page, "Pressure, bar") && has(page, "Force of the wall on the line") &&
                has(page, "<path"));
    assert_false(has(page, "http") || has(page, "<script"));
    assert_true(has(crn::score_page(report, crn::score_of(report), {}), "</html>"));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_good_result_has_full_marks),
                                cmocka_unit_test(marks_fall_in_proportion_between_the_limits),
                                cmocka_unit_test(a_fault_is_seen_by_the_metric_that_should_notice),
                                cmocka_unit_test(a_stent_open_at_76_percent_does_not_have_full_marks),
                                cmocka_unit_test(a_long_session_loses_no_marks_for_its_time),
                                cmocka_unit_test(other_limits_give_other_marks),
                                cmocka_unit_test(what_is_not_known_is_not_judged),
                                cmocka_unit_test(stents_cover_a_lesion_together),
                                cmocka_unit_test(the_page_stands_alone)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
