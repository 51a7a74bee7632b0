// Tests that a label map alone gives the lumen of its vessels: tubes of known sizes, with names or without.
#include "host/base/tests/folder.hpp"
#include "tools/lab/ct/patient/label_map.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::ct;

namespace
{

constexpr double radius_mm = 4.0, spacing_mm = 0.8, length_mm = 64.0;

// A tube along z, the head's axis of scans; label 5 below its middle and 9 above, and a block of label 2
// beside it.
Volume tube_map()
{
    Volume map;
    map.size = {40, 40, 80};
    map.spacing_mm = Eigen::Vector3d::Constant(spacing_mm);
    map.hu.assign(map.count(), 0);
    for (int k = 0; k < 80; ++k)
        for (int j = 0; j < 40; ++j)
            for (int i = 0; i < 40; ++i) {
                const double off_mm = std::hypot(i - 15.3, j - 19.6) * spacing_mm;
                if (off_mm < radius_mm)
                    map.hu[map.at(i, j, k)] = k < 40 ? 5 : 9;
                else if (i > 30 && k > 20 && k < 60)
                    map.hu[map.at(i, j, k)] = 2;
            }
    return map;
}

std::string refusal(const LabelWish &wish)
{
    patient::Choices choices;
    try {
        read_vessel_labels(wish, choices);
    } catch (const Fault &fault) {
        return fault.what();
    }
    return "";
}

void contains(const std::string &text, const char *words)
{
    if (text.find(words) == text.npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), words);
}

void a_tube_of_labels_has_its_volume(void **)
{
    const crn::tests::Folder folder("labels");
    const std::filesystem::path map = folder.file("map.nrrd"), table = folder.file("names.csv");
    write_volume(tube_map(), map);
    std::ofstream(table) << "id,structure\n2,liver\n5,iliac_artery_left\n9,aorta\n";
    patient::Choices choices;
    const VesselLabels labels = read_vessel_labels({map, table, {}}, choices);
    assert_int_equal(labels.names.size(), 2);
    assert_string_equal(labels.names.at(9).c_str(), "aorta");
    const double got = bake::volume_mm3(surface_of_labels(labels));
    // The ends of the tube are the ends of the map; the surface of labels rounds them off.
    const double wanted = std::numbers::pi * radius_mm * radius_mm * length_mm;
    std::printf("# volume of the labelled tube: %.0f mm3, expected %.0f\n", got, wanted);
    assert_true(std::abs(got / wanted - 1) < 0.06);
}

void a_tube_of_labels_becomes_a_scene(void **)
{
    const crn::tests::Folder folder("labels");
    const std::filesystem::path map = folder.file("map.nrrd");
    write_volume(tube_map(), map);
    patient::SceneWish wish;
    wish.folder = folder.file("scene");
    patient::Choices choices;
    bake::Progress progress;
    make_label_scene({map, "", {5, 9}}, wish, choices, progress);
    assert_true(std::filesystem::file_size(wish.folder / "patient.scene") > 1000);
    contains(choices.text(""), "5 label_5, 9 label_9");
    // The head is +y in the scene, and the entry is at the lower end.
    contains(choices.text(""), "in label_5");
}

void labels_that_are_no_vessels_are_refused(void **)
{
    const crn::tests::Folder folder("labels");
    const std::filesystem::path map = folder.file("map.nrrd"), table = folder.file("names.csv");
    write_volume(tube_map(), map);
    std::ofstream(table) << "id,structure\n2,liver\n5,vein\n9,bone\n";
    contains(refusal({map, table, {}}), "--label; it has 2, 5, 9");
    contains(refusal({map, "", {7}}), "no voxel of label 7: it has 2, 5, 9");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_tube_of_labels_has_its_volume),
                                cmocka_unit_test(a_tube_of_labels_becomes_a_scene),
                                cmocka_unit_test(labels_that_are_no_vessels_are_refused)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
