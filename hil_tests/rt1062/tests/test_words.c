/* Claim: every register of the model that keeps what is written to it has its reset value, and keeps each of
 * its fields and nothing else. Reset values: reference manual, from memory; those marked ROM are what the
 * boot ROM leaves, as we assume it. */
#include "hil_tests/rt1062/tests/chip_room.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define SCB 0xe000ed00u
#define SUB(NUMBER, OFFSET) ((NUMBER)*PWM_STRIDE_SMCTRL + (OFFSET))

/* `count` registers from `address` on, `stride` bytes apart; `keeps`: the bits that read as they were
 * written. */
typedef struct row {
    const char *name;
    uint32_t address, bytes, reset, keeps, count, stride;
} row;

static const row plain[] = {
    {"CCM_CACRR", BASE_CCM + CCM_CACRR, 4, 1, 7, 1, 0},
    {"CCM_CBCDR", BASE_CCM + CCM_CBCDR, 4, 0x300, 0x3a001f00, 1, 0},   /* ROM */
    {"CCM_CBCMR", BASE_CCM + CCM_CBCMR, 4, 0x40000, 0xe00c3300, 1, 0}, /* ROM */
    {"CCM_CSCMR1", BASE_CCM + CCM_CSCMR1, 4, 0, 0x7f, 1, 0},
    {"CCM_CSCDR1", BASE_CCM + CCM_CSCDR1, 4, 0, 0x7f, 1, 0},
    {"CCM_ANALOG_PLL_ARM", BASE_CCM_ANALOG + CCM_ANALOG_PLL_ARM, 4, 0x13063, 0x1307f, 1, 0},
    {"CCM_ANALOG_PLL_USB1", BASE_CCM_ANALOG + CCM_ANALOG_PLL_USB1, 4, 0x3000, 0x13042, 1, 0},
    {"CCM_ANALOG_PLL_SYS", BASE_CCM_ANALOG + CCM_ANALOG_PLL_SYS, 4, 0x2001, 0x13001, 1, 0},
    {"CCM_ANALOG_PFD_528", BASE_CCM_ANALOG + CCM_ANALOG_PFD_528, 4, 0x1018101b, 0xbfbfbfbf, 1, 0},
    {"PMU_REG_3P0", BASE_CCM_ANALOG + PMU_REG_3P0, 4, 0, 1, 1, 0},
    {"DCDC_REG3", BASE_DCDC + DCDC_REG3, 4, 12, 0x1f, 1, 0}, /* TRG 1.1 V */
    {"IOMUXC_GPR_GPR6", BASE_IOMUXC_GPR + IOMUXC_GPR_GPR6, 4, 0, 0xffffffff, 1, 0},
    {"IOMUXC_GPR_GPR14", BASE_IOMUXC_GPR + IOMUXC_GPR_GPR14, 4, 0x880000, 0xff0000, 1, 0},
    {"IOMUXC_GPR_GPR16", BASE_IOMUXC_GPR + IOMUXC_GPR_GPR16, 4, 0x200003, 7, 1, 0},
    {"IOMUXC_GPR_GPR17", BASE_IOMUXC_GPR + IOMUXC_GPR_GPR17, 4, 0, 0xffffffff, 1, 0},
    {"IOMUXC_GPR_GPR26 to 29", BASE_IOMUXC_GPR + IOMUXC_GPR_GPR26, 4, 0, 0xffffffff, 4, 4},
    {"PIT_MCR", BASE_PIT + PIT_MCR, 4, 2, 3, 1, 0},
    {"PIT_LDVAL", BASE_PIT + PIT_LDVAL_0, 4, 0, 0xffffffff, 1, 0},
    {"PIT_TCTRL", BASE_PIT + PIT_TCTRL_0, 4, 0, 3, 1, 0},
    {"GPT_CR", BASE_GPT1 + GPT_CR, 4, 0, 0x3ff, 1, 0},
    {"GPT_PR", BASE_GPT1 + GPT_PR, 4, 0, 0xfff, 1, 0},
    {"WDOG_WCR", BASE_WDOG1 + WDOG_WCR, 2, 0x30, 0xff00, 1, 0},
    {"WDOG_WMCR", BASE_WDOG1 + WDOG_WMCR, 2, 1, 1, 1, 0},
    {"GPIO1_DR, GDIR", BASE_GPIO1, 4, 0, 0xffffffff, 2, 4},
    {"GPIO2_DR, GDIR", BASE_GPIO2, 4, 0, 0xffffffff, 2, 4},
    {"GPIO3_DR, GDIR", BASE_GPIO3, 4, 0, 0xffffffff, 2, 4},
    {"LPUART_BAUD", BASE_LPUART6 + LPUART_BAUD, 4, 0x0f000004, 0x1f001fff, 1, 0},
    {"LPUART_CTRL", BASE_LPUART6 + LPUART_CTRL, 4, 0, 0x80000, 1, 0},
    {"XBARA1_SEL", BASE_XBARA1, 2, 0, 0x7f7f, RT_CROSSBAR_OUTPUTS / 2, 2},
    {"ENC_FILT", BASE_ENC1 + ENC_FILT, 2, 0, 0x7ff, RT_DECODERS, 0x4000},
    {"ENC_CTRL", BASE_ENC1 + ENC_CTRL, 2, 0, 0xf7ff, RT_DECODERS, 0x4000},
    {"TMR1_CNTR0", BASE_TMR1 + TMR_CNTR0, 2, 0, 0xffff, 1, 0},
    {"TMR3_CNTR0, 2", BASE_TMR3 + TMR_CNTR0, 2, 0, 0xffff, 2, 2 * TMR_STRIDE_CTRL},
    {"TMR3_FILT0 to 3", BASE_TMR3 + TMR_FILT0, 2, 0, 0x7ff, 4, TMR_STRIDE_CTRL},
    {"TMR1_FILT0, 1", BASE_TMR1 + TMR_FILT0, 2, 0, 0x7ff, 2, TMR_STRIDE_CTRL},
    {"TMR3_CTRL0, 2", BASE_TMR3 + TMR_CTRL0, 2, 0, 0xff80, 2, 2 * TMR_STRIDE_CTRL},
    {"TMR1_CTRL0", BASE_TMR1 + TMR_CTRL0, 2, 0, 0xff80, 1, 0},
    {"TMR3_ENBL", BASE_TMR3 + TMR_ENBL, 2, 0, 5, 1, 0},
    {"TMR1_ENBL", BASE_TMR1 + TMR_ENBL, 2, 0, 1, 1, 0},
    {"PWM2_SMINIT", BASE_PWM2 + PWM_SMINIT_0, 2, 0, 0xffff, 4, PWM_STRIDE_SMCTRL},
    {"PWM2_SMCTRL2", BASE_PWM2 + PWM_SMCTRL2_0, 2, 0, 0x2000, 4, PWM_STRIDE_SMCTRL},
    {"PWM2_SMCTRL", BASE_PWM2 + PWM_SMCTRL_0, 2, 0x400, 0x400, 4, PWM_STRIDE_SMCTRL},
    {"PWM2_SMVAL0 to 5 of 0", BASE_PWM2 + SUB(0, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM2_SMVAL0 to 5 of 1", BASE_PWM2 + SUB(1, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM2_SMVAL0 to 5 of 2", BASE_PWM2 + SUB(2, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM2_SMVAL0 to 5 of 3", BASE_PWM2 + SUB(3, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM2_SMDISMAP", BASE_PWM2 + PWM_SMDISMAP0_0, 2, 0xffff, 0xfff, 4, PWM_STRIDE_SMCTRL},
    {"PWM3_SMINIT", BASE_PWM3 + PWM_SMINIT_0, 2, 0, 0xffff, 4, PWM_STRIDE_SMCTRL},
    {"PWM3_SMCTRL2", BASE_PWM3 + PWM_SMCTRL2_0, 2, 0, 0x2000, 4, PWM_STRIDE_SMCTRL},
    {"PWM3_SMCTRL", BASE_PWM3 + PWM_SMCTRL_0, 2, 0x400, 0x400, 4, PWM_STRIDE_SMCTRL},
    {"PWM3_SMVAL0 to 5 of 0", BASE_PWM3 + SUB(0, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM3_SMVAL0 to 5 of 2", BASE_PWM3 + SUB(2, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM3_SMVAL0 to 5 of 3", BASE_PWM3 + SUB(3, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM3_SMVAL0 to 5 of 1", BASE_PWM3 + SUB(1, PWM_SMVAL0_0), 2, 0, 0xffff, 6, 4},
    {"PWM3_SMDISMAP", BASE_PWM3 + PWM_SMDISMAP0_0, 2, 0xffff, 0xfff, 4, PWM_STRIDE_SMCTRL},
    {"PWM_OUTEN", BASE_PWM2 + PWM_OUTEN, 2, 0, 0xff0, 2, 0x4000},
    {"PWM_MCTRL RUN", BASE_PWM2 + PWM_MCTRL, 2, 0, 0xf00, 2, 0x4000},
    {"PWM_FCTRL", BASE_PWM2 + PWM_FCTRL0, 2, 0, 0xfff0, 2, 0x4000},
    {"PWM_FSTS FFULL", BASE_PWM2 + PWM_FSTS0, 2, 0, 0xf0, 2, 0x4000},
    {"PWM_FFILT", BASE_PWM2 + PWM_FFILT0, 2, 0, 0x7ff, 2, 0x4000},
    {"ADC_HC0", BASE_ADC1 + ADC_HC0, 4, 31, 31, 2, 0x4000},
    {"ADC_CFG", BASE_ADC1 + ADC_CFG, 4, 0, 0xc47f, 2, 0x4000},
    {"ADC_GC AVGE", BASE_ADC1 + ADC_GC, 4, 0, 0x20, 2, 0x4000},
    {"FLEXSPI_MCR0", BASE_FLEXSPI2 + FLEXSPI_MCR0, 4, 2, 0x32, 1, 0},
    {"FLEXSPI_AHBCR", BASE_FLEXSPI2 + FLEXSPI_AHBCR, 4, 0, 0x58, 1, 0},
    {"FLEXSPI_FLSHA1CR0", BASE_FLEXSPI2 + FLEXSPI_FLSHA1CR0, 4, 0x10000, 0x7fffff, 1, 0},
    {"FLEXSPI_FLSHCR1", BASE_FLEXSPI2 + FLEXSPI_FLSHCR1_0, 4, 0x63, 0x3ff, 1, 0},
    {"FLEXSPI_FLSHCR2", BASE_FLEXSPI2 + FLEXSPI_FLSHCR2_0, 4, 0, 0xf0f, 1, 0},
    {"USB_USBCMD RS, ITC", BASE_USB1 + USB_USBCMD, 4, 8 << 16, 0xff2001, 1, 0},
    {"USB_DEVICEADDR", BASE_USB1 + USB_DEVICEADDR, 4, 0, 0, 1, 0},
    {"USB_ENDPTLISTADDR", BASE_USB1 + USB_ASYNCLISTADDR, 4, 0, 0xfffff800, 1, 0},
    {"USB_PORTSC1 PTC", BASE_USB1 + USB_PORTSC1, 4, 0, 0xf0000, 1, 0},
    {"USB_USBMODE", BASE_USB1 + USB_USBMODE, 4, 0, 0xb, 1, 0},
    {"USB_ENDPTCTRL0", BASE_USB1 + USB_ENDPTCTRL0, 4, 0x800080, 0x10001, 1, 0},
    {"USB_ENDPTCTRL1 to 7", BASE_USB1 + USB_ENDPTCTRL_0, 4, 0, 0x8d008d, 7, 4},
    {"VTOR", SCB + 0x08, 4, 0, 0xfffffc00, 1, 0},
    {"SHCSR", SCB + 0x24, 4, 0, 0x70000, 1, 0},
    {"CSSELR", SCB + 0x84, 4, 0, 1, 1, 0},
    {"MPU_CTRL", SCB + 0x94, 4, 0, 7, 1, 0},
    {"DEMCR", SCB + 0xfc, 4, 0, 1 << 24, 1, 0},
};

static const struct {
    uint32_t address, bytes, value;
    const char *name;
} resets[] = {
    {BASE_CCM + CCM_CCGR0 + 12, 4, 0xc0000, "CCGR3: FlexRAM"}, /* ROM, as the next three */
    {BASE_CCM + CCM_CCGR0 + 16, 4, 0x3c, "CCGR4: IOMUXC and its GPR"},
    {BASE_CCM + CCM_CCGR0 + 20, 4, 0x30, "CCGR5: WDOG3"},
    {BASE_CCM + CCM_CCGR0 + 24, 4, 0xc00cc0, "CCGR6: DCDC, FlexSPI, analog part"},
    {BASE_CCM + CCM_CDHIPR, 4, 0, "no handshake runs"},
    {BASE_DCDC + DCDC_REG0, 4, 1u << 31, "the voltage is good"},
    {BASE_RTWDOG + RTWDOG_CS, 4, 0x2920, "RTWDOG_CS"}, /* ROM */
    {BASE_RTWDOG + RTWDOG_TOVAL, 4, 0x400, "RTWDOG_TOVAL"},
    {BASE_SRC + SRC_SRSR, 4, 1, "the cause is power"},
    {BASE_OCOTP + OCOTP_CFG0, 4, 0x4d2a1062, "number of the chip"},
    {BASE_OCOTP + OCOTP_CFG1, 4, 0x01234567, "number of the chip"},
    {BASE_PWM2 + PWM_FSTS0, 2, 0x101, "PWM2: an input at 0 is a fault"},
    {BASE_PWM3 + PWM_FSTS0, 2, 0x101, "PWM3: an input at 0 is a fault"},
    {BASE_USBPHY1 + USBPHY_PWD, 4, 0x1e1c00, "transceiver powered down"},
    {BASE_USBPHY1 + USBPHY_CTRL, 4, 0xc0000000, "transceiver in reset"},
    {BASE_USB1 + USB_USBSTS, 4, 0, "no event of USB"},
    {BASE_USB1 + USB_ENDPTSETUPSTAT, 4, 0, "no setup packet"},
    {BASE_USB1 + USB_ENDPTPRIME, 4, 0, "nothing primed"},
    {BASE_USB1 + USB_ENDPTFLUSH, 4, 0, "nothing flushed"},
    {BASE_USB1 + USB_ENDPTSTAT, 4, 0, "nothing ready"},
    {BASE_USB1 + USB_ENDPTCOMPLETE, 4, 0, "nothing complete"},
    {BASE_PIT + PIT_TFLG_0, 4, 0, "no edge of the millisecond timer"},
    {BASE_ENC1 + ENC_LPOS, 2, 0, "ENC1 at 0"},
    {BASE_ENC2 + ENC_LPOS, 2, 0, "ENC2 at 0"},
    {BASE_ENC3 + ENC_LPOS, 2, 0, "ENC3 at 0"},
    {BASE_ENC4 + ENC_LPOS, 2, 0, "ENC4 at 0"},
    {SCB + 0x14, 4, 0, "no cache"},
    {SCB + 0x28, 4, 0, "no fault"},
    {0xe0001000u, 4, 0, "no cycle counter"},
};

static rt_chip *new_chip(void)
{
    rt_chip *chip = started_chip();
    assert_non_null(chip);
    return chip;
}

static void expect(rt_chip *chip, const char *name, uint32_t address, uint32_t bytes, uint32_t mask,
                   uint32_t value)
{
    uint32_t read = rt_chip_read(chip, address, bytes) & mask;
    if (read != (value & mask)) fail_msg("%s (0x%08x) reads %x, not %x", name, address, read, value & mask);
}

static void state_after_power_up_is_that_of_the_manual(void **state)
{
    (void)state;
    rt_chip *chip = new_chip();
    for (uint32_t gate = CCM_CCGR0; gate <= CCM_CCGR7; gate += 4) {
        bool is_listed = gate >= CCM_CCGR0 + 12 && gate <= CCM_CCGR0 + 24;
        if (!is_listed) expect(chip, "CCGR", BASE_CCM + gate, 4, 0xffffffffu, 0);
    }
    for (size_t i = 0; i < 4; i++)
        expect(chip, resets[i].name, resets[i].address, resets[i].bytes, 0xffffffffu, resets[i].value);
    open_gates(chip);
    for (size_t i = 4; i < sizeof resets / sizeof resets[0]; i++)
        expect(chip, resets[i].name, resets[i].address, resets[i].bytes, 0xffffffffu, resets[i].value);
    for (uint32_t word = 0; word < 8; word++)
        expect(chip, "NVIC_ISER", 0xe000e100u + 4 * word, 4, 0xffffffffu, 0);
    rt_chip_destroy(chip);
}

static void clock_gates_keep_what_is_written(void **state)
{
    (void)state;
    rt_chip *chip = new_chip();
    for (uint32_t gate = CCM_CCGR0; gate <= CCM_CCGR7; gate += 4) {
        rt_chip_write(chip, BASE_CCM + gate, 4, 0xffffffffu);
        expect(chip, "CCGR", BASE_CCM + gate, 4, 0xffffffffu, 0xffffffffu);
        rt_chip_write(chip, BASE_CCM + gate, 4, 0x12345678u);
        expect(chip, "CCGR", BASE_CCM + gate, 4, 0xffffffffu, 0x12345678u);
    }
    rt_chip_destroy(chip);
}

/* Bits that the chip sets by itself: locks, and the state of the fault input. */
static uint32_t own_bits(const row *r)
{
    if (r->address - BASE_CCM_ANALOG < 0x180u) return 1u << 31;
    return r->address == BASE_PWM2 + PWM_FSTS0 ? 0xf0fu : 0;
}

/* The chip is reset before each row, so that no write spoils another register's test. */
static void every_plain_register_has_its_reset_value_and_keeps_its_fields(void **state)
{
    (void)state;
    rt_chip *chip = new_chip();
    for (size_t i = 0; i < sizeof plain / sizeof plain[0]; i++) {
        const row *r = &plain[i];
        rt_chip_reset(chip, RT_RESET_POWER);
        rt_chip_pass_us(chip, 2000);
        open_gates(chip);
        uint32_t width = r->bytes == 2 ? 0xffffu : 0xffffffffu;
        for (uint32_t k = 0; k < r->count; k++) {
            uint32_t at = r->address + k * r->stride;
            expect(chip, r->name, at, r->bytes, width & ~own_bits(r), r->reset);
            rt_chip_write(chip, at, r->bytes, (r->reset ^ r->keeps) & width);
            expect(chip, r->name, at, r->bytes, r->keeps, r->reset ^ r->keeps);
            rt_chip_write(chip, at, r->bytes, r->reset & width);
            expect(chip, r->name, at, r->bytes, r->keeps, r->reset);
        }
    }
    rt_chip_destroy(chip);
}

/* A write to one of the interrupt controller's registers enables, and never disables. */
static void interrupts_are_enabled_by_ones(void **state)
{
    (void)state;
    rt_chip *chip = new_chip();
    for (uint32_t word = 0; word < 8; word++) {
        uint32_t at = 0xe000e100u + 4 * word;
        rt_chip_write(chip, at, 4, 1u << word);
        rt_chip_write(chip, at, 4, 1u << 31);
        expect(chip, "NVIC_ISER", at, 4, 0xffffffffu, 1u << 31 | 1u << word);
    }
    rt_chip_destroy(chip);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(state_after_power_up_is_that_of_the_manual),
        cmocka_unit_test(clock_gates_keep_what_is_written),
        cmocka_unit_test(every_plain_register_has_its_reset_value_and_keeps_its_fields),
        cmocka_unit_test(interrupts_are_enabled_by_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
