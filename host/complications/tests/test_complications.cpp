// These tests check the limits of the wall and what follows from them. A limit must be exceeded for its whole
// time, and a value at the limit does not exceed it. The file that ships states exactly the limits that the
// program has without a file. A mistake in a file is reported with its line. A recording that keeps the
// limits as commands gives them back. The sizes of wounds agree with closed forms.
#include "host/base/examples.hpp"
#include "host/base/text.hpp"
#include "host/complications/injury.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr const char *shipped_file = "shared/examples/complications.toml";

// Writes a file of limits, and returns its path.
std::string limits_file(const std::string &text)
{
    const std::string path = "/tmp/crn_limits_" + std::to_string(getpid()) + ".toml";
    std::ofstream(path) << text;
    return path;
}

std::string refusal_of(const std::string &text)
{
    const std::string path = limits_file(text);
    std::string told;
    try {
        read_complications(path);
    } catch (const FileError &error) {
        told = error.what();
    }
    std::remove(path.c_str());
    return told;
}

void a_value_must_exceed_its_limit_for_the_whole_time(void **)
{
    LimitWatch watch;
    assert_false(watch.take(0, 1.301, 1.3, 96));
    assert_false(watch.take(80, 1.301, 1.3, 96));
    assert_true(watch.take(96, 1.301, 1.3, 96));
}

void at_the_limit_nothing_happens(void **)
{
    LimitWatch watch;
    for (std::uint32_t tick = 0; tick < 10'000; tick += 16) assert_false(watch.take(tick, 1.3, 1.3, 96));
    assert_false(watch.is_above());
}

void a_pause_begins_the_time_anew(void **)
{
    LimitWatch watch;
    assert_false(watch.take(0, 2.0, 1.0, 96));
    assert_false(watch.take(80, 0.5, 1.0, 96));
    assert_false(watch.take(96, 2.0, 1.0, 96));
    assert_false(watch.take(176, 2.0, 1.0, 96));
    assert_true(watch.take(192, 2.0, 1.0, 96));
}

void the_file_that_ships_states_the_limits_that_the_program_has(void **)
{
    assert_true(read_complications(shipped_file) == ComplicationLimits());
    std::ifstream file(shipped_file);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    for (const ComplicationLimit &limit : complication_limits())
        assert_true(text.find(std::string("\n[") + limit.key + "]\n") != std::string::npos);
}

void a_file_may_state_only_some_limits(void **)
{
    const std::string path =
        limits_file("format = 1\nperforation_tip_kPa = { value = 900, source = \"own measurement\" }\n");
    ComplicationLimits wanted;
    wanted.perforation_tip_kPa = 900.0;
    assert_true(read_complications(path) == wanted);
    std::remove(path.c_str());
}

void a_mistake_is_reported_with_file_line_and_field(void **)
{
    const auto told = [](const std::string &text, const char *line, const char *field) {
        const std::string refusal = refusal_of(text);
        if (refusal.find(std::string(".toml:") + line) == std::string::npos ||
            refusal.find(field) == std::string::npos)
            fail_msg("'%s' should name line %s and '%s'", refusal.c_str(), line, field);
    };
    told("format = 1\nperforation_tip_kPa = { value = -3, source = \"x\" }\n", "2", "perforation_tip_kPa");
    told("format = 1\nperforation_tip_kPa = { value = 900 }\n", "2", "source");
    told("format = 1\n\nperforation_kPa = { value = 900, source = \"x\" }\n", "3", "perforation_kPa");
    told("format = 1\nseal_s = { value = nan, source = \"x\" }\n", "2", "seal_s");
    told("format = 1\ndissection_balloon_ratio = { value = 1.4, source = \"x\" }\n", "2",
         "'dissection_balloon_ratio' = 1.4 is not below 'perforation_balloon_ratio' = 1.3");
    told("format = 2\n", "1", "format");
}

void the_commands_of_a_recording_give_the_limits_back(void **)
{
    ComplicationLimits limits;
    limits.perforation_tip_kPa = 812.345;
    limits.pressure_left_pct = 33.0;
    limits.is_on = false;
    ComplicationLimits restored;
    for (const RoomCommand &command : commands_of(limits)) {
        assert_true(refusal(command).empty());
        take_command(restored, command);
    }
    assert_true(restored == limits);
    assert_true(commands_of(ComplicationLimits()).empty());
}

void no_command_leads_out_of_the_limits(void **)
{
    for (std::int32_t number = 0; number < complication_limit_count; ++number)
        for (const std::int32_t value : {0, complication_max_milli}) {
            ComplicationLimits limits;
            const RoomCommand command{RoomAction::complication_limit, {number, value, 0}};
            assert_true(refusal(command).empty());
            take_command(limits, command);
            const ComplicationLimit &limit = complication_limits()[static_cast<std::size_t>(number)];
            assert_true(limits.*limit.value >= limit.low && limits.*limit.value <= limit.high);
        }
    assert_false(refusal({RoomAction::complication_limit, {complication_limit_count, 0, 0}}).empty());
}

// An orifice of area A lets C A sqrt(2 p / rho) pass; a quarter of it is open.
void a_hole_lets_the_flow_of_an_orifice_pass_at_the_arteries_mean_pressure(void **)
{
    const ComplicationLimits limits;
    const double area_m2 = std::numbers::pi * 0.25e-6, p_Pa = 88.0 * 133.322;
    const double wanted_ml_s = 0.25 * 0.6 * area_m2 * std::sqrt(2.0 * p_Pa / 1060.0) * 1e6;
    const double found_ml_s = hole_ml_s_per_mmHg(limits, 1.0) * 88.0;
    assert_true(std::fabs(found_ml_s - wanted_ml_s) < 1e-12);
    // A hole of twice the diameter lets four times the flow pass.
    assert_true(std::fabs(hole_ml_s_per_mmHg(limits, 2.0) / hole_ml_s_per_mmHg(limits, 1.0) - 4.0) < 1e-12);
}

Injury hole_of(double diameter_mm)
{
    Injury injury;
    injury.size_mm = diameter_mm;
    return injury;
}

void the_class_of_a_perforation_follows_from_its_hole(void **)
{
    const ComplicationLimits limits;
    assert_string_equal(injury_class(hole_of(0.19), limits).c_str(), "I");
    assert_string_equal(injury_class(hole_of(0.36), limits).c_str(), "II"); // a wire of 0.014 in
    assert_string_equal(injury_class(hole_of(0.999), limits).c_str(), "II");
    assert_string_equal(injury_class(hole_of(1.0), limits).c_str(), "III");
    assert_true(std::fabs(balloon_hole_mm(limits, 1.3) - 0.8) < 1e-12);
    assert_true(std::fabs(balloon_hole_mm(limits, 1.4) - 1.0) < 1e-12);
}

void the_type_of_a_dissection_follows_from_its_flap(void **)
{
    const ComplicationLimits limits;
    const auto type = [&](double narrowing) {
        Injury injury;
        injury.kind = InjuryKind::dissection;
        injury.narrowing = narrowing;
        return injury_class(injury, limits);
    };
    assert_string_equal((type(0.2) + type(0.3) + type(0.5) + type(0.7) + type(0.9)).c_str(), "BCDEF");
    assert_true(std::fabs(flap_narrowing(limits, InjuryCause::tip, 477.0, 477.0) - 0.2) < 1e-12);
    assert_true(std::fabs(flap_narrowing(limits, InjuryCause::tip, 954.0, 477.0) - 0.6) < 1e-12);
    assert_true(std::fabs(flap_narrowing(limits, InjuryCause::balloon, 1.25, 1.2) - 0.4) < 1e-12);
    // Beyond the limit of a perforation, a balloon makes a hole instead of a larger flap.
    assert_true(std::fabs(flap_narrowing(limits, InjuryCause::balloon, 1.3, 1.2) - 0.6) < 1e-12);
    assert_true(std::fabs(flap_narrowing(limits, InjuryCause::balloon, 2.0, 1.2) - 0.6) < 1e-12);
    assert_true(flap_narrowing(limits, InjuryCause::tip, 1e6, 477.0) < 1.0);
}

void the_pressure_falls_linearly_between_two_losses(void **)
{
    const ComplicationLimits limits;
    assert_true(pressure_left(limits, 0.0, 0.0) == 1.0);
    assert_true(pressure_left(limits, 100.0, 100.0) == 1.0);
    assert_true(std::fabs(pressure_left(limits, 175.0, 175.0) - 0.7) < 1e-12);
    assert_true(std::fabs(pressure_left(limits, 300.0, 300.0) - 0.4) < 1e-12);
    assert_true(std::fabs(pressure_left(limits, 0.0, 1375.0) - 0.7) < 1e-12); // elsewhere
}

void the_notice_says_what_where_and_what_to_do(void **)
{
    Injury injury = hole_of(0.36);
    injury.tool = "Coronary wire";
    injury.vessel = "LAD";
    const std::string notice = injury_notice(injury, {});
    for (const char *part : {"PERFORATION, Ellis II", "LAD", "Coronary wire", "inflate a balloon"})
        assert_true(notice.find(part) != std::string::npos);
}

} // namespace

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_value_must_exceed_its_limit_for_the_whole_time),
        cmocka_unit_test(at_the_limit_nothing_happens),
        cmocka_unit_test(a_pause_begins_the_time_anew),
        cmocka_unit_test(the_file_that_ships_states_the_limits_that_the_program_has),
        cmocka_unit_test(a_file_may_state_only_some_limits),
        cmocka_unit_test(a_mistake_is_reported_with_file_line_and_field),
        cmocka_unit_test(the_commands_of_a_recording_give_the_limits_back),
        cmocka_unit_test(no_command_leads_out_of_the_limits),
        cmocka_unit_test(a_hole_lets_the_flow_of_an_orifice_pass_at_the_arteries_mean_pressure),
        cmocka_unit_test(the_class_of_a_perforation_follows_from_its_hole),
        cmocka_unit_test(the_type_of_a_dissection_follows_from_its_flap),
        cmocka_unit_test(the_pressure_falls_linearly_between_two_losses),
        cmocka_unit_test(the_notice_says_what_where_and_what_to_do),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
