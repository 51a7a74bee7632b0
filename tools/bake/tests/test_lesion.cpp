// These tests check the following. A lesion narrows the vessel tree, the surface and the distance field
// equally, as the scene's text states. Outside the lesion the vessel stays unchanged, and the mesh stays
// closed with its vertices in place. If a value in the text does not fit the vessel, the error message names
// this value.
extern "C" {
#include "firmware/core/lesion.h"
}
#include "host/model/opened_bodies.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/field.hpp"
#include "tools/bake/lesion.hpp"
#include "tools/bake/tests/shapes.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <optional>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::bake;
using namespace crn::bake::tests;
using Eigen::Vector3d;

namespace
{

constexpr double radius_mm = 2.0;

// Makes a tube of radius 2 mm along y, from 0 to 60 mm, with points 5 mm apart and a side branch at 45 mm.
VesselTree tree_of_tube()
{
    VesselTree tree;
    tree.branches.resize(2);
    tree.branches[0].name = "lad";
    for (int i = 0; i <= 12; ++i) {
        tree.branches[0].points_m.emplace_back(0, 5e-3 * i, 0);
        tree.branches[0].radii_m.push_back(radius_mm * 1e-3);
    }
    tree.branches[1].name = "diagonal";
    tree.branches[1].parent = 0;
    tree.branches[1].parent_point = 9;
    tree.branches[1].points_m = {{0, 45e-3, 0}, {20e-3, 50e-3, 0}};
    tree.branches[1].radii_m = {1e-3, 1e-3};
    return tree;
}

LesionText plaque(double eccentricity = 0)
{
    LesionText text;
    text.name = "plaque";
    text.branch = "lad";
    text.at_mm = 30;
    text.length_mm = 16;
    text.stenosis_percent = 70;
    text.eccentricity = eccentricity;
    return text;
}

Mesh capped_tube()
{
    Mesh mesh = tube(radius_mm, 60, 30, 32);
    check_closed(mesh, Cap::flat);
    return mesh;
}

void the_channel_is_the_cosine_of_the_text(void **)
{
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {plaque()});
    const VesselLesion &lesion = tree.lesions.at(0);
    const VesselBranch &lad = tree.branches[0];
    for (std::size_t i = 0; i < lad.points_m.size(); ++i) {
        const double u = (lad.points_m[i].y() * 1e3 - 30) / 16;
        const double left = std::abs(u) < 0.5 ? 1 - 0.7 * 0.5 * (1 + std::cos(turn * u)) : 1;
        assert_true(std::abs(lad.radii_m[i] * 1e3 - radius_mm * left) <
                    2e-3); // the file holds micrometres, and u comes from rounded places
        assert_true(std::hypot(lad.points_m[i].x(), lad.points_m[i].z()) < 1e-9);
    }
    assert_true(std::abs(lad.radii_m[tree.throat(lesion)] - 0.6e-3) < 2e-6);
    assert_true(lad.points_m.front().y() == 0 && std::abs(lad.points_m.back().y() - 60e-3) < 1e-12);
    for (double healthy : lesion.healthy_radii_m) assert_true(std::abs(healthy - radius_mm * 1e-3) < 1e-9);
}

// Small vessels, too: septal arteries had left before the lesion instead of behind it.
void side_branches_still_leave_where_they_left(void **)
{
    VesselTree tree = tree_of_tube();
    VesselBranch septal = tree.branches[1];
    septal.parent_point = 10;
    septal.points_m = {{0, 50e-3, 0}, {0, 50e-3, -20e-3}};
    tree.small.push_back(septal);
    place_lesions(tree, {plaque()});
    assert_true(std::abs(tree.branches[0].points_m[tree.branches[1].parent_point].y() - 45e-3) < 1e-9);
    assert_true(std::abs(tree.branches[0].points_m[tree.small[0].parent_point].y() - 50e-3) < 1e-9);
    std::string error;
    assert_true(check_vessel_tree(tree, error));
}

// With plaque in front (+z) the narrowed channel lies towards the back; with an eccentricity of 1 it touches
// the healthy back wall.
void an_eccentric_channel_lies_away_from_the_plaque(void **)
{
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {plaque(1)});
    const Vector3d middle = tree.branches[0].points_m[tree.throat(tree.lesions[0])];
    assert_true(std::abs(middle.z() + 1.4e-3) < 5e-6 && std::abs(middle.x()) < 1e-9);
    LesionText left = plaque(1);
    left.plaque_deg = 90; // right-handed about +y: from +z towards +x, the patient's left
    tree = tree_of_tube();
    place_lesions(tree, {left});
    assert_true(tree.branches[0].points_m[tree.throat(tree.lesions[0])].x() < -1.39e-3);
}

// At each point of the vessel tree, the distance to the wall of the mesh equals the radius. Chords of 0.4 mm
// length in a circle of 2 mm radius lie up to 0.01 mm inside the circle.
void the_surface_goes_with_the_tree(void **)
{
    for (double eccentricity : {0.0, 0.6}) {
        VesselTree tree = tree_of_tube();
        place_lesions(tree, {plaque(eccentricity)});
        Mesh mesh = capped_tube();
        const Mesh before = mesh;
        refine_lesions(mesh, tree);
        for (std::size_t i = 0; i < before.vertices_mm.size(); ++i)
            assert_true(mesh.vertices_mm[i] == before.vertices_mm[i]);
        assert_true(mesh.triangles.size() > 4 * before.triangles.size());
        assert_true(std::abs(volume_mm3(mesh) - volume_mm3(before)) < 1e-6);
        const std::vector<bool> moved = narrow_lesions(mesh.vertices_mm, tree);
        check_closed(mesh, Cap::none); // throws when the mesh is not closed
        const TriangleTree surface(mesh);
        const VesselLesion &lesion = tree.lesions[0];
        for (std::size_t i = lesion.first_point; i < lesion.first_point + lesion.size(); ++i) {
            const VesselBranch &lad = tree.branches[0];
            const double wall_mm = -surface.nearest(lad.points_m[i] * 1e3).distance_mm;
            // In a tapering channel, the distance to the wall is the radius times the cosine of the taper.
            const double slope = 0.7 * radius_mm * turn / 2 / 16 * 1.001;
            assert_true(wall_mm < lad.radii_m[i] * 1e3 + 0.02);
            assert_true(wall_mm >
                        lad.radii_m[i] * 1e3 / std::sqrt(1 + slope * slope) - 0.1 * eccentricity - 0.04);
        }
        for (std::size_t i = 0; i < mesh.vertices_mm.size(); ++i)
            if (std::abs(mesh.vertices_mm[i].y() - 30) > 8.01) assert_false(moved[i]);
        assert_non_null(std::strstr(lesions_report(tree, surface).c_str(), "70 % by diameter, 91 % by area"));
    }
}

// All round the vessel, a guidewire of 0.18 mm radius must touch the wall at the same position in the mesh
// and in the core. On the axis of a narrow channel, the spline rounds off the peak of the distance field.
void the_field_knows_the_narrowed_wall(void **)
{
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {plaque()});
    Mesh mesh = capped_tube();
    refine_lesions(mesh, tree);
    narrow_lesions(mesh.vertices_mm, tree);
    const TriangleTree surface(mesh);
    Progress progress;
    Field field = make_field(surface, {0.03, 2.5, 1.5, 2}, progress);
    const Vector3d throat_mm = tree.branches[0].points_m[tree.throat(tree.lesions[0])] * 1e3;
    double worst_mm = 0;
    for (double off_mm : {0.42, 0.6})
        for (int k = 0; k < 24; ++k) {
            const double angle = turn * k / 24;
            const crn_vec3 place = to_q30(throat_mm + off_mm * Vector3d(std::cos(angle), 0, std::sin(angle)));
            const double phi_mm = crn_lumen_contact(field.view(), &place).distance_m_q30 * mm_per_q30;
            worst_mm = std::max(worst_mm, std::abs(phi_mm - (off_mm - 0.6)));
        }
    print_message("# worst %.3f mm\n", worst_mm);
    assert_true(worst_mm < 0.05); // a fifth of a voxel
}

// The text of a scene may set a coarse tolerance for the distance field. The field must still resolve a
// channel of 0.4 mm radius, which would vanish without a finer resolution near the lesion. On the axis of a
// channel of 0.4 mm radius, the field shows less than 0.4 mm of clearance, because the spline rounds off the
// peak of the distance.
void a_lesion_asks_more_of_the_field_than_its_scene(void **)
{
    VesselTree tree = tree_of_tube();
    LesionText tight = plaque();
    tight.stenosis_percent = 80;
    place_lesions(tree, {tight});
    Mesh mesh = capped_tube();
    refine_lesions(mesh, tree);
    narrow_lesions(mesh.vertices_mm, tree);
    const TriangleTree surface(mesh);
    Progress progress;
    const auto room_mm =
        [&](const FieldText &text) { // the least clearance that the field leaves on the channel's axis
            Field field = make_field(surface, text, progress);
            double least = 10;
            for (double y = 28; y <= 32; y += 0.1) {
                const crn_vec3 place = to_q30({0, y, 0});
                least = std::min(least, -crn_lumen_contact(field.view(), &place).distance_m_q30 * mm_per_q30);
            }
            return least;
        };
    const double coarse_mm = room_mm({0.12, 2.5, 1.5, 0}),
                 fine_mm = room_mm({0.12, 2.5, 1.5, 0, fine_regions(tree)});
    print_message("# room for %.3f mm without, %.3f mm with its region, throat %.3f mm\n", coarse_mm, fine_mm,
                  tree.branches[0].radii_m[tree.throat(tree.lesions[0])] * 1e3);
    assert_true(coarse_mm < 0.05);
    assert_true(fine_mm > 0.15 && fine_mm < 0.41);
}

// Bakes an eccentric lesion with a stenosis of 70 %, and loads the PLAQUES section of the baked scene as the
// core does.
struct BakedLesion {
    VesselTree tree = tree_of_tube();
    Mesh mesh = capped_tube();
    Progress progress;
    std::optional<Field> field;
    Bytes file;
    crn_scene scene{};
    crn_lesion lesion{};
    crn_lumen lumen{};

    BakedLesion()
    {
        SceneText text;
        text.name = "tube";
        text.lesions = {plaque(0.4)};
        text.lesions[0].yield_kPa = 500;
        text.lesions[0].full_kPa = 300;
        place_lesions(tree, text.lesions);
        refine_lesions(mesh, tree);
        narrow_lesions(mesh.vertices_mm, tree);
        const TriangleTree surface(mesh);
        field.emplace(make_field(surface, {0.03, 2.5, 1.5, 2}, progress));
        file = scene_bytes(text, {0, 3, 0}, {0, 1, 0}, *field, nullptr, &tree);
        assert_int_equal(crn_scene_open(file.data(), file.size(), &scene, nullptr), CRN_SCENE_OK);
        assert_int_equal(scene.plaque_count, 1);
        const crn_scene_plaque_view view = crn_scene_plaque(&scene, 0);
        assert_int_equal(view.yield_Pa, 500000);
        for (int k = 0; k < 3; ++k) {
            lesion.low_m_q30[k] = view.low_m_q30[k];
            lesion.high_m_q30[k] = view.high_m_q30[k];
            lesion.chord_q30[k] = view.chord_q30[k];
        }
        lesion.stretch_q28 = view.stretch_q28;
        lesion.spacing_log2_q30 = view.spacing_log2_q30;
        lesion.station_count = view.station_count;
        lesion.stations = reinterpret_cast<const crn_lesion_station *>(view.stations);
        lumen = *field->view();
        lumen.lesion_count = 1;
        lumen.lesions = &lesion;
    }
    Vector3d throat_mm() const { return tree.branches[0].points_m[tree.throat(tree.lesions[0])] * 1e3; }
    // Returns the core's distance from the wall at a point, in mm, positive outside the lumen. `open` states
    // for each station of the lesion how much of the narrowing has been opened, from 0 to 1.
    double distance_mm(const Vector3d &place_mm, const std::vector<double> &open) const
    {
        crn_lesion_state state{};
        state.bits = 1;
        for (std::size_t i = 0; i < open.size(); ++i)
            state.open_q30[0][i] = static_cast<std::int32_t>(std::lround(std::ldexp(open[i], 30)));
        const crn_vec3 place = to_q30(place_mm);
        crn_lumen_sample sample;
        assert_true(crn_lesion_contact(&lumen, &state, &place, &sample));
        return sample.distance_m_q30 * mm_per_q30;
    }
};

// A fully open lesion has the wall of the healthy vessel, and the wall of a half-open lesion lies halfway
// between the narrowed and the healthy wall. Opening the lesion also magnifies the error that the distance
// field has in the narrow channel.
void opened_it_is_the_healthy_vessel(void **)
{
    const BakedLesion baked;
    for (const double share : {0.5, 1.0}) {
        const std::vector<double> open(baked.lesion.station_count, share);
        double worst_mm = 0;
        for (double y = share < 1 ? 30 : 23; y <= (share < 1 ? 30 : 37); y += 0.7)
            for (int k = 0; k < 24; ++k) {
                const Vector3d ray(std::cos(turn * k / 24), 0, std::sin(turn * k / 24));
                const Vector3d middle =
                    share < 1 ? Vector3d(0.5 * baked.throat_mm() + Vector3d(0, 15, 0)) : Vector3d(0, y, 0);
                worst_mm = std::max(
                    worst_mm, std::abs(baked.distance_mm(middle + (share < 1 ? 1.3 : 2.0) * ray, open)));
            }
        print_message("# open by %.1f: %.3f mm from the wall\n", share, worst_mm);
        assert_true(worst_mm < 0.08);
    }
}

// The host's vessel, used for pictures and blood flow, must have its wall at the same position as the core's
// vessel. The test compares vertices and inscribed spheres after each point along the lesion was opened by a
// fraction from 0.2 to 0.9.
void the_hosts_vessel_opens_as_the_cores_does(void **)
{
    const BakedLesion baked;
    std::vector<double> open;
    for (std::uint32_t i = 0; i < baked.lesion.station_count; ++i)
        open.push_back(0.2 + 0.7 * i / (baked.lesion.station_count - 1));
    const LesionOpening opening(baked.tree, lesion_stations(baked.scene));
    VesselTree now = baked.tree;
    opening.open(baked.tree, open, now);
    Bodies bodies{{{"lumen", "blood", -1, {}, {}}}, baked.tree};
    for (const Vector3d &v : baked.mesh.vertices_mm)
        bodies.bodies[0].vertices_um.push_back((v * 1e3).array().round().matrix().cast<int>());
    for (const auto &corners : baked.mesh.triangles)
        bodies.bodies[0].triangles.push_back({corners[0], corners[1], corners[2]});
    OpenedBodies opened(bodies, opening, nullptr);
    const auto moved = opened.at({}, open);
    assert_int_equal(moved.size(), 1);
    double wall_mm = 0, sphere_mm = 0;
    int count = 0;
    for (const Eigen::Vector3i &v_um : moved[0].vertices_um) {
        if (v_um.y() < 23000 || v_um.y() > 37000)
            continue; // beyond these ends the core does not use the lesion
        wall_mm = std::max(wall_mm, std::abs(baked.distance_mm(v_um.cast<double>() * 1e-3, open)));
        ++count;
    }
    const VesselLesion &lesion = now.lesions[0];
    for (std::size_t i = 2; i + 2 < lesion.size(); ++i) {
        const std::size_t point = lesion.first_point + i;
        for (int k = 0; k < 12; ++k) {
            const Vector3d ray(std::cos(turn * k / 12), 0, std::sin(turn * k / 12));
            const Vector3d place_mm =
                (now.branches[0].points_m[point] + now.branches[0].radii_m[point] * ray) * 1e3;
            sphere_mm = std::max(sphere_mm, std::abs(baked.distance_mm(place_mm, open)));
        }
    }
    print_message("# %d vertices within %.3f mm of the core's wall, spheres within %.3f mm\n", count, wall_mm,
                  sphere_mm);
    assert_true(count > 1000);
    assert_true(wall_mm < 0.06 && sphere_mm < 0.06);
}

// The positions of lesions refer to the healthy vessel. A lesion keeps its position when another lesion is
// added. The added lesion is either an eccentric lesion upstream, whose channel is longer than the vessel, or
// a lesion of the parent vessel at the origin of the branch.
void a_lesion_lies_where_it_would_lie_alone(void **)
{
    LesionText second = plaque(0.5), ostium = plaque(), side = plaque();
    second.name = "second";
    second.at_mm = 46; // it begins where the first ends
    for (bool is_first : {false, true}) {
        VesselTree tree = tree_of_tube();
        place_lesions(tree, is_first ? std::vector{second, plaque(1)} : std::vector{plaque(1), second});
        const Vector3d throat = tree.branches[0].points_m[tree.throat(tree.lesions[is_first ? 0 : 1])];
        assert_true(std::abs(throat.y() - 46e-3) < 2e-6);
    }
    ostium.at_mm = 45;
    side.name = "side";
    side.branch = "diagonal";
    side.at_mm = 8;
    VesselTree alone = tree_of_tube(), both = tree_of_tube();
    place_lesions(alone, {side});
    place_lesions(both, {ostium, side});
    assert_true(alone.branches[1].points_m == both.branches[1].points_m);
}

// The test's vessel bends towards the front within its lesion, and the plaque stays on one side of the
// vessel. Between neighbouring points of the centreline, the vessel turns by 5 degrees.
void plaque_stays_on_its_side_in_a_bend(void **)
{
    VesselTree tree;
    tree.branches.resize(1);
    tree.branches[0].name = "lad";
    for (int deg = 0; deg <= 180; deg += 5) {
        const double angle = turn * deg / 360;
        tree.branches[0].points_m.emplace_back(0, -20e-3 * std::cos(angle), 20e-3 * std::sin(angle));
        tree.branches[0].radii_m.push_back(radius_mm * 1e-3);
    }
    LesionText text = plaque(1);
    text.at_mm = 10; // the vessel runs 29 degrees from the front there, and along it where the lesion begins
    text.length_mm = 18;
    place_lesions(tree, {text});
    const VesselLesion &lesion = tree.lesions[0];
    Vector3d before = Vector3d::Zero();
    for (std::size_t i = 0; i < lesion.size(); ++i) {
        const Vector3d off_m = tree.branches[0].points_m[lesion.first_point + i] - lesion.healthy_points_m[i];
        if (off_m.norm() < 0.05e-3) continue; // rounding changes the direction of short offsets
        const Vector3d now = off_m.normalized();
        if (before.norm() > 0) assert_true(now.dot(before) > std::cos(turn * 6 / 360));
        before = now;
    }
    assert_true(before.norm() > 0);
}

// A side branch of 1 mm radius runs along the vessel, and both vessels have lesions. Where a part of the wall
// lies nearer to the side branch, only the lesion of the side branch moves it.
void walls_go_with_their_own_vessel_when_both_are_narrowed(void **)
{
    VesselTree tree = tree_of_tube();
    tree.branches[1].parent_point = 0;
    tree.branches[1].points_m = {{3.05e-3, 0, 0}, {3.05e-3, 60e-3, 0}};
    LesionText side = plaque();
    side.name = "side";
    side.branch = "diagonal";
    place_lesions(tree, {plaque(), side});
    std::vector<Vector3d> wall_mm = {
        {3.05 - 0.17, 30, 0.985}}; // 1.52 radii from the vessel, 1 from the side branch
    narrow_lesions(wall_mm, tree);
    assert_true((wall_mm[0] - Vector3d(3.05 - 0.3 * 0.17, 30, 0.3 * 0.985)).norm() < 5e-3);
}

// Computer-aided design programs write tubes of long triangles, so the middles of the edges may lie far from
// the lesion.
void triangles_as_long_as_the_vessel_are_divided(void **)
{
    LesionText text = plaque();
    text.at_mm = 15;
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {text});
    Mesh mesh = tube(radius_mm, 60, 1, 32);
    check_closed(mesh, Cap::flat);
    refine_lesions(mesh, tree);
    narrow_lesions(mesh.vertices_mm, tree);
    check_closed(mesh, Cap::none);
    const double wall_mm = -TriangleTree(mesh).nearest({0, 15, 0}).distance_mm;
    assert_true(wall_mm > 0.56 && wall_mm < 0.62);
}

// A chamber of the heart beside the vessel also contains blood, but its blood does not belong to this vessel.
void blood_beside_the_vessel_keeps_its_shape(void **)
{
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {plaque()});
    Mesh beside = capped_tube();
    for (Vector3d &v : beside.vertices_mm) v.x() += 5;
    check_closed(beside, Cap::none);
    const VesselTree none = lesions_within(tree, TriangleTree(beside));
    assert_true(none.lesions.empty());
    assert_true(std::abs(none.branches[0].radii_m[tree.throat(tree.lesions[0])] - radius_mm * 1e-3) < 1e-9);
    Mesh around = capped_tube();
    assert_int_equal(lesions_within(tree, TriangleTree(around)).lesions.size(), 1);
}

void calcium_is_a_closed_shell_in_the_plaque(void **)
{
    LesionText text = plaque(0.5);
    text.calcified_deg = 120;
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {text});
    const BakedBody calcium = calcium_of(tree, tree.lesions[0], text);
    assert_string_equal(calcium.name.c_str(), "plaque_calcium");
    assert_true(volume_mm3(calcium.mesh) > 1);
    for (const Vector3d &v : calcium.mesh.vertices_mm) {
        assert_true(std::hypot(v.x(), v.z()) < radius_mm);
        assert_true(v.z() > -1e-9); // 60 degrees to either side of the front
        double channel_mm = 1e9;    // the distance outside of every ball of the channel
        for (std::size_t i = 0; i < tree.branches[0].points_m.size(); ++i)
            channel_mm = std::min(channel_mm, (v - tree.branches[0].points_m[i] * 1e3).norm() -
                                                  tree.branches[0].radii_m[i] * 1e3);
        assert_true(channel_mm > 0);
    }
}

void a_file_gives_the_lesion_back(void **)
{
    const Folder folder;
    SceneText text;
    text.name = "test";
    VesselTree tree = tree_of_tube();
    place_lesions(tree, {plaque(0.3)});
    write_whole(folder.path / "t.bodies", bodies_bytes(text, {}, tree));
    Bodies bodies;
    std::string error;
    assert_true(read_bodies((folder.path / "t.bodies").string(), bodies, error));
    assert_int_equal(bodies.vessels.lesions.size(), 1);
    const VesselLesion &lesion = bodies.vessels.lesions[0];
    assert_string_equal(lesion.name.c_str(), "plaque");
    assert_int_equal(lesion.first_point, tree.lesions[0].first_point);
    assert_true(lesion.healthy_radii_m == tree.lesions[0].healthy_radii_m);
    for (std::size_t i = 0; i < lesion.size(); ++i)
        assert_true((lesion.healthy_points_m[i] - tree.lesions[0].healthy_points_m[i]).norm() < 1e-9);
}

// The mesh of the vessel has a radius of 2 mm. The centrelines state a radius of 2 mm in one case and 2.5 mm
// in the other case. If the centrelines state 2 mm, the smallest radius of the vessel tree equals that of the
// mesh. If the centrelines state a radius of 2.5 mm, the tree's smallest radius must be 0.3 mm larger than
// the mesh's.
void a_mesh_that_is_not_the_trees_is_warned_of(void **)
{
    for (const double stated_mm : {2.0, 2.5}) {
        VesselTree tree = tree_of_tube();
        for (double &radius_m : tree.branches[0].radii_m) radius_m = stated_mm * 1e-3;
        place_lesions(tree, {plaque()});
        Mesh mesh = capped_tube();
        refine_lesions(mesh, tree);
        narrow_lesions(mesh.vertices_mm, tree);
        const std::string report = lesions_report(tree, TriangleTree(mesh));
        const bool warns = report.find("warning: lesion plaque: the mesh leaves 1.") != std::string::npos &&
                           report.find("where the tree says 1.50 mm") != std::string::npos;
        print_message("# %s", report.c_str());
        assert_true(warns == (stated_mm > 2.1));
    }
}

void what_does_not_fit_is_refused_by_name(void **)
{
    const auto refusal = [](const std::vector<LesionText> &lesions) {
        VesselTree tree = tree_of_tube();
        return complaint([&] { place_lesions(tree, lesions); });
    };
    LesionText text = plaque();
    text.branch = "rca";
    assert_non_null(std::strstr(refusal({text}).c_str(),
                                "'plaque' lies on 'rca', which is no branch: there are lad, diagonal"));
    text = plaque();
    text.at_mm = 55;
    assert_non_null(std::strstr(refusal({text}).c_str(), "reaches from 47.0 to 63.0 mm behind the ostium"));
    LesionText second = plaque();
    second.name = "second";
    second.at_mm = 42;
    assert_non_null(std::strstr(refusal({plaque(), second}).c_str(), "'second' overlaps 'plaque'"));
    second.at_mm = 48;
    assert_string_equal(refusal({plaque(), second}).c_str(), "");
    assert_string_equal(refusal({second, plaque()}).c_str(), "");
}

void a_text_says_where_it_is_wrong(void **)
{
    const Folder folder;
    folder.write("tube.obj", "v 0 0 0\n");
    const auto refusal = [&](const std::string &lesion) {
        const std::filesystem::path file =
            folder.write("scene.toml", scene_text_of("tube.obj") + "[[lesion]]\n" + lesion);
        return complaint([&] { read_scene_text(file, {}); });
    };
    const std::string whole =
        "name = \"p\"\nbranch = \"lad\"\nat_mm = 10\nlength_mm = 8\nstenosis_percent = 75\n";
    assert_string_equal(refusal(whole).c_str(), "");
    assert_non_null(std::strstr(refusal("name = \"p\"\n").c_str(), ":10:1: [[lesion]]: 'branch' is missing"));
    assert_non_null(std::strstr(refusal(whole + "recoill = 3\n").c_str(),
                                "[[lesion]]: unknown key 'recoill', did you mean 'recoil'?"));
    assert_non_null(std::strstr(refusal(whole + "eccentricity = 2\n").c_str(),
                                ":16:16: [[lesion]]: 'eccentricity' = 2 is outside 0 .. 1"));
    assert_non_null(
        std::strstr(refusal(whole + "inside = \"heart\"\n").c_str(), "give calcified_deg as well"));
    assert_non_null(std::strstr(refusal(whole + "calcified_deg = 90\ninside = \"heart\"\n").c_str(),
                                "'heart', which is no body"));
    assert_non_null(
        std::strstr(refusal(whole + "[[lesion]]\n" + whole).c_str(), "two lesions are called 'p'"));
    std::string bodies;
    for (int i = 0; i < CRN_SCENE_BODY_MAX; ++i)
        bodies += "[[body]]\nname = \"b" + std::to_string(i) + "\"\nmesh = \"lumen\"\nmaterial = \"blood\"\n";
    assert_string_equal(refusal(whole + bodies).c_str(), "");
    assert_non_null(std::strstr(refusal(whole + "calcified_deg = 90\n" + bodies).c_str(),
                                "256 bodies and the calcium of 1 lesions are more than 256"));
}

// A balloon can open at most four lesions of a scene, and the report names the lesions that it cannot open.
void more_lesions_than_give_way_are_named(void **)
{
    VesselTree tree = tree_of_tube();
    std::vector<LesionText> lesions;
    for (int i = 0; i < 6; ++i) {
        lesions.push_back(plaque());
        lesions.back().name = "l" + std::to_string(i);
        lesions.back().at_mm = 6 + 8 * i;
        lesions.back().length_mm = 6;
    }
    place_lesions(tree, lesions);
    const Mesh mesh = capped_tube();
    const std::string report = lesions_report(tree, TriangleTree(mesh));
    assert_null(std::strstr(report.c_str(), "l3 stays"));
    assert_non_null(std::strstr(report.c_str(), "note: l4 stays rigid under a balloon"));
    assert_non_null(std::strstr(report.c_str(), "note: l5 stays rigid under a balloon"));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_channel_is_the_cosine_of_the_text),
        cmocka_unit_test(side_branches_still_leave_where_they_left),
        cmocka_unit_test(an_eccentric_channel_lies_away_from_the_plaque),
        cmocka_unit_test(the_surface_goes_with_the_tree),
        cmocka_unit_test(the_field_knows_the_narrowed_wall),
        cmocka_unit_test(a_lesion_asks_more_of_the_field_than_its_scene),
        cmocka_unit_test(opened_it_is_the_healthy_vessel),
        cmocka_unit_test(the_hosts_vessel_opens_as_the_cores_does),
        cmocka_unit_test(a_lesion_lies_where_it_would_lie_alone),
        cmocka_unit_test(plaque_stays_on_its_side_in_a_bend),
        cmocka_unit_test(walls_go_with_their_own_vessel_when_both_are_narrowed),
        cmocka_unit_test(triangles_as_long_as_the_vessel_are_divided),
        cmocka_unit_test(blood_beside_the_vessel_keeps_its_shape),
        cmocka_unit_test(calcium_is_a_closed_shell_in_the_plaque),
        cmocka_unit_test(a_file_gives_the_lesion_back),
        cmocka_unit_test(a_mesh_that_is_not_the_trees_is_warned_of),
        cmocka_unit_test(what_does_not_fit_is_refused_by_name),
        cmocka_unit_test(a_text_says_where_it_is_wrong),
        cmocka_unit_test(more_lesions_than_give_way_are_named),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
