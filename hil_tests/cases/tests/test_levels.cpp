// This test runs every test case of hil_tests/cases at the test levels 0 and 1.
#include "firmware/tests/reference/long_run.h"
#include "hil_tests/cases/cases.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include "hil_tests/l1/emulated_bench.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <set>
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

// Sanitizers see the host and the device at level 0, but not inside the image that the emulated processor
// runs. With sanitizers, level 1 therefore runs only the cases that together use everything that the host
// does with an emulated device: steps, requests, inputs, frames on the wire, a halt and a restart. All other
// cases run with sanitizers at level 0, and without sanitizers at both levels.
const std::set<std::string> &sanitized_on_image()
{
    static const std::set<std::string> names = {
        "lockstep_gives_the_hash_of_the_host_alone",
        "every_question_is_answered",
        "a_free_run_closes_the_loop_as_at_level_0",
        "pedals_syringe_and_inflator_reach_the_host",
        "random_exchanges_give_the_hash_of_the_host_alone",
        "a_frozen_processor_loses_power_in_5_ms_and_latches_a_fault",
        "a_brown_out_is_safe_and_a_new_session_starts_clean",
        "a_cable_pulled_in_mid_transfer_costs_no_bit",
        "no_contact_situation_has_a_limit_cycle",
    };
    return names;
}

bool repeats_level_0(const hil::Case &one)
{
    return REFERENCE_RUN(10) != 10 && !sanitized_on_image().contains(one.name);
}

void the_cases_that_are_named_here_exist(void **)
{
    std::size_t found = 0;
    for (const hil::Case &one : hil::all_cases()) found += sanitized_on_image().count(one.name);
    assert_int_equal(found, sanitized_on_image().size());
}

} // namespace

int main()
{
    hil::SimLevel l0;
    hil::EmulatedLevel l1;
    std::vector<Job> jobs;
    for (hil::Level *level : {static_cast<hil::Level *>(&l0), static_cast<hil::Level *>(&l1)}) {
        for (const hil::Case &one : hil::all_cases()) {
            if (level == &l1 && repeats_level_0(one)) continue;
            jobs.push_back(
                {level, &one, std::string(level->name()) + " " + one.name, spread_of(one, level == &l1)});
        }
    }
    std::vector<CMUnitTest> tests = {cmocka_unit_test(the_cases_that_are_named_here_exist)};
    for (Job &job : jobs) tests.push_back({job.name.c_str(), run, nullptr, nullptr, &job});
    return _cmocka_run_group_tests("levels", tests.data(), tests.size(), nullptr, nullptr);
}
