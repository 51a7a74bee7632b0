// These tests check the rules of the pipeline that docs/budget.md states, each by a sequence whose number of
// cycles follows from the rule: pairs, latencies, and what an instruction consumes early or late. The rules
// are those that others measured on chips of this kind, so the expected numbers are theirs.
#include "tools/chip/instruction.hpp"
#include "tools/chip/pipeline.hpp"
#include <csetjmp>
#include <cstdarg>
#include <string>
#include <vector>

extern "C" {
#include <cmocka.h>
}

namespace
{

using chip::decode;

std::int64_t cycles(const std::vector<std::string> &lines)
{
    std::vector<chip::Instruction> code;
    for (const std::string &line : lines) {
        const std::size_t space = line.find(' ');
        code.push_back(
            decode(0, 4, line.substr(0, space), space < line.size() ? line.substr(space + 1) : ""));
    }
    return chip::cycles_of(code);
}

std::vector<std::string> repeated(const std::vector<std::string> &lines, int times)
{
    std::vector<std::string> all;
    for (int i = 0; i < times; i++) all.insert(all.end(), lines.begin(), lines.end());
    return all;
}

void independent_sums_issue_in_pairs(void **)
{
    assert_int_equal(cycles(repeated({"add.w r0, r4, r5", "add.w r1, r4, r5"}, 10)), 10);
}

void sums_with_a_shifter_issue_alone(void **)
{
    assert_int_equal(cycles(repeated({"add.w r0, r4, r5, lsl #2", "add.w r1, r4, r5, lsl #2"}, 10)), 20);
    assert_int_equal(cycles(repeated({"add.w r0, r4, r5, lsl #2", "add.w r1, r4, r5"}, 10)), 10);
}

void a_product_delays_its_use_by_a_cycle(void **)
{
    assert_int_equal(cycles({"mul.w r0, r4, r5", "add.w r1, r0, r5"}), 3);
    assert_int_equal(cycles({"mul.w r0, r4, r5", "add.w r1, r4, r5"}), 1);
}

void products_issue_one_a_cycle_and_accumulate_without_waiting(void **)
{
    assert_int_equal(cycles(repeated({"smull r0, r1, r4, r5"}, 10)), 10);
    assert_int_equal(cycles(repeated({"smlal r0, r1, r4, r5"}, 10)), 10);
    assert_int_equal(cycles(repeated({"mla r0, r4, r5, r0"}, 10)), 10);
}

void a_loaded_word_serves_a_sum_in_the_next_cycle(void **)
{
    assert_int_equal(cycles({"ldr r0, [r4, #0]", "add.w r1, r0, r5"}), 2);
    assert_int_equal(cycles({"ldrsb.w r0, [r4, #0]", "add.w r1, r0, r5"}), 3); // a byte comes a cycle later
    assert_int_equal(cycles({"ldr r0, [r4, #0]", "mul.w r1, r0, r5"}), 3);     // products wait, too
    assert_int_equal(cycles({"ldr r0, [r4, #0]", "ldr r1, [r0, #0]"}), 3);     // addresses are needed early
}

void loads_pair_where_they_meet_both_banks(void **)
{
    assert_int_equal(cycles(repeated({"ldr r0, [r4, #0]", "ldr r1, [r4, #4]"}, 10)), 10);
    assert_int_equal(cycles(repeated({"ldr r0, [r4, #0]", "ldr r1, [r4, #8]"}, 10)), 20);
    assert_int_equal(cycles(repeated({"ldr r0, [r4, #0]", "ldr r1, [r5, #4]"}, 10)), 20); // not known
}

void stores_issue_one_a_cycle_beside_other_work(void **)
{
    assert_int_equal(cycles(repeated({"str r0, [r4, #0]", "str r1, [r4, #4]"}, 10)), 20);
    assert_int_equal(cycles(repeated({"str r0, [r4, #0]", "add.w r1, r5, r6"}, 10)), 10);
}

void several_registers_take_a_cycle_for_two(void **)
{
    assert_int_equal(cycles({"ldmia.w r4, {r0, r1, r2, r3, r5}"}), 3);
    assert_int_equal(cycles({"push {r4, r5, r6, lr}"}), 2);
}

void bit_fields_issue_as_the_older_of_a_pair(void **)
{
    assert_int_equal(cycles(repeated({"ubfx r0, r4, #2, #3", "add.w r1, r4, r5"}, 10)), 10);
    assert_int_equal(cycles(repeated({"qadd r0, r4, r5", "qadd r1, r4, r5"}, 10)), 20);
}

void mnemonics_lose_flags_and_conditions(void **)
{
    using chip::flags_bit;
    assert_true(decode(0, 2, "bls.n", "120").flow == chip::Flow::conditional);
    assert_true(decode(0, 4, "bl", "120").flow == chip::Flow::direct);
    assert_true(decode(0, 2, "movls", "r0, #1").late == (flags_bit | 1u));
    assert_true((decode(0, 2, "bics", "r0, r1").defines & flags_bit) != 0);
    assert_true(decode(0, 4, "mls", "r0, r1, r2, r3").accumulate == 1u << 3);
    assert_true(decode(0, 4, "ldmia.w", "sp!, {r4, r5, pc}").flow == chip::Flow::indirect);
    assert_true(decode(0, 2, "bx", "lr").flow == chip::Flow::indirect);
    assert_true(decode(0, 4, "ldr.w", "r0, [r1, r2, lsl #2]").early == 6u);
}

void an_unknown_mnemonic_is_refused_by_name(void **)
{
    std::string text;
    try {
        decode(0, 4, "vadd.f32", "s0, s1, s2");
    } catch (const chip::PriceError &error) {
        text = error.what();
    }
    assert_true(text.find("vadd.f32 s0, s1, s2") != std::string::npos);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(independent_sums_issue_in_pairs),
        cmocka_unit_test(sums_with_a_shifter_issue_alone),
        cmocka_unit_test(a_product_delays_its_use_by_a_cycle),
        cmocka_unit_test(products_issue_one_a_cycle_and_accumulate_without_waiting),
        cmocka_unit_test(a_loaded_word_serves_a_sum_in_the_next_cycle),
        cmocka_unit_test(loads_pair_where_they_meet_both_banks),
        cmocka_unit_test(stores_issue_one_a_cycle_beside_other_work),
        cmocka_unit_test(several_registers_take_a_cycle_for_two),
        cmocka_unit_test(bit_fields_issue_as_the_older_of_a_pair),
        cmocka_unit_test(mnemonics_lose_flags_and_conditions),
        cmocka_unit_test(an_unknown_mnemonic_is_refused_by_name),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
