// Tests picture files and the display: libpng must read the PNG files, a failure must leave no file behind,
// and the display must be drawn. Films are in test_film.cpp.
#include "host/base/tests/folder.hpp"
#include "host/picture/overlay.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <limits>
#include <png.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

// All tests share one folder, which is removed at the end.
const tests::Folder &picture_files()
{
    static const tests::Folder files("picture");
    return files;
}

std::string folder()
{
    return picture_files().path;
}

std::size_t files_in_folder()
{
    return picture_files().count();
}

XrayPicture grey_picture(int size)
{
    XrayPicture picture;
    picture.size = size;
    picture.grey.resize(static_cast<std::size_t>(size) * size);
    for (std::size_t i = 0; i < picture.grey.size(); ++i)
        picture.grey[i] = static_cast<std::uint8_t>(i * 7 % 200);
    return picture;
}

} // namespace

static void png_reads_back_byte_for_byte(void **)
{
    const Image image{3, 2, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 255}};
    const std::string path = folder() + "/a.png";
    std::string error;
    assert_true(write_png(path, image, error));
    png_image png;
    std::memset(&png, 0, sizeof png);
    png.version = PNG_IMAGE_VERSION;
    assert_true(png_image_begin_read_from_file(&png, path.c_str()));
    png.format = PNG_FORMAT_RGB;
    std::uint8_t bytes[18];
    assert_true(png_image_finish_read(&png, nullptr, bytes, 0, nullptr));
    assert_memory_equal(bytes, image.bytes.data(), 18);
    std::filesystem::remove(path);
    assert_int_equal(files_in_folder(), 0);
}

static void png_into_a_missing_folder_names_file_and_cause(void **)
{
    std::string error;
    assert_false(write_png(folder() + "/missing/a.png", {1, 1, 1, {0}}, error));
    assert_true(error.find("missing/a.png") != error.npos && error.find("No such file") != error.npos);
}

static void display_draws_over_the_picture_and_nowhere_else(void **)
{
    const XrayPicture picture = grey_picture(512);
    OverlayInfo info;
    info.tools = {
        {"Wire", 120, 90, 0.4, 1, true}, {"Catheter", 80, 0, 0.1, 0, false}, {"Guide", 20, 0, 0, 0, false}};
    const Image image = compose_display(picture, info);
    int changed_in_corner = 0, changed_in_middle = 0;
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 512; ++x) {
            const bool is_changed = image.bytes[3 * (512 * y + x)] != picture.grey[512 * y + x];
            if (x < 128 && y < 48) changed_in_corner += is_changed;
            if (x > 64 && x < 448 && y > 64 && y < 448) changed_in_middle += is_changed;
        }
    assert_true(changed_in_corner > 200);
    assert_int_equal(changed_in_middle, 0);
}

static void display_survives_any_number_and_any_text(void **)
{
    OverlayInfo info;
    const double nan = std::numeric_limits<double>::quiet_NaN(), huge = 1e300;
    info.room.carm.primary_deg = nan;
    info.room.carm.secondary_deg = huge;
    info.room.carm.field_m = -huge;
    info.room.technique.tube_voltage_kV = nan;
    info.room.pulses_per_s = -huge;
    info.time_s = nan;
    info.tools.assign(40, {std::string(300, 'x') + "\xff\x01\n", huge, nan,
                           std::numeric_limits<double>::infinity(), -huge, true});
    info.axial_full_scale_N = 0.0;
    info.kerma_mGy = -nan;
    info.kap_Gy_cm2 = huge;
    info.notice = std::string(500, '\x80');
    info.panel.assign(100, std::string(200, '#'));
    for (int size : {64, 130, 512}) compose_display(grey_picture(size), info);
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(png_reads_back_byte_for_byte),
        cmocka_unit_test(png_into_a_missing_folder_names_file_and_cause),
        cmocka_unit_test(display_draws_over_the_picture_and_nowhere_else),
        cmocka_unit_test(display_survives_any_number_and_any_text),
    };
    const int failed = cmocka_run_group_tests(tests, nullptr, nullptr);
    std::filesystem::remove_all(folder());
    return failed;
}
