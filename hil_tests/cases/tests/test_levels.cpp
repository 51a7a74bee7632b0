// This test runs every test case of hil_tests/cases at the test levels 0 and 1.
#include "firmware/tests/reference/long_run.h"
#include "hil_tests/cases/cases.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

extern "C" {
#include <cmocka.h>
}

namespace
{

struct Job {
    hil::Level *level;
    const hil::Case *what;
    std::string name;
    std::uint32_t spread = 1;
};

void run(void **state)
{
    const Job &job = *static_cast<const Job *>(*state);
    std::string why;
    try {
        hil::Report report;
        hil::CaseOptions options;
        options.spread = job.spread;
        job.what->run(*job.level, options, report);
        std::printf("# %s: %s\n", job.name.c_str(), report.text.c_str());
    } catch (const std::exception &error) {
        why = error.what();
    }
    if (!why.empty())
        fail_msg("%s; again: build/bin/hil --level %s --case %s", why.c_str(), job.level->name(),
                 job.what->name);
}

// On the emulated device of level 1, ten trials of the haptic loop take a minute, and the test case with
// every fault of the rig takes half a minute. With sanitizers, the trials at level 0 take as long as the
// trials at level 1 without sanitizers. This test therefore runs only a part of the trials and faults, and
// `make hil` runs all of them.
std::uint32_t spread_of(const hil::Case &one, bool is_image)
{
    const bool is_short = REFERENCE_RUN(5) != 5;
    if (std::string(one.name) == "no_contact_situation_has_a_limit_cycle")
        return is_image || is_short ? 10 : 1;
    const bool is_long = std::string(one.name) == "a_cable_pulled_in_mid_transfer_costs_no_bit" ||
                         std::string(one.name) == "every_fault_of_the_rig_is_safe_in_5_ms_and_latched";
    return is_image && (is_short || is_long) ? 4 : 1;
}

} // namespace

int main()
{
    hil::SimLevel l0;
    hil::EmulatedLevel l1;
    std::vector<Job> jobs;
    for (hil::Level *level : {static_cast<hil::Level *>(&l0), static_cast<hil::Level *>(&l1)}) {
        for (const hil::Case &one : hil::all_cases())
            jobs.push_back(
                {level, &one, std::string(level->name()) + " " + one.name, spread_of(one, level == &l1)});
    }
    std::vector<CMUnitTest> tests;
    for (Job &job : jobs) tests.push_back({job.name.c_str(), run, nullptr, nullptr, &job});
    return _cmocka_run_group_tests("levels", tests.data(), tests.size(), nullptr, nullptr);
}
