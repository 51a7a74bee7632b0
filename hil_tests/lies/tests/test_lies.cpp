// These tests check commands that talk to a device which sends false messages. Whatever the device sends, the
// command must end within 10 s with exit code 0 or 1 and a message that names the problem. After Ctrl-C the
// command must end within 1 s, and its recording must contain only what this machine's core computes. This
// test runs an evenly spread selection of the lies; `make hil-lies` runs all of them.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/tests/reference/long_run.h"
#include "hil_tests/lies/judge.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

constexpr unsigned jobs = 8;

std::string line_of(const hil::LieCase &one)
{
    return std::string(one.command->name) + ": " + hil::line_of(one.lie);
}

void expect_good(const std::vector<hil::LieCase> &cases, unsigned ticks)
{
    const std::vector<hil::Verdict> verdicts = hil::judge(cases, jobs, ticks, {});
    double slowest_s = 0.0;
    std::string failed;
    for (std::size_t i = 0; i < cases.size(); i++) {
        slowest_s = std::max(slowest_s, verdicts[i].seconds);
        if (!verdicts[i].failure.empty())
            failed +=
                "\n" + line_of(cases[i]) + ": " + verdicts[i].failure + " (" + verdicts[i].message + ")";
    }
    std::printf("# %zu lies, the slowest end after %.2f s\n", cases.size(), slowest_s);
    if (!failed.empty()) fail_msg("%s", failed.c_str());
}

std::vector<hil::LieCase> told_to(const std::string &command, const std::vector<std::string> &lies)
{
    std::vector<hil::LieCase> cases;
    for (const hil::LiedTo &one : hil::lied_to())
        for (const std::string &line : lies)
            if (command == one.name) cases.push_back({&one, hil::lie_of_line(line)});
    assert_int_equal(cases.size(), lies.size());
    return cases;
}

void a_device_that_never_frames_holds_no_command(void **)
{
    std::vector<hil::LieCase> cases;
    for (const hil::LiedTo &command : hil::lied_to()) {
        if (command.is_by_hid) continue;
        for (const char *line : {"stream.zeros at=1 value=0", "stream.garbage at=1 value=0",
                                 "stream.ones at=2 value=0", "stream.drip_zeros at=1 value=0"})
            cases.push_back({&command, hil::lie_of_line(line)});
    }
    expect_good(cases, 600);
}

// In an earlier version, the lies of this test led to exit code 0 and a false recording, because no second
// device checked the results.
void no_falsehood_is_recorded(void **)
{
    const std::vector<std::string> lies = {"ticks.lane0 at=3 value=0",
                                           "hash.value at=2 value=0",
                                           "hash.tick at=1 value=50",
                                           "hash.tick at=1 value=4294967295",
                                           "final_hash.value at=1 value=0",
                                           "final_hash.tick at=1 value=1",
                                           "hello.core at=1 value=1",
                                           "hello.schema at=1 value=0",
                                           "set_up.scene_is_there at=1 value=0",
                                           "ticks.forces at=3 value=2147483647"};
    std::vector<hil::LieCase> cases = told_to("run --record", lies);
    for (const hil::LieCase &one :
         told_to("run --free-run", {"live.lane0 at=3 value=0", "live.input at=3 value=1",
                                    "final_hash.value at=1 value=0", "hello.core at=1 value=1"}))
        cases.push_back(one);
    const std::vector<hil::Verdict> verdicts = hil::judge(cases, jobs, 600, {});
    for (std::size_t i = 0; i < cases.size(); i++) {
        if (!verdicts[i].failure.empty())
            fail_msg("%s: %s", line_of(cases[i]).c_str(), verdicts[i].failure.c_str());
        // The command's message must show that the lie was detected, and must name the false value.
        if (verdicts[i].code != 1) fail_msg("%s: exit code %d", line_of(cases[i]).c_str(), verdicts[i].code);
    }
}

void a_false_snapshot_is_not_recorded(void **)
{
    expect_good(told_to("run --record", {"snapshot.core at=1 value=1000", "snapshot.head at=1 value=24"}),
                5200);
}

void a_spread_of_lies_ends_well(void **)
{
    expect_good(hil::cases_of(REFERENCE_RUN(100) / 10), 600);
}

void a_lie_is_named_by_its_line(void **)
{
    for (const auto &lies : {hil::stream_lies(), hil::hid_lies()})
        for (const hil::Lie &lie : lies) {
            const hil::Lie again = hil::lie_of_line(hil::line_of(lie));
            assert_true(again.name == lie.name && again.at == lie.at && again.value == lie.value);
        }
    assert_true(hil::stream_lies().size() >= 200);
    for (const char *line : {"", "stream.nothing at=1", "stream.zeros at=x", "stream.zeros to=1"}) {
        try {
            hil::lie_of_line(line);
        } catch (const std::invalid_argument &) {
            continue;
        }
        fail_msg("'%s' was taken", line);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_lie_is_named_by_its_line),
        cmocka_unit_test(a_device_that_never_frames_holds_no_command),
        cmocka_unit_test(no_falsehood_is_recorded),
        cmocka_unit_test(a_false_snapshot_is_not_recorded),
        cmocka_unit_test(a_spread_of_lies_ends_well),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
