// Tests which command of the program `ct` carries out `cournand patient`.
#include "host/command/cli_patient.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

std::string joined(const PatientCommandOptions &options, bool is_review, bool has_display)
{
    std::string text;
    for (const std::string &word : patient_words("/bin/ct", options, is_review, has_display))
        text += (text.empty() ? "" : " ") + word;
    return text;
}

PatientCommandOptions own_scan()
{
    PatientCommandOptions options;
    options.scan = "scan.nii";
    options.folder = "mine";
    return options;
}

} // namespace

static void a_new_patient_has_a_window_only_with_a_display(void **)
{
    PatientCommandOptions options = own_scan();
    assert_string_equal(joined(options, false, true).c_str(), "/bin/ct patient scan.nii -o mine --window");
    assert_string_equal(joined(options, false, false).c_str(), "/bin/ct patient scan.nii -o mine");
    options.shows_window = false;
    assert_string_equal(joined(options, false, true).c_str(), "/bin/ct patient scan.nii -o mine");
}

static void the_label_map_and_all_clicks_are_passed_on(void **)
{
    PatientCommandOptions options = own_scan();
    options.labels = "map.nrrd";
    options.names = "names.csv";
    options.clicks = {"artery:1,2,3", "cut:4,5,6"};
    assert_string_equal(joined(options, false, false).c_str(),
                        "/bin/ct patient scan.nii -o mine --labels map.nrrd --names names.csv "
                        "--click artery:1,2,3 --click cut:4,5,6");
}

static void a_review_begins_with_the_folders_own_copy_of_the_scan(void **)
{
    assert_string_equal(joined(own_scan(), true, true).c_str(),
                        "/bin/ct patient mine/scan.ct -o mine --window --look");
}

static void meshes_and_their_choices_go_to_centreline(void **)
{
    PatientCommandOptions options;
    options.folder = "mine";
    options.meshes = {"a.stl", "b.stl"};
    options.choices = {{"--entry", {"1", "-2", "3"}},
                       {"--part", {"x", "y*"}},
                       {"--no-bodies", {}},
                       {"--branches", {"numbers"}}};
    std::string text;
    for (const std::string &word : patient_words("/bin/centreline", options, false, true)) text += word + " ";
    assert_string_equal(text.c_str(),
                        "/bin/centreline patient a.stl b.stl -o mine --entry 1 -2 3 --part x --part y* "
                        "--no-bodies --branches numbers ");
}

static void a_label_map_without_a_scan_goes_to_ct_labels(void **)
{
    PatientCommandOptions options;
    options.folder = "mine";
    options.labels = "map.nii.gz";
    options.names = "names.csv";
    assert_string_equal(joined(options, false, true).c_str(),
                        "/bin/ct labels map.nii.gz --table names.csv -o mine");
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(meshes_and_their_choices_go_to_centreline),
        cmocka_unit_test(a_label_map_without_a_scan_goes_to_ct_labels),
        cmocka_unit_test(a_new_patient_has_a_window_only_with_a_display),
        cmocka_unit_test(the_label_map_and_all_clicks_are_passed_on),
        cmocka_unit_test(a_review_begins_with_the_folders_own_copy_of_the_scan),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
