// Tests how errors, phases and the score are computed from the moments of a session. The test writes the
// sessions moment by moment, so every expected tick is known.
#include "host/assess/assessment.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
extern "C" {
#include <cmocka.h>
}

namespace
{

using Json = nlohmann::ordered_json;

// Returns a session of 10 s with one wire and one straight vessel; `change` sets what happens at each moment.
crn::SessionLog session(const std::function<void(double s, crn::SessionMoment &)> &change)
{
    crn::SessionLog log;
    crn::VesselTree tree;
    tree.branches.push_back({"artery", -1, 0, {{0, 0, 0}, {0, 0.2, 0}}, {1.5e-3, 1.5e-3}});
    log.map = crn::VesselMap(tree);
    log.tools = {"wire"};
    for (std::uint32_t tick = 0; tick <= 10000; tick += crn::SessionLog::every_ticks) {
        crn::SessionMoment moment;
        moment.tick = tick;
        moment.tools[0].has_tip = moment.tools[0].has_place = moment.tools[0].is_in_picture = true;
        change(tick * 1e-3, moment);
        log.moments.push_back(moment);
    }
    log.ticks = 10000;
    return log;
}

crn::Condition condition(const char *text)
{
    return crn::Condition::parse(text, "test", 1, 1);
}

crn::AssessPlan plan_with(const char *when, double for_s, double again_s,
                          crn::Severity severity = crn::Severity::moderate)
{
    crn::AssessPlan plan;
    plan.name = plan.title = "test";
    crn::PlanError error;
    error.name = error.title = "error";
    error.when = condition(when);
    error.severity = severity;
    error.for_s = for_s;
    error.again_s = again_s;
    plan.errors.push_back(error);
    return plan;
}

Json report()
{
    return Json::parse(
        R"({"scene": "s", "session": "t", "ticks": 10000, "hash": "00", "lesions": [], "stents": [],
                           "balloon": null, "contrast": null, "contact": null,
                           "room": {"fluoroscopy_min": 0.1, "total": {"kap_Gy_cm2": 0.1}}})");
}

void an_error_counts_when_its_condition_has_lasted(void **)
{
    const crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.is_xray_on = !((s >= 2.0 && s < 2.3) || (s >= 5.0 && s < 6.0));
    });
    const crn::Evaluation found = crn::evaluate(plan_with("not x-ray on", 0.5, 1.0), log);
    assert_int_equal(found.errors.size(), 1); // the 0.3 s are too short
    assert_in_range(found.errors[0].begin_tick, 5000, 5016);
    assert_in_range(found.errors[0].end_tick, 5968, 6000);
    assert_float_equal(found.lost_marks, 3.0, 0.0);
}

void an_error_counts_again_only_after_a_pause(void **)
{
    const auto flicker = [](double pause_s) {
        return session([pause_s](double s, crn::SessionMoment &moment) {
            moment.is_xray_on = s < 2.0 || (s >= 3.0 && s < 3.0 + pause_s) || s >= 4.0 + pause_s;
        });
    };
    const crn::AssessPlan plan = plan_with("not x-ray on", 0.2, 1.0);
    assert_int_equal(crn::evaluate(plan, flicker(0.5)).errors.size(), 1);
    assert_int_equal(crn::evaluate(plan, flicker(1.5)).errors.size(), 2);
}

void errors_beyond_the_limit_are_listed_and_do_not_count(void **)
{
    const crn::SessionLog log = session(
        [](double s, crn::SessionMoment &moment) { moment.is_xray_on = static_cast<int>(s) % 2 == 0; });
    crn::AssessPlan plan = plan_with("not x-ray on", 0.1, 0.5, crn::Severity::serious);
    plan.errors[0].at_most = 2;
    const crn::Evaluation found = crn::evaluate(plan, log);
    assert_int_equal(found.errors.size(), 5);
    assert_float_equal(found.lost_marks, 8.0, 0.0);
    assert_true(found.errors[1].counts && !found.errors[2].counts);
}

void a_rule_for_a_tool_that_is_not_there_does_not_apply(void **)
{
    const crn::SessionLog log = session([](double, crn::SessionMoment &) {});
    for (const char *text :
         {"guide moves", "balloon above 2 bar", "stent lost", "tip wire off the way", "tip wire in target",
          "wall force at least 1 N", "x-ray on and catheter moves"}) {
        const crn::Evaluation found = crn::evaluate(plan_with(text, 0.0, 1.0), log);
        if (found.why_not[0].empty()) fail_msg("'%s' applies", text);
    }
    assert_string_equal(crn::evaluate(plan_with("x-ray on", 0.0, 1.0), log).why_not[0].c_str(), "");
}

void an_unknown_vessel_is_refused_with_a_suggestion(void **)
{
    const crn::SessionLog log = session([](double, crn::SessionMoment &) {});
    try {
        crn::evaluate(plan_with("tip wire in artrey", 0.0, 1.0), log);
        fail_msg("a plan with an unknown vessel was accepted");
    } catch (const crn::FileError &error) {
        assert_non_null(
            std::strstr(error.what(), "test:1:13: the scene has no vessel 'artrey', did you mean 'artery'"));
    }
}

// A wire inside a catheter, behind the catheter's tip, counts as out of sight only if the catheter's tip is
// out of sight. In this test the wire moves below the edge of the picture from 2 s on. The catheter's tip is
// ahead of the wire and visible in the first case, ahead and not visible in the second, and visible but
// behind in the third.
void a_wire_inside_a_catheter_is_watched_by_the_catheters_tip(void **)
{
    const auto errors = [](bool has_catheter, bool is_catheter_shown, double ahead_mm) {
        crn::SessionLog log = session([&](double s, crn::SessionMoment &moment) {
            moment.is_xray_on = true;
            moment.tools[0].is_in_picture = s < 2.0;
            moment.tools[0].tip_mm.y() = 20.0 * s; // 20 mm/s
            moment.tools[1].has_tip = true;
            moment.tools[1].is_in_picture = is_catheter_shown;
            moment.tools[1].ahead_mm = ahead_mm;
        });
        if (has_catheter) log.tools.push_back("catheter");
        int found = 0;
        for (const crn::FoundError &error : crn::evaluate(crn::standard_plan(false), log).errors)
            found += crn::standard_plan(false).errors[error.kind].name == "tip_out_of_picture";
        return found;
    };
    assert_int_equal(errors(true, true, 30.0), 0);
    assert_int_equal(errors(true, false, 30.0), 1);
    assert_int_equal(errors(true, true, -30.0), 1);
    assert_int_equal(errors(false, true, 30.0), 1); // without a catheter, the rule is that of the wire
}

// The signal of the pressure transducer, not the geometry, decides whether the pressure is damped; here it is
// damped from 2 s to 4 s.
void an_injection_while_the_pressure_is_damped_is_found(void **)
{
    crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.is_pressure_damped = s >= 2.0 && s < 4.0;
        moment.is_injecting = s >= 3.0 && s < 6.0;
    });
    const crn::AssessPlan plan = plan_with("injecting and pressure damped", 0.1, 3.0);
    assert_string_equal(crn::evaluate(plan, log).why_not[0].c_str(), "no device of the session has a lumen");
    log.has_transducer = true;
    const crn::Evaluation found = crn::evaluate(plan, log);
    assert_int_equal(found.errors.size(), 1);
    assert_in_range(found.errors[0].begin_tick, 3000, 3016);
}

// The test makes two injections while the lumen may contain air; the second injection continues to the end.
void each_injection_without_aspiration_is_one_error(void **)
{
    crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.unaspirated_injections = (s >= 2.0) + (s >= 5.0);
        moment.is_injecting = s >= 5.0;
    });
    log.has_transducer = true;
    const crn::Evaluation found = crn::evaluate(plan_with("unaspirated injection begins", 0.0, 1.0), log);
    assert_int_equal(found.errors.size(), 2);
    assert_in_range(found.errors[0].begin_tick, 2000, 2016);
    assert_in_range(found.errors[1].begin_tick, 5000, 5016);
}

// From 2 s to 6 s no wire is in the vessels; another tool moves from 4 s on.
void a_move_while_no_wire_is_on_the_line_is_found(void **)
{
    const crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.has_wire = s < 2.0 || s >= 6.0;
        moment.tools[0].inserted_mm = 10.0 * std::max(s - 4.0, 0.0);
    });
    const crn::Evaluation found =
        crn::evaluate(plan_with("line without wire and tool 1 moves", 0.0, 1.0), log);
    assert_int_equal(found.errors.size(), 1);
    assert_in_range(found.errors[0].begin_tick, 4000, 4100); // the speed is a mean over 160 ms
    assert_in_range(found.errors[0].end_tick, 5968, 6000);
}

// The hand pushes 40 mm in 4 s; the tip stops after 20 mm. The rule must report the stuck tip after 15 mm of
// further pushing.
void a_push_against_a_fixed_tip_is_found(void **)
{
    const crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        crn::ToolMoment &wire = moment.tools[0];
        wire.inserted_mm = 10.0 * std::min(s, 4.0);
        wire.tip_mm = {0.0, std::min(wire.inserted_mm, 20.0), 0.0};
    });
    const crn::Evaluation found =
        crn::evaluate(plan_with("tip wire fixed at least 15 mm and wire advances", 0.0, 1.0), log);
    assert_int_equal(found.errors.size(), 1);
    assert_in_range(found.errors[0].begin_tick, 3200, 3600); // the tip's last 2 mm still count as fixed
}

void phases_follow_each_other_and_their_steps_lie_in_them(void **)
{
    const crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.tools[0].inserted_mm = moment.tools[0].inside_mm = 10.0 * s;
        moment.is_xray_on = s < 3.0;
        moment.injected_ml = s < 6.0 ? 0.0 : 2.0;
    });
    crn::AssessPlan plan;
    plan.phases.push_back({"one", "One", {}, condition("wire inserted at least 20 mm"), 1.0, {}});
    plan.phases.back().steps.push_back({"X-ray", condition("x-ray on"), 1.0});
    plan.phases.push_back({"two", "Two", {}, condition("tip wire in artery at least 50 mm"), 1.0, {}});
    plan.phases.back().steps.push_back({"contrast", condition("injected at least 1 ml"), 1.0});
    plan.phases.push_back({"three", "Three", {}, condition("wire inserted at least 500 mm"), 1.0, {}});
    plan.phases.push_back({"four", "Four", {}, condition("x-ray on"), 1.0, {}});
    const crn::Evaluation found = crn::evaluate(plan, log);
    assert_in_range(*found.phases[0].end_tick, 2000, 2016);
    assert_int_equal(*found.phases[0].steps[0].done_tick, 0);
    assert_int_equal(*found.phases[1].begin_tick, *found.phases[0].end_tick);
    assert_in_range(*found.phases[1].end_tick, 5000, 5016);
    assert_false(found.phases[1].steps[0].done_tick.has_value()); // the contrast medium came after the phase
    assert_true(found.phases[2].begin_tick && !found.phases[2].end_tick);
    assert_false(found.phases[3].begin_tick.has_value()); // the phase before it has not ended
}

double percent(const crn::AssessPlan &plan, const crn::SessionLog &log)
{
    return crn::assessment_of(plan, log, report())["score"]["percent"].get<double>();
}

void the_score_is_the_mean_of_its_parts_by_weight(void **)
{
    const crn::SessionLog log =
        session([](double s, crn::SessionMoment &moment) { moment.is_xray_on = s < 4.0 || s > 6.0; });
    crn::AssessPlan plan = plan_with("not x-ray on", 0.5, 1.0, crn::Severity::serious);
    // In this test, the part of the score for handling errors gives 50 * (1 - 4/40) marks, and the part for
    // the burden on the patient gives 10 of 10 marks. The other parts of the score do not apply, because the
    // session has no phases and lesions.
    assert_float_equal(percent(plan, log), 100.0 * (45.0 + 10.0) / 60.0, 1e-9);
    plan.phases.push_back({"one", "One", {}, condition("injecting"), 1.0, {}});
    assert_float_equal(percent(plan, log), 100.0 * (45.0 + 0.0 + 10.0) / 80.0, 1e-9);
}

void a_life_threatening_error_limits_the_score(void **)
{
    const crn::SessionLog log =
        session([](double s, crn::SessionMoment &moment) { moment.is_xray_on = s < 4.0 || s > 6.0; });
    crn::AssessPlan plan = plan_with("not x-ray on", 0.5, 1.0, crn::Severity::life_threatening);
    assert_true(percent(plan, log) > 80.0);
    plan.score.life_threatening_cap_pct = 60.0;
    assert_float_equal(percent(plan, log), 60.0, 0.0);
}

// The score must be the same if the same motion takes half of the time or twice the time.
void speed_alone_costs_no_marks(void **)
{
    const auto at = [](double speed) {
        return session([speed](double s, crn::SessionMoment &moment) {
            moment.tools[0].inserted_mm = std::min(80.0, 20.0 * speed * s);
            moment.tools[0].tip_mm = {0.0, moment.tools[0].inserted_mm, 0.0};
            moment.is_xray_on = true;
        });
    };
    const crn::AssessPlan plan = crn::read_plan("shared/examples/assessments/navigation.toml");
    assert_float_equal(percent(plan, at(1.0)), percent(plan, at(2.0)), 1e-9);
    assert_float_equal(percent(plan, at(1.0)), percent(plan, at(0.5)), 1e-9);
}

void the_page_has_the_heaviest_error_first_and_no_links(void **)
{
    const crn::SessionLog log = session([](double s, crn::SessionMoment &moment) {
        moment.is_xray_on = s > 2.0;
        moment.injected_ml = s > 5.0 ? s : 0.0;
        moment.is_injecting = s > 5.0;
    });
    crn::AssessPlan plan = plan_with("not x-ray on", 0.5, 1.0);
    crn::PlanError late = plan.errors[0];
    late.name = "late";
    late.title = "Injected <too late>";
    late.when = condition("injecting");
    late.severity = crn::Severity::life_threatening;
    plan.errors.push_back(late);
    const Json assessment = crn::assessment_of(plan, log, report());
    assert_string_equal(assessment["errors"][0]["kind"].get<std::string>().c_str(), "late");
    const std::string page = crn::debrief_page(assessment);
    assert_true(page.find("Injected &lt;too late&gt;") != std::string::npos);
    assert_true(page.find("Injected") < page.find("moderate"));
    for (const char *link : {"http:", "https:", "<script", "src=", "url("})
        assert_true(page.find(link) == std::string::npos);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(an_error_counts_when_its_condition_has_lasted),
        cmocka_unit_test(an_error_counts_again_only_after_a_pause),
        cmocka_unit_test(errors_beyond_the_limit_are_listed_and_do_not_count),
        cmocka_unit_test(a_rule_for_a_tool_that_is_not_there_does_not_apply),
        cmocka_unit_test(an_unknown_vessel_is_refused_with_a_suggestion),
        cmocka_unit_test(a_wire_inside_a_catheter_is_watched_by_the_catheters_tip),
        cmocka_unit_test(an_injection_while_the_pressure_is_damped_is_found),
        cmocka_unit_test(each_injection_without_aspiration_is_one_error),
        cmocka_unit_test(a_move_while_no_wire_is_on_the_line_is_found),
        cmocka_unit_test(a_push_against_a_fixed_tip_is_found),
        cmocka_unit_test(phases_follow_each_other_and_their_steps_lie_in_them),
        cmocka_unit_test(the_score_is_the_mean_of_its_parts_by_weight),
        cmocka_unit_test(a_life_threatening_error_limits_the_score),
        cmocka_unit_test(speed_alone_costs_no_marks),
        cmocka_unit_test(the_page_has_the_heaviest_error_first_and_no_links),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
