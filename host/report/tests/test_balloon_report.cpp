// Tests that the report of a session keeps the figures of a balloon that was taken off the line before the
// end. Without them, a balloon that burst did not count.
#include "host/patient/patient.hpp"
#include "host/report/report_angioplasty.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>

// This header comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

crn_wire_tick_state state_with(std::uint32_t tick, std::uint8_t at_catheter)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.line_count = 2;
    state.line[0] = 1;
    state.line[1] = at_catheter;
    return state;
}

void a_balloon_that_left_is_reported(void **)
{
    std::vector<crn::Instrument> table;
    for (const char *name : {"coronary_014", "balloon_3x20"})
        table.push_back(crn::read_instrument(std::string("shared/examples/instruments/") + name + ".toml"));
    crn::PatientSettings settings;
    settings.line = {1, 0};
    crn::Patient patient({}, table, settings);
    crn::BalloonFigures figures;
    assert_null(patient.latest_balloon());
    assert_true(crn::balloon_report(figures, patient.latest_balloon()).is_null());
    patient.tick({}, state_with(1, 2));
    patient.tick({}, state_with(2, 0));
    figures.is_there = true;
    figures.burst_tick = 1;
    const nlohmann::ordered_json report = crn::balloon_report(figures, patient.latest_balloon());
    assert_string_equal(report.at("tool").get<std::string>().c_str(), table[1].name.c_str());
    assert_true(report.at("burst_s").get<double>() == 1e-3);
    assert_true(report.at("rated_burst_bar").get<double>() == 16.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_balloon_that_left_is_reported)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
