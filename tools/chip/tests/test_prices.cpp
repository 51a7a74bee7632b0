// These tests check the cache, the branch prediction and the figures of the priced ticks by sequences whose
// result follows from their rules, and that a search's drive depends on its seed alone.
#include "tools/chip/branches.hpp"
#include "tools/chip/cache.hpp"
#include "tools/chip/drive.hpp"
#include "tools/chip/figures.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstring>

extern "C" {
#include <cmocka.h>
}

namespace
{

constexpr std::uint32_t set_stride = 256 * chip::line_bytes; // 32 kB with four ways: 256 sets

int misses(chip::Cache &cache, std::initializer_list<std::uint32_t> addresses)
{
    int count = 0;
    for (const std::uint32_t address : addresses) count += cache.access(address, false).is_missing;
    return count;
}

void a_line_is_missed_once(void **)
{
    chip::Cache cache(chip::cache_bytes);
    assert_int_equal(misses(cache, {0, 4, 31, 32, 0, 63}), 2);
}

void a_set_keeps_the_four_lines_used_last(void **)
{
    chip::Cache cache(chip::cache_bytes);
    const auto line = [](std::uint32_t number) { return number * set_stride; };
    assert_int_equal(misses(cache, {line(0), line(1), line(2), line(3)}), 4);
    assert_int_equal(misses(cache, {line(0)}), 0);
    assert_int_equal(misses(cache, {line(4)}), 1); // in place of line 1
    assert_int_equal(misses(cache, {line(0), line(2), line(3)}), 0);
    assert_int_equal(misses(cache, {line(1)}), 1);
}

void a_scene_larger_than_the_cache_is_missed_whole(void **)
{
    chip::Cache cache(chip::cache_bytes);
    int count = 0;
    for (int round = 0; round < 2; round++)
        for (std::uint32_t address = 0; address < 2 * chip::cache_bytes; address += chip::line_bytes)
            count += cache.access(address, false).is_missing;
    assert_int_equal(count, 2 * 2 * 1024);
}

void a_changed_line_is_written_back_when_it_leaves(void **)
{
    chip::Cache cache(chip::cache_bytes);
    const std::uint32_t changed = 3 * set_stride + 8;
    cache.access(changed, true);
    for (std::uint32_t line = 4; line < 7; line++)
        assert_int_equal(cache.access(line * set_stride, false).written_back, 0);
    assert_int_equal(cache.access(7 * set_stride, false).written_back, 3 * set_stride);
    assert_int_equal(cache.access(8 * set_stride, false).written_back, 0);
}

void numbers_are_counted_once_a_tick(void **)
{
    chip::Distinct distinct(10);
    distinct.begin();
    for (const std::size_t number : {3, 4, 3, 9}) distinct.take(number);
    assert_int_equal(distinct.count(), 3);
    distinct.begin();
    distinct.take(3);
    assert_int_equal(distinct.count(), 1);
}

// A loop's branch backwards: the decoder recognises it once, the table knows it from then on, and only the
// last pass is a surprise.
void a_loop_surprises_at_its_end(void **)
{
    chip::BranchPredictor predictor;
    std::uint32_t cycles = 0;
    for (int pass = 0; pass < 10; pass++)
        cycles += predictor.cycles({100, 50, pass < 9, chip::Flow::conditional, false});
    assert_int_equal(cycles, chip::BranchPredictor::decode_cycles + chip::BranchPredictor::late_cycles);
}

void flags_that_are_known_early_make_a_surprise_cheaper(void **)
{
    chip::BranchPredictor predictor;
    assert_int_equal(predictor.cycles({100, 150, true, chip::Flow::conditional, true}),
                     chip::BranchPredictor::early_cycles);
}

void a_return_to_another_place_is_a_surprise(void **)
{
    chip::BranchPredictor predictor;
    predictor.cycles({100, 50, true, chip::Flow::indirect, false});
    assert_int_equal(predictor.cycles({100, 50, true, chip::Flow::indirect, false}), 0);
    assert_int_equal(predictor.cycles({100, 60, true, chip::Flow::indirect, false}),
                     chip::BranchPredictor::late_cycles);
}

void a_miss_takes_84_clocks_of_the_psram(void **)
{
    chip::TickPrice price;
    price.core_cycles = 1000;
    price.misses = 10;
    price.near_misses = 5; // 11 clocks of 150 MHz each
    assert_float_equal(price.cycles(chip::boards[0]), 1000 + 10 * 84 * 600 / 79.2 + 5 * 44, 1e-6);
}

void percentiles_are_nearest_ranks(void **)
{
    std::vector<double> values;
    for (int i = 1000; i > 0; i--) values.push_back(i);
    assert_float_equal(chip::percentile(values, 0.999), 999, 0);
    assert_float_equal(chip::percentile({5}, 0.999), 5, 0);
}

void a_drive_depends_on_its_seed_alone(void **)
{
    chip::Drive first(3, 2, true), again(3, 2, true), other(4, 2, true);
    bool differs = false;
    for (int tick = 0; tick < 8000; tick++) {
        const crn_wire_tick_input one = first.next(), two = again.next(), three = other.next();
        assert_memory_equal(&one, &two, sizeof one);
        differs = differs || one.hands[1].translation_counts != three.hands[1].translation_counts;
    }
    assert_true(differs);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_line_is_missed_once),
        cmocka_unit_test(a_set_keeps_the_four_lines_used_last),
        cmocka_unit_test(a_scene_larger_than_the_cache_is_missed_whole),
        cmocka_unit_test(a_changed_line_is_written_back_when_it_leaves),
        cmocka_unit_test(numbers_are_counted_once_a_tick),
        cmocka_unit_test(a_loop_surprises_at_its_end),
        cmocka_unit_test(flags_that_are_known_early_make_a_surprise_cheaper),
        cmocka_unit_test(a_return_to_another_place_is_a_surprise),
        cmocka_unit_test(a_miss_takes_84_clocks_of_the_psram),
        cmocka_unit_test(percentiles_are_nearest_ranks),
        cmocka_unit_test(a_drive_depends_on_its_seed_alone),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
