/* Claim: a fault acts from its begin to its end and on nothing else: on what is read, what is written, what
 * is stored, a pin, the processor's clock, and the bus. */
#include "hil_tests/rt1062/tests/chip_room.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/* A fault from 10 us to 30 us from now on. */
static rt_fault fault_of(const rt_chip *chip, rt_fault_kind kind, uint32_t address)
{
    return (rt_fault){.kind = kind,
                      .begin = chip->now + 10 * RT_INSTANTS_PER_us,
                      .end = chip->now + 30 * RT_INSTANTS_PER_us,
                      .address = address};
}

static void bits_are_read_wrongly_while_the_fault_lasts(void **state)
{
    rt_chip *chip = *state;
    const uint32_t at = BASE_PIT + PIT_LDVAL_0;
    rt_chip_write(chip, at, 4, 0x1234);
    rt_fault fault = fault_of(chip, RT_FAULT_READ, at);
    fault.clear = 0x4, fault.set = 0x1, fault.flip = 0x30;
    rt_fault_set(chip, &fault);
    rt_chip_pass_us(chip, 9);
    assert_int_equal(rt_chip_read(chip, at, 4), 0x1234);
    rt_chip_pass_us(chip, 2);
    assert_int_equal(rt_chip_read(chip, at, 4), 0x1201);
    assert_int_equal(rt_chip_read(chip, BASE_PIT + PIT_MCR, 4), MASK(PIT_MCR_MDIS));
    rt_chip_pass_us(chip, 20);
    assert_int_equal(rt_chip_read(chip, at, 4), 0x1234);
}

static void register_takes_no_writes_while_the_fault_lasts(void **state)
{
    rt_chip *chip = *state;
    const uint32_t at = BASE_PIT + PIT_LDVAL_0;
    rt_chip_write(chip, at, 4, 1);
    rt_fault fault = fault_of(chip, RT_FAULT_WRITE_LOST, at);
    rt_fault_set(chip, &fault);
    rt_chip_pass_us(chip, 11);
    rt_chip_write(chip, at, 4, 2);
    assert_int_equal(rt_chip_read(chip, at, 4), 1);
    rt_chip_pass_us(chip, 20);
    rt_chip_write(chip, at, 4, 3);
    assert_int_equal(rt_chip_read(chip, at, 4), 3);
}

static uint32_t word_at(rt_chip *chip, const void *at)
{
    static rt_word words[RT_WORDS_MAX];
    uint32_t count = rt_fault_words(chip, words);
    for (uint32_t i = 0; i < count; i++)
        if (words[i].at == at) return i;
    fail_msg("the word is not in the list");
    return 0;
}

static void stored_bit_flips_once(void **state)
{
    rt_chip *chip = *state;
    rt_chip_write(chip, BASE_PIT + PIT_LDVAL_0, 4, 23999);
    rt_fault fault = fault_of(chip, RT_FAULT_UPSET, word_at(chip, &chip->pit.load));
    fault.flip = 1u << 12;
    rt_fault_set(chip, &fault);
    rt_chip_pass_us(chip, 100);
    assert_int_equal(chip->pit.load, 23999u ^ 1u << 12);
}

/* The ROM's clock comes from PFD2 of PLL2; without it, the processor stands until a reset. */
static void upset_of_the_clocks_source_lets_the_processor_stand(void **state)
{
    rt_chip *chip = *state;
    rt_fault fault =
        fault_of(chip, RT_FAULT_UPSET, word_at(chip, &chip->clocks.analog[CCM_ANALOG_PFD_528 / 4]));
    fault.flip = MASK(CCM_ANALOG_PFD_528_PFD2_CLKGATE);
    rt_fault_set(chip, &fault);
    assert_false(rt_fault_core_stands(chip));
    rt_chip_pass_us(chip, 100);
    assert_true(rt_fault_core_stands(chip));
    rt_chip_reset(chip, RT_RESET_WDOG1);
    assert_false(rt_fault_core_stands(chip));
}

static void pin_is_stuck_whatever_drives_it(void **state)
{
    rt_chip *chip = *state;
    rt_pin_drive(chip, RT_PIN_STOP, RT_LOW, chip->now);
    rt_fault fault = fault_of(chip, RT_FAULT_PIN, RT_PIN_STOP);
    fault.set = 1;
    rt_fault_set(chip, &fault);
    assert_false(rt_pin_level(chip, RT_PIN_STOP));
    rt_chip_pass_us(chip, 11);
    assert_true(rt_pin_level(chip, RT_PIN_STOP));
    rt_chip_pass_us(chip, 20);
    assert_false(rt_pin_level(chip, RT_PIN_STOP));
}

/* The millisecond timer counts in a time that the fault states. */
static void tick_lasts_as_the_fault_says(void **state)
{
    rt_chip *chip = *state;
    rt_fault fault = fault_of(chip, RT_FAULT_TICK_RATE, 0);
    fault.begin = chip->now, fault.end = RT_NEVER, fault.set = 250;
    rt_fault_set(chip, &fault);
    rt_chip_run_due(chip);
    rt_chip_write(chip, BASE_CCM + CCM_CSCMR1, 4, MASK(CCM_CSCMR1_PERCLK_CLK_SEL));
    rt_chip_write(chip, BASE_PIT + PIT_MCR, 4, 0);
    rt_chip_write(chip, BASE_PIT + PIT_LDVAL_0, 4, 24000 - 1);
    rt_chip_write(chip, BASE_PIT + PIT_TCTRL_0, 4, MASK(PIT_TCTRL_0_TEN));
    rt_chip_pass_us(chip, 249.9);
    assert_int_equal(rt_chip_read(chip, BASE_PIT + PIT_TFLG_0, 4), 0);
    rt_chip_pass_us(chip, 0.2);
    assert_int_equal(rt_chip_read(chip, BASE_PIT + PIT_TFLG_0, 4), MASK(PIT_TFLG_0_TIF));
}

#define ON(test) cmocka_unit_test_setup_teardown(test, open_chip, close_chip)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON(bits_are_read_wrongly_while_the_fault_lasts),
        ON(register_takes_no_writes_while_the_fault_lasts),
        ON(stored_bit_flips_once),
        ON(upset_of_the_clocks_source_lets_the_processor_stand),
        ON(pin_is_stuck_whatever_drives_it),
        ON(tick_lasts_as_the_fault_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
