// Several balloons may be used in a session, one after the other. Each pressure is compared with the label of
// the balloon that was in use at that time.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "host/report/figures/report_angioplasty.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn;

Instrument balloon_of(const char *name, double rated_burst_kPa)
{
    Instrument made;
    made.name = name;
    made.table.balloon_count = 2;
    made.balloon.emplace();
    made.balloon->rated_burst_kPa = rated_burst_kPa;
    return made;
}

std::vector<Instrument> wire_and_two_balloons()
{
    Instrument wire;
    wire.name = "wire";
    return {wire, balloon_of("soft", 800.0), balloon_of("hard", 2000.0)};
}

void fill(BalloonFigures &figures, std::uint32_t tick, std::uint8_t tool, std::uint16_t kPa)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.line_count = 2;
    state.line[0] = 1;
    state.line[1] = tool;
    state.balloon_kPa = kPa;
    state.balloon_diameter_max_um = tool > 1 ? 3000 : 0;
    figures.take(state);
}

void a_pressure_is_judged_by_the_balloon_that_had_it(void **)
{
    BalloonFigures figures;
    fill(figures, 10, 2, 700);
    fill(figures, 20, 0, 0);
    fill(figures, 30, 3, 1500);
    const auto report = balloon_report(figures, wire_and_two_balloons());
    assert_string_equal(report["tool"].get<std::string>().c_str(), "soft");
    assert_true(report["pressure_max_bar"].get<double>() == 7.0);
    assert_false(report["above_rated_burst"].get<bool>());
}

void too_high_a_pressure_stays_known_after_an_exchange(void **)
{
    BalloonFigures figures;
    fill(figures, 10, 2, 1000);
    fill(figures, 30, 3, 1500);
    fill(figures, 40, 0, 0);
    const auto report = balloon_report(figures, wire_and_two_balloons());
    assert_string_equal(report["tool"].get<std::string>().c_str(), "soft");
    assert_true(report["pressure_max_s"].get<double>() == 0.01);
    assert_true(report["above_rated_burst"].get<bool>());
}

void a_session_without_a_balloon_has_no_report(void **)
{
    BalloonFigures figures;
    fill(figures, 10, 0, 0);
    assert_true(balloon_report(figures, wire_and_two_balloons()).is_null());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_pressure_is_judged_by_the_balloon_that_had_it),
        cmocka_unit_test(too_high_a_pressure_stays_known_after_an_exchange),
        cmocka_unit_test(a_session_without_a_balloon_has_no_report),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
