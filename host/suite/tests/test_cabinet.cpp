// Tests the device cabinet of the preparation: which devices are on the line, in which order, and what it
// says about devices that do not fit into each other.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "host/suite/prep_page.hpp"

// This header comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const crn::Case &lad()
{
    static const crn::Case lesson = [] {
        crn::Case made = crn::read_case(crn::example_path(crn::case_files, "bifurcation"));
        for (const char *name : {"guide_jl4_6f", "j_wire"})
            made.offered.push_back(crn::example_path(crn::instrument_files, name));
        return made;
    }();
    return lesson;
}

std::size_t device(const crn::DeviceCabinet &cabinet, const std::string &name)
{
    const auto &devices = cabinet.devices();
    const auto found = std::find_if(devices.begin(), devices.end(), [&](const crn::CabinetDevice &one) {
        return one.path.find(name) != one.path.npos;
    });
    assert_true(found != devices.end());
    return static_cast<std::size_t>(found - devices.begin());
}

void a_case_begins_with_its_own_line(void **)
{
    const crn::DeviceCabinet cabinet(lad());
    assert_string_equal(cabinet.refusal().c_str(), "");
    assert_true(cabinet.paths() == lad().start.tools); // from the innermost
    assert_int_equal(cabinet.inserted_mm().size(), 3);
    for (const crn::DeviceCabinet::Finding &finding : cabinet.findings()) assert_true(finding.is_good);
}

void a_wire_that_is_too_thick_is_refused_with_both_diameters(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "coronary_014"));
    cabinet.toggle(device(cabinet, "j_wire")); // 0.89 mm, and the balloon catheter's lumen has 0.42 mm
    const std::string refusal = cabinet.refusal();
    assert_non_null(std::strstr(refusal.c_str(), "does not pass the lumen"));
    assert_non_null(std::strstr(refusal.c_str(), "mm"));
}

void another_guiding_catheter_may_take_the_place_of_the_first(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "guide_jl3_6f"));
    assert_non_null(std::strstr(cabinet.refusal().c_str(), "speak of 3 devices"));
    cabinet.toggle(device(cabinet, "guide_jl4_6f"));
    assert_string_equal(cabinet.refusal().c_str(), "");
    assert_non_null(std::strstr(cabinet.paths().back().c_str(), "guide_jl4_6f"));
}

void a_stent_needs_its_balloon_on_the_line(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "balloon_3x20"));
    const auto findings = cabinet.findings();
    assert_true(std::any_of(findings.begin(), findings.end(),
                            [](const auto &one) { return !one.is_good && one.text.find("The stent") == 0; }));
}

void a_fourth_device_does_not_go_on_the_line(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "j_wire"));
    assert_int_equal(cabinet.line().size(), 3);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_case_begins_with_its_own_line),
        cmocka_unit_test(a_wire_that_is_too_thick_is_refused_with_both_diameters),
        cmocka_unit_test(another_guiding_catheter_may_take_the_place_of_the_first),
        cmocka_unit_test(a_stent_needs_its_balloon_on_the_line),
        cmocka_unit_test(a_fourth_device_does_not_go_on_the_line),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
