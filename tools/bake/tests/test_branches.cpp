// These tests check the following. Centrelines in any order and direction become the tree along which blood
// flows; if the centrelines form no tree, the error message names one of them.
#include "host/model/bodies.hpp"
#include "tools/bake/branches.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/fault.hpp"
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::bake;

namespace
{

Curve line(const char *file, const Eigen::Vector3d &from_mm, const Eigen::Vector3d &to_mm,
           double first_radius_mm, double last_radius_mm)
{
    Curve made;
    made.name = file;
    for (int i = 0; i <= 10; ++i)
        made.spheres.push_back({from_mm + 0.1 * i * (to_mm - from_mm),
                                first_radius_mm + 0.1 * i * (last_radius_mm - first_radius_mm)});
    return made;
}

// The test has an aorta that was traced upwards and divides at its lower end, a renal artery traced towards
// the aorta, and two iliac arteries traced in opposite directions.
std::vector<Curve> four()
{
    return {line("a/left_iliac.mrk.json", {80, -120, 0}, {1, -3, 0}, 4, 5),
            line("a/renal.mrk.json", {70, 95, 0}, {2, 100, 0}, 2.5, 3),
            line("a/aorta.mrk.json", {0, 0, 0}, {0, 200, 0}, 9, 12),
            line("a/right_iliac.mrk.json", {0, 1, 0}, {-80, -120, 0}, 5, 4)};
}

void refuses(const std::function<void()> &call, const char *words)
{
    try {
        call();
    } catch (const Fault &fault) {
        if (std::string(fault.what()).find(words) == std::string::npos) fail_msg("says: %s", fault.what());
        return;
    }
    fail_msg("accepted, expected: %s", words);
}

void lines_in_any_order_and_direction_become_a_tree(void **)
{
    const VesselTree tree = join_branches(four(), {});
    assert_int_equal(tree.branches.size(), 4);
    assert_string_equal(tree.branches[0].name.c_str(), "aorta");
    assert_true((tree.branches[0].points_m.front() - Eigen::Vector3d(0, 0.2, 0)).norm() <
                1e-9); // the radius at its widest end
    for (std::size_t b = 1; b < 4; ++b) {
        const VesselBranch &branch = tree.branches[b];
        assert_int_equal(branch.parent, 0);
        assert_true((branch.points_m.front() - tree.branches[0].points_m[branch.parent_point]).norm() <
                    0.005);
        assert_int_equal(branch.parent_point, branch.name == "renal" ? 5 : 10);
        assert_true(tree.is_outlet(b));
    }
    assert_false(tree.is_outlet(0)); // the branch divides there
}

// The centreline tool and VMTK write a fork as two branches that begin at the same point, here slightly
// beyond the trunk's end.
void branches_that_begin_together_leave_one_parent(void **)
{
    const VesselTree tree = join_branches({line("trunk", {0, 0, 0}, {0, 50, 0}, 6, 5),
                                           line("left", {0, 50.5, 0}, {30, 90, 0}, 3, 2.5),
                                           line("right", {0, 50.5, 0}, {-30, 90, 0}, 3, 2.5)},
                                          {});
    for (std::size_t b = 1; b < 3; ++b) {
        assert_int_equal(tree.branches[b].parent, 0);
        assert_int_equal(tree.branches[b].parent_point, tree.branches[0].points_m.size() - 1);
        assert_true(tree.is_outlet(b));
    }
    assert_false(tree.is_outlet(0));
}

void inlet_beds_and_flows_are_those_of_the_text(void **)
{
    TreeText text;
    text.inlet = "aorta"; // the inlet is its first end, though the other is wider
    text.flow_ml_min = {{"left_iliac", 300.0}};
    text.left_coronary = {"right_iliac"};
    const VesselTree tree = join_branches(four(), text);
    assert_true(tree.branches[0].points_m.front().norm() < 1e-9);
    for (const VesselBranch &branch : tree.branches) {
        assert_true(branch.flow_ml_s == (branch.name == "left_iliac" ? 5.0 : 0.0));
        assert_true((branch.bed == VesselBed::left_coronary) == (branch.name == "right_iliac"));
    }
}

void what_makes_no_tree_is_refused_by_name(void **)
{
    std::vector<Curve> apart = four();
    apart[1] = line("a/renal.mrk.json", {70, 95, 0}, {30, 100, 0}, 2.5, 3);
    refuses([&] { join_branches(apart, {}); }, "'renal' ends 2.");
    std::vector<Curve> twice = four();
    twice[1].name = "b/aorta.mrk.json";
    refuses([&] { join_branches(twice, {}); }, "two centrelines called 'aorta'");
    TreeText text;
    text.inlet = "heart";
    refuses([&] { join_branches(four(), text); }, "no centreline 'heart'");
    text = {};
    text.flow_ml_min = {{"femoral", 300.0}};
    refuses([&] { join_branches(four(), text); }, "'femoral', which is no centreline");
    text.flow_ml_min = {{"aorta", 300.0}};
    refuses([&] { join_branches(four(), text); }, "'aorta', where no blood leaves");
}

void a_branch_is_called_as_its_file(void **)
{
    assert_string_equal(branch_name("x/left renal.mrk.json").c_str(), "left renal");
    assert_int_equal(branch_name(std::string(60, 'a') + ".mrk.json").size(), 31);
}

// The table [tree] of a scene's text is written as a section of the body file, and the host reads an equal
// tree from this section.
void a_tree_of_the_text_comes_back_from_the_body_file(void **)
{
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("cournand-branches-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const std::filesystem::path file = folder / "a.toml", bodies_file = folder / "a.bodies";
    std::ofstream(file) << "[scene]\nname = \"a\"\n[lumen]\nmesh = \"a.toml\"\nunit = \"mm\"\n"
                           "[tree]\ncentrelines = [\"a.toml\"]\ninlet = \"aorta\"\ninlet_end = \"last\"\n"
                           "flow_ml_min = { renal = 600 }\n"
                           "[entry]\nposition_mm = [0, 0, 0]\ndirection = [0, 1, 0]\n";
    const SceneText text = read_scene_text(file, {});
    assert_false(text.tree.is_of_lumen);
    const VesselTree tree = join_branches(four(), text.tree);
    write_whole(bodies_file, bodies_bytes(text, {}, tree));
    Bodies read;
    std::string error;
    const bool is_read = read_bodies(bodies_file.string(), read, error);
    std::filesystem::remove_all(folder);
    if (!is_read) fail_msg("%s", error.c_str());
    assert_int_equal(read.vessels.branches.size(), 4);
    for (std::size_t b = 0; b < 4; ++b) {
        const VesselBranch &made = tree.branches[b], &got = read.vessels.branches[b];
        assert_string_equal(got.name.c_str(), made.name.c_str());
        assert_true(got.parent == made.parent && got.parent_point == made.parent_point);
        assert_true(got.flow_ml_s == (made.name == "renal" ? 10.0 : 0.0));
        for (std::size_t i = 0; i < 11; ++i) {
            assert_true((got.points_m[i] - made.points_m[i]).norm() < 1e-9);
            assert_true(std::abs(got.radii_m[i] - made.radii_m[i]) < 1e-9);
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(lines_in_any_order_and_direction_become_a_tree),
        cmocka_unit_test(branches_that_begin_together_leave_one_parent),
        cmocka_unit_test(inlet_beds_and_flows_are_those_of_the_text),
        cmocka_unit_test(what_makes_no_tree_is_refused_by_name),
        cmocka_unit_test(a_branch_is_called_as_its_file),
        cmocka_unit_test(a_tree_of_the_text_comes_back_from_the_body_file),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
