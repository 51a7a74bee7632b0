// This test injects some faults of every kind (make hil injects all faults), and checks the code of the fault
// campaign itself.
#include "hil_tests/campaign/table.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <set>
#include <stdexcept>

extern "C" {
#include <cmocka.h>
}

namespace
{

void a_spread_of_faults_does_no_harm(void **)
{
    hil::SimLevel level;
    const hil::Undisturbed undisturbed = hil::run_undisturbed(level);
    hil::CampaignTable table;
    for (const hil::Fault &fault : hil::spread_of(hil::all_faults(), 208))
        table.add(fault, hil::run_fault(level, fault, undisturbed));
    table.print();
    assert_int_equal(table.failures(), 0);
    assert_true(table.count() >= 200);
}

void two_thousand_faults_have_lines_of_their_own_that_name_them(void **)
{
    std::set<std::string> lines;
    for (const hil::Fault &fault : hil::all_faults()) {
        const std::string line = hil::line_of(fault);
        assert_true(lines.insert(line).second);
        assert_string_equal(hil::line_of(hil::fault_of(line)).c_str(), line.c_str());
    }
    assert_true(lines.size() >= 2000);
}

void a_line_that_names_no_fault_is_refused_with_the_word(void **)
{
    for (const char *line :
         {"", "link.flop", "link.flip bit", "link.flip bit=x", "link.flip tick=1", "link.drop way=up",
          "rig.encoder_jump session=lockstep", "link.drop session=none", "link.drop frame=4294967296"}) {
        bool is_refused = false;
        try {
            hil::fault_of(line);
        } catch (const std::invalid_argument &error) {
            is_refused = *error.what() != '\0';
        }
        assert_true(is_refused);
    }
}

// The device receives half a frame from a host that then crashes, and afterwards the HELLO message of the
// next host.
void a_host_that_died_within_a_frame_does_not_keep_the_next_one_out(void **)
{
    hil::SimBench bench(hil::campaign_plant());
    const std::uint8_t half[] = {9, 1, 2, 3};
    bench.pipe().write(half);
    crn::Link link(bench.pipe());
    assert_true(link.hello().accepted);
}

// The host library sends messages on its own while the program that uses it waits.
void a_host_that_waits_is_not_silent(void **)
{
    hil::SimBench bench(hil::campaign_plant());
    crn::Link link(bench.pipe());
    hil::campaign_set_up(link);
    hil::start_free_run(bench, link);
    assert_int_equal(link.free_run(500).size(), 496); // batches of 16
    assert_int_equal(link.read_status().state, CRN_WIRE_STATE_RUNNING);
    const crn_wire_fault_log log = link.read_fault_log();
    for (std::uint16_t i = 0; i < log.entries_count; i++)
        assert_int_not_equal(log.entries[i].code, CRN_FAULT_CODE_HOST_SILENT);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_spread_of_faults_does_no_harm),
        cmocka_unit_test(two_thousand_faults_have_lines_of_their_own_that_name_them),
        cmocka_unit_test(a_line_that_names_no_fault_is_refused_with_the_word),
        cmocka_unit_test(a_host_that_died_within_a_frame_does_not_keep_the_next_one_out),
        cmocka_unit_test(a_host_that_waits_is_not_silent),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
