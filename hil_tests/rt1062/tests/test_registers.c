/* Claim: every peripheral of the model becomes ready only when it was programmed rightly and its time has
 * passed, and names what is missing otherwise. Each test uses the registers as an image would, without a
 * processor. */
#include "hil_tests/rt1062/cache.h"
#include "hil_tests/rt1062/tests/chip_room.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static void expect_finding(const rt_chip *chip, const char *part)
{
    for (uint32_t i = 0; i < chip->findings_count; i++)
        if (strstr(chip->findings[i].text, part) != NULL) return;
    rt_report(chip, stderr, NULL, NULL);
    fail_msg("no finding says '%s'", part);
}

static void expect_wait(const rt_chip *chip, const char *part)
{
    const rt_wait *wait;
    for (uint32_t i = 0; (wait = rt_unanswered(chip, i)) != NULL; i++)
        if (strstr(wait->reason, part) != NULL) return;
    rt_report(chip, stderr, NULL, NULL);
    fail_msg("no unanswered wait says '%s'", part);
}

static void expect_quiet(const rt_chip *chip)
{
    if (rt_report(chip, stderr, NULL, NULL) != 0) fail_msg("waits or findings are left");
}

/* --- clocks --- */
/* The lock time of the ARM PLL is 2,250 periods of 24 MHz: 93.75 us. */
static void arm_pll_locks_after_its_time_and_not_before(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM,
       MASK(CCM_ANALOG_PLL_ARM_BYPASS) | MASK(CCM_ANALOG_PLL_ARM_ENABLE) |
           BITS(CCM_ANALOG_PLL_ARM_DIV_SELECT, 100));
    rt_chip_pass_us(chip, 93.0);
    assert_int_equal(rd(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM) & MASK(CCM_ANALOG_PLL_ARM_LOCK), 0);
    expect_wait(chip, "PLL_ARM LOCK: the PLL takes its time");
    rt_chip_pass_us(chip, 1.0);
    assert_true(rd(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM) & MASK(CCM_ANALOG_PLL_ARM_LOCK));
    expect_quiet(chip);
}

static void pll_with_a_divider_out_of_range_never_locks(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM,
       MASK(CCM_ANALOG_PLL_ARM_ENABLE) | MASK(CCM_ANALOG_PLL_ARM_BYPASS) |
           BITS(CCM_ANALOG_PLL_ARM_DIV_SELECT, 109));
    rt_chip_pass_us(chip, 1e6);
    assert_int_equal(rd(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM) & MASK(CCM_ANALOG_PLL_ARM_LOCK), 0);
    expect_wait(chip, "divider is out of range");
}

static void start_arm_pll(rt_chip *chip)
{
    uint32_t pll = MASK(CCM_ANALOG_PLL_ARM_ENABLE) | BITS(CCM_ANALOG_PLL_ARM_DIV_SELECT, 100);
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM, pll);
    rt_chip_pass_us(chip, 100);
    assert_true(rd(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM) & MASK(CCM_ANALOG_PLL_ARM_LOCK));
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PERIPH_CLK2_SEL, 1) | BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1));
    wr(chip, BASE_CCM, CCM_CBCDR, BITS(CCM_CBCDR_IPG_PODF, 3) | MASK(CCM_CBCDR_PERIPH_CLK_SEL));
    rt_chip_pass_us(chip, 2);
    assert_int_equal(rd(chip, BASE_CCM, CCM_CDHIPR), 0);
    assert_true(fabs(chip->clocks.core_Hz - 24e6) < 1);
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PERIPH_CLK2_SEL, 1) | BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 3));
    wr(chip, BASE_CCM, CCM_CBCDR, BITS(CCM_CBCDR_IPG_PODF, 3)); /* back to the PLL: 1,200 MHz / 2 */
    rt_chip_pass_us(chip, 2);
}

static void six_hundred_megahertz_wait_for_the_voltage(void **state)
{
    rt_chip *chip = *state;
    start_arm_pll(chip);
    rt_chip_pass_us(chip, 1000);
    assert_int_not_equal(rd(chip, BASE_CCM, CCM_CDHIPR) & MASK(CCM_CDHIPR_PERIPH_CLK_SEL_BUSY), 0);
    expect_wait(chip, "voltage is too low");
    wr(chip, BASE_DCDC, DCDC_REG3, BITS(DCDC_REG3_TRG, 18));
    assert_int_equal(rd(chip, BASE_DCDC, DCDC_REG0) & MASK(DCDC_REG0_STS_DC_OK), 0);
    rt_chip_pass_us(chip, 60);
    assert_true(rd(chip, BASE_DCDC, DCDC_REG0) & MASK(DCDC_REG0_STS_DC_OK));
    assert_int_equal(rd(chip, BASE_CCM, CCM_CDHIPR), 0);
    assert_true(fabs(rt_clock_ipg_Hz(chip) - 150e6) < 1);
    expect_quiet(chip);
}

static void closed_gate_wrong_width_and_unknown_register_are_findings(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CCGR0 + 4, 0);
    wr(chip, BASE_PIT, PIT_MCR, 0);
    expect_finding(chip, "PIT+0x0 is accessed while its clock gate CCGR1 CG6 is closed");
    rt_chip_write(chip, BASE_WDOG1 + WDOG_WMCR, 4, 0);
    expect_finding(chip, "WDOG1+0x8 is accessed with 32 bits; its registers have 16");
    rd(chip, BASE_LPUART6, 0x2c);
    expect_finding(chip, "LPUART6+0x2c is read, and the model has no such register");
    rd(chip, 0x40010000u, 0);
    expect_finding(chip, "belongs to no peripheral");
}

/* --- FlexSPI2 and PSRAM --- */
static const struct {
    uint32_t mux, mode, daisy, choice;
} memory_pins[7] = {{0x70, 8, 0x72c, 1}, {0x74, 8, 0, 0},     {0x78, 8, 0x750, 1}, {0x7c, 8, 0x730, 1},
                    {0x80, 8, 0x734, 1}, {0x84, 8, 0x738, 1}, {0x88, 8, 0x73c, 1}};

static void set_lut(rt_chip *chip, uint32_t sequence, uint32_t first, uint32_t second)
{
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUT_0 + 16 * sequence, first);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUT_0 + 16 * sequence + 4, second);
}

static uint32_t two(uint32_t a, uint32_t la, uint32_t oa, uint32_t b, uint32_t lb, uint32_t ob)
{
    return a << 10 | la << 8 | oa | (b << 10 | lb << 8 | ob) << 16;
}

static bool ip_command(rt_chip *chip, uint32_t sequence)
{
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCR1, BITS(FLEXSPI_IPCR1_ISEQID, sequence));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCMD, 1);
    rt_chip_pass_us(chip, 1);
    bool is_done = (rd(chip, BASE_FLEXSPI2, FLEXSPI_INTR) & MASK(FLEXSPI_INTR_IPCMDDONE)) != 0;
    wr(chip, BASE_FLEXSPI2, FLEXSPI_INTR, MASK(FLEXSPI_INTR_IPCMDDONE));
    return is_done;
}

/* Sets the controller up, with `wait` clocks before data are read. */
static void start_memory(rt_chip *chip, uint32_t wait)
{
    for (int i = 0; i < 7; i++) {
        wr(chip, BASE_IOMUXC, memory_pins[i].mux, memory_pins[i].mode | 1u << 4);
        if (memory_pins[i].daisy != 0) wr(chip, BASE_IOMUXC, memory_pins[i].daisy, memory_pins[i].choice);
    }
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_FLEXSPI2_PODF, 4));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_FLSHCR2_0, BITS(FLEXSPI_FLSHCR2_0_AWRSEQID, 1));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_MCR0, BITS(FLEXSPI_MCR0_RXCLKSRC, 1));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTKEY, 0x5af05af0u);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTCR, MASK(FLEXSPI_LUTCR_UNLOCK));
    set_lut(chip, 0, two(1, 2, 0xeb, 2, 2, 24), two(12, 2, wait, 9, 2, 4));
    set_lut(chip, 1, two(1, 2, 0x38, 2, 2, 24), two(8, 2, 4, 0, 0, 0));
    set_lut(chip, 2, two(1, 0, 0x35, 0, 0, 0), 0);
}

static void psram_answers_after_it_was_put_on_four_lines(void **state)
{
    rt_chip *chip = *state;
    uint32_t value = 0x12345678, back = 0;
    start_memory(chip, 6);
    assert_true(rt_flexspi_access(chip, RT_PSRAM_BEGIN + 64, 4, true, &value));
    assert_true(rt_flexspi_access(chip, RT_PSRAM_BEGIN + 64, 4, false, &back));
    assert_int_equal(back, 0xffffffffu); /* it does not understand the command yet */
    assert_true(ip_command(chip, 2));
    assert_true(rt_flexspi_is_sound(chip));
    assert_true(rt_flexspi_access(chip, RT_PSRAM_BEGIN + 64, 4, true, &value));
    assert_true(rt_flexspi_access(chip, RT_PSRAM_BEGIN + 64, 4, false, &back));
    assert_int_equal(back, value);
    /* A line: select 3 + 3 clocks (reset value), command 2, address 6, waiting 6, 64 of data, at 79.2 MHz. */
    double ns = (double)rt_flexspi_line_instants(chip) * 1000 / RT_INSTANTS_PER_us;
    assert_true(fabs(ns - 84 / 79.2e6 * 1e9) < 0.1);
    expect_quiet(chip);
}

static void psram_with_wrong_waiting_clocks_is_not_sound(void **state)
{
    rt_chip *chip = *state;
    start_memory(chip, 5);
    assert_true(ip_command(chip, 2));
    assert_false(rt_flexspi_is_sound(chip));
}

static void command_without_a_data_pin_never_ends(void **state)
{
    rt_chip *chip = *state;
    start_memory(chip, 6);
    wr(chip, BASE_IOMUXC, memory_pins[4].daisy, 0);
    assert_false(ip_command(chip, 2));
    expect_wait(chip, "FLEXSPI2_INTR IPCMDDONE: a pin of the PSRAM is not connected");
}

static void locked_look_up_table_keeps_its_words(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_FLEXSPI2, FLEXSPI_MCR0, 0);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTCR, MASK(FLEXSPI_LUTCR_UNLOCK)); /* without the key */
    set_lut(chip, 0, 1, 2);
    assert_int_equal(chip->flexspi.lut[0], 0);
    expect_finding(chip, "while the table is locked");
}

/* A line takes 84 clocks of 79.2 MHz. The fifth line of a set takes the place of the one not used for
 * longest; if the processor has changed that one, it is written first. */
static void cache_takes_the_time_of_its_lines(void **state)
{
    rt_chip *chip = *state;
    static rt_cache cache;
    const double line_us = 84 / 79.2;
    const uint32_t way_bytes = RT_CACHE_SETS * RT_CACHE_LINE_BYTES;
    start_memory(chip, 6);
    assert_true(ip_command(chip, 2));
    rt_cache_clear(&cache);
    uint64_t begin = chip->now;
    rt_cache_access(&cache, chip, RT_PSRAM_BEGIN, true);
    rt_cache_access(&cache, chip, RT_PSRAM_BEGIN + 28, false); /* the same line */
    for (uint32_t way = 1; way < 4; way++)
        rt_cache_access(&cache, chip, RT_PSRAM_BEGIN + way * way_bytes, false);
    assert_int_equal(cache.misses, 4);
    rt_cache_access(&cache, chip, RT_PSRAM_BEGIN + 4 * way_bytes, false); /* the changed line leaves */
    assert_int_equal(cache.misses, 5);
    assert_int_equal(cache.writes, 1);
    rt_cache_access(&cache, chip, RT_PSRAM_BEGIN + 2 * way_bytes, false); /* still there */
    assert_int_equal(cache.hits, 2);
    double us = (double)(chip->now - begin) / RT_INSTANTS_PER_us;
    assert_true(fabs(us - 6 * line_us) < 0.01);
    begin = chip->now; /* of the OCRAM, a line takes 44 cycles, and so does a changed one that leaves */
    const uint32_t near_address = RT_OCRAM_BEGIN + 0x20000;
    for (uint32_t way = 0; way < 5; way++)
        rt_cache_access(&cache, chip, near_address + 64 + way * way_bytes, true);
    assert_int_equal(cache.near_misses, 5);
    assert_int_equal(cache.misses, 5);
    assert_int_equal(chip->now - begin, 6 * 44 * chip->clocks.instants_per_cycle);
}

/* A region of 512 kB of which the first two eighths are left out, as the port has it over the OCRAM. */
static void memory_protection_leaves_out_parts_of_a_region(void **state)
{
    rt_chip *chip = *state;
    const uint32_t ram = 0x20200000u, rbar = 0xe000ed9cu, rasr = 0xe000eda0u, size_512_kB = 18 << 1 | 1,
                   all = 3 << 24, uncached = 1 << 19, write_back = 1 << 19 | 3 << 16;
    rt_core_write(chip, rbar, ram | 1 << 4 | 3);
    rt_core_write(chip, rasr, uncached | all | size_512_kB);
    rt_core_write(chip, rbar, ram | 1 << 4 | 4);
    rt_core_write(chip, rasr, write_back | all | 3 << 8 | size_512_kB);
    rt_core_write(chip, 0xe000ed94u, 1);
    assert_false(rt_mpu_is_cached(chip, ram));
    assert_false(rt_mpu_is_cached(chip, ram + 0x1ffff));
    assert_true(rt_mpu_is_cached(chip, ram + 0x20000));
    assert_true(rt_mpu_is_cached(chip, ram + 0x7ffff));
    assert_true(rt_mpu_allows(chip, ram, RT_ACCESS_WRITE));
    assert_false(rt_mpu_allows(chip, ram + 0x80000, RT_ACCESS_READ));
}

/* --- timers and watchdogs --- */
static void pit_makes_an_edge_every_millisecond(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CSCMR1, MASK(CCM_CSCMR1_PERCLK_CLK_SEL));
    wr(chip, BASE_PIT, PIT_MCR, 0);
    wr(chip, BASE_PIT, PIT_LDVAL_0, 24000 - 1);
    wr(chip, BASE_PIT, PIT_TCTRL_0, MASK(PIT_TCTRL_0_TIE) | MASK(PIT_TCTRL_0_TEN));
    rt_core_write(chip, 0xe000e100u + 4 * (122 / 32), 1u << 122 % 32);
    rt_chip_pass_us(chip, 999.9);
    assert_int_equal(rt_chip_interrupt(chip), -1);
    rt_chip_pass_us(chip, 0.2);
    assert_int_equal(rt_chip_interrupt(chip), 122);
    wr(chip, BASE_PIT, PIT_TFLG_0, MASK(PIT_TFLG_0_TIF));
    assert_int_equal(rt_chip_interrupt(chip), -1);
    rt_chip_pass_us(chip, 1000);
    assert_int_equal(rt_chip_interrupt(chip), 122);
}

static void gpt_counts_microseconds(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CSCMR1, MASK(CCM_CSCMR1_PERCLK_CLK_SEL));
    wr(chip, BASE_GPT1, GPT_PR, 23);
    wr(chip, BASE_GPT1, GPT_CR, BITS(GPT_CR_CLKSRC, 2) | MASK(GPT_CR_ENMOD) | MASK(GPT_CR_EN));
    rt_chip_pass_us(chip, 12345.5);
    assert_int_equal(rd(chip, BASE_GPT1, GPT_CNT), 12345);
}

static void watchdog_bites_two_seconds_after_the_last_service(void **state)
{
    rt_chip *chip = *state;
    wr16(chip, BASE_WDOG1, WDOG_WCR,
         BITS(WDOG_WCR_WT, 3) | MASK(WDOG_WCR_WDA) | MASK(WDOG_WCR_SRS) | MASK(WDOG_WCR_WDE));
    rt_chip_pass_us(chip, 1.9e6);
    wr16(chip, BASE_WDOG1, WDOG_WSR, 0x5555);
    wr16(chip, BASE_WDOG1, WDOG_WSR, 0xaaaa);
    rt_chip_pass_us(chip, 1.9e6);
    assert_int_equal(chip->reset, RT_RESET_NONE);
    wr16(chip, BASE_WDOG1, WDOG_WSR, 0xaaaa); /* half of the service is none */
    rt_chip_pass_us(chip, 0.2e6);
    assert_int_equal(chip->reset, RT_RESET_WDOG1);
    rt_chip_reset(chip, chip->reset);
    assert_int_equal(rd(chip, BASE_SRC, SRC_SRSR), MASK(SRC_SRSR_WDOG_RST_B));
}

static void rtwdog_takes_changes_only_after_its_key(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_RTWDOG, RTWDOG_CNT, 0xd928c520u);
    wr(chip, BASE_RTWDOG, RTWDOG_TOVAL, 0xffff);
    assert_int_equal(chip->reset, RT_RESET_NONE);
    rt_chip_pass_us(chip, 10); /* 255 clocks of 99 MHz are 2.6 us */
    wr(chip, BASE_RTWDOG, RTWDOG_CS, 0);
    assert_int_equal(chip->reset, RT_RESET_RTWDOG);
}

/* --- encoders --- */
static void connect_first_decoder(rt_chip *chip)
{
    wr(chip, BASE_IOMUXC, 0x24, 3);
    wr(chip, BASE_IOMUXC, 0x28, 3);
    wr16(chip, BASE_XBARA1, 66, 6 | 7 << 8);
    wr16(chip, BASE_ENC1, ENC_FILT, BITS(ENC_FILT_FILT_CNT, 2) | BITS(ENC_FILT_FILT_PER, 6));
}

static void set_phases(rt_chip *chip, int step, uint64_t instant)
{
    static const bool a[4] = {false, true, true, false}, b[4] = {false, false, true, true};
    rt_pin_drive(chip, RT_PIN_ENCODER_A0, a[step & 3] ? RT_HIGH : RT_LOW, instant);
    rt_pin_drive(chip, RT_PIN_ENCODER_B0, b[step & 3] ? RT_HIGH : RT_LOW, instant);
}

static int32_t position(rt_chip *chip)
{
    uint32_t low = rd16(chip, BASE_ENC1, ENC_LPOS);
    return (int32_t)(rd16(chip, BASE_ENC1, ENC_UPOSH) << 16 | low);
}

static void decoder_counts_every_edge_in_both_directions(void **state)
{
    rt_chip *chip = *state;
    connect_first_decoder(chip);
    set_phases(chip, 0, chip->now);
    for (int i = 1; i <= 100; i++) {
        rt_chip_pass_us(chip, 1);
        set_phases(chip, i, chip->now);
    }
    rt_chip_pass_us(chip, 1);
    assert_int_equal(position(chip), 100);
    for (int i = 99; i >= -50; i--) {
        rt_chip_pass_us(chip, 1);
        set_phases(chip, i, chip->now);
    }
    rt_chip_pass_us(chip, 1);
    assert_int_equal(position(chip), -50);
    assert_int_equal(rd16(chip, BASE_ENC1, ENC_CTRL2), 0);
}

/* 5 samples of 6 clocks at 99 MHz are 303 ns. */
static void decoder_ignores_a_glitch_and_reports_an_illegal_step(void **state)
{
    rt_chip *chip = *state;
    connect_first_decoder(chip);
    set_phases(chip, 0, chip->now);
    rt_chip_pass_us(chip, 5);
    rt_pin_drive(chip, RT_PIN_ENCODER_A0, RT_HIGH, chip->now);
    rt_chip_pass_us(chip, 0.2);
    rt_pin_drive(chip, RT_PIN_ENCODER_A0, RT_LOW, chip->now);
    rt_chip_pass_us(chip, 5);
    assert_int_equal(position(chip), 0);
    set_phases(chip, 2, chip->now); /* both phases at once */
    rt_chip_pass_us(chip, 5);
    assert_int_equal(rd16(chip, BASE_ENC1, ENC_CTRL2), MASK(ENC_CTRL2_SABIRQ));
}

static void decoder_without_its_crossbar_input_counts_nothing(void **state)
{
    rt_chip *chip = *state;
    connect_first_decoder(chip);
    wr16(chip, BASE_XBARA1, 66, 0);
    for (int i = 0; i <= 10; i++) {
        rt_chip_pass_us(chip, 1);
        set_phases(chip, i, chip->now);
    }
    assert_int_equal(position(chip), 0);
}

/* --- PWM --- */
static void start_pwm(rt_chip *chip)
{
    wr(chip, BASE_IOMUXC, 0x34, 3); /* the fault line */
    wr16(chip, BASE_XBARA1, 48, 17u << 8);
    rt_pin_drive(chip, RT_PIN_FAULT, RT_HIGH, chip->now);
    uint32_t at = BASE_PWM2 + 2 * PWM_STRIDE_SMCTRL;
    wr16(chip, at, PWM_SMVAL1_0, 7499);
    wr16(chip, at, PWM_SMVAL3_0, 1500);
    wr16(chip, at, PWM_SMDISMAP0_0, BITS(PWM_SMDISMAP0_0_DIS0A, 1));
    wr16(chip, BASE_PWM2, PWM_FCTRL0, BITS(PWM_FCTRL0_FSAFE, 1));
    wr16(chip, BASE_PWM2, PWM_FSTS0, BITS(PWM_FSTS0_FFULL, 1) | BITS(PWM_FSTS0_FFLAG, 1));
    wr16(chip, BASE_PWM2, PWM_MCTRL, BITS(PWM_MCTRL_LDOK, 4));
    wr16(chip, BASE_PWM2, PWM_MCTRL, BITS(PWM_MCTRL_RUN, 4) | rd16(chip, BASE_PWM2, PWM_MCTRL));
    wr16(chip, BASE_PWM2, PWM_OUTEN, BITS(PWM_OUTEN_PWMA_EN, 4));
}

static void fault_line_turns_the_output_off_until_it_is_cleared_and_gone(void **state)
{
    rt_chip *chip = *state;
    start_pwm(chip);
    assert_true(fabs(rt_pwm_duty(chip, 0, 2, false) - 0.2) < 1e-12);
    rt_pin_drive(chip, RT_PIN_FAULT, RT_LOW, chip->now);
    assert_true(rt_pwm_duty(chip, 0, 2, false) == 0);
    rt_pin_drive(chip, RT_PIN_FAULT, RT_HIGH, chip->now);
    assert_true(rt_pwm_duty(chip, 0, 2, false) == 0); /* latched */
    wr16(chip, BASE_PWM2, PWM_FSTS0, BITS(PWM_FSTS0_FFULL, 1) | BITS(PWM_FSTS0_FFLAG, 1));
    assert_true(fabs(rt_pwm_duty(chip, 0, 2, false) - 0.2) < 1e-12);
    rt_pin_drive(chip, RT_PIN_FAULT, RT_OPEN, chip->now); /* a broken cable: the pad has no pull-up here */
    assert_true(rt_pwm_duty(chip, 0, 2, false) == 0);
    wr16(chip, BASE_PWM2, PWM_FSTS0, BITS(PWM_FSTS0_FFULL, 1) | BITS(PWM_FSTS0_FFLAG, 1));
    assert_true(rt_pwm_duty(chip, 0, 2, false) == 0); /* cleared, and not gone */
}

static void buffered_values_act_only_with_ldok(void **state)
{
    rt_chip *chip = *state;
    start_pwm(chip);
    wr16(chip, BASE_PWM2 + 2 * PWM_STRIDE_SMCTRL, PWM_SMVAL3_0, 3750);
    assert_true(fabs(rt_pwm_duty(chip, 0, 2, false) - 0.2) < 1e-12);
    wr16(chip, BASE_PWM2, PWM_MCTRL, rd16(chip, BASE_PWM2, PWM_MCTRL) | BITS(PWM_MCTRL_LDOK, 4));
    assert_true(fabs(rt_pwm_duty(chip, 0, 2, false) - 0.5) < 1e-12);
}

/* --- ADC --- */
static void adc_converts_after_its_calibration_and_with_a_slow_enough_clock(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_IOMUXC, 0x118, 5);
    wr(chip, BASE_IOMUXC, 0x308, 0); /* AD_B1_07: no keeper */
    rt_pin_volts(chip, RT_PIN_FORCE0, 1.65);
    wr(chip, BASE_ADC1, ADC_CFG, BITS(ADC_CFG_MODE, 2)); /* 99 MHz: too fast */
    wr(chip, BASE_ADC1, ADC_GC, MASK(ADC_GC_CAL));
    rt_chip_pass_us(chip, 1e5);
    assert_true(rd(chip, BASE_ADC1, ADC_GC) & MASK(ADC_GC_CAL));
    expect_wait(chip, "ADC1_GC CAL: the converter's clock stands or is over 40 MHz");
    wr(chip, BASE_ADC1, ADC_CFG, BITS(ADC_CFG_MODE, 2) | BITS(ADC_CFG_ADICLK, 1) | BITS(ADC_CFG_ADIV, 1));
    wr(chip, BASE_ADC1, ADC_GC, MASK(ADC_GC_CAL));
    rt_chip_pass_us(chip, 1e3);
    assert_int_equal(rd(chip, BASE_ADC1, ADC_GC) & MASK(ADC_GC_CAL), 0);
    wr(chip, BASE_ADC1, ADC_HC0, 12);
    assert_int_equal(rd(chip, BASE_ADC1, ADC_HS), 0);
    rt_chip_pass_us(chip, 2);
    assert_int_equal(rd(chip, BASE_ADC1, ADC_HS), MASK(ADC_HS_COCO0));
    assert_int_equal(rd(chip, BASE_ADC1, ADC_R0), 2048);
    expect_quiet(chip);
}

#define ON(test) cmocka_unit_test_setup_teardown(test, open_chip, close_chip)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON(arm_pll_locks_after_its_time_and_not_before),
        ON(pll_with_a_divider_out_of_range_never_locks),
        ON(six_hundred_megahertz_wait_for_the_voltage),
        ON(closed_gate_wrong_width_and_unknown_register_are_findings),
        ON(psram_answers_after_it_was_put_on_four_lines),
        ON(psram_with_wrong_waiting_clocks_is_not_sound),
        ON(command_without_a_data_pin_never_ends),
        ON(locked_look_up_table_keeps_its_words),
        ON(cache_takes_the_time_of_its_lines),
        ON(memory_protection_leaves_out_parts_of_a_region),
        ON(pit_makes_an_edge_every_millisecond),
        ON(gpt_counts_microseconds),
        ON(watchdog_bites_two_seconds_after_the_last_service),
        ON(rtwdog_takes_changes_only_after_its_key),
        ON(decoder_counts_every_edge_in_both_directions),
        ON(decoder_ignores_a_glitch_and_reports_an_illegal_step),
        ON(decoder_without_its_crossbar_input_counts_nothing),
        ON(fault_line_turns_the_output_off_until_it_is_cleared_and_gone),
        ON(buffered_values_act_only_with_ldok),
        ON(adc_converts_after_its_calibration_and_with_a_slow_enough_clock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
