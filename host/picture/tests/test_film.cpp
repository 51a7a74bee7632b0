// Tests the films that the program writes, by reading them with ffprobe and ffmpeg. Pictures, colours, frame
// rate and key pictures of a film must be right, and the film's index must come first, also with millions of
// pictures and above 4 GiB.
#include "host/base/tests/folder.hpp"
#include "host/picture/h264.hpp"
#include "host/picture/mp4_file.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

// All tests share one folder, which is removed at the end.
const tests::Folder &film_files()
{
    static const tests::Folder files("film");
    return files;
}

// Returns what a program prints.
std::string output_of(const std::string &command)
{
    std::FILE *pipe = popen(command.c_str(), "r");
    std::string all;
    char part[4096];
    for (std::size_t count; (count = std::fread(part, 1, sizeof part, pipe)) > 0;) all.append(part, count);
    pclose(pipe);
    return all;
}

std::string bytes_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// Decodes a film and returns its pictures as RGB bytes, one picture after the other.
std::string decoded(const std::string &path)
{
    return output_of("ffmpeg -v error -i " + path +
                     " -sws_flags bilinear+accurate_rnd+full_chroma_int -f rawvideo -pix_fmt rgb24 -");
}

Image black(int width, int height)
{
    return {width, height, 3, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height))};
}

struct Square {
    int x, y, edge;
    int colour[3];
};

void draw(Image &image, const Square &square)
{
    for (int y = square.y; y < square.y + square.edge; ++y)
        for (int x = square.x; x < square.x + square.edge; ++x)
            for (int i = 0; i < 3; ++i)
                image.bytes[static_cast<std::size_t>(3 * (y * image.width + x) + i)] =
                    static_cast<std::uint8_t>(square.colour[i]);
}

// Makes a picture of grey noise, similar to the quantum noise of an X-ray picture. Every number gives another
// picture.
Image noise(int width, int height, std::uint32_t number)
{
    Image image = black(width, height);
    std::uint32_t state = 12345 + number;
    for (std::size_t i = 0; i < image.bytes.size(); i += 3) {
        int sum = 0; // of four, so that the middle is more frequent
        for (int k = 0; k < 4; ++k) {
            state = state * 1664525u + 1013904223u;
            sum += static_cast<int>(state >> 27);
        }
        for (std::size_t k = 0; k < 3; ++k) image.bytes[i + k] = static_cast<std::uint8_t>(66 + sum);
    }
    return image;
}

// Writes a film of noise; if this fails, the test fails with the reason.
void write_noise(const std::string &path, int pictures)
{
    std::string error;
    VideoWriter film;
    bool is_fine = film.open(path, 128, 96, 15, error);
    for (int i = 0; is_fine && i < pictures; ++i)
        is_fine = film.add(noise(128, 96, static_cast<std::uint32_t>(i)), error);
    if (!is_fine || !film.finish(error)) fail_msg("%s", error.c_str());
}

std::uint32_t u32_at(const std::string &bytes, std::size_t place)
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[place + i]);
    return value;
}

} // namespace

static void film_has_every_picture_at_its_rate(void **)
{
    const std::string path = film_files().file("a.mp4");
    std::string error;
    VideoWriter film;
    assert_true(film.open(path, 128, 96, 15, error));
    for (std::uint32_t i = 0; i < 20; ++i) assert_true(film.add(noise(128, 96, i), error));
    assert_false(std::filesystem::exists(path)); // not before it is whole
    assert_true(film.finish(error));
    assert_int_equal(film_files().count(), 1);
    const std::string said = output_of(
        "ffprobe -v error -count_frames -show_entries "
        "stream=codec_name,width,height,pix_fmt,color_range,color_space,color_transfer,"
        "color_primaries,r_frame_rate,avg_frame_rate,duration,nb_frames,nb_read_frames -of csv=p=0 " +
        path);
    assert_string_equal(said.c_str(), "h264,128,96,yuv420p,tv,bt709,bt709,bt709,15/1,15/1,1.333333,20,20\n");
    std::filesystem::remove(path);
}

static void film_shows_what_was_given(void **)
{
    const std::string path = film_files().file("a.mp4");
    constexpr int width = 210, height = 130; // not multiples of 16
    const Square squares[] = {{20, 12, 30, {255, 255, 255}}, {80, 12, 30, {255, 0, 0}},
                              {140, 12, 30, {0, 255, 0}},    {20, 80, 30, {0, 0, 255}},
                              {80, 80, 30, {255, 176, 64}},  {140, 80, 30, {128, 128, 128}}};
    std::string error;
    VideoWriter film;
    assert_true(film.open(path, width, height, 30, error));
    for (int i = 0; i < 3; ++i) { // everything moves by two pixels
        Image image = black(width, height);
        for (Square square : squares) {
            square.x += 2 * i;
            draw(image, square);
        }
        assert_true(film.add(image, error));
    }
    assert_true(film.finish(error));
    const std::string rgb = decoded(path);
    assert_int_equal(rgb.size(), 3 * 3 * width * height);
    for (int i = 0; i < 3; ++i)
        for (const Square &square : squares)
            for (int y = square.y - 8; y < square.y + square.edge + 8; ++y)
                for (int x = square.x - 8; x < square.x + square.edge + 8; ++x) {
                    // Colour has only half the resolution of brightness, so around coloured squares the
                    // comparison ignores a wider border than around grey squares.
                    const bool is_grey =
                        square.colour[0] == square.colour[1] && square.colour[1] == square.colour[2];
                    const int border = is_grey ? 1 : 4;
                    const int in = std::min({x - square.x, y - square.y, square.x + square.edge - 1 - x,
                                             square.y + square.edge - 1 - y});
                    if (in >= -border && in < border) continue;
                    for (int k = 0; k < 3; ++k) {
                        const int place = 3 * ((i * height + y) * width + x + 2 * i) + k;
                        const int is = static_cast<std::uint8_t>(rgb[static_cast<std::size_t>(place)]);
                        const int expected = in >= 0 ? square.colour[k] : 0;
                        if (std::abs(is - expected) > 16)
                            fail_msg("picture %d, column %d, row %d, colour %d: %d, expected %d", i,
                                     x + 2 * i, y, k, is, expected);
                    }
                }
    std::filesystem::remove(path);
}

static void film_keeps_the_noise_of_a_picture(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 40);
    const std::string rgb = decoded(path);
    const std::size_t bytes = 3 * 128 * 96;
    assert_int_equal(rgb.size(), 40 * bytes);
    for (std::uint32_t i = 0; i < 40; ++i) {
        const Image given = noise(128, 96, i);
        double squares = 0;
        for (std::size_t k = 0; k < bytes; ++k)
            squares += std::pow(static_cast<std::uint8_t>(rgb[i * bytes + k]) - given.bytes[k], 2);
        const double psnr_dB = 10 * std::log10(255 * 255 / (squares / static_cast<double>(bytes)));
        if (psnr_dB < 36) fail_msg("picture %u: %.1f dB, expected at least 36 dB", i, psnr_dB);
    }
    std::filesystem::remove(path);
}

// The film has key pictures at regular intervals. A player can begin at any key picture, so the user can jump
// to any time.
static void film_has_a_key_picture_every_two_seconds(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 65);
    const std::string flags = output_of("ffprobe -v error -show_entries packet=flags -of csv=p=0 " + path);
    std::string keys;
    for (std::size_t at = 0, number = 0; at < flags.size(); at = flags.find('\n', at) + 1, ++number)
        if (flags[at] == 'K') keys += std::to_string(number) + " ";
    assert_string_equal(keys.c_str(), "0 30 60 ");
    // To show a picture in the middle, the decoder must begin with the key picture before it.
    const std::string late =
        output_of("ffmpeg -v error -ss 2.4 -i " + path + " -f rawvideo -pix_fmt rgb24 -");
    assert_int_equal(late.size(), (65 - 36) * 3 * 128 * 96);
    std::filesystem::remove(path);
}

// A decoder in hardware may refuse a film whose level does not permit its bit rate. The level 1.3 permits 960
// kbit/s in the profile High, and the level 1.2 only 480 (H.264, tables ).
static void film_states_a_level_that_permits_its_bit_rate(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 65);
    const std::string said =
        output_of("ffprobe -v error -show_entries stream=level,bit_rate -of csv=p=0 " + path);
    int level = 0;
    double bit_per_s = 0;
    if (std::sscanf(said.c_str(), "%d,%lf", &level, &bit_per_s) != 2) fail_msg("%s", said.c_str());
    if (bit_per_s < 500e3 || bit_per_s > 900e3) fail_msg("%.0f bit/s, so it needs another level", bit_per_s);
    assert_int_equal(level, 13);
    std::filesystem::remove(path);
}

static void film_has_its_index_before_the_pictures(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 130); // more than one of the blocks that are moved, 256 KiB
    const std::string bytes = bytes_of(path);
    if (bytes.size() < 550'000) fail_msg("%zu bytes", bytes.size());
    std::string types;
    std::size_t place = 0;
    while (place + 8 <= bytes.size() && u32_at(bytes, place) >= 8) {
        types += bytes.substr(place + 4, 4) + " ";
        place += u32_at(bytes, place);
    }
    assert_string_equal(types.c_str(), "ftyp moov mdat ");
    assert_int_equal(place, bytes.size());
    // If the position of a chunk were wrong, the decoded pictures would be broken.
    assert_string_equal(output_of("ffmpeg -v error -i " + path + " -f null - 2>&1").c_str(), "");
    std::filesystem::remove(path);
}

static void same_pictures_give_the_same_bytes(void **)
{
    const std::string first = film_files().file("a.mp4"), second = film_files().file("b.mp4");
    write_noise(first, 40);
    write_noise(second, 40);
    assert_true(bytes_of(first) == bytes_of(second));
    std::filesystem::remove(first);
    std::filesystem::remove(second);
}

static void film_without_pictures_is_a_file(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 0);
    const std::string said =
        output_of("ffprobe -v error -show_entries stream=codec_name,width -of csv=p=0 " + path);
    assert_string_equal(said.c_str(), "h264,128\n");
    std::filesystem::remove(path);
}

// The test makes a film of ten hours at 60 pictures per second (6.5 GB) as a sparse file, whose pictures take
// no space on the disk.
static void index_holds_millions_of_pictures_and_more_than_4_GiB(void **)
{
    constexpr std::uint32_t pictures = 2'160'000, picture_bytes = 3'000, key_every = 120;
    const H264Encoder encoder(128, 96, 60);
    Mp4Index index;
    for (std::uint32_t i = 0; i < pictures; ++i) assert_true(index.add(picture_bytes, i % key_every == 0));
    const std::vector<std::uint8_t> head =
        index.head({128, 96, 60, encoder.sequence_parameters(), encoder.picture_parameters()});
    const std::string path = film_files().file("long.mp4");
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char *>(head.data()), static_cast<std::streamsize>(head.size()));
    std::filesystem::resize_file(path, head.size() + std::uint64_t{pictures} * picture_bytes);
    const std::string whole =
        output_of("ffprobe -v error -show_entries stream=r_frame_rate,duration,nb_frames -of csv=p=0 " +
                  path + " 2>/dev/null");
    assert_string_equal(whole.c_str(), "60/1,36000.000000,2160000\n");
    const std::string late = output_of(
        "ffprobe -v error -read_intervals 35998%+#1 -show_entries packet=pts,size,pos -of csv=p=0 " + path +
        " 2>/dev/null");
    const std::uint64_t number = 35'998 * 60, begin = head.size() + number * picture_bytes;
    assert_string_equal(late.c_str(),
                        (std::to_string(number) + ",3000," + std::to_string(begin) + "\n").c_str());
    std::filesystem::remove(path);
}

// The file uses 32-bit positions, and a 32-bit length for the box with the pictures, only if it is small
// enough for such numbers.
static void index_is_wide_only_where_it_must_be(void **)
{
    const H264Encoder encoder(128, 96, 15);
    const Mp4Track track{128, 96, 15, encoder.sequence_parameters(), encoder.picture_parameters()};
    const auto head_of = [&](std::uint64_t bytes) {
        Mp4Index index;
        index.add(static_cast<std::uint32_t>(bytes / 2), true);
        index.add(static_cast<std::uint32_t>(bytes - bytes / 2), false);
        const std::vector<std::uint8_t> head = index.head(track);
        return std::string(head.begin(), head.end());
    };
    const std::size_t narrow_bytes = head_of(1000).size();
    const std::uint64_t last = 0xffffffffull - narrow_bytes;
    const std::string narrow = head_of(last), wide = head_of(last + 1), large = head_of(0xffffffffull);
    assert_true(narrow.find("stco") != narrow.npos && narrow.find("co64") == narrow.npos);
    assert_true(wide.find("stco") == wide.npos && wide.find("co64") != wide.npos);
    assert_int_equal(u32_at(wide, wide.size() - 8), last + 1 + 8);
    assert_int_equal(u32_at(large, large.size() - 16), 1);
    assert_int_equal(u32_at(large, large.size() - 8), 1); // 4 GiB + 15: 1 above 32 bits, and 14 below
    assert_int_equal(u32_at(large, large.size() - 4), 15);
}

static void film_that_is_given_up_leaves_nothing(void **)
{
    std::string error;
    {
        VideoWriter film;
        assert_true(film.open(film_files().file("b.mp4"), 128, 96, 15, error));
        assert_true(film.add(noise(128, 96, 0), error));
        assert_int_equal(film_files().count(), 1);
    }
    assert_int_equal(film_files().count(), 0);
}

static void film_refuses_wrong_sizes_and_missing_folders(void **)
{
    std::string error;
    VideoWriter film;
    assert_false(film.open(film_files().file("c.mp4"), 127, 128, 15, error));
    assert_true(error.find("even") != error.npos);
    assert_false(film.open(film_files().file("c.mp4"), 3074, 128, 15, error));
    assert_true(error.find("c.mp4") != error.npos && error.find("3072 pixels (--size)") != error.npos);
    assert_false(film.open(film_files().file("c.mp4"), 128, 128, 61, error));
    assert_true(error.find("60 pictures per second (--fps)") != error.npos);
    assert_false(film.open(film_files().file("missing/c.mp4"), 128, 128, 15, error));
    assert_true(error.find("No such file") != error.npos);
    assert_true(film.open(film_files().file("c.mp4"), 128, 128, 15, error));
    assert_false(film.add({64, 64, 3, std::vector<std::uint8_t>(64 * 64 * 3)}, error));
    assert_true(error.find("another size") != error.npos);
    assert_int_equal(film_files().count(), 0);
}

static void film_of_the_largest_size_is_written(void **)
{
    const std::string path = film_files().file("a.mp4");
    std::string error;
    VideoWriter film;
    assert_true(film.open(path, H264Encoder::edge_max, H264Encoder::edge_max, 60, error));
    assert_true(film.add(black(H264Encoder::edge_max, H264Encoder::edge_max), error));
    assert_true(film.finish(error));
    const std::string said = output_of(
        "ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 " +
        path);
    assert_string_equal(said.c_str(), "3072,3072,1\n");
    std::filesystem::remove(path);
}

// When the library openh264 fails, its message must become part of our error message and must not go to the
// terminal.
static void error_of_the_library_is_a_message(void **)
{
    const std::string log = film_files().file("log");
    const int terminal = dup(STDERR_FILENO), file = open(log.c_str(), O_WRONLY | O_CREAT, 0600);
    dup2(file, STDERR_FILENO);
    std::string error;
    try {
        const H264Encoder encoder(H264Encoder::edge_max + 16, H264Encoder::edge_max + 16, 15);
    } catch (const std::runtime_error &failed) {
        error = failed.what();
    }
    dup2(terminal, STDERR_FILENO);
    close(terminal);
    close(file);
    assert_string_equal(bytes_of(log).c_str(), "");
    std::filesystem::remove(log);
    if (error.find("openh264 does not encode 3088 x 3088 pixels") == error.npos ||
        error.find("width * height <= 9437184") == error.npos ||
        error.find("; choose a smaller --size") == error.npos || error.find("0x") != error.npos)
        fail_msg("%s", error.c_str());
}

// In this test the disk becomes full while pictures are written, or later when only the index is missing.
static void film_on_a_full_disk_says_so_and_leaves_nothing(void **)
{
    const std::string path = film_files().file("a.mp4");
    write_noise(path, 40);
    const rlim_t whole = std::filesystem::file_size(path);
    std::filesystem::remove(path);
    rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (const rlim_t room : {whole / 2, whole - 1}) {
        std::string error;
        VideoWriter film;
        assert_true(film.open(path, 128, 96, 15, error));
        const rlimit full{room, before.rlim_max};
        setrlimit(RLIMIT_FSIZE, &full);
        bool is_fine = true;
        int pictures = 0;
        for (; is_fine && pictures < 40; ++pictures)
            is_fine = film.add(noise(128, 96, static_cast<std::uint32_t>(pictures)), error);
        const bool are_pictures_written = is_fine;
        if (is_fine) is_fine = film.finish(error);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_false(is_fine);
        assert_int_equal(are_pictures_written, room == whole - 1);
        assert_true(error.find("a.mp4: cannot be written") != error.npos);
        assert_true(error.find("make room on the disk") != error.npos);
        assert_int_equal(film_files().count(), 0);
    }
}

static void film_that_is_interrupted_leaves_nothing(void **)
{
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        std::string error;
        VideoWriter film;
        bool is_fine = film.open(film_files().file("e.mp4"), 128, 96, 15, error);
        for (std::uint32_t i = 0; is_fine && i < 10; ++i) is_fine = film.add(noise(128, 96, i), error);
        if (is_fine && film_files().count() == 1) raise(SIGINT);
        _exit(1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    assert_int_equal(film_files().count(), 0);
}

// If a program handles Ctrl-C itself, it decides what happens to the film, and the writer continues.
static void film_survives_an_interrupt_that_the_program_handles(void **)
{
    const std::string path = film_files().file("e.mp4");
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        struct sigaction handler {
        };
        handler.sa_handler = [](int) {};
        sigaction(SIGINT, &handler, nullptr);
        std::string error;
        VideoWriter film;
        bool is_fine = film.open(path, 128, 96, 15, error);
        for (std::uint32_t i = 0; is_fine && i < 10; ++i) {
            raise(SIGINT);
            is_fine = film.add(noise(128, 96, i), error);
        }
        _exit(is_fine && film.finish(error) ? 0 : 1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_true(std::filesystem::exists(path));
    std::filesystem::remove(path);
    assert_int_equal(film_files().count(), 0);
}

int main()
{
    signal(SIGINT, SIG_DFL); // a shell starts background programs with Ctrl-C ignored
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(film_has_every_picture_at_its_rate),
        cmocka_unit_test(film_shows_what_was_given),
        cmocka_unit_test(film_keeps_the_noise_of_a_picture),
        cmocka_unit_test(film_has_a_key_picture_every_two_seconds),
        cmocka_unit_test(film_states_a_level_that_permits_its_bit_rate),
        cmocka_unit_test(film_has_its_index_before_the_pictures),
        cmocka_unit_test(same_pictures_give_the_same_bytes),
        cmocka_unit_test(film_without_pictures_is_a_file),
        cmocka_unit_test(index_holds_millions_of_pictures_and_more_than_4_GiB),
        cmocka_unit_test(index_is_wide_only_where_it_must_be),
        cmocka_unit_test(film_that_is_given_up_leaves_nothing),
        cmocka_unit_test(film_refuses_wrong_sizes_and_missing_folders),
        cmocka_unit_test(film_of_the_largest_size_is_written),
        cmocka_unit_test(error_of_the_library_is_a_message),
        cmocka_unit_test(film_on_a_full_disk_says_so_and_leaves_nothing),
        cmocka_unit_test(film_that_is_interrupted_leaves_nothing),
        cmocka_unit_test(film_survives_an_interrupt_that_the_program_handles),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
