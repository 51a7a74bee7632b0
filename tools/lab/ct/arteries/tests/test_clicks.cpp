// Tests the file of clicks and the option --click of `ct patient`.
#include "host/base/tests/folder.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <fstream>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using namespace crn::ct;

namespace
{

const std::string cut_text = "format = 1\n[[click]]\nkind = \"cut\"\nat_mm = [1, 2, 3]\nradius_mm = 5\n";

template <class Work> std::string message_of(const Work &work)
{
    try {
        work();
    } catch (const std::exception &error) {
        return error.what();
    }
    return "";
}

std::string message_of_file(const std::string &text)
{
    const tests::Folder folder("clicks");
    std::ofstream(folder.file("clicks.toml")) << text;
    return message_of([&] { read_clicks(folder.file("clicks.toml")); });
}

void assert_tells(const std::string &message, const char *part)
{
    if (message.find(part) == std::string::npos) fail_msg("'%s' does not name '%s'", message.c_str(), part);
}

} // namespace

static void clicks_are_read_as_they_were_written(void **)
{
    const tests::Folder folder("clicks");
    assert_int_equal(read_clicks(folder.file("clicks.toml")).size(), 0);
    const std::vector<Click> clicks = {click_of("artery:1.5,-20,3"), click_of("cut:0,0,-7.25:4"),
                                       click_of("bridge:1,2,3"), click_of("entry:4,5,6"),
                                       click_of("name:7,8,9:left renal")};
    write_clicks(folder.file("clicks.toml"), clicks);
    const std::vector<Click> read = read_clicks(folder.file("clicks.toml"));
    assert_int_equal(read.size(), clicks.size());
    for (std::size_t i = 0; i < read.size(); ++i) assert_true(read[i].is_same(clicks[i]));
    assert_true(read[1].radius_mm == 4 && read[1].kind == ClickKind::cut && read[1].at_mm.z() == -7.25);
    assert_string_equal(read[4].branch.c_str(), "left renal");
}

static void mistakes_in_the_file_are_named_with_line_and_field(void **)
{
    assert_string_equal(message_of_file(cut_text).c_str(), "");
    assert_tells(message_of_file("format = 1\n[[click]]\nkind = \"vein\"\nat_mm = [1, 2, 3]\n"), ":3:");
    assert_tells(message_of_file("format = 1\n[[click]]\nkind = \"artery\"\nat_mm = [1, 2]\n"), "'at_mm'");
    assert_tells(message_of_file(cut_text + "[[click]]\nkind = \"artery\"\n"), "click 2");
    assert_tells(message_of_file(cut_text + "depth = 5\n"), "'depth'");
    assert_tells(
        message_of_file("format = 1\n[[click]]\nkind = \"entry\"\nat_mm = [1, 2, 3]\nradius_mm = 5\n"),
        "'radius_mm' is only for cuts");
    assert_tells(message_of_file("format = 1\n[[click]]\nkind = \"name\"\nat_mm = [1, 2, 3]\n"), "'branch'");
    std::string many = "format = 1\n";
    for (int i = 0; i < 101; ++i) many += "[[click]]\nkind = \"artery\"\nat_mm = [1, 2, 3]\n";
    assert_tells(message_of_file(many), "more than 100 clicks");
}

static void mistakes_in_the_option_are_named(void **)
{
    for (const auto &[option, part] :
         {std::pair{"vein:1,2,3", "no kind of click"}, std::pair{"artery:1,2", "three numbers"},
          std::pair{"artery:1,2,x", "three numbers"}, std::pair{"artery:1,2,3:4", "more text"},
          std::pair{"cut:1,2,3:0", "0.5 to 50 mm"}, std::pair{"name:1,2,3", "1 to 63 letters"},
          std::pair{"name:1,2,3:a/b", "1 to 63 letters"}})
        assert_tells(message_of([&, option = option] { click_of(option); }), part);
}

static void a_click_outside_the_scan_or_in_air_is_refused_by_name(void **)
{
    Volume scan;
    scan.size = {20, 20, 20};
    scan.hu.assign(scan.count(), 40.0f);
    for (int k = 0; k < 20; ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 12; i < 20; ++i) scan.hu[scan.at(i, j, k)] = -1000.0f;
    const auto refused = [&](const char *option) {
        return message_of([&] { check_clicks({click_of(option)}, scan); });
    };
    assert_string_equal(refused("artery:5,5,-5").c_str(), "");
    assert_tells(refused("artery:5,5,5"), "'at_mm' (5, 5, 5) is outside the scan");
    assert_tells(refused("artery:15,5,-5"), "'at_mm' (15, 5, -5) is in air");
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(clicks_are_read_as_they_were_written),
        cmocka_unit_test(mistakes_in_the_file_are_named_with_line_and_field),
        cmocka_unit_test(mistakes_in_the_option_are_named),
        cmocka_unit_test(a_click_outside_the_scan_or_in_air_is_refused_by_name),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
