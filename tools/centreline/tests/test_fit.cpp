// These tests check the following. Fitted spheres lie in the middle of the vessel and touch its wall.
// Branches, junctions and ends are at the right positions. The spheres of a beating vessel keep their number
// and order. The test uses tubes and arcs whose centrelines and radii are known. The permitted error of a
// sphere is 5 % of the radius for its centre and 3 % for its radius (requirement 5 of issue 6).
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/fit/carry.hpp"
#include "tools/centreline/fit/guided.hpp"
#include "tools/centreline/tests/shapes.hpp"

using namespace crn;
using namespace crn::centreline;
using namespace crn::centreline::tests;

namespace
{

constexpr double centre_share = 0.05, radius_share = 0.03;

bake::Progress progress;

// Coarse voxels are accurate enough for the rough paths, because the spheres are fitted to the wall itself.
LumenWish coarse()
{
    LumenWish wish;
    wish.voxel_mm = 0.35;
    return wish;
}

struct Worst {
    double centre = 0, radius = 0; // in radii
    std::size_t spheres = 0;
};

void print(const char *what, const Worst &worst)
{
    std::printf("# %s: centres within %.2f %%, radii within %.2f %% of the radius (%zu spheres)\n", what,
                100 * worst.centre, 100 * worst.radius, worst.spheres);
    assert_true(worst.spheres > 10);
    assert_true(worst.centre <= centre_share);
    assert_true(worst.radius <= radius_share);
}

Worst worst_in_tube(const Tree &tree, double radius_mm, double bend_mm)
{
    Worst worst;
    for (const Branch &branch : tree.branches)
        for (const Sphere &sphere : branch.spheres) {
            worst.centre = std::max(worst.centre, tube_off_mm(sphere.centre_mm, bend_mm) / radius_mm);
            worst.radius = std::max(worst.radius, std::abs(sphere.radius_mm / radius_mm - 1));
            ++worst.spheres;
        }
    return worst;
}

Tree automatic(const Lumen &lumen, AutoWish wish = {})
{
    std::vector<std::string> notes;
    return fit_automatic(lumen, wish, notes, progress);
}

void a_straight_and_a_bent_tube_are_recovered_to_their_openings(void **)
{
    for (double bend_mm : {0.0, 18.0}) {
        const Lumen lumen(tube_mesh(2.0, 30.0, bend_mm, 60, 40), coarse(), progress);
        assert_int_equal(lumen.openings().size(), 2);
        const Tree tree = automatic(lumen);
        assert_int_equal(tree.branches.size(), 1);
        print(bend_mm > 0 ? "bent tube" : "straight tube", worst_in_tube(tree, 2.0, bend_mm));
        // The expected length of the centreline is measured between the two end planes of the tube.
        const double length = length_mm(tree.branches[0]);
        if (std::abs(length - 30) > 0.3) fail_msg("is %.2f mm long, expected 30", length);
    }
}

void check_fork(const Tree &tree, const char *what)
{
    Worst worst;
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        for (const Sphere &sphere : tree.branches[b].spheres) {
            const Truth truth = fork_truth(sphere.centre_mm);
            if (truth.other_mm < truth.radius_mm)
                continue; // there is no single true radius where vessels meet
            worst.centre = std::max(worst.centre, truth.off_mm / truth.radius_mm);
            worst.radius = std::max(worst.radius, std::abs(sphere.radius_mm / truth.radius_mm - 1));
            ++worst.spheres;
        }
    print(what, worst);
}

void a_fork_of_arcs_is_found_without_help(void **)
{
    const Lumen lumen(fork_mesh(0.4), coarse(), progress);
    AutoWish wish;
    wish.inlet_mm = Eigen::Vector3d(0, -20, 0);
    const Tree tree = automatic(lumen, wish);
    assert_int_equal(tree.branches.size(), 3);
    assert_int_equal(tree.branches[1].parent, 0);
    assert_int_equal(tree.branches[2].parent, 0);
    check_fork(tree, "fork, automatic");
    // The first and the last sphere of a branch touch the round ends of the vessel, so their centres are the
    // ends of the original curves.
    const double y = tree.branches[0].spheres.front().centre_mm.y();
    if (std::abs(y + 20) > 0.5) fail_msg("begins at y = %.2f, expected -20", y);
    for (int b : {1, 2}) {
        const Eigen::Vector3d end = tree.branches[b].spheres.back().centre_mm;
        const Eigen::Vector3d wanted(std::copysign(fork_bend_mm * (1 - std::cos(fork_angle)), end.x()),
                                     fork_bend_mm * std::sin(fork_angle), 0);
        if ((end - wanted).norm() > 0.5)
            fail_msg("ends %.2f mm from the end of the arc", (end - wanted).norm());
    }
}

std::vector<Point> fork_points()
{
    const double x = fork_bend_mm * (1 - std::cos(fork_angle)), y = fork_bend_mm * std::sin(fork_angle);
    return {{PointKind::start, "in", "", {0.4, -19, 0.3}},
            {PointKind::end, "left", "", {x, y - 0.5, 0.5}},
            {PointKind::bifurcation, "trunk", "", {0.3, 1, -0.5}},
            {PointKind::end, "right", "", {-x, y - 0.5, -0.4}}};
}

void points_of_a_person_give_the_same_fork(void **)
{
    const Lumen lumen(fork_mesh(0.4), coarse(), progress);
    std::vector<std::string> notes;
    const Tree tree = fit_points(lumen, fork_points(), {}, notes, progress);
    assert_int_equal(notes.size(), 0);
    assert_int_equal(tree.branches.size(), 3);
    assert_string_equal(tree.branches[0].name.c_str(), "trunk");
    assert_string_equal(tree.branches[1].name.c_str(), "left");
    assert_string_equal(tree.branches[2].name.c_str(), "right");
    for (int b : {1, 2}) {
        assert_int_equal(tree.branches[b].parent, 0);
        assert_int_equal(tree.branches[b].parent_sphere, tree.branches[0].spheres.size() - 1);
    }
    assert_true(tree.branches[0].spheres.front().is_manual && tree.branches[0].spheres.back().is_manual);
    assert_true(tree.branches[1].spheres.back().is_manual && !tree.branches[1].spheres[3].is_manual);
    check_fork(tree, "fork, by points");
    // From the points that the tool has proposed, the fit must find the same tree again.
    const Tree again = fit_points(lumen, points_of(tree), {}, notes, progress);
    assert_int_equal(again.branches.size(), 3);
    assert_string_equal(again.branches[2].name.c_str(), "right");
}

void without_a_bifurcation_point_the_ways_tell_where_they_part(void **)
{
    const Lumen lumen(fork_mesh(0.4), coarse(), progress);
    std::vector<Point> points = fork_points();
    points.erase(points.begin() + 2);
    std::vector<std::string> notes;
    const Tree tree = fit_points(lumen, points, {}, notes, progress);
    assert_int_equal(tree.branches.size(), 3);
    check_fork(tree, "fork, by its ends");
}

void points_that_cannot_be_used_are_named(void **)
{
    const Lumen lumen(fork_mesh(0.6), coarse(), progress);
    std::vector<std::string> notes;
    const auto with = [&](const std::function<void(std::vector<Point> &)> &change) {
        std::vector<Point> points = fork_points();
        change(points);
        return [&lumen, &notes, points] { fit_points(lumen, points, {}, notes, progress); };
    };
    says(with([](auto &p) { p.erase(p.begin()); }), {"no start point", "add one"});
    says(with([](auto &p) { p.resize(1); }), {"no end point"});
    says(with([](auto &p) {
             p[1].position_mm = {0, 90, 0};
         }),
         {"end point 'left'", "(0.0, 90.0, 0.0) mm", "outside"});
    says(with([](auto &p) {
             p[2].position_mm = {-5, 18, 0}, p.pop_back();
         }),
         {"bifurcation point 'trunk'", "no way"});
    says(with([](auto &p) { p[1].name = "right"; }), {"two points are called 'right'"});
    says(with([](auto &p) { p[1].after = "right"; }), {"comes after 'right'", "no start or bifurcation"});
    says(with([](auto &p) { p[2].after = "trunk"; }), {"circle"});
    std::vector<Point> one_end = fork_points();
    one_end.pop_back();
    fit_points(lumen, one_end, {}, notes, progress);
    assert_true(!notes.empty() && notes.back().find("only 1 branch leaves") != std::string::npos);
}

void short_stubs_are_pruned(void **)
{
    // The tests use a tube with a bump of half a radius, and a tube with a side branch.
    for (double reach_mm : {3.5, 12.0}) {
        std::vector<Branch> lines(2);
        for (int i = 0; i <= 30; ++i) lines[0].spheres.push_back({{0, 1.0 * i, 0}, 3});
        for (int i = 0; i <= 12; ++i) lines[1].spheres.push_back({{(reach_mm - 1.5) * i / 12, 15, 0}, 1.5});
        const Lumen lumen(bake::surface_of(lines, 0.4, progress), coarse(), progress);
        assert_int_equal(automatic(lumen).branches.size(), reach_mm > 10 ? 3 : 1);
    }
}

// A ball has no length. Before, such a mesh gave a tree of length 0 and the exit code 0.
void a_tree_without_length_is_refused(void **)
{
    std::vector<Branch> ball(1);
    ball[0].spheres = {{{0, 0, 0}, 5}, {{0, 0.01, 0}, 5}};
    const Lumen lumen(bake::surface_of(ball, 0.5, progress), coarse(), progress);
    says([&] { automatic(lumen); }, {"only 0.", "mm long", "--inlet", "--part"});
}

// A spike beside a crack has voxels of next to no depth, from which no path leads away.
void an_inlet_leads_away_even_beside_a_voxel_without_neighbours(void **)
{
    bake::Mesh mesh = tube_mesh(3, 60, 0, 60, 24);
    mesh.triangles.erase(mesh.triangles.begin() + 700);
    mesh.vertices_mm[24 * 30] *= 1.6;
    const Lumen lumen(mesh, coarse(), progress);
    for (const Eigen::Vector3d &inlet : {Eigen::Vector3d(4.6, 30, 0), Eigen::Vector3d(0, -0.5, 0)}) {
        AutoWish wish;
        wish.inlet_mm = inlet;
        double length = 0;
        for (const Branch &branch : automatic(lumen, wish).branches) length += length_mm(branch);
        assert_true(length > 25);
    }
}

// Makes the mesh of one frame of a heartbeat, in which a forked vessel bends out of its plane, shifts and
// narrows.
Eigen::Vector3d beaten(const Eigen::Vector3d &p, int frame)
{
    const double beat = std::sin(turn * frame / 24), squeeze = 1 - 0.06 * beat * beat;
    return {p.x() * squeeze + 2 * beat, p.y() + 1.5 * beat,
            p.z() * squeeze + 6 * beat * std::sin(p.y() / 25)};
}

void a_beating_fork_keeps_its_spheres_and_their_order(void **)
{
    const Folder folder;
    const bake::Mesh mesh = fork_mesh(0.7);
    for (int frame = 0; frame < 24; ++frame) {
        bake::Mesh moved = mesh;
        for (Eigen::Vector3d &v : moved.vertices_mm) v = beaten(v, frame);
        write_obj(folder.path / ("heart" + std::to_string(frame) + ".obj"),
                  moved); // heart10 sorts before heart2 by name
    }
    const Lumen lumen(mesh, coarse(), progress);
    AutoWish wish;
    wish.inlet_mm = Eigen::Vector3d(0, -20, 0);
    wish.grow.spacing = 1.0;
    const Tree tree = automatic(lumen, wish);
    bake::MeshText text;
    text.placement.unit = "mm";
    const std::vector<std::filesystem::path> files = frames_of(folder.path);
    assert_int_equal(files.size(), 24);
    const std::vector<Frame> frames = carried(tree, files, text, {}, progress);
    double worst = 0, worst_where_vessels_meet = 0; // in radii
    for (int n = 0; n < 24; ++n) {
        const Tree &now = frames[n].tree;
        check_tree(now, frames[n].name);
        assert_int_equal(now.branches.size(), tree.branches.size());
        for (std::size_t b = 0; b < now.branches.size(); ++b) {
            const Branch &branch = now.branches[b], &first = tree.branches[b];
            assert_int_equal(branch.parent, first.parent);
            assert_int_equal(branch.parent_sphere, first.parent_sphere);
            assert_int_equal(branch.spheres.size(), first.spheres.size());
            for (std::size_t i = 0; i < branch.spheres.size(); ++i) {
                const Eigen::Vector3d &at = branch.spheres[i].centre_mm;
                const Eigen::Vector3d &was = first.spheres[i].centre_mm;
                const Truth truth = fork_truth(was);
                double &largest = truth.other_mm < truth.radius_mm ? worst_where_vessels_meet : worst;
                largest = std::max(largest, (at - beaten(was, n)).norm() / truth.radius_mm);
                if (i == 0) continue;
                const Eigen::Vector3d then = first.spheres[i].centre_mm - first.spheres[i - 1].centre_mm,
                                      step = at - branch.spheres[i - 1].centre_mm;
                if (step.dot(then) <= 0)
                    fail_msg("frame %d, branch %zu: sphere %zu stands before the one before", n, b, i);
            }
        }
    }
    std::printf(
        "# a beating fork: spheres within %.1f %% of a radius from where their points went (%.1f %% where "
        "vessels meet)\n",
        100 * worst, 100 * worst_where_vessels_meet);
    assert_true(worst <
                centre_share); // the middle of the moved vessel differs slightly from the moved middle
    assert_true(worst_where_vessels_meet < 0.3);
}

void frames_of_another_topology_are_refused(void **)
{
    const Folder folder;
    bake::Mesh mesh = fork_mesh(0.9);
    write_obj(folder.path / "f0.obj", mesh);
    says([&] { frames_of(folder.path); }, {"holds 1 meshes"});
    std::swap(mesh.triangles[5], mesh.triangles[6]);
    write_obj(folder.path / "f1.obj", mesh);
    Tree tree;
    tree.branches.push_back(straight("t", {0, -18, 0}, {0, -5, 0}, 9, 3, 3));
    bake::MeshText text;
    text.placement.unit = "mm";
    says([&] { carried(tree, frames_of(folder.path), text, {}, progress); },
         {"f1.obj", "triangle 5", "one topology"});
    mesh.triangles.pop_back();
    write_obj(folder.path / "f1.obj", mesh);
    says([&] { carried(tree, frames_of(folder.path), text, {}, progress); }, {"f1.obj"});
    says([&] { frames_of(folder.path / "none"); }, {"none", "cannot be read"});
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_straight_and_a_bent_tube_are_recovered_to_their_openings),
                                cmocka_unit_test(a_fork_of_arcs_is_found_without_help),
                                cmocka_unit_test(points_of_a_person_give_the_same_fork),
                                cmocka_unit_test(without_a_bifurcation_point_the_ways_tell_where_they_part),
                                cmocka_unit_test(points_that_cannot_be_used_are_named),
                                cmocka_unit_test(short_stubs_are_pruned),
                                cmocka_unit_test(a_tree_without_length_is_refused),
                                cmocka_unit_test(an_inlet_leads_away_even_beside_a_voxel_without_neighbours),
                                cmocka_unit_test(a_beating_fork_keeps_its_spheres_and_their_order),
                                cmocka_unit_test(frames_of_another_topology_are_refused)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
