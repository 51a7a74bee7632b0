// Tests the pictures, outlines and clicks of the review window with volumes whose voxels are known.
#include "host/base/pending_file.hpp"
#include "host/base/tests/folder.hpp"
#include "host/base/text.hpp"
#include "tools/lab/ct/review/review_state.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <thread>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::ct;
using Eigen::Vector3d;

namespace
{

// Water of 20 x 30 x 40 voxels of 1 x 2 x 0.5 mm, with bright voxels.
CtVolume water_with(const std::vector<std::array<int, 3>> &bright)
{
    CtVolume volume;
    volume.size = {20, 30, 40};
    volume.spacing_mm = {1, 2, 0.5};
    volume.first_mm = {-10, 5, 7};
    volume.permille.assign(volume.count(), 1000);
    for (const auto &at : bright) volume.permille[volume.index(at[0], at[1], at[2])] = 3000;
    return volume;
}

Vector3d place_of(const CtVolume &volume, const std::array<int, 3> &voxel)
{
    return volume.first_mm + Vector3d(voxel[0], voxel[1], voxel[2]).cwiseProduct(volume.spacing_mm);
}

// The middle of the white pixels.
Eigen::Vector2d white_middle(const SectionPicture &picture)
{
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double count = 0;
    for (int row = 0; row < picture.edge_px; ++row)
        for (int column = 0; column < picture.edge_px; ++column)
            if (picture.grey[static_cast<std::size_t>(row * picture.edge_px + column)] == 255) {
                sum += Eigen::Vector2d(column + 0.5, row + 0.5);
                ++count;
            }
    assert_true(count > 0);
    return sum / count;
}

constexpr Section sections[] = {Section::sagittal, Section::axial, Section::coronal};
constexpr int edge_px = 240;

} // namespace

static void a_bright_voxel_is_drawn_where_it_lies(void **)
{
    const std::array<int, 3> voxel = {15, 22, 31};
    const CtVolume volume = water_with({voxel});
    for (const Section section : sections) {
        const SectionPicture picture =
            section_of(volume, section, place_of(volume, voxel), 3, {-100, 500}, edge_px);
        const Eigen::Vector2d drawn = white_middle(picture), due = picture.pixel(place_of(volume, voxel));
        assert_true((drawn - due).norm() < 1); // less than a pixel of 0.25 mm
    }
}

// The patient's left is at the right of axial and coronal pictures, the head on top; the front is on top of
// axial pictures and at the left of sagittal ones.
static void sections_have_the_sides_that_radiologists_expect(void **)
{
    const CtVolume volume = water_with({});
    const Vector3d middle = place_of(volume, {10, 15, 20});
    const auto moved = [&](Section section, const Vector3d &by) {
        const SectionPicture picture = section_of(volume, section, middle, 0, {-100, 500}, edge_px);
        return Eigen::Vector2d(picture.pixel(middle + by) - picture.pixel(middle));
    };
    assert_true(moved(Section::axial, Vector3d::UnitX()).x() > 0);
    assert_true(moved(Section::coronal, Vector3d::UnitX()).x() > 0);
    assert_true(moved(Section::coronal, Vector3d::UnitY()).y() < 0);
    assert_true(moved(Section::sagittal, Vector3d::UnitY()).y() < 0);
    assert_true(moved(Section::axial, Vector3d::UnitZ()).y() < 0);
    assert_true(moved(Section::sagittal, Vector3d::UnitZ()).x() < 0);
}

static void a_pixel_of_a_slab_has_the_depth_of_its_brightest_voxel(void **)
{
    const std::array<int, 3> voxel = {15, 22, 31};
    const CtVolume volume = water_with({voxel});
    for (const Section section : sections) {
        // The slab reaches from the middle over the bright voxel.
        const int normal = static_cast<int>(section);
        Vector3d centre = place_of(volume, {10, 15, 20});
        const double off_mm = std::fabs(place_of(volume, voxel)[normal] - centre[normal]);
        const SectionPicture picture =
            section_of(volume, section, centre, 2 * off_mm + 1, {-100, 500}, edge_px);
        const Eigen::Vector2d pixel = picture.pixel(place_of(volume, voxel));
        const Vector3d found = picture.place(pixel.x(), pixel.y());
        assert_true((found - place_of(volume, voxel)).norm() < 0.2); // half a pixel's diagonal
    }
}

static void the_outline_of_a_box_is_its_cut(void **)
{
    bake::Mesh box; // -1 ... 1 by -2 ... 2 by -3 ... 3 mm
    for (int corner = 0; corner < 8; ++corner)
        box.vertices_mm.push_back(
            {corner & 1 ? 1.0 : -1.0, corner & 2 ? 2.0 : -2.0, corner & 4 ? 3.0 : -3.0});
    box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const double girths[] = {20, 16, 12}; // across x, y, z
    for (const Section section : sections) {
        double length = 0;
        for (const auto &[from, to] : outline_of(box, section, 0.25)) {
            length += (to - from).norm();
            assert_true(std::fabs(from[static_cast<int>(section)] - 0.25) < 1e-12);
        }
        assert_true(std::fabs(length - girths[static_cast<int>(section)]) < 1e-9);
        assert_true(outline_of(box, section, 5).empty());
    }
}

static void a_click_is_saved_and_asks_for_another_run(void **)
{
    const tests::Folder folder("review");
    CtVolume volume = water_with({});
    volume.permille[volume.index(0, 0, 0)] = 0; // air
    write_ct_volume(folder.file("scan.ct"), volume);
    {
        ReviewState state(folder.path, {});
        assert_true(state.has_scan());
        assert_false(state.needs_run());
        state.set_cross(place_of(volume, {10, 15, 20}));
        assert_true(state.add_click(ClickKind::bridge));
        assert_true(state.needs_run());
        assert_false(state.add_click(ClickKind::name)); // without a name
        assert_false(state.add_click(ClickKind::name, "a/b"));
        assert_true(state.add_click(ClickKind::name, "left_renal_artery"));
        state.set_cross(place_of(volume, {0, 0, 0}));
        assert_false(state.add_click(ClickKind::artery)); // in air
        assert_true(state.trouble().find("air") != std::string::npos);
    }
    ReviewState again(folder.path, {});
    assert_int_equal(again.clicks().size(), 2);
    assert_true(again.clicks()[0].kind == ClickKind::bridge);
    assert_true((again.clicks()[0].at_mm - place_of(volume, {10, 15, 20})).norm() < 1e-9);
    assert_true(again.clicks()[1].branch == "left_renal_artery");
    assert_true(again.needs_run()); // nobody has made the scene with them
    again.remove_click(0);
    assert_int_equal(read_clicks(folder.file("clicks.toml")).size(), 1);
}

static void a_damaged_file_of_the_folder_is_named(void **)
{
    const tests::Folder folder("review_damaged");
    write_ct_volume(folder.file("scan.ct"), water_with({}));
    std::string bytes = read_text_file(folder.file("scan.ct"));
    bytes[200] = static_cast<char>(bytes[200] ^ 1);
    write_whole_file(folder.file("scan.ct"), bytes);
    ReviewState state(folder.path, {});
    assert_false(state.has_scan());
    write_whole_file(folder.file("steps.json"), "{}\n"); // a good file does not hide the damaged one
    assert_true(state.look());
    assert_true(state.folder().trouble.find("scan.ct") != std::string::npos);
    state.set_cross({0, 0, 0}); // nothing to look at, and no crash
    assert_false(state.add_click(ClickKind::artery));
}

static void finished_steps_and_findings_are_read(void **)
{
    const tests::Folder folder("review_steps");
    write_whole_file(folder.file("steps.json"), "{\"scan\": \"3 1234abcd\", \"lumen\": \"3 1234abcd\"}\n");
    write_whole_file(folder.file("report.json"), "{\"check\": [\"look\", \"at it\"], \"facts\": [3]}\n");
    PatientFolder read(folder.path);
    assert_true(read.look());
    assert_false(read.look()); // nothing has changed
    for (const ReviewStep &step : read.steps())
        assert_int_equal(step.is_done, std::string(step.name) == "scan" || std::string(step.name) == "lumen");
    assert_int_equal(read.check.size(), 2);
    assert_int_equal(read.facts.size(), 0); // no text
    write_whole_file(folder.file("patient.scene"), "of an earlier run");
    assert_false(read.has_scene()); // its step is not done
    std::filesystem::remove(folder.file("steps.json"));
    assert_true(read.look());
    for (const ReviewStep &step : read.steps()) assert_false(step.is_done);
}

static void the_message_of_a_command_that_failed_is_shown(void **)
{
    const tests::Folder folder("review_failed");
    ReviewState state(folder.path,
                      {"/bin/sh", "-c", "echo first >&2; echo 'scan: no contrast medium' >&2; exit 1"});
    state.run();
    for (int i = 0; i < 1000 && state.trouble().empty(); ++i) {
        state.look();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    assert_string_equal(state.trouble().c_str(), "scan: no contrast medium");
    assert_false(state.is_running());
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_bright_voxel_is_drawn_where_it_lies),
        cmocka_unit_test(sections_have_the_sides_that_radiologists_expect),
        cmocka_unit_test(a_pixel_of_a_slab_has_the_depth_of_its_brightest_voxel),
        cmocka_unit_test(the_outline_of_a_box_is_its_cut),
        cmocka_unit_test(a_click_is_saved_and_asks_for_another_run),
        cmocka_unit_test(a_damaged_file_of_the_folder_is_named),
        cmocka_unit_test(finished_steps_and_findings_are_read),
        cmocka_unit_test(the_message_of_a_command_that_failed_is_shown),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
