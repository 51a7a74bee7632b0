// These tests check the vessels of the shipped man's lungs (docs/anatomy.md): how many there are, how wide
// and how long, that they end before the pleura, and that their tubes are closed and keep the area of a round
// vessel.
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/soft/lung_vessels.hpp"
#include "tools/anatomy/soft/tube_mesh.hpp"
#include "tools/anatomy/vessel_file.hpp"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace anatomy;

namespace
{

struct Lung {
    LocalDistance distance;
    Box box;
    LungSpace space;
    std::vector<LungTree> trees; // arteries, veins

    Lung(const MeshRequest &request, LungSide side)
        : distance(request.distance_in), box(request.bounds),
          space(distance, box), trees{lung_arteries(side, space, box), lung_veins(side, space, box)}
    {
    }
};

const std::vector<Lung> &lungs()
{
    static const std::vector<Lung> both = [] {
        std::vector<Lung> made;
        for (const Body &body : patient_bodies(shipped_vessels("aorta"), {})) {
            if (body.name == "lung_right") made.emplace_back(body.request, LungSide::right);
            if (body.name == "lung_left") made.emplace_back(body.request, LungSide::left);
        }
        return made;
    }();
    return both;
}

/* The length of those pieces of all vessels that are wider than this. */
double length_mm(const LungTree &tree, double wider_than_mm)
{
    double sum = 0.0;
    for (const LungVessel &vessel : tree.vessels)
        for (size_t i = 0; i + 1 < vessel.course.size(); i++)
            if (2.0 * vessel.course[i + 1].radius_mm > wider_than_mm)
                sum += (vessel.course[i + 1].position_mm - vessel.course[i].position_mm).norm();
    return sum;
}

double depth_mm(const Lung &lung, const Vec3 &point)
{
    Box here;
    here.include(point, 0.0);
    return -lung.distance(here, LungSpace::REACH_MM)(point);
}

// Singhal 1973 (Circ. Res. 33:190, one cast, from memory) has orders of 1.33, 2.09, 3.65, 5.82, 8.06, 14.8
// and 30 mm, with 675, 203, 66, 20, 8, 3 and 1 arteries of 6.6, 10.5, 17.9, 20.7, 10.9, 32.0 and 90.5 mm.
// Without the last two orders, which lie outside the lungs: 8.3 m that are wider than 1.06 mm, half-way to
// the next order, and 1.7 m wider than 2.76 mm. The model has 0.76 and 0.58 of them: each narrow vessel costs
// time in every picture.
void the_arteries_are_as_long_as_those_of_a_cast(void **)
{
    double narrow_mm = 0.0, wide_mm = 0.0;
    for (const Lung &lung : lungs()) {
        narrow_mm += length_mm(lung.trees[0], 1.06);
        wide_mm += length_mm(lung.trees[0], 2.76);
    }
    std::printf("# wider than 1.06 mm: %.0f mm, cast 8300 mm; wider than 2.76 mm: %.0f mm, cast 1700 mm\n",
                narrow_mm, wide_mm);
    assert_true(narrow_mm > 0.5 * 8300.0 && narrow_mm < 8300.0);
    assert_true(wide_mm > 0.4 * 1700.0 && wide_mm < 1700.0);
}

// Arteries and veins of a lung have 390 to 475 ends each, all of them 1 mm wide.
void hundreds_of_vessels_become_one_millimetre_wide(void **)
{
    for (const Lung &lung : lungs())
        for (const LungTree &tree : lung.trees) {
            double least_mm = 1e9, widest_mm = 0.0;
            for (const LungVessel &vessel : tree.vessels) {
                least_mm = std::min(least_mm, 2.0 * vessel.course.back().radius_mm);
                widest_mm = std::max(widest_mm, 2.0 * vessel.course.front().radius_mm);
                assert_true(std::is_sorted(
                    vessel.course.begin(), vessel.course.end(),
                    [](const CurvePoint &a, const CurvePoint &b) { return a.radius_mm > b.radius_mm; }));
            }
            std::printf("# %zu ends; %.2f to %.1f mm wide\n", tree.ends, least_mm, widest_mm);
            assert_true(tree.ends > 350 && tree.ends < 520);
            assert_true(std::abs(least_mm - 1.0) < 1e-9);
        }
}

// Measured: the tubes keep 1.5 mm from the surface of the lung, and their ends 7 mm. The body's wide part
// keeps 1.3 mm (soft/bodies.cpp).
void the_vessels_end_before_the_pleura(void **)
{
    for (const Lung &lung : lungs()) {
        const Mesh mesh = narrow_lung_vessels(lung.trees, lung.space);
        assert_string_equal(closed_mesh_fault(mesh).c_str(), "");
        double nearest_mm = 1e9, end_mm = 1e9;
        for (const Vec3 &vertex : mesh.vertices_mm) nearest_mm = std::min(nearest_mm, depth_mm(lung, vertex));
        for (const LungTree &tree : lung.trees)
            for (const LungVessel &vessel : tree.vessels)
                end_mm = std::min(end_mm, depth_mm(lung, vessel.course.back().position_mm));
        std::printf("# %zu triangles, %.1f ml; nearest %.2f mm, ends %.2f mm\n", mesh.triangles.size(),
                    mesh_volume_mm3(mesh) * 1e-3, nearest_mm, end_mm);
        assert_true(nearest_mm > 1.0);
        assert_true(end_mm > 5.0);
    }
}

// A prism with the area of the circle has its volume, whatever the number of sides.
void a_tube_has_the_volume_of_a_round_vessel(void **)
{
    for (const int sides : {3, 4, 6}) {
        Mesh mesh;
        add_tube(mesh, {{{1, 2, 3}, 0.5, 0}, {{1, 2, 13}, 0.5, 0}, {{1, 2, 25}, 0.5, 0}}, sides);
        assert_string_equal(closed_mesh_fault(mesh).c_str(), "");
        const double wanted_mm3 = std::numbers::pi * 0.25 * 22.0;
        if (std::abs(mesh_volume_mm3(mesh) - wanted_mm3) > 1e-9 * wanted_mm3)
            fail_msg("%d sides: %.6f mm3, wanted %.6f", sides, mesh_volume_mm3(mesh), wanted_mm3);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_arteries_are_as_long_as_those_of_a_cast),
        cmocka_unit_test(hundreds_of_vessels_become_one_millimetre_wide),
        cmocka_unit_test(the_vessels_end_before_the_pleura),
        cmocka_unit_test(a_tube_has_the_volume_of_a_round_vessel),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
