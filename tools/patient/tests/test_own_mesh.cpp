// These tests check the following. From the meshes of vessels as people have them, the tool finds the lumen
// of known shapes: tubes, walls of two sheets, parts that overlap or almost touch. Volumes are compared with
// closed forms. Unit, axes and arteries are found. A whole folder can be baked, and its entry lies in the
// vessel.
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/tests/shapes.hpp"
#include "tools/patient/scene_folder.hpp"
#include "tools/patient/wall.hpp"
#include <numbers>

using namespace crn;
using namespace crn::patient;
using centreline::tests::Folder;
using centreline::tests::says;
using centreline::tests::tube_mesh;
using centreline::tests::write_obj;
using Eigen::Vector3d;
using std::numbers::pi;

namespace
{

bake::Progress own_progress;

void is_near(double got, double wanted, double share, const char *what)
{
    std::printf("# %s: %.4g, expected %.4g\n", what, got, wanted);
    if (!(std::abs(got - wanted) <= share * std::abs(wanted)))
        fail_msg("%s is %.6g, expected %.6g within %.1f %%", what, got, wanted, 100 * share);
}

bake::Mesh reversed(bake::Mesh mesh)
{
    for (bake::Triangle &t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

bake::Mesh together(bake::Mesh one, const bake::Mesh &other)
{
    const auto base = static_cast<std::uint32_t>(one.vertices_mm.size());
    one.vertices_mm.insert(one.vertices_mm.end(), other.vertices_mm.begin(), other.vertices_mm.end());
    for (const bake::Triangle &t : other.triangles)
        one.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    return one;
}

bake::Mesh moved(bake::Mesh mesh, const Vector3d &by)
{
    for (Vector3d &v : mesh.vertices_mm) v += by;
    return mesh;
}

// A wall: an outer and an inner tube, with a ring at both ends that joins them.
constexpr int tube_along = 60, tube_around = 40;

bake::Mesh walled_tube(double inner_mm, double outer_mm, double length_mm, double bend_mm, bool has_rims)
{
    bake::Mesh mesh = together(tube_mesh(outer_mm, length_mm, bend_mm, tube_along, tube_around),
                               reversed(tube_mesh(inner_mm, length_mm, bend_mm, tube_along, tube_around)));
    const auto half = static_cast<std::uint32_t>((tube_along + 1) * tube_around);
    for (const int i : {0, tube_along})
        for (int j = 0; has_rims && j < tube_around; ++j) {
            const auto a = static_cast<std::uint32_t>(i * tube_around + j),
                       b = static_cast<std::uint32_t>(i * tube_around + (j + 1) % tube_around);
            const bool is_first = i == 0;
            mesh.triangles.push_back(is_first ? bake::Triangle{a, b, b + half}
                                              : bake::Triangle{b, a, b + half});
            mesh.triangles.push_back(is_first ? bake::Triangle{a, b + half, a + half}
                                              : bake::Triangle{b + half, a, a + half});
        }
    return mesh;
}

// The volume of a prism of `tube_around` corners, as a tube's mesh is.
double tube_mm3(double radius_mm, double length_mm)
{
    return tube_around * radius_mm * radius_mm / 2 * std::sin(2 * pi / tube_around) * length_mm;
}

WholeLumen whole(const std::vector<Part> &parts, UnionWish wish = {}, std::string *text = nullptr)
{
    Choices choices;
    WholeLumen made = whole_lumen(parts, wish, choices, own_progress);
    if (text) *text = choices.text("");
    return made;
}

void contains(const std::string &text, const char *words)
{
    if (text.find(words) == text.npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), words);
}

// --- walls ---

void a_lumen_alone_is_no_wall(void **)
{
    assert_false(lumen_of_wall(tube_mesh(3, 80, 0, tube_along, tube_around)).has_value());
    // A vessel that turns back sees itself from outside.
    assert_false(lumen_of_wall(tube_mesh(3, 60, 12, tube_along, tube_around)).has_value());
    assert_false(lumen_of_wall(reversed(tube_mesh(3, 80, 0, tube_along, tube_around))).has_value());
}

void the_lumen_of_a_wall_is_inside_its_inner_sheet(void **)
{
    for (const double bend_mm : {0.0, 15.0})
        for (const bool has_rims : {true, false})
            for (const bool is_inside_out : {true, false}) {
                bake::Mesh wall = walled_tube(3, 4.2, 50, bend_mm, has_rims);
                if (is_inside_out) wall = reversed(wall);
                const std::optional<WallFound> found = lumen_of_wall(wall);
                assert_true(found.has_value());
                is_near(found->thickness_mm, 1.2, 0.03, "thickness of the wall in mm");
                is_near(bake::volume_mm3(whole({{"wall", wall}}).closed), tube_mm3(3, 50), 0.01,
                        "volume of the lumen in mm3");
            }
}

void a_wall_may_be_taken_as_stated(void **)
{
    const bake::Mesh wall = walled_tube(3, 4.2, 50, 0, true);
    UnionWish wish;
    wish.walls = "lumen";
    std::string text;
    // The mesh then is the solid between the sheets.
    is_near(bake::volume_mm3(whole({{"wall", wall}}, wish, &text).closed),
            tube_mm3(4.2, 50) - tube_mm3(3, 50), 0.01, "volume of the wall in mm3");
    wish.walls = "wall";
    says(
        [&] {
            whole({{"tube", tube_mesh(3, 80, 0, tube_along, tube_around)}}, wish);
        },
        {"no wall", "--walls"});
}

// --- parts ---

void a_good_mesh_stays_as_it_is(void **)
{
    const WholeLumen made = whole({{"tube", tube_mesh(3, 80, 0, tube_along, tube_around)}});
    assert_false(made.is_remade);
    is_near(bake::volume_mm3(made.closed), tube_mm3(3, 80), 1e-9, "volume of a tube in mm3");
    is_near(
        bake::volume_mm3(whole({{"tube", reversed(tube_mesh(3, 80, 0, tube_along, tube_around))}}).closed),
        tube_mm3(3, 80), 1e-9, "volume of a tube that was inside out in mm3");
}

void parts_that_overlap_become_one_lumen(void **)
{
    // One of two tubes goes on inside the other for 20 mm.
    std::string text;
    const WholeLumen made =
        whole({{"aorta", tube_mesh(5, 60, 0, tube_along, tube_around)},
               {"iliac", moved(tube_mesh(3, 60, 0, tube_along, tube_around), {0, 40, 0})}},
              {}, &text);
    assert_true(made.is_remade);
    is_near(bake::volume_mm3(made.closed), tube_mm3(5, 60) + tube_mm3(3, 40), 0.02,
            "volume of two tubes in mm3");
    contains(text, "2 parts become one");
}

void a_gap_between_parts_is_bridged(void **)
{
    const std::vector<Part> parts = {
        {"one", tube_mesh(4, 40, 0, tube_along, tube_around)},
        {"two", moved(tube_mesh(4, 40, 0, tube_along, tube_around), {0, 42, 0})}};
    std::string text;
    const double both = bake::volume_mm3(whole(parts, {}, &text).closed);
    contains(text, "bridges");
    UnionWish none;
    none.bridge_mm = 0;
    const double one = bake::volume_mm3(whole(parts, none, &text).closed);
    contains(text, "left out");
    is_near(one, tube_mm3(4, 40), 0.02, "volume of one tube in mm3");
    // The bridge is a tube of 0.9 of the radius over 2 mm.
    is_near(both - 2 * one, tube_mm3(3.6, 2), 0.4, "volume of the bridge in mm3");
}

// --- unit, axes, names ---

Part read_one(const bake::Mesh &mesh, double numbers_per_mm, PartsWish wish, Frame &frame,
              Choices *said = nullptr)
{
    const Folder folder;
    bake::Mesh scaled = mesh;
    for (Vector3d &v : scaled.vertices_mm) v *= numbers_per_mm;
    write_obj(folder.path / "vessel.obj", scaled);
    wish.files = {folder.path / "vessel.obj"};
    Choices choices;
    return read_parts(wish, said ? *said : choices, frame).front();
}

void the_unit_is_found(void **)
{
    const bake::Mesh tube = tube_mesh(3, 300, 0, tube_along, tube_around);
    const std::pair<double, const char *> units[] = {{1, "mm"}, {1e-3, "m"}, {1e3, "um"}};
    for (const auto &[scale, unit] : units) {
        Frame frame;
        const Part part = read_one(tube, scale, {}, frame);
        assert_string_equal(frame.unit.c_str(), unit);
        Eigen::AlignedBox3d box;
        for (const Vector3d &v : part.mesh.vertices_mm) box.extend(v);
        is_near(box.sizes().y(), 300, 1e-4, "length in mm");
    }
    Frame frame;
    says([&] { read_one(tube, 1e-9, {}, frame); }, {"in no unit", "--unit"});
    PartsWish wish;
    wish.unit = "cm";
    read_one(tube, 0.1, wish, frame);
    assert_string_equal(frame.unit.c_str(), "cm");
}

// Programs for flow simulations write centimetres. Before, an aorta of 30 cm was taken for vessels of 30 mm.
void centimetres_are_known_by_how_thin_vessels_would_be(void **)
{
    Frame frame;
    read_one(tube_mesh(10, 300, 0, tube_along, tube_around), 0.1, {}, frame);
    assert_string_equal(frame.unit.c_str(), "cm");
    // A short piece of a wide vessel, and a long thin vessel, are in mm.
    read_one(tube_mesh(4, 40, 0, tube_along, tube_around), 1, {}, frame);
    assert_string_equal(frame.unit.c_str(), "mm");
    read_one(tube_mesh(1.2, 100, 0, tube_along, tube_around), 1, {}, frame);
    assert_string_equal(frame.unit.c_str(), "mm");
}

// Before, such meshes were refused. The second layer may look the other way, as the back of a surface does.
void doubled_triangles_count_once(void **)
{
    const bake::Mesh tube = tube_mesh(3, 80, 0, tube_along, tube_around);
    const std::size_t count = tube.triangles.size();
    bake::Mesh twice = tube, back = tube;
    twice.triangles.insert(twice.triangles.end(), tube.triangles.begin(), tube.triangles.end());
    const bake::Mesh other = reversed(tube);
    back.triangles.insert(back.triangles.end(), other.triangles.begin(), other.triangles.end());
    for (const bake::Mesh &mesh : {twice, back, together(tube, tube)}) {
        Choices choices;
        Frame frame;
        const Part part = read_one(mesh, 1, {}, frame, &choices);
        assert_int_equal(part.mesh.triangles.size(), count);
        contains(choices.text(""), formatted("%zu triangles count once", count).c_str());
        const WholeLumen made = whole({part});
        assert_false(made.is_remade);
        is_near(bake::volume_mm3(made.closed), tube_mm3(3, 80), 1e-5, "volume of a tube in mm3");
    }
    Choices none;
    Frame frame;
    read_one(tube, 1, {}, frame, &none);
    assert_true(none.text("").find("doubled") == std::string::npos);
}

void a_part_that_is_there_twice_counts_once(void **)
{
    const Folder folder;
    write_obj(folder.path / "vessel.obj", tube_mesh(3, 80, 0, tube_along, tube_around));
    write_obj(folder.path / "copy.obj", tube_mesh(3, 80, 0, tube_along, tube_around));
    PartsWish wish;
    wish.files = {folder.path / "vessel.obj", folder.path / "copy.obj"};
    Choices choices;
    Frame frame;
    assert_int_equal(read_parts(wish, choices, frame).size(), 1);
    contains(choices.text(""), "count once");
}

void the_head_of_a_scan_is_found(void **)
{
    bake::Mesh scan = tube_mesh(3, 200, 0, tube_along, tube_around);
    for (Vector3d &v : scan.vertices_mm) v = Vector3d(v.x(), v.z(), v.y());
    Frame frame;
    const Part part = read_one(scan, 1, {}, frame);
    assert_string_equal(frame.axes.c_str(), "+x,+z,-y");
    Eigen::AlignedBox3d box;
    for (const Vector3d &v : part.mesh.vertices_mm) box.extend(v);
    is_near(box.sizes().y(), 200, 1e-6, "height in mm");
    assert_true(axes_of("-x,+z,+y").determinant() > 0);
    bool is_refused = false;
    try {
        axes_of("+x,+y,-z");
    } catch (const std::exception &fault) {
        is_refused = std::string(fault.what()).find("mirror") != std::string::npos;
    }
    assert_true(is_refused);
}

void names_are_short_and_unique(void **)
{
    const std::vector<std::string> names =
        short_names({"VH_M_aortic_arch", "VH_M_Left Renal", "VH_M_aortic-arch",
                     "VH_M_posterior_descending_branch_of_something"});
    assert_string_equal(names[0].c_str(), "aortic_arch");
    assert_string_equal(names[1].c_str(), "left_renal");
    assert_string_equal(names[2].c_str(), "aortic_arch_2");
    assert_true(names[3].size() <= 31);
    assert_true(is_artery_name("VH_M_left_renal_artery"));
    assert_true(is_artery_name("VHF_posterior_left_ventricular_branch"));
    assert_false(is_artery_name("VH_M_pulmonary_artery_L"));
    assert_false(is_artery_name("VHF_posterior_vein_of_left_ventricle"));
    assert_false(is_artery_name("VH_M_left_cardiac_atrium"));
}

// A scene stores 31 letters, which the usual names of coronary arteries need.
void long_names_stay_whole_or_are_said_to_be_cut(void **)
{
    Choices choices;
    const std::vector<std::string> names = short_names(
        {"VH_M_left_anterior_descending_artery", "VH_M_diagonal_branch_of_left_anterior_descending",
         "VH_M_diagonal_branch_of_left_anterior_interventricular", "VH_M_lad", "VH_M_lad", "VH_M_lad_2"},
        &choices);
    assert_string_equal(names[0].c_str(), "left_anterior_descending_artery");
    for (std::size_t a = 0; a < names.size(); ++a) {
        assert_true(names[a].size() <= 31);
        for (std::size_t b = 0; b < a; ++b) assert_string_not_equal(names[a].c_str(), names[b].c_str());
    }
    const std::string said = choices.text("");
    contains(said,
             "cut       diagonal_branch_of_left_anterio for VH_M_diagonal_branch_of_left_anterior_desc");
    contains(said, "at most 31 letters");
    assert_true(said.find("left_anterior_descending_artery for") == said.npos);
}

// --- the whole folder ---

void a_bent_tube_becomes_a_scene(void **)
{
    const Folder folder;
    Choices choices;
    SceneWish wish;
    wish.folder = folder.path / "scene";
    const std::vector<Part> parts = {{"tube", tube_mesh(4, 150, 60, 150, tube_around)}};
    make_scene_folder(parts, {"mm", "+x,+y,+z", {}}, wish, choices, own_progress);
    const centreline::Tree tree = centreline::read_tree(wish.folder / "tree.csv");
    assert_int_equal(tree.branches.size(), 1);
    is_near(centreline::length_mm(tree.branches[0]), 150, 0.01, "length of the centreline in mm");
    for (const char *file : {"patient.scene", "patient.bodies", "lumen.ply", "tissue.ply", "bake.txt"})
        assert_true(std::filesystem::file_size(wish.folder / file) > 100);
    // The sheath's end lies in the middle of the tube.
    const bake::SceneText text = bake::read_scene_text(wish.folder / "scene.toml", {});
    assert_true(centreline::tests::tube_off_mm(text.entry.position_mm, 60) < 0.2);
    const std::string written = read_text_file((wish.folder / "scene.toml").string());
    for (const char *flag : {"--inlet", "--entry", "--branches", "--walls", "--no-bodies"})
        contains(written, flag);
    contains(read_text_file((wish.folder / "practice.session").string()), "advance wire 60 mm");
}

void a_fork_enters_at_its_lowest_wide_end(void **)
{
    const Folder folder;
    Choices choices;
    SceneWish wish;
    wish.folder = folder.path / "scene";
    // The trunk's end at y = -20 is the widest and the lowest.
    make_scene_folder({{"fork", centreline::tests::fork_mesh(0.4)}}, {"mm", "+x,+y,+z", {}}, wish, choices,
                      own_progress);
    const centreline::Tree tree = centreline::read_tree(wish.folder / "tree.csv");
    assert_int_equal(tree.branches.size(), 3);
    const bake::SceneText text = bake::read_scene_text(wish.folder / "scene.toml", {});
    assert_true(text.entry.position_mm.y() < 0);
    assert_true(text.entry.direction.y() > 0.8);
    wish.entry_mm = Vector3d(20, 30, 0);
    make_scene_folder({{"fork", centreline::tests::fork_mesh(0.4)}}, {"mm", "+x,+y,+z", {}}, wish, choices,
                      own_progress);
    const bake::SceneText other = bake::read_scene_text(wish.folder / "scene.toml", {});
    assert_true(other.entry.position_mm.x() > 2);
    assert_true(other.entry.direction.y() < 0);
}

// Vessels of the gut are thin and far apart: voxels as fine as their volume allows are too many for the box.
void a_thin_vessel_in_a_large_box_becomes_a_scene(void **)
{
    constexpr double radius_mm = 1.5, bend_mm = 120, length_mm = 750, rise = 0.3;
    constexpr int along = 750, around = 24;
    bake::Mesh helix = tube_mesh(radius_mm, length_mm, bend_mm, along, around);
    for (std::size_t i = 0; i < helix.vertices_mm.size(); ++i)
        helix.vertices_mm[i].z() += rise * length_mm / along * static_cast<double>(i / around);
    const Folder folder;
    SceneWish wish;
    wish.folder = folder.path / "scene";
    Choices choices;
    make_scene_folder({{"gut", helix}}, {"mm", "+x,+y,+z", {}}, wish, choices, own_progress);
    const centreline::Tree tree = centreline::read_tree(wish.folder / "tree.csv");
    assert_int_equal(tree.branches.size(), 1);
    is_near(centreline::length_mm(tree.branches[0]), length_mm * std::hypot(1.0, rise), 0.02,
            "length of the centreline in mm");
}

// --- real parts (../shared/anatomy) ---

std::filesystem::path anatomy(const char *file)
{
    const char *folder = std::getenv("CRN_ANATOMY");
    const std::filesystem::path path = std::filesystem::path(folder ? folder : "../shared/anatomy") / file;
    if (!std::filesystem::exists(path)) {
        print_message("skipped: no %s in $CRN_ANATOMY or ../shared/anatomy\n", file);
        skip();
    }
    return path;
}

// Before, `centreline auto` ended with 0 and a tree of length 0: its inlet lay in the thin wall.
void a_real_wall_has_a_tree(void **)
{
    PartsWish wish;
    wish.files = {anatomy("hra_female/VH_F_Vasculature_v1.0.glb")};
    wish.parts = {"VHF_pulmonary_artery_L"};
    Choices choices;
    Frame frame;
    const std::vector<Part> parts = read_parts(wish, choices, frame);
    assert_int_equal(parts.size(), 1);
    // The mesh as it is: the solid between the sheets.
    std::vector<std::string> notes;
    const centreline::Lumen wall(parts[0].mesh, {}, own_progress);
    double length_mm = 0;
    try {
        for (const centreline::Branch &branch :
             centreline::fit_automatic(wall, {}, notes, own_progress).branches)
            length_mm += centreline::length_mm(branch);
        assert_true(length_mm > 20);
    } catch (const Fault &fault) {
        contains(fault.what(), "--inlet");
    }
    // The lumen inside the wall is several times as large.
    const WholeLumen made = whole(parts);
    std::printf("# lumen of a real wall: %.2f ml\n", bake::volume_mm3(made.closed) / 1000);
    assert_true(bake::volume_mm3(made.closed) > 3 * 1535);
    const centreline::Lumen lumen(made.surface, {}, own_progress);
    length_mm = 0;
    for (const centreline::Branch &branch :
         centreline::fit_automatic(lumen, {}, notes, own_progress).branches)
        length_mm += centreline::length_mm(branch);
    assert_true(length_mm > 40);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_lumen_alone_is_no_wall),
                                cmocka_unit_test(the_lumen_of_a_wall_is_inside_its_inner_sheet),
                                cmocka_unit_test(a_wall_may_be_taken_as_stated),
                                cmocka_unit_test(a_good_mesh_stays_as_it_is),
                                cmocka_unit_test(parts_that_overlap_become_one_lumen),
                                cmocka_unit_test(a_gap_between_parts_is_bridged),
                                cmocka_unit_test(the_unit_is_found),
                                cmocka_unit_test(centimetres_are_known_by_how_thin_vessels_would_be),
                                cmocka_unit_test(doubled_triangles_count_once),
                                cmocka_unit_test(a_part_that_is_there_twice_counts_once),
                                cmocka_unit_test(the_head_of_a_scan_is_found),
                                cmocka_unit_test(names_are_short_and_unique),
                                cmocka_unit_test(long_names_stay_whole_or_are_said_to_be_cut),
                                cmocka_unit_test(a_bent_tube_becomes_a_scene),
                                cmocka_unit_test(a_fork_enters_at_its_lowest_wide_end),
                                cmocka_unit_test(a_thin_vessel_in_a_large_box_becomes_a_scene),
                                cmocka_unit_test(a_real_wall_has_a_tree)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
