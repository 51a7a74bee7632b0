// Tests the choice of devices in the preparation: which devices are chosen, in which order, and what is
// reported about devices that do not fit into each other.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "host/suite/prep_page.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
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

// Returns the path of the tool at each position, or an empty path for a position without a tool.
std::vector<std::string> tools_at(const crn::DeviceCabinet &cabinet)
{
    std::vector<std::string> paths;
    for (const auto &one : cabinet.positions())
        paths.push_back(one ? cabinet.devices()[*one].path : std::string());
    return paths;
}

void a_case_begins_with_its_own_line(void **)
{
    const crn::DeviceCabinet cabinet(lad());
    assert_string_equal(cabinet.refusal().c_str(), "");
    assert_true(tools_at(cabinet) == lad().start.tools); // from the innermost
    assert_int_equal(cabinet.inserted_mm().size(), lad().start.tools.size());
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
    cabinet.toggle(device(cabinet, "guide_jl4_6f"));
    assert_string_equal(cabinet.refusal().c_str(), "");
    assert_non_null(std::strstr(tools_at(cabinet).back().c_str(), "guide_jl4_6f"));
}

void what_is_not_on_the_line_lies_on_the_device_table(void **)
{
    const crn::DeviceCabinet cabinet(lad());
    assert_true(cabinet.paths() == lad().offered);
    const std::vector<std::string> words = cabinet.line_words();
    const std::vector<std::string> tools = tools_at(cabinet);
    for (std::size_t k = 0; k < words.size(); ++k)
        assert_string_equal(lad().offered.at(std::stoul(words[k]) - 1).c_str(), tools[k].c_str());
}

// The guiding catheter keeps its position when the balloon catheter is removed, so the case's goals for the
// guiding catheter stay valid.
void a_device_that_is_taken_off_leaves_its_position_free(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "balloon_3x20"));
    assert_string_equal(cabinet.refusal().c_str(), "");
    assert_string_equal(cabinet.line_words().at(1).c_str(), "nothing");
    assert_true(cabinet.inserted_mm().at(1) == 0.0);
    assert_non_null(std::strstr(tools_at(cabinet).at(2).c_str(), "guide_jl3_6f"));
}

// In this test a second balloon of the same kind is on the device table. In a case, the innermost position
// may also be without a device at the start.
void a_device_that_is_offered_twice_is_on_the_line_once(void **)
{
    crn::Case lesson = lad();
    lesson.offered.push_back(lesson.start.tools.at(1));
    const crn::DeviceCabinet twice(lesson);
    assert_int_equal(twice.line().size(), 3);
    assert_false(twice.devices().back().is_on_line);
    lesson.start.tools[1].clear();
    lesson.start.inserted_um[1] = 0;
    const crn::DeviceCabinet free(lesson);
    assert_string_equal(free.refusal().c_str(), "");
    assert_string_equal(free.line_words().at(1).c_str(), "nothing");
    assert_true(tools_at(free) == lesson.start.tools);
}

void an_empty_line_cannot_begin(void **)
{
    crn::DeviceCabinet cabinet(lad());
    for (const char *name : {"coronary_014", "balloon_3x20", "guide_jl3_6f"})
        cabinet.toggle(device(cabinet, name));
    assert_non_null(std::strstr(cabinet.refusal().c_str(), "No device is on the line"));
}

void a_stent_may_wait_for_a_balloon_on_the_table(void **)
{
    crn::DeviceCabinet cabinet(lad());
    cabinet.toggle(device(cabinet, "balloon_3x20"));
    const auto findings = cabinet.findings();
    assert_true(std::any_of(findings.begin(), findings.end(), [](const auto &one) {
        return one.is_good && one.text.find("which stays on the table") != one.text.npos;
    }));
}

void a_stent_without_a_balloon_of_its_size_is_named(void **)
{
    crn::Case lesson = lad();
    std::erase_if(lesson.offered, [](const std::string &path) { return path.find("balloon") != path.npos; });
    const crn::DeviceCabinet cabinet(lesson);
    assert_non_null(std::strstr(cabinet.refusal().c_str(), "no device carries it"));
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
        cmocka_unit_test(what_is_not_on_the_line_lies_on_the_device_table),
        cmocka_unit_test(a_device_that_is_taken_off_leaves_its_position_free),
        cmocka_unit_test(a_device_that_is_offered_twice_is_on_the_line_once),
        cmocka_unit_test(an_empty_line_cannot_begin),
        cmocka_unit_test(a_stent_may_wait_for_a_balloon_on_the_table),
        cmocka_unit_test(a_stent_without_a_balloon_of_its_size_is_named),
        cmocka_unit_test(a_fourth_device_does_not_go_on_the_line),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
