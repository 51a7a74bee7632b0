/* Claim: every pin of the board reaches its peripheral by its own setting and by no other one, and every
 * encoder, motor, converter channel and sequence of the PSRAM's controller works like the first of its kind.
 */
#include "hil_tests/rt1062/tests/chip_room.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { NO_DAISY = 0, PULL_KEEPER = 1 << 12, SION = 1 << 4, MHZ = 1000000 };

/* --- IOMUXC --- */
static const struct {
    uint32_t pin, mux, mode, pad, daisy, choice;
} pins[] = {
    {RT_PIN_ENCODER_A0, PAD_EMC_04_XBAR1_INOUT06, DAISY_XBAR1_IN06_EMC_04},
    {RT_PIN_ENCODER_A0 + 1, PAD_EMC_06_XBAR1_INOUT08, DAISY_XBAR1_IN08_EMC_06},
    {RT_PIN_ENCODER_A0 + 2, PAD_EMC_36_XBAR1_IN22, DAISY_XBAR1_IN22_EMC_36},
    {RT_PIN_ENCODER_A0 + 3, PAD_B1_00_XBAR1_INOUT14, DAISY_XBAR1_IN14_B1_00},
    {RT_PIN_ENCODER_A0 + 4, PAD_AD_B1_00_QTIMER3_TIMER0, DAISY_QTIMER3_TIMER0_AD_B1_00},
    {RT_PIN_ENCODER_A0 + 5, PAD_AD_B1_02_QTIMER3_TIMER2, DAISY_QTIMER3_TIMER2_AD_B1_02},
    {RT_PIN_ENCODER_A0 + 6, PAD_B0_00_QTIMER1_TIMER0, NO_DAISY, 0},
    {RT_PIN_ENCODER_B0, PAD_EMC_05_XBAR1_INOUT07, DAISY_XBAR1_IN07_EMC_05},
    {RT_PIN_ENCODER_B0 + 1, PAD_EMC_07_XBAR1_INOUT09, DAISY_XBAR1_IN09_EMC_07},
    {RT_PIN_ENCODER_B0 + 2, PAD_EMC_37_XBAR1_IN23, DAISY_XBAR1_IN23_EMC_37},
    {RT_PIN_ENCODER_B0 + 3, PAD_B1_01_XBAR1_INOUT15, DAISY_XBAR1_IN15_B1_01},
    {RT_PIN_ENCODER_B0 + 4, PAD_AD_B1_01_QTIMER3_TIMER1, DAISY_QTIMER3_TIMER1_AD_B1_01},
    {RT_PIN_ENCODER_B0 + 5, PAD_AD_B1_03_QTIMER3_TIMER3, DAISY_QTIMER3_TIMER3_AD_B1_03},
    {RT_PIN_ENCODER_B0 + 6, PAD_B0_01_QTIMER1_TIMER1, NO_DAISY, 0},
    {RT_PIN_PWM0, PAD_B0_10_FLEXPWM2_PWMA02, NO_DAISY, 0},
    {RT_PIN_PWM0 + 1, PAD_B0_11_FLEXPWM2_PWMB02, NO_DAISY, 0},
    {RT_PIN_PWM0 + 2, PAD_B1_02_FLEXPWM2_PWMA03, NO_DAISY, 0},
    {RT_PIN_PWM0 + 3, PAD_B1_03_FLEXPWM2_PWMB03, NO_DAISY, 0},
    {RT_PIN_PWM0 + 4, PAD_EMC_31_FLEXPWM3_PWMA01, NO_DAISY, 0},
    {RT_PIN_PWM0 + 5, PAD_EMC_32_FLEXPWM3_PWMB01, NO_DAISY, 0},
    {RT_PIN_DIRECTION0, PAD_SD_B0_00_GPIO3_IO12, NO_DAISY, 0},
    {RT_PIN_DIRECTION0 + 1, PAD_SD_B0_01_GPIO3_IO13, NO_DAISY, 0},
    {RT_PIN_DIRECTION0 + 2, PAD_SD_B0_02_GPIO3_IO14, NO_DAISY, 0},
    {RT_PIN_DIRECTION0 + 3, PAD_SD_B0_03_GPIO3_IO15, NO_DAISY, 0},
    {RT_PIN_DIRECTION0 + 4, PAD_SD_B0_04_GPIO3_IO16, NO_DAISY, 0},
    {RT_PIN_DIRECTION0 + 5, PAD_SD_B0_05_GPIO3_IO17, NO_DAISY, 0},
    {RT_PIN_FAULT, PAD_EMC_08_XBAR1_INOUT17, DAISY_XBAR1_IN17_EMC_08},
    {RT_PIN_DRIVE, PAD_B0_12_GPIO2_IO12, NO_DAISY, 0},
    {RT_PIN_ENABLE, PAD_AD_B1_15_GPIO1_IO31, NO_DAISY, 0},
    {RT_PIN_LAMP, PAD_B0_03_GPIO2_IO03, NO_DAISY, 0},
    {RT_PIN_STOP, PAD_AD_B0_12_GPIO1_IO12, NO_DAISY, 0},
    {RT_PIN_PEDAL_XRAY, PAD_AD_B0_13_GPIO1_IO13, NO_DAISY, 0},
    {RT_PIN_PEDAL_CINE, PAD_B0_02_GPIO2_IO02, NO_DAISY, 0},
    {RT_PIN_UNLOCK, PAD_B1_12_GPIO2_IO28, NO_DAISY, 0},
    {RT_PIN_STAGE, PAD_B1_13_GPIO2_IO29, NO_DAISY, 0},
    {RT_PIN_CONSOLE, PAD_AD_B0_02_LPUART6_TX, DAISY_LPUART6_TX_AD_B0_02},
    {RT_PIN_FORCE0, PAD_AD_B1_07_GPIO1_IO23, NO_DAISY, 0},
    {RT_PIN_FORCE0 + 1, PAD_AD_B1_06_GPIO1_IO22, NO_DAISY, 0},
    {RT_PIN_FORCE0 + 2, PAD_AD_B1_10_GPIO1_IO26, NO_DAISY, 0},
    {RT_PIN_CURRENT0, PAD_AD_B1_08_GPIO1_IO24, NO_DAISY, 0},
    {RT_PIN_CURRENT0 + 1, PAD_AD_B1_09_GPIO1_IO25, NO_DAISY, 0},
    {RT_PIN_CURRENT0 + 2, PAD_AD_B1_04_GPIO1_IO20, NO_DAISY, 0},
    {RT_PIN_PRESSURE, PAD_AD_B1_11_GPIO1_IO27, NO_DAISY, 0},
    {RT_PIN_SUPPLY, PAD_AD_B1_14_GPIO1_IO30, NO_DAISY, 0},
    {RT_PIN_MEMORY0, PAD_EMC_23_FLEXSPI2_A_DQS, DAISY_FLEXSPI2_IPP_IND_DQS_FA_EMC_23},
    {RT_PIN_MEMORY0 + 1, PAD_EMC_24_FLEXSPI2_A_SS0_B, NO_DAISY, 0},
    {RT_PIN_MEMORY0 + 2, PAD_EMC_25_FLEXSPI2_A_SCLK, DAISY_FLEXSPI2_IPP_IND_SCK_FA_EMC_25},
    {RT_PIN_MEMORY0 + 3, PAD_EMC_26_FLEXSPI2_A_DATA00, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT0_EMC_26},
    {RT_PIN_MEMORY0 + 4, PAD_EMC_27_FLEXSPI2_A_DATA01, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT1_EMC_27},
    {RT_PIN_MEMORY0 + 5, PAD_EMC_28_FLEXSPI2_A_DATA02, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT2_EMC_28},
    {RT_PIN_MEMORY0 + 6, PAD_EMC_29_FLEXSPI2_A_DATA03, DAISY_FLEXSPI2_IPP_IND_IO_FA_BIT3_EMC_29},
};
enum { PINS = sizeof pins / sizeof pins[0] };

static bool is_analog(uint32_t pin)
{
    return pin >= RT_PIN_FORCE0 && pin <= RT_PIN_SUPPLY;
}

static void route(rt_chip *chip, size_t i)
{
    wr(chip, BASE_IOMUXC, pins[i].mux, pins[i].mode);
    wr(chip, BASE_IOMUXC, pins[i].pad, is_analog(pins[i].pin) ? 0 : 0x10b0);
    if (pins[i].daisy != NO_DAISY) wr(chip, BASE_IOMUXC, pins[i].daisy, pins[i].choice);
}

static void route_all(rt_chip *chip)
{
    for (size_t i = 0; i < PINS; i++) route(chip, i);
}

static bool is_routed(rt_chip *chip, size_t i)
{
    return rt_pin_is_routed(chip, (rt_pin)pins[i].pin);
}

static void every_pin_is_connected_by_its_own_setting_alone(void **state)
{
    rt_chip *chip = *state;
    for (size_t i = 0; i < PINS; i++) {
        route(chip, i);
        if (!is_routed(chip, i)) fail_msg("%s is not connected", rt_pin_name((rt_pin)pins[i].pin));
        wr(chip, BASE_IOMUXC, pins[i].mux, pins[i].mode ^ 1u);
        assert_false(is_routed(chip, i));
        wr(chip, BASE_IOMUXC, pins[i].mux, pins[i].mode);
        if (pins[i].daisy != NO_DAISY) {
            wr(chip, BASE_IOMUXC, pins[i].daisy, pins[i].choice ^ 1u);
            assert_false(is_routed(chip, i));
            wr(chip, BASE_IOMUXC, pins[i].daisy, pins[i].choice);
        }
        if (is_analog(pins[i].pin)) {
            wr(chip, BASE_IOMUXC, pins[i].pad, PULL_KEEPER);
            assert_false(is_routed(chip, i));
            wr(chip, BASE_IOMUXC, pins[i].pad, 0);
        }
        assert_true(is_routed(chip, i));
    }
}

/* An open pin has the level of its pull resistor: PKE and PUE on, PUS not "down". */
static void open_pin_has_the_level_of_its_resistor(void **state)
{
    rt_chip *chip = *state;
    const uint32_t pull_up = PULL_KEEPER | 1 << 13 | 2 << 14, pull_down = PULL_KEEPER | 1 << 13;
    route_all(chip);
    for (size_t i = 0; i < PINS; i++) {
        rt_pin pin = (rt_pin)pins[i].pin;
        bool is_input =
            pin < RT_PIN_PWM0 || pin == RT_PIN_FAULT || (pin >= RT_PIN_STOP && pin <= RT_PIN_STAGE);
        if (!is_input) continue;
        wr(chip, BASE_IOMUXC, pins[i].pad, pull_up);
        assert_true(rt_pin_level(chip, pin));
        wr(chip, BASE_IOMUXC, pins[i].pad, pull_down);
        assert_false(rt_pin_level(chip, pin));
        wr(chip, BASE_IOMUXC, pins[i].pad, pull_up & ~(uint32_t)PULL_KEEPER);
        assert_false(rt_pin_level(chip, pin));
    }
}

static void registers_of_pins_keep_what_is_written(void **state)
{
    rt_chip *chip = *state;
    for (size_t i = 0; i < PINS; i++) {
        const uint32_t at[3] = {pins[i].mux, pins[i].pad, pins[i].daisy};
        for (int k = 0; k < (pins[i].daisy != NO_DAISY ? 3 : 2); k++) {
            if (k == 0) assert_int_equal(rd(chip, BASE_IOMUXC, at[k]), 5);
            if (k == 1) assert_int_equal(rd(chip, BASE_IOMUXC, at[k]), 0x10b0);
            wr(chip, BASE_IOMUXC, at[k], 0x1f0f9);
            assert_int_equal(rd(chip, BASE_IOMUXC, at[k]), 0x1f0f9);
            wr(chip, BASE_IOMUXC, at[k], 0);
            assert_int_equal(rd(chip, BASE_IOMUXC, at[k]), 0);
        }
    }
}

/* --- GPIO --- */
static const struct {
    uint32_t base, bit, pin;
} outputs[] = {{BASE_GPIO3, 12, RT_PIN_DIRECTION0},
               {BASE_GPIO3, 13, RT_PIN_DIRECTION0 + 1},
               {BASE_GPIO3, 14, RT_PIN_DIRECTION0 + 2},
               {BASE_GPIO3, 15, RT_PIN_DIRECTION0 + 3},
               {BASE_GPIO3, 16, RT_PIN_DIRECTION0 + 4},
               {BASE_GPIO3, 17, RT_PIN_DIRECTION0 + 5},
               {BASE_GPIO2, 12, RT_PIN_DRIVE},
               {BASE_GPIO1, 31, RT_PIN_ENABLE},
               {BASE_GPIO2, 3, RT_PIN_LAMP}},
  inputs[] = {{BASE_GPIO1, 12, RT_PIN_STOP},
              {BASE_GPIO1, 13, RT_PIN_PEDAL_XRAY},
              {BASE_GPIO2, 2, RT_PIN_PEDAL_CINE},
              {BASE_GPIO2, 28, RT_PIN_UNLOCK},
              {BASE_GPIO2, 29, RT_PIN_STAGE}};

static void outputs_follow_their_bit_when_they_are_outputs(void **state)
{
    rt_chip *chip = *state;
    route_all(chip);
    for (size_t i = 0; i < sizeof outputs / sizeof outputs[0]; i++) {
        rt_pin pin = (rt_pin)outputs[i].pin;
        uint32_t bit = 1u << outputs[i].bit;
        wr(chip, outputs[i].base, GPIO_DR_SET, bit);
        assert_false(rt_pin_level(chip, pin));
        wr(chip, outputs[i].base, GPIO_GDIR, bit);
        assert_true(rt_pin_level(chip, pin));
        assert_int_equal(rd(chip, outputs[i].base, GPIO_PSR) & bit, bit);
        wr(chip, outputs[i].base, GPIO_DR_CLEAR, ~bit);
        assert_true(rt_pin_level(chip, pin));
        wr(chip, outputs[i].base, GPIO_DR_CLEAR, bit);
        assert_false(rt_pin_level(chip, pin));
        wr(chip, outputs[i].base, GPIO_DR_SET, ~bit);
        assert_false(rt_pin_level(chip, pin));
        wr(chip, outputs[i].base, GPIO_DR, bit);
        assert_true(rt_pin_level(chip, pin));
        wr(chip, outputs[i].base, GPIO_DR, 0);
    }
}

static void inputs_are_read_as_the_rig_drives_them(void **state)
{
    rt_chip *chip = *state;
    route_all(chip);
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++) {
        for (int level = 0; level < 2; level++) {
            rt_pin_drive(chip, (rt_pin)inputs[i].pin, level ? RT_HIGH : RT_LOW, chip->now);
            uint32_t read = rd(chip, inputs[i].base, GPIO_PSR);
            assert_int_equal(read, level ? 1u << inputs[i].bit : 0);
        }
        rt_pin_drive(chip, (rt_pin)inputs[i].pin, RT_LOW, chip->now);
    }
}

/* --- encoders --- */
static void connect(rt_chip *chip, uint32_t output, uint32_t input)
{
    uint32_t at = output & ~1u, shift = output % 2 * 8;
    wr16(chip, BASE_XBARA1, at, (rd16(chip, BASE_XBARA1, at) & ~(0x7fu << shift)) | input << shift);
}

static void step_to(rt_chip *chip, uint32_t encoder, int step)
{
    static const bool a[4] = {false, true, true, false}, b[4] = {false, false, true, true};
    rt_pin_drive(chip, (rt_pin)(RT_PIN_ENCODER_A0 + encoder), a[step & 3] ? RT_HIGH : RT_LOW, chip->now);
    rt_pin_drive(chip, (rt_pin)(RT_PIN_ENCODER_B0 + encoder), b[step & 3] ? RT_HIGH : RT_LOW, chip->now);
    rt_chip_pass_us(chip, 1);
}

static void every_decoder_counts_from_its_first_value(void **state)
{
    static const uint32_t bases[RT_DECODERS] = {BASE_ENC1, BASE_ENC2, BASE_ENC3, BASE_ENC4};
    static const uint8_t from[RT_DECODERS][2] = {{6, 7}, {8, 9}, {22, 23}, {14, 15}};
    rt_chip *chip = *state;
    route_all(chip);
    for (uint32_t i = 0; i < RT_DECODERS; i++) {
        connect(chip, 66 + 5 * i, from[i][0]);
        connect(chip, 67 + 5 * i, from[i][1]);
        wr16(chip, bases[i], ENC_FILT, BITS(ENC_FILT_FILT_CNT, 2) | BITS(ENC_FILT_FILT_PER, 6));
        wr16(chip, bases[i], ENC_UINIT, 0x1234);
        wr16(chip, bases[i], ENC_LINIT, 0xfffe);
        step_to(chip, i, 0);
        wr16(chip, bases[i], ENC_CTRL, MASK(ENC_CTRL_SWIP));
        assert_int_equal(rd16(chip, bases[i], ENC_CTRL), 0);
        for (int step = 1; step <= 5; step++) step_to(chip, i, step);
        wr16(chip, bases[i], ENC_CTRL, 0); /* without SWIP the count stays */
        assert_int_equal(rd16(chip, bases[i], ENC_LPOS), 3);
        assert_int_equal(rd16(chip, bases[i], ENC_UPOSH), 0x1235);
        for (int step = 4; step >= -3; step--) step_to(chip, i, step);
        assert_int_equal(rd16(chip, bases[i], ENC_LPOS), 0xfffb);
        assert_int_equal(rd16(chip, bases[i], ENC_UPOSH), 0x1234);
        assert_int_equal(rd16(chip, bases[i], ENC_CTRL2), 0);
        step_to(chip, i, -1); /* both phases at once */
        assert_int_equal(rd16(chip, bases[i], ENC_CTRL2), MASK(ENC_CTRL2_SABIRQ));
        wr16(chip, bases[i], ENC_CTRL2, MASK(ENC_CTRL2_SABIRQ));
        assert_int_equal(rd16(chip, bases[i], ENC_CTRL2), 0);
    }
}

/* A filter of (FILT_CNT + 3) samples, FILT_PER clocks apart, at 99 MHz: 5 samples of 200 clocks are 10.1 us.
 */
static void filter_lets_a_level_pass_after_its_time(void **state)
{
    static const struct {
        uint32_t base, filter, count, encoder;
        int step;
    } places[] = {{BASE_ENC1, ENC_FILT, ENC_LPOS, 0, 1},
                  {BASE_TMR3, TMR_FILT0, TMR_CNTR0, 4, 1},
                  {BASE_TMR3, TMR_FILT0 + TMR_STRIDE_CTRL, TMR_CNTR0, 4, 2},
                  {BASE_TMR3, TMR_FILT0 + 2 * TMR_STRIDE_CTRL, TMR_CNTR0 + 2 * TMR_STRIDE_CTRL, 5, 1},
                  {BASE_TMR3, TMR_FILT0 + 3 * TMR_STRIDE_CTRL, TMR_CNTR0 + 2 * TMR_STRIDE_CTRL, 5, 2},
                  {BASE_TMR1, TMR_FILT0, TMR_CNTR0, 6, 1},
                  {BASE_TMR1, TMR_FILT0 + TMR_STRIDE_CTRL, TMR_CNTR0, 6, 2}};
    rt_chip *chip = *state;
    route_all(chip);
    connect(chip, 66, 6);
    connect(chip, 67, 7);
    const uint32_t first = BITS(TMR_CTRL0_CM, 4) | BITS(TMR_CTRL0_PCS, 0) | BITS(TMR_CTRL0_SCS, 1);
    wr16(chip, BASE_TMR3, TMR_CTRL0, first);
    wr16(chip, BASE_TMR1, TMR_CTRL0, first);
    wr16(chip, BASE_TMR3, TMR_CTRL0 + 2 * TMR_STRIDE_CTRL,
         BITS(TMR_CTRL0_CM, 4) | BITS(TMR_CTRL0_PCS, 2) | BITS(TMR_CTRL0_SCS, 3));
    wr16(chip, BASE_TMR3, TMR_ENBL, 5);
    wr16(chip, BASE_TMR1, TMR_ENBL, 1);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        step_to(chip, places[i].encoder, places[i].step - 1);
        rt_chip_pass_us(chip, 20);
        uint32_t before = rd16(chip, places[i].base, places[i].count);
        wr16(chip, places[i].base, places[i].filter,
             BITS(ENC_FILT_FILT_CNT, 2) | BITS(ENC_FILT_FILT_PER, 200));
        step_to(chip, places[i].encoder, places[i].step);
        rt_chip_pass_us(chip, 9);
        assert_int_equal(rd16(chip, places[i].base, places[i].count), before);
        rt_chip_pass_us(chip, 0.3);
        assert_int_equal(rd16(chip, places[i].base, places[i].count), (before + 1) & 0xffff);
        wr16(chip, places[i].base, places[i].filter, 0);
    }
}

static void every_timer_counts_and_stands_without_its_enable_bit(void **state)
{
    static const struct {
        uint32_t base, channel, encoder;
    } timers[RT_TIMER_CHANNELS] = {{BASE_TMR3, 0, 4}, {BASE_TMR3, 2, 5}, {BASE_TMR1, 0, 6}};
    rt_chip *chip = *state;
    route_all(chip);
    for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++) {
        uint32_t at = timers[i].base + timers[i].channel * TMR_STRIDE_CTRL;
        wr16(chip, at, TMR_FILT0, BITS(TMR_FILT0_FILT_CNT, 2) | BITS(TMR_FILT0_FILT_PER, 6));
        wr16(chip, at, TMR_FILT0 + TMR_STRIDE_CTRL,
             BITS(TMR_FILT0_FILT_CNT, 2) | BITS(TMR_FILT0_FILT_PER, 6));
        wr16(chip, at, TMR_CNTR0, 0xffff);
        step_to(chip, timers[i].encoder, 0);
        for (uint32_t wrong = 0; wrong < 4; wrong++) { /* mode, first input, second input, enable bit */
            uint32_t control = BITS(TMR_CTRL0_CM, wrong == 0 ? 5 : 4) |
                               BITS(TMR_CTRL0_PCS, timers[i].channel + (wrong == 1 ? 1 : 0)) |
                               BITS(TMR_CTRL0_SCS, (timers[i].channel + (wrong == 2 ? 0 : 1)) & 3u);
            wr16(chip, at, TMR_CTRL0, control);
            wr16(chip, timers[i].base, TMR_ENBL, wrong == 3 ? 0 : 1u << timers[i].channel);
            step_to(chip, timers[i].encoder, 1);
            step_to(chip, timers[i].encoder, 2);
            assert_int_equal(rd16(chip, at, TMR_CNTR0), 0xffff);
            step_to(chip, timers[i].encoder, 1);
            step_to(chip, timers[i].encoder, 0);
        }
        wr16(chip, timers[i].base, TMR_ENBL, 1u << timers[i].channel);
        for (int step = 1; step <= 4; step++) step_to(chip, timers[i].encoder, step);
        assert_int_equal(rd16(chip, at, TMR_CNTR0), 3);
        for (int step = 3; step >= -4; step--) step_to(chip, timers[i].encoder, step);
        assert_int_equal(rd16(chip, at, TMR_CNTR0), 0xfffb);
    }
}

/* --- motors --- */
static const struct {
    uint32_t base, module, submodule, is_b;
} motors[6] = {{BASE_PWM2, 0, 2, 0}, {BASE_PWM2, 0, 2, 1}, {BASE_PWM2, 0, 3, 0},
               {BASE_PWM2, 0, 3, 1}, {BASE_PWM3, 1, 1, 0}, {BASE_PWM3, 1, 1, 1}};

static bool has_duty(rt_chip *chip, size_t i, double duty)
{
    double is = rt_pwm_duty(chip, motors[i].module, motors[i].submodule, motors[i].is_b != 0);
    return fabs(is - duty) < 1e-12;
}

static void start_motors(rt_chip *chip)
{
    route_all(chip);
    connect(chip, 49, 17);
    connect(chip, 56, 17);
    rt_pin_drive(chip, RT_PIN_FAULT, RT_HIGH, chip->now);
    for (size_t i = 0; i < 6; i++) {
        uint32_t base = motors[i].base, at = base + motors[i].submodule * PWM_STRIDE_SMCTRL;
        uint32_t bit = 1u << motors[i].submodule;
        wr16(chip, at, PWM_SMCTRL2_0, MASK(PWM_SMCTRL2_0_INDEP));
        wr16(chip, at, PWM_SMINIT_0, 100);
        wr16(chip, at, PWM_SMVAL1_0, 1099);
        wr16(chip, at, motors[i].is_b ? PWM_SMVAL4_0 : PWM_SMVAL2_0, 200);
        wr16(chip, at, motors[i].is_b ? PWM_SMVAL5_0 : PWM_SMVAL3_0, 300 + 100 * (uint32_t)i);
        wr16(chip, at, PWM_SMDISMAP0_0, 0x111);
        wr16(chip, base, PWM_FCTRL0, BITS(PWM_FCTRL0_FSAFE, 1));
        wr16(chip, base, PWM_FSTS0, BITS(PWM_FSTS0_FFULL, 1) | BITS(PWM_FSTS0_FFLAG, 1));
        wr16(chip, base, PWM_MCTRL, rd16(chip, base, PWM_MCTRL) | BITS(PWM_MCTRL_RUN, bit));
        wr16(chip, base, PWM_MCTRL, rd16(chip, base, PWM_MCTRL) | BITS(PWM_MCTRL_LDOK, bit));
    }
}

static void every_motor_has_its_duty_when_it_is_on(void **state)
{
    rt_chip *chip = *state;
    start_motors(chip);
    assert_int_equal(rd16(chip, BASE_PWM2, PWM_MCTRL), 0xc00); /* both run, and no value waits */
    assert_int_equal(rd16(chip, BASE_PWM3, PWM_MCTRL), 0x200);
    for (size_t i = 0; i < 6; i++) {
        uint32_t bit = 1u << motors[i].submodule, base = motors[i].base;
        assert_true(has_duty(chip, i, 0));
        wr16(chip, base, PWM_OUTEN,
             motors[i].is_b ? BITS(PWM_OUTEN_PWMB_EN, bit) : BITS(PWM_OUTEN_PWMA_EN, bit));
        assert_true(has_duty(chip, i, 0.1 + 0.1 * (double)i));
        for (size_t k = 0; k < 6; k++)
            if (k != i && motors[k].base == base) assert_true(has_duty(chip, k, 0));
        wr16(chip, base, PWM_MCTRL, 0);
        assert_true(has_duty(chip, i, 0));
        wr16(chip, base, PWM_MCTRL, 0xf00);
        wr16(chip, base, PWM_OUTEN, 0);
    }
}

static void waiting_values_can_be_taken_back(void **state)
{
    rt_chip *chip = *state;
    uint32_t at = BASE_PWM2 + 2 * PWM_STRIDE_SMCTRL;
    wr16(chip, BASE_PWM2, PWM_MCTRL, BITS(PWM_MCTRL_LDOK, 4)); /* it does not run, so LDOK waits */
    assert_int_equal(rd16(chip, BASE_PWM2, PWM_MCTRL), BITS(PWM_MCTRL_LDOK, 4));
    wr16(chip, at, PWM_SMVAL3_0, 5);
    assert_int_equal(rd16(chip, at, PWM_SMVAL3_0), 0);
    wr16(chip, BASE_PWM2, PWM_MCTRL, BITS(PWM_MCTRL_CLDOK, 4));
    assert_int_equal(rd16(chip, BASE_PWM2, PWM_MCTRL), 0);
    wr16(chip, at, PWM_SMVAL3_0, 5);
    assert_int_equal(rd16(chip, at, PWM_SMVAL3_0), 5);
}

/* Each motor, each bit of its fault map and of the fault's control, in both modules. */
static void fault_acts_on_each_output_as_its_map_says(void **state)
{
    rt_chip *chip = *state;
    start_motors(chip);
    for (size_t i = 0; i < 6; i++) {
        uint32_t base = motors[i].base, at = base + motors[i].submodule * PWM_STRIDE_SMCTRL;
        double duty = 0.1 + 0.1 * (double)i;
        const uint32_t clear = BITS(PWM_FSTS0_FFULL, 1) | BITS(PWM_FSTS0_FFLAG, 1);
        wr16(chip, base, PWM_OUTEN, 0xff0);
        rt_pin_drive(chip, RT_PIN_FAULT, RT_LOW, chip->now);
        assert_true(has_duty(chip, i, 0));
        assert_int_equal(rd16(chip, base, PWM_FSTS0), 0x111);
        wr16(chip, at, PWM_SMDISMAP0_0, 0x111 & ~(motors[i].is_b ? 0x10u : 1u));
        assert_true(has_duty(chip, i, duty));
        wr16(chip, at, PWM_SMDISMAP0_0, 0x111);
        wr16(chip, base, PWM_FSTS0, clear);
        assert_int_equal(rd16(chip, base, PWM_FSTS0), 0x110); /* the flag goes, the input stays */
        assert_true(has_duty(chip, i, 0));
        rt_pin_drive(chip, RT_PIN_FAULT, RT_HIGH, chip->now);
        rt_pin_drive(chip, RT_PIN_FAULT, RT_LOW, chip->now);
        rt_pin_drive(chip, RT_PIN_FAULT, RT_HIGH, chip->now);
        wr16(chip, base, PWM_FSTS0, BITS(PWM_FSTS0_FFULL, 1)); /* a zero clears nothing */
        assert_int_equal(rd16(chip, base, PWM_FSTS0), 0x11);
        assert_true(has_duty(chip, i, 0));
        wr16(chip, base, PWM_FSTS0, clear);
        assert_int_equal(rd16(chip, base, PWM_FSTS0), 0x10);
        assert_true(has_duty(chip, i, duty));
        wr16(chip, base, PWM_FCTRL0, BITS(PWM_FCTRL0_FLVL, 1)); /* now the high level is the fault */
        assert_true(has_duty(chip, i, 0));
        wr16(chip, base, PWM_FCTRL0, BITS(PWM_FCTRL0_FSAFE, 1) | BITS(PWM_FCTRL0_FAUTO, 1));
        assert_true(has_duty(chip, i, duty)); /* comes back by itself */
        wr16(chip, base, PWM_FCTRL0, BITS(PWM_FCTRL0_FSAFE, 1));
        wr16(chip, base, PWM_FSTS0, clear);
    }
}

/* --- converters --- */
static void every_channel_converts_its_pin(void **state)
{
    static const struct {
        uint32_t base, channel, pin;
    } channels[] = {{BASE_ADC1, 12, RT_PIN_FORCE0},       {BASE_ADC1, 11, RT_PIN_FORCE0 + 1},
                    {BASE_ADC1, 15, RT_PIN_FORCE0 + 2},   {BASE_ADC1, 13, RT_PIN_CURRENT0},
                    {BASE_ADC1, 14, RT_PIN_CURRENT0 + 1}, {BASE_ADC1, 9, RT_PIN_CURRENT0 + 2},
                    {BASE_ADC1, 0, RT_PIN_PRESSURE},      {BASE_ADC2, 0, RT_PIN_PRESSURE},
                    {BASE_ADC2, 3, RT_PIN_SUPPLY}};
    rt_chip *chip = *state;
    route_all(chip);
    const uint32_t setting = BITS(ADC_CFG_MODE, 2) | BITS(ADC_CFG_ADICLK, 1) | BITS(ADC_CFG_ADIV, 1);
    for (uint32_t base = BASE_ADC1; base <= BASE_ADC2; base += BASE_ADC2 - BASE_ADC1) {
        wr(chip, base, ADC_CFG, setting);
        wr(chip, base, ADC_GC, MASK(ADC_GC_CAL));
        rt_chip_pass_us(chip, 560); /* 14,000 clocks of 24.75 MHz are 566 us */
        assert_int_equal(rd(chip, base, ADC_GC), MASK(ADC_GC_CAL));
        rt_chip_pass_us(chip, 10);
        assert_int_equal(rd(chip, base, ADC_GC), 0);
        assert_int_equal(rd(chip, base, ADC_GS), 0);
    }
    for (uint32_t i = 0; i < sizeof channels / sizeof channels[0]; i++) {
        uint32_t base = channels[i].base, counts = 300 + 400 * i;
        rt_pin_volts(chip, (rt_pin)channels[i].pin, counts * 3.3 / 4095);
        wr(chip, base, ADC_HC0, channels[i].channel);
        rt_chip_pass_us(chip, 0.9); /* 25 clocks are 1.01 us */
        assert_int_equal(rd(chip, base, ADC_HS), 0);
        rt_chip_pass_us(chip, 0.2);
        assert_int_equal(rd(chip, base, ADC_HS), 1);
        assert_int_equal(rd(chip, base, ADC_R0), counts);
        assert_int_equal(rd(chip, base, ADC_HS), 0);
        wr(chip, base, ADC_CFG, setting | BITS(ADC_CFG_AVGS, 1)); /* 8 samples */
        wr(chip, base, ADC_GC, MASK(ADC_GC_AVGE));
        wr(chip, base, ADC_HC0, channels[i].channel);
        rt_chip_pass_us(chip, 8);
        assert_int_equal(rd(chip, base, ADC_HS), 0);
        rt_chip_pass_us(chip, 0.2);
        assert_int_equal(rd(chip, base, ADC_HS), 1);
        wr(chip, base, ADC_GC, 0);
        wr(chip, base, ADC_CFG, setting);
    }
}

static void conversion_within_a_calibration_spoils_it(void **state)
{
    rt_chip *chip = *state;
    route_all(chip);
    for (uint32_t base = BASE_ADC1; base <= BASE_ADC2; base += BASE_ADC2 - BASE_ADC1) {
        wr(chip, base, ADC_CFG, BITS(ADC_CFG_MODE, 2) | BITS(ADC_CFG_ADICLK, 1) | BITS(ADC_CFG_ADIV, 1));
        wr(chip, base, ADC_GC, MASK(ADC_GC_CAL));
        wr(chip, base, ADC_HC0, 0);
        assert_int_equal(rd(chip, base, ADC_GC), 0);
        assert_int_equal(rd(chip, base, ADC_GS), MASK(ADC_GS_CALF));
        wr(chip, base, ADC_GS, MASK(ADC_GS_CALF));
        assert_int_equal(rd(chip, base, ADC_GS), 0);
    }
}

/* --- FlexSPI2: each of the 16 sequences, and each of its four words --- */
static void every_sequence_reads_the_memory(void **state)
{
    rt_chip *chip = *state;
    route_all(chip);
    for (size_t i = 0; i < PINS; i++)
        if (pins[i].pin >= RT_PIN_MEMORY0) wr(chip, BASE_IOMUXC, pins[i].mux, pins[i].mode | SION);
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_FLEXSPI2_PODF, 4));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTKEY, 0x5af05af0u);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTCR, MASK(FLEXSPI_LUTCR_UNLOCK));
    chip->psram.has_four_lines = true;
    for (uint32_t i = 0; i < 16; i++) {
        uint32_t value = 0, at = FLEXSPI_LUT_0 + 16 * i;
        wr(chip, BASE_FLEXSPI2, FLEXSPI_MCR0, MASK(FLEXSPI_MCR0_MDIS) | BITS(FLEXSPI_MCR0_RXCLKSRC, 1));
        wr(chip, BASE_FLEXSPI2, FLEXSPI_FLSHCR2_0, BITS(FLEXSPI_FLSHCR2_0_ARDSEQID, i));
        wr(chip, BASE_FLEXSPI2, FLEXSPI_MCR0, BITS(FLEXSPI_MCR0_RXCLKSRC, 1));
        wr(chip, BASE_FLEXSPI2, at, 0x0a180000u | 0x06ebu);      /* command 0xeb, address, four lines */
        wr(chip, BASE_FLEXSPI2, at + 4, 0x32010000u | 0x3201u);  /* two clocks of waiting */
        wr(chip, BASE_FLEXSPI2, at + 8, 0x32010000u | 0x3202u);  /* three */
        wr(chip, BASE_FLEXSPI2, at + 12, 0x26040000u | 0x3201u); /* one, and data */
        chip->psram.memory[4 * i] = (uint8_t)(7 * i + 1);
        assert_true(rt_flexspi_access(chip, RT_PSRAM_BEGIN + 4 * i, 1, false, &value));
        assert_int_equal(value, 7 * i + 1);
        wr(chip, BASE_FLEXSPI2, at, 0);
    }
}

#define ON(test) cmocka_unit_test_setup_teardown(test, open_chip, close_chip)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON(every_pin_is_connected_by_its_own_setting_alone),
        ON(open_pin_has_the_level_of_its_resistor),
        ON(registers_of_pins_keep_what_is_written),
        ON(outputs_follow_their_bit_when_they_are_outputs),
        ON(inputs_are_read_as_the_rig_drives_them),
        ON(every_decoder_counts_from_its_first_value),
        ON(filter_lets_a_level_pass_after_its_time),
        ON(every_timer_counts_and_stands_without_its_enable_bit),
        ON(every_motor_has_its_duty_when_it_is_on),
        ON(waiting_values_can_be_taken_back),
        ON(fault_acts_on_each_output_as_its_map_says),
        ON(every_channel_converts_its_pin),
        ON(conversion_within_a_calibration_spoils_it),
        ON(every_sequence_reads_the_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
