// These tests check the following. The inverse of the map with which `bake` narrows a lesion's wall is exact
// to a hundredth of a millimetre. The surface of the blood returns to the healthy wall by as much as the
// lesion is open at each station (point), and changes nowhere else. Calcium is pushed outwards and keeps its
// volume, also in a beating heart. No mesh changes while no lesion is open. Shapes have closed forms.
#include "host/model/lesion_wall.hpp"
#include "host/model/opened_bodies.hpp"
#include "host/stent/tests/stent_heart.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;
constexpr double radius_mm = 2.0, stenosis = 0.7, aside = 0.4;
constexpr double throat_mm = radius_mm * (1 - stenosis);

// The tube is 60 mm long along y and 2 mm wide, with a side branch at 38 mm. The lesion narrows the tube by
// 70 % over 16 mm about y = 30. The channel through the lesion is off the axis by 0.4 of the lost diameter.
VesselTree tube_tree()
{
    VesselTree tree;
    tree.branches.resize(2);
    VesselBranch &branch = tree.branches[0];
    branch.name = "LAD";
    VesselLesion lesion;
    lesion.name = "plaque";
    for (int i = 0; i <= 120; ++i) {
        const double y = 0.5 * i, u = (y - 30) / 16;
        const bool is_in = std::abs(u) <= 0.5;
        const double lost = is_in ? stenosis * 0.5 * (1 + std::cos(2 * pi * u)) : 0;
        branch.points_m.push_back(Vector3d(0, y, -aside * lost * radius_mm) * 1e-3);
        branch.radii_m.push_back((1 - lost) * radius_mm * 1e-3);
        if (!is_in) continue;
        if (lesion.healthy_radii_m.empty()) lesion.first_point = static_cast<std::size_t>(i);
        lesion.healthy_points_m.push_back(Vector3d(0, y, 0) * 1e-3);
        lesion.healthy_radii_m.push_back(radius_mm * 1e-3);
    }
    tree.branches[1] = {"diagonal", 0, 76, {{0, 38e-3, 0}, {12e-3, 42e-3, 0}}, {1e-3, 1e-3}};
    tree.lesions.push_back(lesion);
    return tree;
}

const LesionStations stations{17, 1e-3};

// Makes a tube along y as a closed mesh, in um. The mesh has a ring of 32 vertices every half millimetre, and
// a vertex in the middle of each end.
Body tube(double radius, double length_mm)
{
    Body body{"lumen", "blood", -1, {}, {}};
    const auto rows = static_cast<std::uint32_t>(std::lround(2 * length_mm)) + 1;
    constexpr std::uint32_t around = 32;
    const auto add = [&](const Vector3d &v_mm) {
        body.vertices_um.push_back((v_mm * 1e3).array().round().matrix().cast<int>());
    };
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t k = 0; k < around; ++k)
            add({radius * std::cos(2 * pi * k / around), 0.5 * row, radius * std::sin(2 * pi * k / around)});
    add({0, 0, 0});
    add({0, length_mm, 0});
    for (std::uint32_t k = 0; k < around; ++k) {
        const std::uint32_t next = (k + 1) % around, last = (rows - 1) * around;
        for (std::uint32_t row = 0; row + 1 < rows; ++row) {
            const std::uint32_t a = row * around + k, b = row * around + next;
            body.triangles.push_back({a, a + around, b});
            body.triangles.push_back({b, a + around, b + around});
        }
        body.triangles.push_back({rows * around, k, next});
        body.triangles.push_back({rows * around + 1, last + next, last + k});
    }
    return body;
}

void narrow(Body &body, const VesselTree &tree)
{
    const LesionWall wall(tree, 0);
    for (Eigen::Vector3i &v_um : body.vertices_um)
        v_um += (wall.way_m(v_um.cast<double>() * 1e-6) * 1e6).array().round().matrix().cast<int>();
}

double off_mm(const Eigen::Vector3i &a_um, const Eigen::Vector3i &b_um)
{
    return (a_um - b_um).cast<double>().norm() * 1e-3;
}

double volume_mm3(const Body &body, std::span<const Eigen::Vector3i> vertices_um)
{
    double sum = 0;
    for (const auto &corners : body.triangles) {
        const auto at = [&](int k) -> Vector3d {
            return vertices_um[corners[static_cast<std::size_t>(k)]].cast<double>() * 1e-3;
        };
        sum += at(0).dot(at(1).cross(at(2))) / 6;
    }
    return sum;
}

// The test covers a grid of radii and angles at the narrowest point: near the wall, beside the branch, and in
// the transition to the region that does not move.
void the_map_of_a_wall_is_undone(void **)
{
    const LesionWall wall(tube_tree(), 0);
    double worst_mm = 0;
    int moved = 0;
    const LesionWall bent(beating_artery(true), 0);
    for (int i = 0; i < 2000; ++i) { // a spiral about the artery's bend, 1.4 mm off its line
        const double s = 20 + 0.005 * i, angle = 0.1 * i, at = s - artery_middle_mm;
        const Vector3d across = Vector3d(-0.02 * at, 1, 0).normalized();
        const Vector3d from = (Vector3d(s, 0.01 * at * at, 0) +
                               1.4 * (std::cos(angle) * across + std::sin(angle) * Vector3d::UnitZ())) *
                              1e-3;
        LesionWall::Healthy back;
        if (!bent.healthy_of(from + bent.way_m(from), back)) back.place_m = from;
        worst_mm = std::max(worst_mm, (back.place_m - from).norm() * 1e3);
    }
    for (double y = 20; y <= 40; y += 0.7)
        for (double r = 0.5; r < 2.4 * radius_mm; r += 0.3)
            for (int k = 0; k < 16; ++k) {
                const Vector3d from = Vector3d(r * std::cos(pi * k / 8), y, r * std::sin(pi * k / 8)) * 1e-3;
                const Vector3d to = from + wall.way_m(from);
                LesionWall::Healthy back;
                if (!wall.healthy_of(to, back)) back.place_m = to;
                moved += (to - from).norm() > 0.1e-3;
                const double again = (back.place_m + wall.way_m(back.place_m) - to).norm() * 1e3;
                worst_mm = std::max(worst_mm, again);
                if (r <= lesion_near_radii * radius_mm &&
                    y < 35) // beyond, the transition folds: more than one place maps there
                    worst_mm = std::max(worst_mm, (back.place_m - from).norm() * 1e3);
            }
    print_message("# %d places, undone within %.5f mm\n", moved, worst_mm);
    assert_true(moved > 1000);
    assert_true(worst_mm < 0.01); // at a corner of the line there may be two feet
}

void opened_wholly_a_body_is_the_healthy_one_and_half_open_half_way(void **)
{
    Bodies bodies{{tube(radius_mm, 60)}, tube_tree()};
    const std::vector<Eigen::Vector3i> healthy_um = bodies.bodies[0].vertices_um;
    narrow(bodies.bodies[0], bodies.vessels);
    const std::vector<Eigen::Vector3i> narrow_um = bodies.bodies[0].vertices_um;
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&stations, 1}), nullptr);
    const auto moved_to = [&](double share) {
        const auto vertices_um = opened.at({}, std::vector<double>(17, share))[0].vertices_um;
        return std::vector<Eigen::Vector3i>(vertices_um.begin(), vertices_um.end());
    };
    const std::vector<Eigen::Vector3i> whole_um = moved_to(1.0), half_um = moved_to(0.5);
    double whole_mm = 0, half_mm = 0;
    std::size_t moved = 0;
    for (std::size_t i = 0; i < healthy_um.size(); ++i) {
        moved += narrow_um[i] != healthy_um[i];
        whole_mm = std::max(whole_mm, off_mm(whole_um[i], healthy_um[i]));
        half_mm = std::max(half_mm, off_mm(2 * half_um[i], narrow_um[i] + healthy_um[i]));
    }
    print_message("# %zu vertices of %zu: %.4f mm off the healthy ones\n", opened.vertex_count(),
                  healthy_um.size(), whole_mm);
    assert_true(whole_mm < 4e-3 && half_mm < 6e-3);
    assert_true(opened.vertex_count() >= moved && opened.vertex_count() < moved + 40);
}

// The narrowest point of the lesion is at y = 30 mm. Only the lesion's points from y = 27 to 33 mm are open:
// the opening (1 means fully open) is 0.6 in the middle and falls to 0 at both ends.
void a_body_opens_station_by_station(void **)
{
    Bodies bodies{{tube(radius_mm, 60)}, tube_tree()};
    narrow(bodies.bodies[0], bodies.vessels);
    const std::vector<Eigen::Vector3i> narrow_um = bodies.bodies[0].vertices_um;
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&stations, 1}), nullptr);
    std::vector<double> open(17, 0.0);
    for (int i = 6; i <= 10; ++i) open[static_cast<std::size_t>(i)] = 0.6 - 0.2 * std::abs(i - 8);
    const auto moved = opened.at({}, open);
    const double middle_mm = 0.4 * -aside * stenosis * radius_mm; // 1 - 0.6 of it
    for (std::size_t i = 0; i < narrow_um.size(); ++i) {
        const Eigen::Vector3i now = moved[0].vertices_um[i];
        if (std::abs(narrow_um[i].y() - 30000) >= 3000) assert_true(now == narrow_um[i]);
        if (narrow_um[i].y() != 30000) continue;
        const double r = std::hypot(now.x() * 1e-3, now.z() * 1e-3 - middle_mm);
        if (std::fabs(r - (throat_mm + 0.6 * (radius_mm - throat_mm))) > 5e-3) fail_msg("%.4f mm", r);
    }
}

void while_nothing_is_open_nothing_is_touched(void **)
{
    Bodies bodies{{tube(radius_mm, 60)}, tube_tree()};
    narrow(bodies.bodies[0], bodies.vessels);
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&stations, 1}), nullptr);
    assert_true(opened.at({}, std::vector<double>(17, 0.0)).empty());
    assert_true(opened.at({}, {}).empty()); // a device that reports no lesions
    assert_int_equal(opened.at({}, std::vector<double>(17, 0.1)).size(), 1);
    assert_true(opened.at({}, std::vector<double>(17, 0.0)).empty());
}

// Only the blood of the lesion's vessel may change; a heart chamber beside the vessel and the flesh around it
// must not.
void other_bodies_stay(void **)
{
    Bodies bodies{{tube(radius_mm, 60), tube(10, 60), tube(1, 60)}, tube_tree()};
    bodies.bodies[1].material = "soft_tissue";
    for (Eigen::Vector3i &v_um : bodies.bodies[2].vertices_um) v_um.x() += 3500; // blood 2.5 mm beside it
    narrow(bodies.bodies[0], bodies.vessels);
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&stations, 1}), nullptr);
    const auto moved = opened.at({}, std::vector<double>(17, 1.0));
    assert_int_equal(moved.size(), 1);
    assert_int_equal(moved[0].body, 0);
}

// A half shell of calcium lies around the channel of the lesion, 1.6 to 1.9 mm from its middle. The calcium
// must end up outside the opened lumen, with its volume unchanged.
void calcium_goes_out_with_the_wall_and_keeps_its_volume(void **)
{
    Bodies bodies{{tube(radius_mm, 60), tube(1.0, 8)}, tube_tree()};
    Body &calcium = bodies.bodies[1];
    calcium.name = "plaque_calcium";
    calcium.material = "bone_cortical";
    // The tube is bent into a half shell: its x coordinate becomes the angle, and its z coordinate the
    // distance from the middle.
    for (Eigen::Vector3i &v_um : calcium.vertices_um) {
        const double angle = v_um.x() * 1e-3, r = 1.75 + 0.15 * v_um.z() * 1e-3;
        v_um = (Vector3d(r * std::sin(angle), 26 + v_um.y() * 1e-3, r * std::cos(angle) - 0.4) * 1e3)
                   .array()
                   .round()
                   .matrix()
                   .cast<int>();
    }
    narrow(bodies.bodies[0], bodies.vessels);
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&stations, 1}), nullptr);
    for (const double share : {0.5, 1.0}) {
        const auto moved = opened.at({}, std::vector<double>(17, share));
        assert_int_equal(moved.size(), 2);
        double nearest_mm = 1e9;
        for (const Eigen::Vector3i &v : moved[1].vertices_um) {
            const double u = (v.y() * 1e-3 - 30) / 16,
                         lost = (1 - share) * stenosis * 0.5 * (1 + std::cos(2 * pi * u)) * radius_mm;
            nearest_mm = std::min(nearest_mm,
                                  std::hypot(v.x() * 1e-3, v.z() * 1e-3 + aside * lost) - (radius_mm - lost));
        }
        const double ratio =
            volume_mm3(calcium, moved[1].vertices_um) / volume_mm3(calcium, calcium.vertices_um);
        print_message("# open by %.1f: %.3f mm outside the lumen, %.3f of its volume\n", share, nearest_mm,
                      ratio);
        assert_true(nearest_mm > 0.02);
        assert_true(std::fabs(ratio - 1) < 0.08);
    }
}

// In a beating heart the opened wall must be where the heart moves the wall of the healthy vessel.
void in_a_heart_that_beats_the_open_wall_beats(void **)
{
    const BeatingLattice lattice;
    Bodies bodies{{}, beating_artery(true)};
    Body body = tube(1.5, 50);
    for (Eigen::Vector3i &v_um : body.vertices_um) { // along x, in the artery's bend
        const double s = v_um.y() * 1e-3 - artery_middle_mm;
        v_um = {v_um.y(), v_um.x() + static_cast<int>(std::lround(0.01 * s * s * 1e3)), v_um.z()};
    }
    for (auto &corners : body.triangles) std::swap(corners[0], corners[1]); // mirrored
    body.moves = true;
    const std::vector<Eigen::Vector3i> healthy_um = body.vertices_um;
    narrow(body, bodies.vessels);
    bodies.bodies = {body};
    MovingBodies moving(*lattice.motion, bodies);
    const LesionStations of_artery{13, 1e-3};
    OpenedBodies opened(bodies, LesionOpening(bodies.vessels, {&of_artery, 1}), &*lattice.motion);
    double worst_mm = 0, way_mm = 0;
    for (int key = 0; key < 24; key += 5) {
        const MotionMoment moment{static_cast<std::uint32_t>((std::uint64_t(key) << 32) / 24), 0};
        const auto &at = opened.at(moment, std::vector<double>(13, 1.0), moving.at(moment));
        assert_int_equal(at.size(), 1);
        for (std::size_t i = 0; i < healthy_um.size(); ++i) {
            const Vector3d there_um = lattice.motion->push(healthy_um[i].cast<double>() * 1e-6, moment) * 1e6;
            worst_mm = std::max(worst_mm, (at[0].vertices_um[i].cast<double>() - there_um).norm() * 1e-3);
            way_mm = std::max(way_mm, (there_um - healthy_um[i].cast<double>()).norm() * 1e-3);
        }
        assert_true(moving.at(moment)[0].vertices_um[0] ==
                    at[0].vertices_um[0]); // far from it, where the heart moves it
    }
    print_message("# moved by up to %.1f mm, off by %.4f mm\n", way_mm, worst_mm);
    assert_true(way_mm > 4 && worst_mm < 0.01);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_map_of_a_wall_is_undone),
        cmocka_unit_test(opened_wholly_a_body_is_the_healthy_one_and_half_open_half_way),
        cmocka_unit_test(a_body_opens_station_by_station),
        cmocka_unit_test(while_nothing_is_open_nothing_is_touched),
        cmocka_unit_test(other_bodies_stay),
        cmocka_unit_test(calcium_goes_out_with_the_wall_and_keeps_its_volume),
        cmocka_unit_test(in_a_heart_that_beats_the_open_wall_beats),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
