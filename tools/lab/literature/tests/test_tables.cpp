// These tests check that an incomplete published table is refused, that figures are judged by the published
// spread, and that a table that gets worse is noticed.
#include "tools/lab/literature/pages.hpp"
#include "tools/lab/literature/verdict.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn::literature;
namespace fs = std::filesystem;

namespace
{

const std::string head =
    "title = \"t\"\nsource = \"s\"\nidentifier = \"i\"\nexperiment = \"e\"\nsimulation = \"s\"\n"
    "spread = \"s\"\ncomment = \"c\"\n";
const std::string judged = "kind = \"validation\"\n[[row]]\nname = \"a\"\nwhat = \"a\"\nunit = \"1\"\n";

fs::path folder()
{
    const fs::path path = fs::temp_directory_path() / ("cournand_literature_" + std::to_string(getpid()));
    fs::remove_all(path);
    fs::create_directories(path);
    return path;
}

std::vector<Table> read(const std::string &text)
{
    const fs::path path = folder();
    std::ofstream(path / "one.toml") << text;
    return read_tables(path.string());
}

void refused(const std::string &text, const char *why)
{
    try {
        read(text);
    } catch (const std::exception &error) {
        if (!std::strstr(error.what(), why)) fail_msg("'%s' does not say '%s'", error.what(), why);
        return;
    }
    fail_msg("not refused: %s", why);
}

void an_incomplete_table_is_refused(void **)
{
    assert_int_equal(read(head + judged + "mean = 1\ndeviation = 0.1\n").size(), 1);
    for (const char *key :
         {"title", "source", "identifier", "experiment", "simulation", "spread", "comment"}) {
        std::string text = head + judged + "mean = 1\ndeviation = 0.1\n";
        const std::size_t begin = text.find(key);
        refused(text.erase(begin, text.find('\n', begin) + 1 - begin), key);
    }
    refused(head + judged + "mean = 1\n", "without a published spread");
    refused(head + judged, "no published figure");
    refused(head + judged + "mean = 1\nlow = 0\n", "either");
    refused(head + judged + "low = 2\nhigh = 1\n", "below");
    refused(head + judged + "mean = 1\ndeviation = -1\n", "above 0");
    refused(head + "kind = \"validation\"\n", "at least one figure");
    refused(head + judged + "low = 1\nwidth = 2\n", "width");
    refused(head + judged + "low = 1\n[[row]]\nname = \"a\"\nwhat = \"b\"\nunit = \"1\"\nlow = 1\n", "twice");
    refused("kind = \"x\"\n" + head, "kind");
}

// Within two standard deviations of the mean, or within the range; a fitted row never counts.
void figures_are_judged_by_the_published_spread(void **)
{
    const std::vector<Table> tables =
        read(head + judged +
             "mean = 10\ndeviation = 2\n[[row]]\nname = \"b\"\nwhat = \"b\"\nunit = \"1\"\nhigh = 5\n" +
             "[[row]]\nname = \"c\"\nwhat = \"c\"\nunit = \"1\"\nmean = 1\nfitted = true\n");
    Measured one;
    one.table = &tables[0];
    const auto verdict = [&](double a, double b, double c) {
        one.figures.values = {{"a", a}, {"b", b}, {"c", c}};
        return one.verdict();
    };
    assert_string_equal(verdict(14, 5, 99).c_str(), "pass");
    assert_string_equal(verdict(6, -1e9, 99).c_str(), "pass");
    assert_string_equal(verdict(14.01, 5, 99).c_str(), "fail");
    assert_string_equal(verdict(10, 5.01, 1).c_str(), "fail");
    assert_string_equal(verdict(NAN, 0, 1).c_str(), "fail");
    assert_string_equal(distance_text(tables[0].rows[0], 7).c_str(), "-1.5 SD");
    assert_string_equal(distance_text(tables[0].rows[1], 4).c_str(), "inside");
    assert_string_equal(distance_text(tables[0].rows[1], 6).c_str(), "+20 % beyond");
    one.failure = "it broke";
    assert_string_equal(one.verdict().c_str(), "stopped");
}

void every_row_needs_its_figure(void **)
{
    const std::vector<Table> tables = read(head + judged + "high = 5\n");
    const auto complaint = [&](const Figures &figures) -> std::string {
        try {
            check_complete(tables[0], figures);
        } catch (const std::exception &error) {
            return error.what();
        }
        return "";
    };
    assert_string_equal(complaint({{{"a", 1}}, {}}).c_str(), "");
    assert_non_null(std::strstr(complaint({}).c_str(), "no figure 'a'"));
    assert_non_null(std::strstr(complaint({{{"a", INFINITY}}, {}}).c_str(), "finite"));
    assert_non_null(std::strstr(complaint({{{"a", 1}, {"b", 1}}, {}}).c_str(), "no row"));
}

void a_table_that_gets_worse_is_noticed(void **)
{
    const std::vector<Table> tables = read(head + judged + "high = 5\n");
    Measured one;
    one.table = &tables[0];
    const auto compared = [&](double value, const Expectations &expected, bool is_whole = true) {
        one.figures.values = {{"a", value}};
        return compare({one}, expected, is_whole);
    };
    assert_int_equal(compared(6, {{"one", "pass"}}).worse.size(), 1);
    assert_int_equal(compared(6, {{"one", "fail"}}).worse.size(), 0);
    assert_int_equal(compared(4, {{"one", "fail"}}).better.size(), 1);
    assert_int_equal(compared(4, {}).unknown.size(), 1);
    assert_int_equal(compared(4, {{"one", "pass"}, {"two", "pass"}}).gone.size(), 1);
    assert_int_equal(compared(4, {{"one", "pass"}, {"two", "pass"}}, false).gone.size(), 0);
}

void the_list_of_verdicts_is_read_as_written(void **)
{
    const fs::path path = folder() / "expected.tsv";
    const Expectations all{{"one", "pass"}, {"two", "fail"}};
    std::ofstream(path) << expectations_text(all);
    assert_true(read_expectations(path.string()) == all);
    for (const char *line : {"one\tmaybe\n", "one\n", "one\tpass\tx\n", "one\tpass\none\tfail\n"}) {
        std::ofstream(path) << line;
        bool is_refused = false;
        try {
            read_expectations(path.string());
        } catch (const std::exception &error) {
            is_refused = std::strstr(error.what(), "expected.tsv:") != nullptr;
        }
        assert_true(is_refused);
    }
}

// A figure beyond the picture is an arrow at its edge, and text is escaped.
void a_picture_shows_every_figure(void **)
{
    const std::vector<Table> tables =
        read(head + judged +
             "mean = 10\ndeviation = 2\n[[row]]\nname = \"b\"\nwhat = \"b < c\"\nunit = \"1\"\nhigh = 5\n");
    Measured one;
    one.table = &tables[0];
    one.figures.values = {{"a", 10}, {"b", 500}};
    const std::string svg = picture(one);
    assert_non_null(std::strstr(svg.c_str(), "<circle"));
    assert_non_null(std::strstr(svg.c_str(), "▶"));
    assert_non_null(std::strstr(svg.c_str(), "b &lt; c"));
    assert_null(std::strstr(svg.c_str(), "nan"));
}

int remove_folder(void **)
{
    fs::remove_all(folder());
    return 0;
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(an_incomplete_table_is_refused),
        cmocka_unit_test(figures_are_judged_by_the_published_spread),
        cmocka_unit_test(every_row_needs_its_figure),
        cmocka_unit_test(a_table_that_gets_worse_is_noticed),
        cmocka_unit_test(the_list_of_verdicts_is_read_as_written),
        cmocka_unit_test(a_picture_shows_every_figure),
    };
    return cmocka_run_group_tests(tests, nullptr, remove_folder);
}
