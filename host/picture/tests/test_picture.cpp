// Tests pictures as files. libpng reads the PNG files back, and ffprobe the MP4 files. Failures leave nothing
// behind, and the display is drawn.
#include "host/base/tests/folder.hpp"
#include "host/picture/overlay.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <png.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

// All tests share one folder, which is removed at the end.
const tests::Folder &all_files()
{
    static const tests::Folder files("picture");
    return files;
}

std::string folder()
{
    return all_files().path;
}

std::size_t files_in_folder()
{
    return all_files().count();
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

std::string output_of(const std::string &command)
{
    std::FILE *pipe = popen(command.c_str(), "r");
    char text[512] = {};
    const std::size_t count = std::fread(text, 1, sizeof text - 1, pipe);
    pclose(pipe);
    return std::string(text, count);
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

static void film_has_every_picture_at_its_rate(void **)
{
    const std::string path = folder() + "/a.mp4";
    std::string error;
    VideoWriter film;
    assert_true(film.open(path, 128, 128, 15, error));
    for (int i = 0; i < 20; ++i) assert_true(film.add(compose_display(grey_picture(128), {}), error));
    assert_false(std::filesystem::exists(path)); // not before it is whole
    assert_true(film.finish(error));
    assert_int_equal(files_in_folder(), 1);
    const std::string said = output_of("ffprobe -v error -count_frames -show_entries "
                                       "stream=codec_name,pix_fmt,r_frame_rate,nb_read_frames -of csv=p=0 " +
                                       path);
    assert_string_equal(said.c_str(), "h264,yuv420p,15/1,20\n");
    std::filesystem::remove(path);
}

static void film_that_is_given_up_leaves_nothing(void **)
{
    std::string error;
    {
        VideoWriter film;
        assert_true(film.open(folder() + "/b.mp4", 128, 128, 15, error));
        assert_true(film.add(compose_display(grey_picture(128), {}), error));
    }
    assert_int_equal(files_in_folder(), 0);
}

static void film_refuses_wrong_sizes_and_missing_folders(void **)
{
    std::string error;
    VideoWriter film;
    assert_false(film.open(folder() + "/c.mp4", 127, 128, 15, error));
    assert_true(error.find("even") != error.npos);
    assert_false(film.open(folder() + "/missing/c.mp4", 128, 128, 15, error));
    assert_true(error.find("No such file") != error.npos);
    assert_true(film.open(folder() + "/c.mp4", 128, 128, 15, error));
    assert_false(film.add({64, 64, 3, std::vector<std::uint8_t>(64 * 64 * 3)}, error));
    assert_true(error.find("another size") != error.npos);
    assert_int_equal(files_in_folder(), 0);
}

static void film_without_ffmpeg_says_what_to_install(void **)
{
    const std::string path = std::getenv("PATH");
    setenv("PATH", folder().c_str(), 1);
    std::string error;
    VideoWriter film;
    bool is_fine = film.open(folder() + "/d.mp4", 128, 128, 15, error);
    for (int i = 0; is_fine && i < 200; ++i)
        is_fine = film.add(compose_display(grey_picture(128), {}), error);
    if (is_fine) is_fine = film.finish(error);
    setenv("PATH", path.c_str(), 1);
    assert_false(is_fine);
    assert_true(error.find("ffmpeg was not found") != error.npos);
    assert_int_equal(files_in_folder(), 0);
}

// ffmpeg must not be in the process group that receives Ctrl-C, because only our program decides what happens
// to the film.
static void film_survives_an_interrupt_of_the_foreground_group(void **)
{
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        setpgid(0, 0);
        signal(SIGINT, SIG_IGN);
        std::string error;
        VideoWriter film;
        bool is_fine = film.open(folder() + "/e.mp4", 128, 128, 15, error);
        for (int i = 0; is_fine && i < 10; ++i)
            is_fine = film.add(compose_display(grey_picture(128), {}), error);
        usleep(50'000);
        kill(0, SIGINT);
        usleep(50'000);
        is_fine = is_fine && film.add(compose_display(grey_picture(128), {}), error) && film.finish(error);
        _exit(is_fine ? 0 : 1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_true(std::filesystem::exists(folder() + "/e.mp4"));
    std::filesystem::remove(folder() + "/e.mp4");
    assert_int_equal(files_in_folder(), 0);
}

// This fake ffmpeg never reads and never ends by itself, so that only the death of its parent can end it.
static void film_program_ends_when_we_are_killed(void **)
{
    const std::string program = folder() + "/ffmpeg", number = folder() + "/number";
    std::ofstream(program) << "#!/bin/sh\necho $$ >" << number << ".new && mv " << number << ".new " << number
                           << "\nexec sleep 60\n";
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const std::string path = std::getenv("PATH");
    setenv("PATH", (folder() + ":" + path).c_str(), 1);
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        std::string error;
        VideoWriter film;
        if (film.open(folder() + "/f.mp4", 128, 128, 15, error))
            for (;;) pause();
        _exit(1);
    }
    setenv("PATH", path.c_str(), 1);
    const auto wait_until = [](const auto &condition) {
        for (int i = 0; i < 500 && !condition(); ++i) usleep(10'000);
        return condition();
    };
    assert_true(wait_until([&] { return std::filesystem::exists(number); }));
    pid_t ffmpeg = 0;
    std::ifstream(number) >> ffmpeg;
    assert_true(ffmpeg > 1);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, nullptr, 0), child);
    // The process has disappeared, or is a zombie whose parent has not collected it yet.
    const bool is_gone = wait_until([&] {
        std::ifstream stat("/proc/" + std::to_string(ffmpeg) + "/stat");
        const std::string text{std::istreambuf_iterator<char>(stat), {}};
        return text.empty() || text.find(") Z ") != text.npos;
    });
    if (!is_gone) kill(ffmpeg, SIGKILL);
    assert_true(is_gone);
    assert_false(std::filesystem::exists(folder() + "/f.mp4"));
    std::filesystem::remove_all(folder());
    std::filesystem::create_directory(folder());
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
        cmocka_unit_test(film_has_every_picture_at_its_rate),
        cmocka_unit_test(film_that_is_given_up_leaves_nothing),
        cmocka_unit_test(film_refuses_wrong_sizes_and_missing_folders),
        cmocka_unit_test(film_without_ffmpeg_says_what_to_install),
        cmocka_unit_test(film_survives_an_interrupt_of_the_foreground_group),
        cmocka_unit_test(film_program_ends_when_we_are_killed),
        cmocka_unit_test(display_draws_over_the_picture_and_nowhere_else),
        cmocka_unit_test(display_survives_any_number_and_any_text),
    };
    const int failed = cmocka_run_group_tests(tests, nullptr, nullptr);
    std::filesystem::remove_all(folder());
    return failed;
}
