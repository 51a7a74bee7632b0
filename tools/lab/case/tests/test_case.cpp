// These tests check the following. The files of a case are read back with the values with which they were
// written. For every error in the case's folder, the message names the file, the field and the remedy.
// Numbers are written with 9 significant digits, so the relative tolerance of the comparison is 1e-8.
#include "host/base/tests/folder.hpp"
#include "tools/lab/case/case.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace crn::insertion;
using crn::tests::Folder;

namespace
{

Case shipped(const std::filesystem::path &folder)
{
    Case c;
    c.folder = folder;
    c.name = "a \"J\" wire";
    c.instrument = "j_wire.toml:physical";
    c.scene = "phantom.scene";
    c.surface = "lumen.ply";
    c.force = "force.csv";
    c.mouth_mm = {-55, -152.25, 4.5};
    c.direction = {0.6, 0.8, 0};
    c.gravity_m_s2 = {0, 0, -9.81};
    c.friction_kinetic = 0.1;
    c.friction_static = 0.12;
    c.speed_mm_per_s = 20;
    c.depths = {{"iliac", 60, 10, "d1.nrrd", "depth_1.csv"}, {"aortic", 110, 40, "", "depth_2.csv"}};
    return c;
}

// Returns the error message that reading the case gives, or "" if there is none.
template <class Read> std::string refusal(Read read)
{
    try {
        read();
    } catch (const crn::Fault &error) {
        return error.what();
    }
    return {};
}

void a_case_comes_back_as_it_was_written(void **)
{
    const Folder folder{"case"};
    const Case c = shipped(folder.path);
    write_case(c);
    const Case back = read_case(folder.path);
    assert_string_equal(back.name.c_str(), c.name.c_str());
    assert_true(back.instrument == c.instrument && back.surface == c.surface && back.force == c.force);
    assert_true((back.mouth_mm - c.mouth_mm).norm() < 1e-6);
    assert_true((back.gravity_m_s2 - c.gravity_m_s2).norm() < 1e-7);
    assert_int_equal(back.depths.size(), 2);
    assert_true(back.depths[0].scan == "d1.nrrd" && back.depths[1].scan.empty());
    assert_true(back.path_in(back.scene) == std::filesystem::path(folder.path) / "phantom.scene");
}

// A person may begin a case whose only data are scans. The program adds scene, surface and mouth_mm to
// case.toml later, and changes nothing else in this file.
void a_case_of_scans_alone_is_completed_in_place(void **)
{
    const Folder folder{"case"};
    const std::filesystem::path file = std::filesystem::path(folder.path) / "case.toml";
    const std::string head = "# my scan\nformat = 1 # the first\n",
                      rest = "name = \"a\"\ninstrument = \"i.toml\"\nfriction_kinetic = 0.1\n"
                             "friction_static = 0.1\nspeed_mm_per_s = 20\n\n[[depth]]\nname = \"one\"\n"
                             "inserted_mm = 60\nturn_deg = 0\nscan = \"s.nrrd\"\ncentreline = \"d.csv\"\n";
    std::ofstream(file) << head << rest;
    assert_true(refusal([&] { read_case(folder.path); }).find("ct segment") != std::string::npos);
    Case c = read_case(folder.path, CaseParts::before_segmentation);
    assert_true(!c.has_mouth && c.scene.empty() && c.surface.empty());
    c.has_mouth = true;
    c.mouth_mm = {1.5, -2, 3};
    c.direction = {0, 0.6, 0.8};
    c.scene = "lumen.scene";
    c.surface = "lumen.ply";
    complete_case(c);
    const Case back = read_case(folder.path);
    assert_true(back.mouth_mm == c.mouth_mm && back.scene == c.scene && back.surface == c.surface);
    std::ifstream stream(file);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    assert_int_equal(text.find(head), 0);
    assert_true(text.find(rest) == text.size() - rest.size());
    c.scene = "other.scene";
    complete_case(c);
    assert_true(read_case(folder.path).scene == "lumen.scene");
}

void the_hand_turns_evenly_with_the_feed_between_depths(void **)
{
    const Case c = shipped("somewhere");
    assert_true(c.turn_deg_at(0) == 10 && c.turn_deg_at(60) == 10);
    assert_true(std::abs(c.turn_deg_at(85) - 25) < 1e-12);
    assert_true(c.turn_deg_at(110) == 40 && c.turn_deg_at(200) == 40);
}

void lines_and_forces_come_back_and_further_columns_are_passed_over(void **)
{
    const Folder folder{"case"};
    const std::filesystem::path line = std::filesystem::path(folder.path) / "line.csv",
                                force = std::filesystem::path(folder.path) / "force.csv";
    write_centreline(line, {{1.25, -2, 3}, {4, 5.0625, -6}});
    assert_true((read_centreline(line)[1] - Eigen::Vector3d(4, 5.0625, -6)).norm() < 1e-7);
    std::ofstream(line) << "x_mm,y_mm,z_mm,unsure_mm\n0,0,0,0.2\n1,2,3,0.1\n\n";
    assert_true(read_centreline(line)[1] == Eigen::Vector3d(1, 2, 3));
    write_force(force, {{0, 0}, {10, 125.5}});
    assert_true(read_force(force)[1].axial_mN == 125.5);
}

void wrong_cases_are_refused_with_file_line_and_field(void **)
{
    const Folder folder{"case"};
    write_case(shipped(folder.path));
    const std::filesystem::path file = std::filesystem::path(folder.path) / "case.toml";
    std::ifstream stream(file);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    const struct {
        const char *from, *to, *wanted;
    } faults[] = {
        {"format = 1", "format = 2", "'format' must be 1"},
        {"speed_mm_per_s = 20", "speed_mm_per_s = nan",
         "'speed_mm_per_s' is not a finite number: give one from 1 to 200"},
        {"friction_static = 0.12", "friction_static = 0.05", "'friction_static' = 0.05 is outside"},
        {"direction = [0.6,", "direction = [0.7,", "'direction' is not of length 1"},
        {"inserted_mm = 110", "inserted_mm = 50", "depth 2: 'inserted_mm' is not more"},
        {"scene = ", "scenes = ", "unknown key 'scenes', did you mean 'scene'?"},
        {"turn_deg = 10", "turndeg = 10", "depth 1: unknown key 'turndeg', did you mean 'turn_deg'?"},
        {"turn_deg = 10", "turn_deg = \"10\"", "depth 1: 'turn_deg' is not a finite number"},
        {"[[depth]]", "[[depth]", "case.toml:"},
    };
    for (const auto &fault : faults) {
        std::string text = whole;
        text.replace(text.find(fault.from), std::string(fault.from).size(), fault.to);
        std::ofstream(file) << text;
        const std::string said = refusal([&] { read_case(folder.path); });
        if (said.find(fault.wanted) == std::string::npos)
            fail_msg("\"%s\" does not hold \"%s\"", said.c_str(), fault.wanted);
    }
    assert_true(refusal([] { read_case("/nowhere"); }).find("no such file") != std::string::npos);
}

void wrong_lines_and_traces_are_refused(void **)
{
    const Folder folder{"case"};
    const std::filesystem::path file = std::filesystem::path(folder.path) / "f.csv";
    const auto says = [&](const char *text, const char *wanted, auto read) {
        std::ofstream(file) << text;
        const std::string said = refusal([&] { read(file); });
        if (said.find(wanted) == std::string::npos)
            fail_msg("\"%s\" does not hold \"%s\"", said.c_str(), wanted);
    };
    says("x,y,z\n1,2,3\n", "does not begin with x_mm", read_centreline);
    says("x_mm,y_mm,z_mm\n1,2,3\n", "fewer than two points", read_centreline);
    says("x_mm,y_mm,z_mm\n1,2,3\n1,2\n", ":3: give 3 numbers", read_centreline);
    says("x_mm,y_mm,z_mm\n1,2,3\n1,2,inf\n", ":3: give 3 numbers", read_centreline);
    says("inserted_mm,axial_mN\n1,2\n0.5,3\n", "insertion falls", read_force);
}

} // namespace

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_case_comes_back_as_it_was_written),
        cmocka_unit_test(a_case_of_scans_alone_is_completed_in_place),
        cmocka_unit_test(the_hand_turns_evenly_with_the_feed_between_depths),
        cmocka_unit_test(lines_and_forces_come_back_and_further_columns_are_passed_over),
        cmocka_unit_test(wrong_cases_are_refused_with_file_line_and_field),
        cmocka_unit_test(wrong_lines_and_traces_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
