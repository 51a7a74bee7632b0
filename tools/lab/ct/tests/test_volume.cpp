// These tests check the following. A volume is read back from every file format with its values and
// positions. Left-handed grids keep their places. If a scan has wrong spacing, axes or values, the error
// message names this fault. The error message also names slices that are missing, duplicated, unevenly
// spaced, mixed or truncated. No truncated or damaged file crashes the readers. For every format, the test
// cuts and damages 2 files at positions that follow from a printed seed.
#include "host/base/tests/folder.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace crn::ct;
using crn::Fault;
using crn::tests::Folder;
namespace fs = std::filesystem;

namespace
{

// Returns a volume on an oblique grid with a different value in every voxel, so that no axis can be mistaken
// for another axis.
Volume sample()
{
    Volume volume;
    volume.size = {7, 9, 5};
    volume.spacing_mm = {0.53, 0.6, 1};
    volume.origin_mm = {-10, 20, 30};
    const double c = std::cos(0.3), s = std::sin(0.3);
    volume.direction << c, 0, s, 0, 1, 0, -s, 0, c;
    volume.hu.resize(volume.count());
    for (std::size_t i = 0; i < volume.count(); ++i) volume.hu[i] = static_cast<float>(i) - 200;
    return volume;
}

std::string bytes_of(const fs::path &file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void put_bytes(const fs::path &file, const std::string &bytes)
{
    std::ofstream(file, std::ios::binary) << bytes;
}

void replace_in(const fs::path &file, const std::string &what, const std::string &by)
{
    std::string bytes = bytes_of(file);
    const std::size_t at = bytes.find(what);
    assert_true(at != std::string::npos);
    put_bytes(file, bytes.replace(at, what.size(), by));
}

// Checks that reading `path` fails with a message that contains all given parts.
void refused(const fs::path &path, const std::vector<std::string> &parts)
{
    try {
        read_volume(path);
    } catch (const Fault &fault) {
        const std::string text = fault.what();
        for (const std::string &part : parts)
            if (text.find(part) == std::string::npos) {
                std::printf("# expected '%s' in: %s\n", part.c_str(), text.c_str());
                fail_msg("the message lacks a part");
            }
        return;
    }
    std::printf("# %s was read\n", path.c_str());
    fail_msg("a damaged file was read");
}

double most_apart(const Volume &a, const Volume &b)
{
    double most = 0;
    for (int k = 0; k < a.size[2]; ++k)
        for (int j = 0; j < a.size[1]; ++j)
            for (int i = 0; i < a.size[0]; ++i) {
                const double there = b.value(b.voxel(a.scene({double(i), double(j), double(k)})));
                most = std::max(most, std::abs(there - static_cast<double>(a.hu[a.at(i, j, k)])));
            }
    return most;
}

void every_format_keeps_values_and_places(void **)
{
    const Folder folder{"volume"};
    for (const char *name : {"a.nrrd", "a.nii", "a.nii.gz", "a.mha", "series"}) {
        write_volume(sample(), folder.file(name));
        const Volume back = read_volume(folder.file(name));
        const double apart = most_apart(sample(), back);
        std::printf("# %s: values at the same places are apart by %.2g HU\n", name, apart);
        assert_true(back.size == sample().size);
        assert_true((back.spacing_mm - sample().spacing_mm).norm() < 1e-5);
        assert_true(apart < 1e-3);
    }
}

void the_scene_looks_at_the_patient_as_lps_does(void **)
{
    assert_true(scene_from_lps({1, 2, 3}) == Eigen::Vector3d(1, 3, -2));
    assert_true(lps_from_scene(scene_from_lps({4, 5, 6})) == Eigen::Vector3d(4, 5, 6));
    const Volume volume = sample();
    assert_true((volume.voxel(volume.scene({2, 3, 1.5})) - Eigen::Vector3d(2, 3, 1.5)).norm() < 1e-9);
}

// If the third axis of a file runs backwards, the scan is read without mirroring, and a note reports the
// reversed axis.
void mirrored_axes_keep_their_places(void **)
{
    const Folder folder{"mirror"};
    Volume mirrored = sample();
    mirrored.direction.col(2) = -mirrored.direction.col(2);
    mirrored.origin_mm = sample().lps({0, 0, 4});
    for (int k = 0; k < 5; ++k)
        std::copy_n(sample().hu.begin() + 63 * k, 63, mirrored.hu.begin() + 63 * (4 - k));
    for (const char *name : {"m.nrrd", "m.mha", "m.nii"}) {
        write_volume(mirrored, folder.file(name));
        const Volume back = read_volume(folder.file(name));
        assert_true(most_apart(sample(), back) < 1e-3);
        assert_int_equal(back.notes.size(), 1);
        assert_true(back.notes[0].find("left-handed") != std::string::npos);
    }
}

void impossible_grids_are_refused(void **)
{
    const Folder folder{"grid"};
    const auto header = [&](const char *spacing, const char *transform) {
        put_bytes(
            folder.file("a.mha"),
            std::string("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                        "TransformMatrix = ") +
                transform + "\nOffset = 0 0 0\nElementSpacing = " + spacing +
                "\nDimSize = 2 2 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" + "0123456789abcdef");
    };
    const char *upright = "1 0 0 0 1 0 0 0 1";
    header("1 1 1", upright);
    read_volume(folder.file("a.mha"));
    for (const char *spacing : {"0 1 1", "1 nan 1", "1 1 -2", "1 1 1000", "0.0001 1 1"}) {
        header(spacing, upright);
        refused(folder.file("a.mha"), {"a.mha", ":"});
    }
    header("1 1 1000", upright);
    refused(folder.file("a.mha"), {"spacing 1 x 1 x 1000 mm", "mend the header"});
    header("1 1 1", "1 0 0 0.3 0.954 0 0 0 1");
    refused(folder.file("a.mha"), {"right angles", "resample"});
    header("1 1 1", "0 0 0 0 0 0 0 0 0");
    refused(folder.file("a.mha"), {"a.mha"});
    try {
        check_grid({2, 2, 2}, {1, std::numeric_limits<double>::quiet_NaN(), 1}, {0, 0, 0},
                   Eigen::Matrix3d::Identity(), "a");
        fail_msg("a spacing that is no number was accepted");
    } catch (const Fault &fault) {
        assert_true(std::string(fault.what()).find("spacing 1 x nan x 1 mm") != std::string::npos);
    }
}

// ITK replaces a spacing that it does not understand by 1 mm, so lengths would be measured at a wrong scale.
void a_scale_that_is_none_is_refused(void **)
{
    const Folder folder{"scale"};
    const auto header = [&](const std::string &scale) {
        put_bytes(folder.file("a.nrrd"),
                  "NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: raw\n" +
                      scale + "\n\n0123456789abcdef");
    };
    const std::string space = "space: left-posterior-superior\nspace directions: ";
    header(space + "(1,0,0) (0,1,0) (0,0,1)");
    read_volume(folder.file("a.nrrd"));
    header(space + "(1e300,0,0) (0,1,0) (0,0,1)");
    refused(folder.file("a.nrrd"), {"a.nrrd:8", "space directions", "1e300"});
    header(space + "none (0,1,0) (0,0,1)");
    refused(folder.file("a.nrrd"), {"a.nrrd:8", "'none' gives no scale"});
    header(space + "(1,0,0) (0,1,0) (0,0,1)\nspace units: \"m\" \"m\" \"m\"");
    refused(folder.file("a.nrrd"), {"a.nrrd:9", "space units", "mm"});
    header("space dimension: 3");
    refused(folder.file("a.nrrd"), {"a.nrrd", "no 'spacings'", "scale is unknown"});
    header("spacings: 1 nan 1");
    refused(folder.file("a.nrrd"), {"a.nrrd:7", "spacings", "finite"});
}

// One of the test's files would make ITK search without end; the others would make ITK reserve memory without
// limit.
void absurd_numbers_of_axes_and_voxels_are_refused(void **)
{
    const Folder folder{"axes"};
    write_volume(sample(), folder.file("a.mha"));
    const std::string whole = bytes_of(folder.file("a.mha"));
    replace_in(folder.file("a.mha"), "NDims = 3", "NDims = -1");
    refused(folder.file("a.mha"), {"a.mha:", "NDims is '-1'"});
    put_bytes(folder.file("a.mha"), whole);
    replace_in(folder.file("a.mha"), "DimSize = 7 9 5", "DimSize = 99999 99999 99999");
    refused(folder.file("a.mha"), {"a.mha"});
    put_bytes(folder.file("a.mha"), whole.substr(0, whole.size() - 2));
    refused(folder.file("a.mha"), {"a.mha", "truncated"});
}

void truncated_series_are_refused(void **)
{
    const Folder folder{"series"};
    const fs::path series = folder.file("s");
    const auto fresh = [&] { write_volume(sample(), series); };
    fresh();
    fs::remove(series / "0003.dcm");
    refused(series, {"truncated", "4 of 5 images"});
    fresh();
    fs::remove(series / "0005.dcm");
    refused(series, {"truncated", "4 of 5 images"});
    fresh();
    fs::resize_file(series / "0002.dcm", fs::file_size(series / "0002.dcm") - 40);
    refused(series, {"0002.dcm", "truncated"});
    fresh();
    fs::resize_file(series / "0002.dcm", 90);
    refused(series, {"0002.dcm", "truncated"});
    fresh();
    fs::copy_file(series / "0002.dcm", series / "copy.dcm");
    refused(series, {"same place", "0002.dcm", "copy.dcm"});
    fresh();
    Volume other = sample();
    other.hu[0] = 7;
    write_volume(other, folder.file("t"));
    fs::rename(folder.file("t") + "/0001.dcm", series / "other.dcm");
    refused(series, {"2 series", "keep one"});
    fs::create_directory(folder.file("empty"));
    refused(folder.file("empty"), {"no DICOM image"});
    refused(folder.file("absent.nrrd"), {"is not there"});
    refused(series / "0001.dcm", {"folder"});
}

// The headers of a series do not show whether a slice is missing, so the program compares the positions of
// the slices.
void missing_and_uneven_slices_are_named(void **)
{
    const std::vector<std::string> names = {"a", "b", "c", "d", "e"};
    const auto places = [](std::vector<double> heights, double sideways = 0) {
        std::vector<Eigen::Vector3d> result;
        for (const double z : heights) result.emplace_back(sideways * z, 0, z);
        return result;
    };
    const auto said = [&](const std::vector<Eigen::Vector3d> &at) -> std::string {
        try {
            order_slices(at, {0, 0, 1}, names, "s");
        } catch (const Fault &fault) {
            return fault.what();
        }
        return "";
    };
    const SliceOrder order = order_slices(places({4, 3, 2, 1, 0}), {0, 0, 1}, names, "s");
    assert_true(order.order == std::vector<std::size_t>({4, 3, 2, 1, 0}) && order.distance_mm == 1);
    assert_true(said(places({0, 1, 2, 5, 6})).find("2 slices are missing between c and d") !=
                std::string::npos);
    assert_true(said(places({0, 1, 2, 3.4, 4.4})).find("uneven slices: c and d are 1.400 mm apart") !=
                std::string::npos);
    assert_true(said(places({0, 1, 2, 2, 3})).find("same place") != std::string::npos);
    assert_true(said(places({0, 1, 2, 3, 4}, 0.3)).find("sideways") != std::string::npos);
}

void other_contents_are_refused(void **)
{
    const Folder folder{"content"};
    Volume volume = sample();
    std::fill(volume.hu.begin(), volume.hu.end(), 5.0f);
    write_volume(volume, folder.file("a.nrrd"));
    refused(folder.file("a.nrrd"), {"is empty", "all voxels are 5"});
    put_bytes(folder.file("a.txt"), "hello");
    refused(folder.file("a.txt"), {"ending is not known", ".nrrd"});
    put_bytes(folder.file("b.nrrd"), "hello");
    refused(folder.file("b.nrrd"), {"b.nrrd", "export it again"});
    write_volume(sample(), folder.file("c.nii"));
    fs::resize_file(folder.file("c.nii"), 352 + 100);
    refused(folder.file("c.nii"), {"c.nii", "truncated"});
    write_volume(sample(), folder.file("d.nrrd"));
    replace_in(folder.file("d.nrrd"), "sizes: 7 9 5", "sizes: 7 9 9");
    refused(folder.file("d.nrrd"), {"d.nrrd"});
}

// RFC 1952 permits further members after the first; gzip itself accepts zeros after the last one.
void what_follows_compressed_values_is_refused_unless_it_is_zeros_or_a_member(void **)
{
    const Folder folder{"after"};
    const fs::path file = folder.file("a.nii.gz");
    write_volume(sample(), file);
    const std::string whole = bytes_of(file),
                      empty_member("\x1f\x8b\x08\0\0\0\0\0\0\x03\x03\0\0\0\0\0\0\0\0\0", 20);
    for (const std::string &rest :
         {std::string(600, '\0'), empty_member, empty_member + std::string(3, '\0')}) {
        put_bytes(file, whole + rest);
        assert_true(most_apart(sample(), read_volume(file)) < 1e-3);
    }
    for (const std::string &rest : {std::string("?\0", 2), std::string("\0??", 3), empty_member + "xy"}) {
        put_bytes(file, whole + rest);
        refused(file, {"a.nii.gz", "damaged", "export it again"});
    }
    put_bytes(file, whole + empty_member.substr(0, 15));
    refused(file, {"a.nii.gz", "truncated"});
}

// Each file is either read, or refused by a Fault; with any other outcome the test fails.
void cut_and_damaged_files_never_crash(void **)
{
    const Folder folder{"fuzz"};
    const unsigned seed = 20260101;
    std::printf("# seed %u\n", seed);
    std::mt19937 random(seed);
    std::size_t refusals = 0, reads = 0;
    write_volume(sample(), folder.file("series"));
    for (const char *name : {"f.nrrd", "f.nii", "f.nii.gz", "f.mha", "series/0003.dcm"}) {
        const bool is_slice = std::string(name).find('/') != std::string::npos;
        const fs::path file = folder.file(name);
        if (!is_slice) write_volume(sample(), file);
        const std::string whole = bytes_of(file);
        for (int trial = 0; trial < 60; ++trial) {
            std::string bytes = whole;
            if (trial % 2 == 0) bytes.resize(random() % whole.size());
            for (unsigned i = random() % 4; i > 0 && trial % 2 == 1; --i)
                bytes[random() % std::min<std::size_t>(bytes.size(), 700)] = static_cast<char>(random());
            put_bytes(file, bytes);
            try {
                read_volume(is_slice ? file.parent_path() : file);
                ++reads;
            } catch (const Fault &) {
                ++refusals;
            }
        }
    }
    std::printf("#- %zu damaged files refused, %zu read\n", refusals, reads);
    assert_true(refusals > 100);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_format_keeps_values_and_places),
        cmocka_unit_test(the_scene_looks_at_the_patient_as_lps_does),
        cmocka_unit_test(mirrored_axes_keep_their_places),
        cmocka_unit_test(impossible_grids_are_refused),
        cmocka_unit_test(a_scale_that_is_none_is_refused),
        cmocka_unit_test(absurd_numbers_of_axes_and_voxels_are_refused),
        cmocka_unit_test(truncated_series_are_refused),
        cmocka_unit_test(missing_and_uneven_slices_are_named),
        cmocka_unit_test(other_contents_are_refused),
        cmocka_unit_test(what_follows_compressed_values_is_refused_unless_it_is_zeros_or_a_member),
        cmocka_unit_test(cut_and_damaged_files_never_crash),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
