// Checks where vessels are shown that tools have pushed aside: the tools at rest lie where the vessel is, and
// a place of the vessel moves with the part of the tools that is nearest.
#include "host/patient/pushed_vessels.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

#include <cmocka.h>

namespace
{

using crn::PushedVessels;
using crn::WireFrame;
using Eigen::Vector3d;

// Tools along +x, from the tip at x = 0.2 m; the vessel is pushed by 8 mm towards +y at station 4, 31 mm
// behind the tip, and by half as much at its neighbours.
WireFrame pushed_frame()
{
    WireFrame wire;
    wire.walls.resize(6);
    wire.walls[4].way_m = {0, 8e-3, 0};
    wire.walls[4].widened_m = 1e-3;
    wire.walls[3].way_m = wire.walls[5].way_m = {0, 4e-3, 0};
    for (int i = 0; i <= 100; ++i) {
        const double arc_m = 2e-3 * i;
        wire.nodes.push_back({{0.2 - arc_m, crn::wall_way(wire, arc_m).way_m.y(), 0}, arc_m});
    }
    return wire;
}

void a_way_is_linear_between_stations_and_ends_behind_the_last(void **)
{
    const WireFrame wire = pushed_frame();
    const double spacing = crn::wall_spacing_m;
    assert_true(std::abs(crn::wall_way(wire, 4 * spacing).way_m.y() - 8e-3) < 1e-12);
    assert_true(std::abs(crn::wall_way(wire, 3.25 * spacing).way_m.y() - 5e-3) < 1e-12);
    assert_true(std::abs(crn::wall_way(wire, 5.5 * spacing).way_m.y() - 2e-3) < 1e-12);
    assert_true(std::abs(crn::wall_way(wire, 4.5 * spacing).widened_m - 0.5e-3) < 1e-12);
    assert_true(crn::wall_way(wire, 6 * spacing).way_m.isZero(0));
    assert_true(crn::wall_way(wire, -1).way_m.isZero(0));
}

void the_tools_at_rest_lie_on_the_axis(void **)
{
    const WireFrame rest = crn::at_rest(pushed_frame());
    assert_true(rest.walls.empty());
    for (const crn::WireNode &node : rest.nodes) assert_true(std::abs(node.position_m.y()) < 1e-12);
}

void a_place_moves_with_the_nearest_part_of_the_tools(void **)
{
    const PushedVessels pushed(pushed_frame());
    const double x_m = 0.2 - 4 * crn::wall_spacing_m;
    assert_false(pushed.is_empty());
    // nodes every 2 mm stand for the stations, so the peak is rounded off
    assert_true(std::abs(pushed.way_m({x_m, 0, 0}).y() - 8e-3) < 0.5e-3);
    const double beside = pushed.way_m({x_m, 0, 0.01}).y() / pushed.way_m({x_m, 0, 0}).y();
    assert_true(std::abs(beside - std::exp(-0.16)) < 1e-9);
    assert_true(pushed.way_m({x_m, 0, 0.06}).isZero(0));
    assert_true(pushed.way_m({0.1, 0, 0}).norm() < 1e-6);
}

void vessels_at_rest_need_no_work(void **)
{
    WireFrame wire = pushed_frame();
    wire.walls.clear();
    assert_true(PushedVessels(wire).is_empty());
    assert_true(PushedVessels(wire).way_m({0.17, 0, 0}).isZero(0));
    wire.walls.resize(3);
    assert_true(PushedVessels(wire).is_empty());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_way_is_linear_between_stations_and_ends_behind_the_last),
        cmocka_unit_test(the_tools_at_rest_lie_on_the_axis),
        cmocka_unit_test(a_place_moves_with_the_nearest_part_of_the_tools),
        cmocka_unit_test(vessels_at_rest_need_no_work),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
