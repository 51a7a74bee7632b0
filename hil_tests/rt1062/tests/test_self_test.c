/* Claim: the self-test at boot finds a bad word of memory and any changed bit of the image, says so on the
 * console, and gives the power stage no power; the watchdog then resets the chip. Bits are flipped in the
 * model of the chip, in the flash before the start and in the memories while they are tested. */
#define _POSIX_C_SOURCE 200809L
#include "hil_tests/rt1062/tests/image_room.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { BOOT_ms = 200, STEP_us = 1000 };

static rt_chip *chip;
static rt_engine *engine;

static int open_board(void **state)
{
    (void)state;
    if (!begin_image(&chip, &engine)) return 1;
    rt_usb_plug(chip, true);
    return 0;
}

static int close_board(void **state)
{
    (void)state;
    end_image(chip, engine);
    return 0;
}

static bool says(const char *text)
{
    return console_says(chip, text);
}

/* Runs in small steps, in which neither enable nor a motor's PWM may be high. */
static rt_stop run_without_power(double ms)
{
    rt_stop stop = RT_STOP_TIME;
    for (double us = 0; us < ms * 1000 && stop == RT_STOP_TIME; us += STEP_us) {
        stop = rt_engine_run_us(engine, STEP_us);
        assert_false(rt_pin_level(chip, RT_PIN_ENABLE));
        for (int k = 0; k < 6; k++) assert_false(rt_pin_level(chip, (rt_pin)(RT_PIN_PWM0 + k)));
    }
    return stop;
}

static void expect_stop(const char *text)
{
    for (int ms = 0; ms < BOOT_ms && !says("reset\n"); ms++)
        assert_int_equal(run_without_power(1), RT_STOP_TIME);
    if (!says(text)) fail_msg("the console says '%s', expected '%s'", chip->uart.text, text);
    assert_true(says("; power stays off, waiting for the watchdog's reset\n"));
    assert_false(says("cournand on"));
    assert_false(rt_usb_is_attached(chip));
    /* The watchdog runs, and nobody serves it. */
    assert_true((chip->watchdogs.wcr & MASK(WDOG_WCR_WDE)) != 0 && chip->watchdogs.served == 0);
}

/* --- the image --- */

static void flip_flash(uint32_t address)
{
    const uint32_t word = rt_engine_word(engine, address & ~1u);
    rt_engine_patch(engine, address & ~1u, (uint16_t)(word ^ 1u << 4));
}

/* Requirement: SR-24 */
static void a_changed_bit_of_the_code_keeps_the_power_off(void **state)
{
    (void)state;
    flip_flash(rt_engine_symbol(engine, "code_load") + (rt_engine_symbol(engine, "crn_safety_drive") & ~1u));
    expect_stop("self-test: the image is damaged, CRC differs by 0x");
}

static void a_changed_bit_of_the_boot_header_keeps_the_power_off(void **state)
{
    (void)state;
    flip_flash(RT_FLASH_BEGIN + 0x1c0 + 0x20); /* reserved: the ROM does not read it */
    expect_stop("self-test: the image is damaged, CRC differs by 0x");
}

static void a_changed_bit_of_the_data_keeps_the_power_off(void **state)
{
    (void)state;
    flip_flash(rt_engine_symbol(engine, "data_load"));
    expect_stop("self-test: the image is damaged, CRC differs by 0x");
}

static void an_image_without_its_crc_keeps_the_power_off(void **state)
{
    (void)state;
    const uint32_t at = rt_engine_symbol(engine, "image_crc32");
    rt_engine_patch(engine, at, 0);
    rt_engine_patch(engine, at + 2, 0);
    expect_stop("self-test: the image is damaged, CRC differs by 0x");
}

/* --- the memories --- */

/* Flips a bit of a word as soon as the march has given the word `begin` the value `value`. */
static void flip_when(uint32_t begin, uint32_t value, uint32_t address)
{
    for (int i = 0; i < 4000 && rt_engine_word(engine, begin) != value; i++) {
        assert_int_equal(rt_engine_run_us(engine, 50), RT_STOP_TIME);
    }
    assert_int_equal(rt_engine_word(engine, begin), value);
    const rt_fault fault = {
        .kind = RT_FAULT_MEMORY, .begin = chip->now, .end = RT_NEVER, .address = address, .flip = 1u << 17};
    rt_fault_set(chip, &fault);
}

static void expect_bad_word(uint32_t address)
{
    char text[64];
    snprintf(text, sizeof text, "self-test: bad memory at 0x%08x", (unsigned)address);
    expect_stop(text);
}

/* Requirement: SR-25 */
static void a_bad_word_of_data_memory_keeps_the_power_off(void **state)
{
    (void)state;
    const uint32_t begin = rt_engine_symbol(engine, "data_begin");
    flip_when(begin, UINT32_MAX, begin + 0x40000);
    expect_bad_word(begin + 0x40000);
}

static void a_bad_word_of_the_stack_keeps_the_power_off(void **state)
{
    (void)state;
    const uint32_t begin = rt_engine_symbol(engine, "data_begin"),
                   top = rt_engine_symbol(engine, "stack_top");
    flip_when(begin, UINT32_MAX, top - 4);
    expect_bad_word(top - 4);
}

static void a_bad_word_of_the_usb_memory_keeps_the_power_off(void **state)
{
    (void)state;
    const uint32_t begin = rt_engine_symbol(engine, "dma_begin");
    flip_when(begin, UINT32_MAX, begin + 0x100);
    expect_bad_word(begin + 0x100);
}

/* --- the clock --- */

/* Returns whether the lamp of the state FAULT blinks within some milliseconds; in READY it is dark. */
static bool blinks(double ms)
{
    bool is_lit = false;
    for (double at = 0; at < ms; at += 5) {
        assert_int_equal(run_without_power(5), RT_STOP_TIME);
        is_lit = is_lit || rt_pin_level(chip, RT_PIN_LAMP);
    }
    return is_lit;
}

/* Boots at an active bus of high or full speed, and lets the timer's period be `thousandths` of its own. */
static bool blinks_with_a_tick_of(uint32_t thousandths, bool high_speed)
{
    assert_int_equal(open_board(NULL), 0);
    assert_int_equal(run_without_power(BOOT_ms), RT_STOP_TIME);
    rt_usb_bus_reset(chip, high_speed);
    assert_false(blinks(280));
    const rt_fault fault = {
        .kind = RT_FAULT_TICK_RATE, .begin = chip->now, .end = RT_NEVER, .set = thousandths};
    rt_fault_set(chip, &fault);
    const bool is_found = blinks(128.0 * 2 * thousandths / 1000 + 200);
    assert_int_equal(close_board(NULL), 0);
    return is_found;
}

/* Requirement: SR-26 */
static void a_tick_that_is_too_fast_or_too_slow_stops_the_device(void **state)
{
    (void)state;
    assert_true(blinks_with_a_tick_of(100, true));
    assert_true(blinks_with_a_tick_of(1100, false));
}

static void a_tick_within_2_per_cent_and_a_bus_that_rests_are_no_fault(void **state)
{
    (void)state;
    assert_false(blinks_with_a_tick_of(980, true));
    assert_int_equal(open_board(NULL), 0);
    while (!rt_usb_is_attached(chip)) assert_int_equal(run_without_power(0.1), RT_STOP_TIME);
    for (int i = 0; i < 2; i++) { /* first at the first edge of the timer */
        rt_usb_bus_reset(chip, true);
        assert_false(blinks(150));
        rt_usb_suspend(chip, true);
        assert_false(blinks(60));
        rt_usb_suspend(chip, false);
        assert_false(blinks(100));
    }
    assert_int_equal(close_board(NULL), 0);
}

int main(void)
{
#define BOARD_TEST(name) cmocka_unit_test_setup_teardown(name, open_board, close_board)
    const struct CMUnitTest tests[] = {
        BOARD_TEST(a_changed_bit_of_the_code_keeps_the_power_off),
        BOARD_TEST(a_changed_bit_of_the_boot_header_keeps_the_power_off),
        BOARD_TEST(a_changed_bit_of_the_data_keeps_the_power_off),
        BOARD_TEST(an_image_without_its_crc_keeps_the_power_off),
        BOARD_TEST(a_bad_word_of_data_memory_keeps_the_power_off),
        BOARD_TEST(a_bad_word_of_the_stack_keeps_the_power_off),
        BOARD_TEST(a_bad_word_of_the_usb_memory_keeps_the_power_off),
        cmocka_unit_test(a_tick_that_is_too_fast_or_too_slow_stops_the_device),
        cmocka_unit_test(a_tick_within_2_per_cent_and_a_bus_that_rests_are_no_fault),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
