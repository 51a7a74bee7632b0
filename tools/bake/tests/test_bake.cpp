// These tests check the following. A baked lumen equals the given surface within the stated tolerance, at
// every refinement level of the field's bricks (blocks of voxels). Its file opens. If a scene cannot be
// baked, the program `bake` prints one sentence with the reason, and the old files remain. The tests use a
// torus, whose distance is known in closed form, and texts of scenes with one fault each.
#include "shared/scene/scene.h"
#include "tools/bake/tests/shapes.hpp"
#include "tools/bake/tests/texts.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;

namespace
{

constexpr double ring_mm = 50, tube_mm = 6;

// Returns the largest difference between the field's distance and the exact distance to the torus, within 1.5
// mm of the wall.
double worst_of(Field &field, double inner_mm)
{
    std::mt19937_64 random(17);
    const auto draw = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
    double worst = 0;
    for (int i = 0; i < 100000; ++i) {
        const double u = turn * draw(), v = turn * draw(), r = inner_mm - 1.5 + 3 * draw(),
                     w = ring_mm + r * std::cos(v);
        const Eigen::Vector3d p(w * std::cos(u), w * std::sin(u), r * std::sin(v));
        const crn_vec3 q = to_q30(p);
        const double got = crn_lumen_contact(field.view(), &q).distance_m_q30 * mm_per_q30;
        worst = std::max(worst, std::abs(got - torus_distance(p, ring_mm, inner_mm)));
    }
    return worst;
}

void field_of_a_torus_is_its_closed_form_distance(void **)
{
    Progress progress;
    const Mesh mesh = torus(ring_mm, tube_mm, 500, 100); // its chords are off by 0.001 and 0.003 mm
    const TriangleTree tree(mesh);
    Field field = make_field(tree, {10, 2.5, 1.5, 0}, progress);
    const double worst = worst_of(field, tube_mm);
    // The field may differ from the exact distance to the torus by the sum of three errors. The three errors
    // are rounding to 1/64 voxel (0.015 mm), the spline's error at a curved wall (0.01 mm), and the error of
    // flat triangles.
    if (worst > 0.03) fail_msg("worst %.4f mm, allowed 0.03", worst);
    assert_true(field.bricks_of_level[1] == 0);
}

void bricks_are_refined_until_the_tolerance_holds(void **)
{
    Progress progress;
    const Mesh mesh = torus(15, 2.0, 300, 80);
    const TriangleTree tree(mesh);
    double before = 1;
    for (int level = 0; level <= 2; ++level) {
        Field field = make_field(tree, {0.004, 1.9, 1.5, level}, progress);
        assert_true(field.bricks_of_level[level] > 0);
        FieldError error = measure_field(field.view(), tree, 20000, 3, progress);
        if (error.percent99_mm > 0.75 * before)
            fail_msg("level %d: 99 %% within %.4f mm, before %.4f", level, error.percent99_mm, before);
        before = level < 1 ? error.percent99_mm
                           : 2; /* level 2 holds 0.97 mm only, so its far points count as wrong */
    }
}

// Neighbouring bricks of the field store equal samples where they overlap, so the wall has no step between
// bricks.
void neighbouring_bricks_agree_where_they_overlap(void **)
{
    Progress progress;
    const Mesh mesh = torus(ring_mm, tube_mm, 400, 80);
    const TriangleTree tree(mesh);
    const Field field = make_field(tree, {10, 2.5, 1.5, 0}, progress);
    const auto *count = field.lumen.brick_count_xyz;
    std::size_t compared = 0;
    for (std::size_t i = 0; i + 1 < field.index.size(); ++i) {
        if (i % count[0] == count[0] - 1u || field.index[i] < 2 || field.index[i + 1] < 2) continue;
        const std::int8_t *a = &field.samples[(field.index[i] - 2u) * 1000],
                          *b = &field.samples[(field.index[i + 1] - 2u) * 1000];
        for (int n = 0; n < 100; ++n) {
            assert_int_equal(a[n * 10 + 8], b[n * 10]);
            assert_int_equal(a[n * 10 + 9], b[n * 10 + 1]);
            ++compared;
        }
    }
    assert_true(compared > 1000);
}

void smallest_radius_is_that_of_the_tube(void **)
{
    const Mesh mesh = torus(ring_mm, tube_mm, 400, 80);
    const Worst smallest = smallest_radius(TriangleTree(mesh), 5000);
    assert_true(std::abs(smallest.mm - tube_mm) < 0.2 /* 3 % for facets */);
}

void contact_agrees_with_libccd(void **)
{
    Progress progress;
    const Mesh mesh = torus(ring_mm, tube_mm, 400, 80);
    const TriangleTree tree(mesh);
    Field field = make_field(tree, {0.05, 2.5, 1.5, 1}, progress);
    const Referee referee = measure_contact(field.view(), tree, 300, 7, progress);
    assert_int_equal(referee.poses, 300);
    assert_true(referee.touching > 200);
    if (referee.disagreement.mm > 0.08)
        fail_msg("worst disagreement %.4f mm, allowed 0.08", referee.disagreement.mm);
}

// --- whole runs ---
Options options_in(const Folder &folder, const std::filesystem::path &scene)
{
    Options options;
    options.scene = scene;
    options.output = folder.path / "out.scene";
    options.folders.data = folder.path;
    options.poses = 100;
    options.points = 2000;
    return options;
}

std::vector<std::uint8_t> read_file(const std::filesystem::path &file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_torus(const Folder &folder, const std::string &name)
{
    write_ply(torus(ring_mm, tube_mm, 200, 40), folder.path / name);
}

void whole_run_writes_files_that_open(void **)
{
    const Folder folder;
    Progress progress;
    write_torus(folder, "lumen.ply");
    const auto text = folder.write(
        "scene.toml",
        scene_text_of("lumen.ply") +
            "[[body]]\nname = \"wall\"\nmesh = \"lumen\"\nmaterial = \"blood\"\ninside = \"skin\"\n"
            "[[body]]\nname = \"skin\"\nmesh = \"lumen.ply\"\nunit = \"mm\"\nscale = 2\nmaterial = "
            "\"soft\"\n");
    const std::string report = bake(options_in(folder, text), progress);
    contains(report, {"bricks", "field error", "99.9 %", "libccd", "seed 1", "smallest lumen    radius 5.",
                      "out.scene"});
    alignas(16) static std::uint8_t buffer[4 << 20];
    auto bytes = read_file(folder.path / "out.scene");
    assert_true(bytes.size() <= sizeof buffer);
    std::memcpy(buffer, bytes.data(), bytes.size());
    crn_scene scene;
    assert_int_equal(crn_scene_open(buffer, bytes.size(), &scene, nullptr), CRN_SCENE_OK);
    assert_string_equal(scene.name, "test");
    assert_int_equal(scene.entry_direction_q30[0], -(1 << 30));
    bytes = read_file(folder.path / "out.bodies");
    std::memcpy(buffer, bytes.data(), bytes.size());
    assert_int_equal(crn_scene_open(buffer, bytes.size(), &scene, nullptr), CRN_SCENE_OK);
    assert_int_equal(scene.body_count, 2);
    assert_int_equal(crn_scene_body(&scene, 0).parent, 1);
    assert_int_equal(crn_scene_body(&scene, 1).parent, -1);
}

void same_input_gives_the_same_bytes(void **)
{
    const Folder folder;
    Progress progress;
    write_torus(folder, "lumen.ply");
    const Options options =
        options_in(folder, folder.write("scene.toml", scene_text_of("lumen.ply", "tolerance_mm = 0.1")));
    bake(options, progress);
    const auto first = read_file(options.output);
    bake(options, progress);
    assert_true(first == read_file(options.output));
}

// Before, `[lumen]` refused the parts of an atlas, which overlap: their triangles cross.
void parts_of_a_lumen_that_overlap_become_one(void **)
{
    Folder folder;
    Progress progress;
    Mesh two = tube(6, 60, 60, 60);
    Mesh other = tube(4, 60, 60, 60);
    const auto base = static_cast<std::uint32_t>(two.vertices_mm.size());
    for (const Eigen::Vector3d &v : other.vertices_mm)
        two.vertices_mm.push_back(v + Eigen::Vector3d(0, 45.3, 0));
    for (const Triangle &t : other.triangles)
        two.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    write_ply(two, folder.path / "atlas.ply");
    const auto text = [&](const std::string &more) {
        return folder.write("scene.toml",
                            "[scene]\nname = \"atlas\"\n[lumen]\nmesh = \"atlas.ply\"\nunit = \"mm\"\n"
                            "cap = true\n" +
                                more + "[entry]\nposition_mm = [0, 20, 0]\ndirection = [0, 1, 0]\n");
    };
    std::string report;
    contains(complaint([&] { lumen_surface(read_scene_text(text(""), {}), report, progress); }), {"cross"});
    report.clear();
    const Mesh one = lumen_surface(read_scene_text(text("solid_mm = 0.4\n"), {}), report, progress);
    const auto tube_mm3 = [](double radius_mm, double length_mm) {
        return 30 * radius_mm * radius_mm * std::sin(turn / 60) * length_mm;
    };
    // The smaller tube begins 15 mm inside the larger one. A grid rounds edges by half a voxel.
    const double wanted = tube_mm3(6, 60) + tube_mm3(4, 45.3), got = volume_mm3(one);
    std::printf("# volume of two tubes: %.1f mm3, expected %.1f\n", got, wanted);
    assert_true(std::abs(got / wanted - 1) < 0.02);
    contains(report, {"solid             the lumen", "voxels of 0.40 mm", "capped the opening"});
    contains(complaint([&] {
                 read_scene_text(folder.write("lines.toml", "[scene]\nname = \"lines\"\n[lumen]\n"
                                                            "centrelines = [\"atlas.ply\"]\nsolid_mm = 0.5\n"
                                                            "[entry]\nposition_mm = [0, 20, 0]\n"
                                                            "direction = [0, 1, 0]\n"),
                                 {});
             }),
             {"solid_mm", "surface_mm"});
}

void axes_and_offset_move_the_surface(void **)
{
    const Folder folder;
    Progress progress;
    write_torus(folder, "lumen.ply");
    SceneText text = read_scene_text(
        folder.write("scene.toml",
                     scene_text_of("lumen.ply",
                                   "axes = [\"+y\", \"-x\", \"+z\"]\nscale = 0.5\noffset_mm = [1, 2, 3]")),
        {folder.path, {}});
    std::string report;
    const Mesh mesh = lumen_surface(text, report, progress);
    // The first vertex of the mesh file is (56, 0, 0). The patient's left is the file's y axis, and the
    // direction to the head is the file's -x axis; y is 0 for the first vertex.
    assert_true((mesh.vertices_mm.size() == 8000) &&
                std::abs(volume_mm3(mesh) / (turn * turn / 2 * 25 * 9) - 1) < 0.01);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) box.extend(v);
    assert_true((box.center() - Eigen::Vector3d(1, 2, 3)).norm() < 1e-6);
}

std::string refusal(const Folder &folder, const std::string &text)
{
    Progress progress;
    return complaint([&] { bake(options_in(folder, folder.write("scene.toml", text)), progress); });
}

void faults_of_the_text_name_line_and_key(void **)
{
    const Folder folder;
    write_torus(folder, "lumen.ply");
    const std::string good = scene_text_of("lumen.ply");
    contains(refusal(folder, "[scene\n"), {"scene.toml:1:"});
    contains(refusal(folder, ""), {"'scene' is missing: add the table [scene]"});
    contains(refusal(folder, "[scene]\nname = 3\n" + good.substr(good.find("[lumen]"))),
             {"scene.toml:2:", "'name' is not a text"});
    contains(refusal(folder, scene_text_of("none.ply")), {"scene.toml:4:", "none.ply", "no readable file"});
    contains(refusal(folder, scene_text_of("data:none.ply")), {"--data"});
    contains(refusal(folder, scene_text_of("lumen.ply", "tolerance_mm = \"x\"")),
             {"scene.toml:6:", "tolerance_mm", "0.005 to 1"});
    contains(refusal(folder, scene_text_of("lumen.ply", "level_max = 7")),
             {"'level_max' = 7 is outside 0 .. 2"});
    contains(refusal(folder, scene_text_of("lumen.ply", "level_max = 0.5")),
             {"[lumen]: 'level_max' is not a whole number"});
    contains(refusal(folder, scene_text_of("lumen.ply", "colour = 1")),
             {"scene.toml:6:", "[lumen]: unknown key 'colour'; known:", "tolerance_mm"});
    contains(refusal(folder, scene_text_of("lumen.ply", "tolerence_mm = 0.1")),
             {"scene.toml:6:", "[lumen]: unknown key 'tolerence_mm', did you mean 'tolerance_mm'?"});
    contains(refusal(folder, scene_text_of("lumen.ply", "axes = [\"+x\", \"+x\", \"+z\"]")),
             {"axes", "twice"});
    contains(refusal(folder, scene_text_of("lumen.ply", "axes = [\"-x\", \"+y\", \"+z\"]")),
             {"axes", "mirror"});
    contains(refusal(folder, scene_text_of("lumen.ply", "centrelines = [\"a\"]")),
             {"either mesh or centrelines"});
    contains(refusal(folder, scene_text_of("lumen.ply", "", "[0, 50]")), {"position_mm", "three numbers"});
    contains(refusal(folder,
                     good + "[[body]]\nname = \"a\"\nmesh = \"lumen\"\nmaterial = \"m\"\ninside = \"b\"\n"),
             {"'a'", "inside 'b'"});
    contains(refusal(folder, good + "[[body]]\nname = \"a\"\nmesh = \"lumen\"\n"), {"'a' needs a material"});
}

void entry_must_lie_in_the_lumen_and_look_into_it(void **)
{
    const Folder folder;
    write_torus(folder, "lumen.ply");
    contains(refusal(folder, scene_text_of("lumen.ply", "", "[0, 0, 0]")), {"[entry]", "outside the lumen"});
    contains(refusal(folder, scene_text_of("lumen.ply", "", "[0, 55.5, 0]")), {"[entry]", "within 1 mm"});
    contains(refusal(folder, scene_text_of("lumen.ply", "", "[-54, 0, 0]")),
             {"[entry]", "points into the wall"});
}

void bodies_in_a_circle_and_unwritable_output_leave_the_old_files(void **)
{
    const Folder folder;
    write_torus(folder, "lumen.ply");
    folder.write("out.scene", "old");
    const std::string circle = "[[body]]\nname = \"a\"\nmesh = \"lumen\"\nmaterial = \"m\"\ninside = \"b\"\n"
                               "[[body]]\nname = \"b\"\nmesh = \"lumen\"\nmaterial = \"m\"\ninside = \"a\"\n";
    contains(refusal(folder, scene_text_of("lumen.ply") + circle), {"correct `inside`"});
    assert_true(read_file(folder.path / "out.scene").size() == 3);
    assert_true(folder.is_empty_but(3)); /* lumen.ply, scene.toml, out.scene */
    Progress progress;
    Options options = options_in(folder, folder.write("scene.toml", scene_text_of("lumen.ply")));
    options.output = folder.path / "nowhere" / "out.scene";
    contains(complaint([&] { bake(options, progress); }), {"nowhere/out.scene", "cannot be written"});
}

const char *markup_head =
    "{\"markups\": [{\"type\": \"Curve\", \"coordinateUnits\": \"mm\", \"controlPoints\": [";
std::string markup(const std::string &points, const std::string &radii)
{
    return markup_head + points + "], \"measurements\": [{\"name\": \"Radius\", \"controlPointValues\": [" +
           radii + "]}]}]}";
}

void faults_of_a_centreline_name_point_and_field(void **)
{
    const Folder folder;
    const std::string text = "[scene]\nname = \"t\"\n[lumen]\ncentrelines = "
                             "[\"a.mrk.json\"]\n[entry]\ncentreline = \"a.mrk.json\"\nend = \"first\"\n";
    const std::string p = "{\"position\": [0, 0, 0]}, {\"position\": [0, 40, 0]}";
    const auto with = [&](const std::string &file) {
        folder.write("a.mrk.json", file);
        return refusal(folder, text);
    };
    contains(with("{"), {"a.mrk.json", "no JSON"});
    contains(with("[]"), {"no 'markups'"});
    contains(with("{\"markups\": 3}"), {"a.mrk.json"});
    contains(with(markup("{\"position\": [0, 0, 0]}", "5")), {"1 control points"});
    contains(with(markup(p, "5")), {"'Radius' has 1 values for 2 control points"});
    contains(with(markup(p, "5, -1")), {"Radius of control point 1", "not above zero"});
    contains(with(markup("{\"position\": [0, null, 0]}, {\"position\": [0, 40, 0]}", "5, 5")),
             {"position of control point 0", "finite"});
    contains(with(markup(p, "500, 500")), {"largest radius", "coordinateUnits"});
    contains(with(markup(p, "5000, 5000")), {"sphere 0", "5000", "check the file's unit"});
    contains(with(std::string(markup_head) + p + "]}]}"), {"no measurement 'Radius'"});
    assert_string_equal(with(markup(p, "5, 4")).c_str(), "");
}

void stevebench_obj_is_refused_with_its_faults(void **)
{
    const char *folder_name = std::getenv("CRN_ANATOMY");
    const std::filesystem::path obj = std::filesystem::path(folder_name ? folder_name : "../shared/anatomy") /
                                      "steve_bench/mechanical_thrombectomy_collision_FIX_REMESH.obj";
    if (!std::filesystem::exists(obj)) skip();
    const Folder folder;
    contains(refusal(folder, scene_text_of(std::filesystem::absolute(obj).string())),
             {"non-manifold edges", "open edges", "triangle"});
}

// The scene file of the shipped example on the real centrelines has at most 2 MB of data. The error of its
// distance field is within 0.15 mm at 99.9 % of the points near the wall.
void stevebench_scene_keeps_its_size_and_error(void **)
{
    const char *folder_name = std::getenv("CRN_ANATOMY");
    const std::filesystem::path data = folder_name ? folder_name : "../shared/anatomy";
    if (!std::filesystem::exists(data / "steve_bench")) skip();
    Progress progress;
    std::string report;
    const SceneText text = read_scene_text("shared/examples/steve_iliac_arch.toml", {data, {}});
    const Mesh surface = lumen_surface(text, report, progress);
    const TriangleTree tree(surface);
    Field field = make_field(
        tree, {text.lumen.tolerance_mm, text.lumen.inside_mm, text.lumen.outside_mm, text.lumen.level_max},
        progress);
    const std::size_t bytes = scene_bytes(text, {8.9, 44.1, 18.7}, {0, 1, 0}, field).size();
    if (bytes > 2'000'000) fail_msg("%zu bytes, allowed 2,000,000", bytes);
    const FieldError error = measure_field(field.view(), tree, 50000, 2, progress);
    if (error.permille999_mm > 0.15) fail_msg("99.9 %% within %.4f mm, allowed 0.15", error.permille999_mm);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(field_of_a_torus_is_its_closed_form_distance),
        cmocka_unit_test(bricks_are_refined_until_the_tolerance_holds),
        cmocka_unit_test(neighbouring_bricks_agree_where_they_overlap),
        cmocka_unit_test(smallest_radius_is_that_of_the_tube),
        cmocka_unit_test(contact_agrees_with_libccd),
        cmocka_unit_test(whole_run_writes_files_that_open),
        cmocka_unit_test(same_input_gives_the_same_bytes),
        cmocka_unit_test(parts_of_a_lumen_that_overlap_become_one),
        cmocka_unit_test(axes_and_offset_move_the_surface),
        cmocka_unit_test(faults_of_the_text_name_line_and_key),
        cmocka_unit_test(entry_must_lie_in_the_lumen_and_look_into_it),
        cmocka_unit_test(bodies_in_a_circle_and_unwritable_output_leave_the_old_files),
        cmocka_unit_test(faults_of_a_centreline_name_point_and_field),
        cmocka_unit_test(stevebench_obj_is_refused_with_its_faults),
        cmocka_unit_test(stevebench_scene_keeps_its_size_and_error),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
