// These tests check the following. Curves that touch become one tree, a tree can be cut at its junctions, and
// the flow through a tree obeys Poiseuille's law. The test compares the results with formulas in closed form.
#include "tools/centreline/flow.hpp"
#include "tools/centreline/join.hpp"
#include "tools/centreline/tests/trees.hpp"
#include <numbers>

using namespace crn::centreline;
using namespace crn::centreline::tests;

namespace
{

using std::numbers::pi;
constexpr double ml_min = 60.0 / 1000.0; // per mm^3/s

void is_near(double got, double wanted, double share, const char *what)
{
    if (!(std::abs(got - wanted) <= share * std::abs(wanted)))
        fail_msg("%s is %.9g, expected %.9g", what, got, wanted);
}

void curves_that_touch_become_a_tree(void **)
{
    Tree curves;
    // The first of the two thinner curves begins inside the trunk's tube, and the second thinner curve ends
    // inside the trunk's tube.
    curves.branches.push_back(straight("b", {1, 10, 0}, {12, 14, 0}, 12, 1, 1));
    curves.branches.push_back(straight("c", {-15, 22, 0}, {-2, 20, 0}, 14, 1, 1));
    curves.branches.push_back(straight("trunk", {0, 0, 0}, {0, 40, 0}, 41, 4, 3));
    curves.branches.push_back(straight("far", {100, 0, 0}, {100, 9, 0}, 9, 1, 1));
    const Tree tree = joined(curves);
    check_tree(tree, "joined");
    assert_string_equal(tree.branches[0].name.c_str(), "trunk");
    int found = 0;
    for (const Branch &branch : tree.branches) {
        if (branch.name == "far") assert_int_equal(branch.parent, -1);
        if (branch.name != "b" && branch.name != "c") continue;
        ++found;
        assert_int_equal(branch.parent, 0);
        // The end of curve b inside the trunk's tube is nearest to sphere 10 of the trunk, and that of curve
        // c is nearest to sphere 20. Branches b and c must leave the trunk at these two spheres, and the last
        // sphere of each of the two branches must lie outside the trunk.
        assert_int_equal(branch.parent_sphere, branch.name == "b" ? 10 : 20);
        assert_true(std::abs(branch.spheres.back().centre_mm.x()) > 10);
    }
    assert_int_equal(found, 2);
}

double length_of_all_mm(const Tree &tree)
{
    double sum = 0;
    for (const Branch &branch : tree.branches) sum += length_mm(branch);
    return sum;
}

// Before, `convert` returned a tree with parents as it was, whatever --inlet said.
void a_tree_with_parents_begins_at_the_inlet(void **)
{
    const Tree before = y_tree();
    const Eigen::Vector3d left_end = before.branches[1].spheres.back().centre_mm;
    std::vector<std::string> notes;
    const Tree tree = joined(before, &left_end, &notes);
    check_tree(tree, "turned");
    assert_int_equal(tree.branches.size(), 3);
    assert_string_equal(tree.branches[0].name.c_str(), "left");
    assert_true((tree.branches[0].spheres.front().centre_mm - left_end).norm() < 1e-12);
    for (int b : {1, 2}) assert_int_equal(tree.branches[b].parent, 0);
    is_near(length_of_all_mm(tree), length_of_all_mm(before), 1e-12, "the length of all branches");
    assert_int_equal(notes.size(), 1);
    assert_true(notes[0].find("reversed") != std::string::npos);
    // At the end where it begins already, it stays as it is.
    const Eigen::Vector3d root = before.branches[0].spheres.front().centre_mm;
    assert_same_tree(joined(before, &root), before);
}

void a_single_curve_begins_at_the_inlet(void **)
{
    Tree tree;
    tree.branches.push_back(straight("curve", {0, 0, 0}, {0, 20, 0}, 21, 2, 1));
    const Eigen::Vector3d end(0, 20, 0);
    assert_true((joined(tree, &end).branches[0].spheres.front().centre_mm - end).norm() < 1e-12);
}

void an_inlet_away_from_all_ends_is_refused(void **)
{
    const Eigen::Vector3d away(0, -30, 0);
    says([&] { joined(y_tree(), &away); }, {"30.0 mm from the nearest end", "(0.0, 0.0, 0.0) mm"});
}

// Before, a file with parents among the files kept all others from being joined.
void curves_join_a_tree_that_has_parents(void **)
{
    Tree tree = y_tree();
    tree.branches.push_back(straight("side", {0.4, 2, 0}, {12, 2, 0}, 25, 0.5, 0.5));
    tree.branches.push_back(straight("far", {100, 0, 0}, {100, 9, 0}, 9, 0.4, 0.4));
    std::vector<std::string> notes;
    const Tree made = joined(tree, nullptr, &notes);
    check_tree(made, "joined");
    for (const Branch &branch : made.branches) {
        if (branch.name == "far" || branch.name == "trunk")
            assert_int_equal(branch.parent, -1);
        else
            assert_string_equal(made.branches[branch.parent].name.c_str(), "trunk");
        if (branch.name == "side") assert_int_equal(branch.parent_sphere, 2);
        if (branch.name == "left" || branch.name == "right") assert_int_equal(branch.parent_sphere, 5);
    }
    assert_int_equal(notes.size(), 1);
    assert_true(notes[0].find("'far'") != std::string::npos);
}

// A tree of three branches whose root begins in a trunk: all keep their places, but the root's part inside
// the trunk is cut off.
void a_tree_joins_another_with_its_root(void **)
{
    Tree tree = y_tree();
    for (Branch &branch : tree.branches)
        for (Sphere &sphere : branch.spheres) sphere.centre_mm += Eigen::Vector3d(0, 0.2, 0);
    tree.branches.push_back(straight("aorta", {-30, 0, 0}, {30, 0, 0}, 61, 4, 4));
    const Tree made = joined(tree);
    check_tree(made, "joined");
    assert_int_equal(made.branches.size(), 4);
    assert_string_equal(made.branches[0].name.c_str(), "aorta");
    assert_string_equal(made.branches[1].name.c_str(), "trunk");
    assert_int_equal(made.branches[1].parent, 0);
    assert_int_equal(made.branches[1].parent_sphere, 30);
    for (int b : {2, 3}) {
        assert_int_equal(made.branches[b].parent, 1);
        const Branch &trunk = made.branches[1];
        assert_int_equal(made.branches[b].parent_sphere, trunk.spheres.size() - 1);
    }
}

void a_tree_grows_by_the_deepest_end(void **)
{
    // In the one-dimensional example each curve is a pair of coordinates [first, last], and its depth in a
    // branch is the distance to the nearer end of the branch.
    const std::vector<std::array<double, 2>> curves = {{5, 9}, {2, 1}, {0, 1}, {100, 101}, {3, 5}};
    std::vector<Joint> joints;
    const auto depth = [&](std::size_t curve, bool is_last, std::size_t branch) {
        const auto &other = curves[joints[branch].curve];
        const double at = curves[curve][is_last];
        const double apart = std::min(std::abs(at - other[0]), std::abs(at - other[1]));
        return apart > 50 ? INFINITY : apart;
    };
    grow_tree(curves.size(), 2, depth, [&](const Joint &joint) { joints.push_back(joint); });
    const Joint wanted[] = {{2, 0, false, INFINITY},
                            {1, 0, true, 0},
                            {4, 1, false, 1},
                            {0, 2, false, 0},
                            {3, 0, false, INFINITY}};
    assert_int_equal(joints.size(), 5);
    for (std::size_t i = 0; i < 5; ++i) {
        assert_int_equal(joints[i].curve, wanted[i].curve);
        assert_true(joints[i].depth == wanted[i].depth);
        if (!std::isfinite(wanted[i].depth)) continue;
        assert_int_equal(joints[i].parent, wanted[i].parent);
        assert_int_equal(joints[i].is_last, wanted[i].is_last);
    }
}

// As in a file from VMTK, two lines begin at one inlet and coincide up to the fork.
void lines_that_run_together_part_where_they_part(void **)
{
    Tree curves;
    for (double side : {1.0, -1.0}) {
        Branch line = straight("", {0, 0, 0}, {0, 20, 0}, 41, 2, 2);
        const Branch rest = straight("", {0, 20, 0}, {12 * side, 30 + side, 0}, 30, 2, 2);
        line.spheres.insert(line.spheres.end(), rest.spheres.begin() + 1, rest.spheres.end());
        curves.branches.push_back(line);
    }
    const Tree tree = split_at_junctions(joined(curves));
    check_tree(tree, "parted");
    assert_int_equal(tree.branches.size(), 3);
    const Eigen::Vector3d fork = tree.branches[0].spheres.back().centre_mm;
    // The computed position of the fork may be wrong by the distance within which a curve still counts as
    // part of its parent.
    if ((fork - Eigen::Vector3d(0, 20, 0)).norm() > 1.2) fail_msg("forks at %.2f, %.2f", fork.x(), fork.y());
}

void a_split_tree_ends_at_every_junction(void **)
{
    Tree tree;
    tree.branches.push_back(straight("trunk", {0, 0, 0}, {0, 10, 0}, 11, 2, 2));
    for (int at : {3, 7}) {
        Branch side =
            straight("side", {0, static_cast<double>(at), 0}, {9, static_cast<double>(at), 0}, 10, 1, 1);
        side.spheres[0].radius_mm = 2;
        side.parent = 0;
        side.parent_sphere = static_cast<std::size_t>(at);
        tree.branches.push_back(side);
    }
    const Tree split = split_at_junctions(tree);
    check_tree(split, "split");
    assert_int_equal(split.branches.size(), 5);
    assert_int_equal(sphere_count(split), sphere_count(tree) + 2); // each cut sphere counts twice
    for (const Branch &branch : split.branches)
        if (branch.parent >= 0)
            assert_int_equal(branch.parent_sphere, split.branches[branch.parent].spheres.size() - 1);
}

void own_spheres_begin_outside_the_parent(void **)
{
    Tree tree;
    tree.branches.push_back(straight("trunk", {0, 0, 0}, {0, 10, 0}, 11, 3, 3));
    Branch side = straight("side", {0, 5, 0}, {10, 5, 0}, 21, 1, 1);
    side.parent = 0;
    side.parent_sphere = 5;
    tree.branches.push_back(side);
    assert_int_equal(first_own_sphere(tree, 0), 0);
    assert_int_equal(first_own_sphere(tree, 1), 6); // at x = 3, where it leaves the parent's tube
}

// The flow resistance of a cylinder of length L and radius r is R = 8 mu L / (pi r^4) for the viscosity mu;
// for a cone the formula uses the mean of r^-4 over the length.
void resistance_of_a_tube_is_poiseuilles(void **)
{
    is_near(tube_resistance({{0, 0, 0}, 1.5}, {{0, 7, 0}, 1.5}, 3.5),
            8 * 3.5e-3 * 7 / (pi * std::pow(1.5, 4)), 1e-12, "tube");
    double sum = 0;
    constexpr int pieces = 20000;
    for (int i = 0; i < pieces; ++i) sum += std::pow(2 - 1.2 * (i + 0.5) / pieces, -4) / pieces;
    is_near(tube_resistance({{0, 0, 0}, 2.0}, {{0, 7, 0}, 0.8}, 3.5), 8 * 3.5e-3 * 7 * sum / pi, 1e-7,
            "cone");
}

void flow_divides_as_the_conductances(void **)
{
    Tree tree;
    tree.branches.push_back(straight("trunk", {0, 0, 0}, {0, 20, 0}, 5, 2, 2));
    const double radii[] = {1.5, 1.0}, lengths[] = {30, 15};
    for (int k = 0; k < 2; ++k) {
        Branch side =
            straight("side", {0, 20, 0}, {k ? -lengths[k] : lengths[k], 20, 0}, 6, radii[k], radii[k]);
        side.parent = 0;
        side.parent_sphere = 4;
        tree.branches.push_back(side);
    }
    FlowSettings settings;
    settings.inlet_ml_min = 120;
    const std::vector<double> flow = set_flow(tree, settings);
    is_near(flow[0], 120, 1e-12, "inlet");
    is_near(flow[1] + flow[2], 120, 1e-12, "sum of the branches");
    const double cubes = 1.5 * 1.5 * 1.5 + 1, bed = 90 * 133.322 / (120 / ml_min) * cubes;
    double conductance[2];
    for (int k = 0; k < 2; ++k)
        conductance[k] =
            1 / (8 * 3.5e-3 * lengths[k] / (pi * std::pow(radii[k], 4)) + bed / std::pow(radii[k], 3));
    is_near(flow[1] / flow[2], conductance[0] / conductance[1], 1e-9, "ratio");
    is_near(tree.branches[1].spheres[3].speed_mm_s, flow[1] / ml_min / (pi * 1.5 * 1.5), 1e-12, "speed");
    is_near(tree.branches[0].spheres[0].speed_mm_s, 120 / ml_min / (pi * 4), 1e-12, "speed at the inlet");
}

// A side branch in the middle of a vessel takes part of the vessel's flow, and volume is conserved at every
// sphere.
void flow_is_kept_along_a_branch_with_sides(void **)
{
    Tree tree;
    tree.branches.push_back(straight("trunk", {0, 0, 0}, {0, 20, 0}, 21, 2, 1));
    Branch side = straight("side", {0, 8, 0}, {10, 8, 0}, 9, 1, 1);
    side.parent = 0;
    side.parent_sphere = 8;
    tree.branches.push_back(side);
    const std::vector<double> flow = set_flow(tree, {});
    const auto through = [&](std::size_t i) {
        const Sphere &s = tree.branches[0].spheres[i];
        return s.speed_mm_s * pi * s.radius_mm * s.radius_mm * ml_min;
    };
    is_near(through(0), 150 * pi * 4 * ml_min, 1e-12, "inlet");
    is_near(through(8), through(0), 1e-12, "before");
    is_near(through(9) + flow[1], through(0), 1e-12, "behind");
    is_near(through(20), through(9), 1e-12, "end");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(curves_that_touch_become_a_tree),
                                cmocka_unit_test(a_tree_with_parents_begins_at_the_inlet),
                                cmocka_unit_test(a_single_curve_begins_at_the_inlet),
                                cmocka_unit_test(an_inlet_away_from_all_ends_is_refused),
                                cmocka_unit_test(curves_join_a_tree_that_has_parents),
                                cmocka_unit_test(a_tree_joins_another_with_its_root),
                                cmocka_unit_test(a_tree_grows_by_the_deepest_end),
                                cmocka_unit_test(lines_that_run_together_part_where_they_part),
                                cmocka_unit_test(a_split_tree_ends_at_every_junction),
                                cmocka_unit_test(own_spheres_begin_outside_the_parent),
                                cmocka_unit_test(resistance_of_a_tube_is_poiseuilles),
                                cmocka_unit_test(flow_divides_as_the_conductances),
                                cmocka_unit_test(flow_is_kept_along_a_branch_with_sides)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
