/* Claim: each operation of the model takes its time, neither less nor more, and the parts of the chip that
 * test_registers.c leaves out (USB, console, watchdogs, the core's own registers) do what their bits say. */
#include "hil_tests/rt1062/tests/chip_room.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { LIST = RT_OCRAM_BEGIN, TRANSFER = RT_OCRAM_BEGIN + 0x1000, BUFFER = RT_OCRAM_BEGIN + 0x2000 };

/* Bits `mask` of a register are `before` shortly before `us` have passed, and `after` shortly after. */
static void expect_change(rt_chip *chip, uint32_t at, uint32_t mask, uint32_t before, uint32_t after,
                          double us)
{
    rt_chip_pass_us(chip, us * 0.96);
    assert_int_equal(rt_chip_read(chip, at, 4) & mask, before);
    rt_chip_pass_us(chip, us * 0.08);
    assert_int_equal(rt_chip_read(chip, at, 4) & mask, after);
}

/* --- clocks --- */
static void every_pll_locks_after_its_periods_of_the_crystal(void **state)
{
    static const struct {
        uint32_t offset, off, on;
        double us;
    } plls[] = {{CCM_ANALOG_PLL_SYS, 0x3001, 0x2001, 11250 / 24.0},
                {CCM_ANALOG_PLL_USB1, 0x2000, 0x3000, 383 / 24.0},
                {CCM_ANALOG_PLL_ARM, 0x13064, 0x12064, 2250 / 24.0}};
    rt_chip *chip = *state;
    for (int i = 0; i < 3; i++) {
        uint32_t at = BASE_CCM_ANALOG + plls[i].offset;
        rt_chip_write(chip, at, 4, plls[i].off);
        assert_int_equal(rt_chip_read(chip, at, 4), plls[i].off);
        rt_chip_write(chip, at, 4, plls[i].on);
        expect_change(chip, at, 1u << 31, 0, 1u << 31, plls[i].us);
    }
}

static void handshakes_and_voltage_take_their_time(void **state)
{
    rt_chip *chip = *state;
    static const struct {
        uint32_t offset, value, busy;
    } changes[] = {{CCM_CACRR, 0, MASK(CCM_CDHIPR_ARM_PODF_BUSY)},
                   {CCM_CBCDR, 0x700, MASK(CCM_CDHIPR_AHB_PODF_BUSY)}};
    for (int i = 0; i < 2; i++) {
        wr(chip, BASE_CCM, changes[i].offset, changes[i].value);
        expect_change(chip, BASE_CCM + CCM_CDHIPR, 0xffffffffu, changes[i].busy, 0, 1);
    }
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_PERIPH_CLK2_SEL, 1));
    wr(chip, BASE_CCM, CCM_CBCDR, 0x700 | MASK(CCM_CBCDR_PERIPH_CLK_SEL));
    expect_change(chip, BASE_CCM + CCM_CDHIPR, 0xffffffffu, MASK(CCM_CDHIPR_PERIPH_CLK_SEL_BUSY), 0, 1);
    assert_true(fabs(rt_clock_ipg_Hz(chip) - 24e6 / 2 / 4) < 1);
    wr(chip, BASE_DCDC, DCDC_REG3, 18);
    expect_change(chip, BASE_DCDC + DCDC_REG0, 1u << 31, 0, 1u << 31, 50);
}

static void clocks_follow_their_dividers(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CSCMR1, MASK(CCM_CSCMR1_PERCLK_CLK_SEL) | 5);
    assert_true(fabs(rt_clock_perclk_Hz(chip) - 4e6) < 1);
    wr(chip, BASE_CCM, CCM_CSCMR1, 2);
    assert_true(fabs(rt_clock_perclk_Hz(chip) - 33e6) < 1);
    wr(chip, BASE_CCM, CCM_CSCDR1, MASK(CCM_CSCDR1_UART_CLK_SEL) | 3);
    assert_true(fabs(rt_clock_uart_Hz(chip) - 6e6) < 1);
    wr(chip, BASE_CCM, CCM_CSCDR1, 1);
    assert_true(fabs(rt_clock_uart_Hz(chip) - 40e6) < 1);
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_FLEXSPI2_PODF, 3));
    assert_true(fabs(rt_clock_flexspi2_Hz(chip) - 99e6) < 1);
    wr(chip, BASE_CCM, CCM_CBCMR,
       BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_FLEXSPI2_CLK_SEL, 1));
    assert_true(rt_clock_flexspi2_Hz(chip) == 0);
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PFD_528, 0x1024101b); /* share 36 is out of range */
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1));
    assert_true(rt_clock_flexspi2_Hz(chip) == 0);
}

/* --- timers and watchdogs --- */
static void reset_of_the_microsecond_timer_takes_half_a_microsecond(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_GPT1, GPT_PR, 7);
    wr(chip, BASE_GPT1, GPT_CR, MASK(GPT_CR_SWR));
    expect_change(chip, BASE_GPT1 + GPT_CR, MASK(GPT_CR_SWR), MASK(GPT_CR_SWR), 0, 0.5);
    assert_int_equal(rd(chip, BASE_GPT1, GPT_PR), 0);
    wr(chip, BASE_CCM, CCM_CSCMR1, MASK(CCM_CSCMR1_PERCLK_CLK_SEL));
    wr(chip, BASE_GPT1, GPT_PR, 23);
    wr(chip, BASE_GPT1, GPT_CR, BITS(GPT_CR_CLKSRC, 2) | MASK(GPT_CR_EN)); /* without ENMOD it goes on */
    assert_int_equal(rd(chip, BASE_GPT1, GPT_CNT), (uint32_t)(chip->now / RT_INSTANTS_PER_us));
    wr(chip, BASE_GPT1, GPT_CR, 0);
    assert_int_equal(rd(chip, BASE_GPT1, GPT_CNT), 0);
    wr(chip, BASE_GPT1, GPT_CR, BITS(GPT_CR_CLKSRC, 2) | MASK(GPT_CR_ENMOD) | MASK(GPT_CR_EN));
    rt_chip_pass_us(chip, 40.5);
    assert_int_equal(rd(chip, BASE_GPT1, GPT_CNT), 40);
}

static void millisecond_timer_stands_without_each_of_its_bits(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CSCMR1, MASK(CCM_CSCMR1_PERCLK_CLK_SEL));
    wr(chip, BASE_PIT, PIT_LDVAL_0, 24000 - 1);
    wr(chip, BASE_PIT, PIT_TCTRL_0, MASK(PIT_TCTRL_0_TEN)); /* off by MDIS */
    rt_chip_pass_us(chip, 1500);
    assert_int_equal(rd(chip, BASE_PIT, PIT_TFLG_0), 0);
    wr(chip, BASE_PIT, PIT_TCTRL_0, 0);
    wr(chip, BASE_PIT, PIT_MCR, 0);
    rt_chip_pass_us(chip, 1500);
    assert_int_equal(rd(chip, BASE_PIT, PIT_TFLG_0), 0);
    wr(chip, BASE_PIT, PIT_TCTRL_0, MASK(PIT_TCTRL_0_TEN));
    expect_change(chip, BASE_PIT + PIT_TFLG_0, 1, 0, 1, 1000);
    wr(chip, 0xe000e100u, 4 * (122 / 32), 1u << 122 % 32);
    assert_int_equal(rt_chip_interrupt(chip), -1); /* TIE is off */
    wr(chip, BASE_PIT, PIT_TCTRL_0, MASK(PIT_TCTRL_0_TEN) | MASK(PIT_TCTRL_0_TIE));
    assert_int_equal(rt_chip_interrupt(chip), 122);
    wr(chip, BASE_PIT, PIT_TFLG_0, 0); /* a zero clears nothing */
    assert_int_equal(rt_chip_interrupt(chip), 122);
}

static void watchdogs_bite_after_their_time_and_name_themselves(void **state)
{
    rt_chip *chip = *state;
    const uint32_t fixed = MASK(WDOG_WCR_SRS) | MASK(WDOG_WCR_WDA);
    rt_chip_write(chip, BASE_WDOG1 + WDOG_WCR, 2, BITS(WDOG_WCR_WT, 1) | fixed); /* WDE is off */
    assert_int_equal(rt_chip_read(chip, BASE_WDOG1 + WDOG_WCR, 2), BITS(WDOG_WCR_WT, 1) | fixed);
    rt_chip_pass_us(chip, 1.1e6);
    assert_int_equal(chip->reset, RT_RESET_NONE);
    rt_chip_reset(chip, RT_RESET_POWER);
    wr(chip, BASE_CCM, CCM_CCGR0 + 12, 0xffffffffu);
    rt_chip_write(chip, BASE_WDOG1 + WDOG_WCR, 2, BITS(WDOG_WCR_WT, 1) | fixed | MASK(WDOG_WCR_WDE));
    rt_chip_write(chip, BASE_WDOG1 + WDOG_WCR, 2, BITS(WDOG_WCR_WT, 1) | fixed); /* WDE stays */
    assert_int_equal(rt_chip_read(chip, BASE_WDOG1 + WDOG_WCR, 2) & MASK(WDOG_WCR_WDE), MASK(WDOG_WCR_WDE));
    rt_chip_pass_us(chip, 0.96e6);
    assert_int_equal(chip->reset, RT_RESET_NONE);
    rt_chip_pass_us(chip, 0.08e6);
    assert_int_equal(chip->reset, RT_RESET_WDOG1);
    rt_chip_reset(chip, RT_RESET_WDOG1);
    assert_int_equal(rd(chip, BASE_SRC, SRC_SRSR), MASK(SRC_SRSR_WDOG_RST_B));
    wr(chip, BASE_SRC, SRC_SRSR, MASK(SRC_SRSR_WDOG_RST_B));
    assert_int_equal(rd(chip, BASE_SRC, SRC_SRSR), 0);
    wr(chip, BASE_CCM, CCM_CCGR0 + 12, 0xffffffffu);
    rt_chip_write(chip, BASE_WDOG1 + WDOG_WCR, 2, MASK(WDOG_WCR_WDA)); /* SRS 0: at once */
    assert_int_equal(chip->reset, RT_RESET_WDOG1);
}

/* While a debugger halts the processor, the watchdog stands if WDBG allows it. */
static void watchdog_stands_in_debug_if_its_bit_allows_it(void **state)
{
    rt_chip *chip = *state;
    for (uint32_t stands = 0; stands < 2; stands++) {
        rt_chip_reset(chip, RT_RESET_POWER);
        rt_chip_write(chip, BASE_CCM + CCM_CCGR0 + 12, 4, 0xffffffffu);
        rt_chip_write(chip, BASE_WDOG1 + WDOG_WCR, 2,
                      MASK(WDOG_WCR_SRS) | MASK(WDOG_WCR_WDA) | MASK(WDOG_WCR_WDE) |
                          BITS(WDOG_WCR_WDBG, stands));
        rt_watchdogs_halt(chip, RT_INSTANTS_PER_us * 100000);
        rt_chip_pass_us(chip, 0.55e6);
        assert_int_equal(chip->reset, stands ? RT_RESET_NONE : RT_RESET_WDOG1);
    }
}

static void low_power_watchdog_bites_when_it_was_unlocked_and_turned_on(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_RTWDOG, RTWDOG_CNT, 0xd928c520u);
    rt_chip_pass_us(chip, 2.4); /* 255 clocks of 99 MHz are 2.58 us */
    wr(chip, BASE_RTWDOG, RTWDOG_TOVAL, 0x200);
    wr(chip, BASE_RTWDOG, RTWDOG_CS, MASK(RTWDOG_CS_EN) | MASK(RTWDOG_CS_UPDATE));
    assert_int_equal(rd(chip, BASE_RTWDOG, RTWDOG_TOVAL), 0x200);
    assert_int_equal(rd(chip, BASE_RTWDOG, RTWDOG_CS), MASK(RTWDOG_CS_EN) | MASK(RTWDOG_CS_UPDATE));
    rt_chip_pass_us(chip, 0x200 / 32768.0 * 0.96e6);
    assert_int_equal(chip->reset, RT_RESET_NONE);
    rt_chip_pass_us(chip, 0x200 / 32768.0 * 0.08e6);
    assert_int_equal(chip->reset, RT_RESET_RTWDOG);
    rt_chip_reset(chip, RT_RESET_RTWDOG);
    assert_int_equal(rd(chip, BASE_SRC, SRC_SRSR), MASK(SRC_SRSR_WDOG3_RST_B));
    wr(chip, BASE_CCM, CCM_CCGR0 + 20, 0xffffffffu);
    wr(chip, BASE_RTWDOG, RTWDOG_CNT, 0xd928c520u);
    rt_chip_pass_us(chip, 2.8);
    wr(chip, BASE_RTWDOG, RTWDOG_TOVAL, 0x200);
    assert_int_equal(chip->reset, RT_RESET_RTWDOG);
}

/* --- FlexSPI2 --- */
static void controller_of_the_memory_takes_its_time(void **state)
{
    rt_chip *chip = *state;
    wr(chip, BASE_CCM, CCM_CBCMR, BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1) | BITS(CCM_CBCMR_FLEXSPI2_PODF, 4));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_MCR0, MASK(FLEXSPI_MCR0_SWRESET));
    expect_change(chip, BASE_FLEXSPI2 + FLEXSPI_MCR0, 1, 1, 0, 2);
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_STS0), 3);
    for (rt_pin pin = RT_PIN_MEMORY0; pin < RT_PINS; pin++) {
        static const uint32_t rows[7][3] = {{0x70, 0x72c, 1}, {0x74, 0, 0},     {0x78, 0x750, 1},
                                            {0x7c, 0x730, 1}, {0x80, 0x734, 1}, {0x84, 0x738, 1},
                                            {0x88, 0x73c, 1}};
        wr(chip, BASE_IOMUXC, rows[pin - RT_PIN_MEMORY0][0], 8 | 1 << 4);
        if (rows[pin - RT_PIN_MEMORY0][1] != 0)
            wr(chip, BASE_IOMUXC, rows[pin - RT_PIN_MEMORY0][1], rows[pin - RT_PIN_MEMORY0][2]);
    }
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTKEY, 0x5af05af0u);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUTCR, MASK(FLEXSPI_LUTCR_UNLOCK));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_LUT_0 + 16 * 5, 0x0435); /* sequence 5: command 0x35 on one line */
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCR0, 0);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCR1, BITS(FLEXSPI_IPCR1_ISEQID, 5));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCMD, 0); /* no trigger */
    rt_chip_pass_us(chip, 1);
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_INTR), 0);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_IPCMD, 1);
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_STS0), 0);
    /* the select line's 3 + 3 clocks and 8 of the command, at 79.2 MHz */
    expect_change(chip, BASE_FLEXSPI2 + FLEXSPI_INTR, 1, 0, 1, 14 / 79.2);
    assert_true(chip->psram.has_four_lines);
    chip->flexspi.intr |= MASK(FLEXSPI_INTR_IPCMDERR);
    wr(chip, BASE_FLEXSPI2, FLEXSPI_INTR, 1);
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_INTR), MASK(FLEXSPI_INTR_IPCMDERR));
    wr(chip, BASE_FLEXSPI2, FLEXSPI_INTR, MASK(FLEXSPI_INTR_IPCMDERR));
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_INTR), 0);
    assert_int_equal(rd(chip, BASE_FLEXSPI2, FLEXSPI_STS0), 3);
}

/* --- console --- */
static void console_sends_a_byte_in_ten_bits(void **state)
{
    rt_chip *chip = *state;
    static const uint32_t pad[3] = {PAD_AD_B0_02_LPUART6_TX}, daisy[2] = {DAISY_LPUART6_TX_AD_B0_02};
    wr(chip, BASE_IOMUXC, pad[0], pad[1]);
    wr(chip, BASE_IOMUXC, daisy[0], daisy[1]);
    wr(chip, BASE_CCM, CCM_CSCDR1, MASK(CCM_CSCDR1_UART_CLK_SEL));
    wr(chip, BASE_LPUART6, LPUART_BAUD, BITS(LPUART_BAUD_OSR, 25) | 8); /* 24 MHz / 26 / 8 */
    wr(chip, BASE_LPUART6, LPUART_DATA, 'x');                           /* TE is off: lost */
    wr(chip, BASE_LPUART6, LPUART_CTRL, MASK(LPUART_CTRL_TE));
    wr(chip, BASE_LPUART6, LPUART_DATA, 'a');
    wr(chip, BASE_LPUART6, LPUART_DATA, 'b');
    expect_change(chip, BASE_LPUART6 + LPUART_STAT, MASK(LPUART_STAT_TDRE), 0, MASK(LPUART_STAT_TDRE),
                  10 / (24.0 / 26 / 8));
    wr(chip, BASE_LPUART6, LPUART_DATA, 'c');
    assert_int_equal(rd(chip, BASE_LPUART6, LPUART_STAT), 0);
    assert_string_equal(chip->uart.text, "abc");
}

/* --- USB --- */
static void start_transceiver(rt_chip *chip)
{
    wr(chip, BASE_CCM_ANALOG, PMU_REG_3P0, 1);
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_USB1, 0x3040);
    wr(chip, BASE_USBPHY1, USBPHY_CTRL_CLR, MASK(USBPHY_CTRL_SFTRST));
    wr(chip, BASE_USBPHY1, USBPHY_CTRL_CLR, MASK(USBPHY_CTRL_CLKGATE));
    wr(chip, BASE_USBPHY1, USBPHY_PWD, 0);
}

static void transceiver_needs_each_of_its_conditions(void **state)
{
    rt_chip *chip = *state;
    start_transceiver(chip);
    assert_true(rt_usb_phy_runs(chip));
    static const uint32_t pll_wrong[] = {0x3000, 0x2040, 0x1040, 0x13040, 0x3042};
    for (int i = 0; i < 5; i++) {
        wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_USB1, pll_wrong[i]);
        rt_chip_pass_us(chip, 20);
        assert_false(rt_usb_phy_runs(chip));
    }
    wr(chip, BASE_CCM_ANALOG, CCM_ANALOG_PLL_USB1, 0x3040);
    rt_chip_pass_us(chip, 20);
    wr(chip, BASE_CCM_ANALOG, PMU_REG_3P0, 0);
    assert_false(rt_usb_phy_runs(chip));
    wr(chip, BASE_CCM_ANALOG, PMU_REG_3P0, 1);
    wr(chip, BASE_USBPHY1, USBPHY_PWD, 0x400);
    assert_int_equal(rd(chip, BASE_USBPHY1, USBPHY_PWD), 0x400);
    assert_false(rt_usb_phy_runs(chip));
    wr(chip, BASE_USBPHY1, USBPHY_PWD, 0);
    wr(chip, BASE_USBPHY1, USBPHY_CTRL_SET, MASK(USBPHY_CTRL_CLKGATE) | MASK(USBPHY_CTRL_ENUTMILEVEL2));
    assert_false(rt_usb_phy_runs(chip));
    assert_int_equal(rd(chip, BASE_USBPHY1, USBPHY_CTRL),
                     MASK(USBPHY_CTRL_CLKGATE) | MASK(USBPHY_CTRL_ENUTMILEVEL2));
    wr(chip, BASE_USBPHY1, USBPHY_CTRL_CLR, MASK(USBPHY_CTRL_CLKGATE));
    assert_true(rt_usb_phy_runs(chip));
    wr(chip, BASE_USBPHY1, USBPHY_CTRL_SET, MASK(USBPHY_CTRL_SFTRST));
    assert_int_equal(rd(chip, BASE_USBPHY1, USBPHY_PWD), 0x1e1c00);
    assert_false(rt_usb_phy_runs(chip));
}

/* A controller in device mode on an active bus at high speed, whose queue heads lie at LIST. */
static void start_controller(rt_chip *chip)
{
    start_transceiver(chip);
    memset(chip->ocram, 0, 0x3000);
    wr(chip, BASE_USB1, USB_USBCMD, MASK(USB_USBCMD_RST));
    expect_change(chip, BASE_USB1 + USB_USBCMD, MASK(USB_USBCMD_RST), MASK(USB_USBCMD_RST), 0, 5);
    wr(chip, BASE_USB1, USB_USBMODE, 2);
    wr(chip, BASE_USB1, USB_ASYNCLISTADDR, LIST);
    assert_int_equal(rd(chip, BASE_USB1, USB_OTGSC), 0);
    rt_usb_plug(chip, true);
    assert_false(rt_usb_is_attached(chip));
    wr(chip, BASE_USB1, USB_USBCMD, MASK(USB_USBCMD_RS));
    assert_true(rt_usb_is_attached(chip));
    assert_int_equal(rd(chip, BASE_USB1, USB_OTGSC), MASK(USB_OTGSC_BSV));
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_PCI));
    wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_PCI));
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), 0);
    wr(chip, BASE_USB1, USB_DEVICEADDR, 5u << 25);
    rt_usb_bus_reset(chip, true);
    assert_int_equal(rd(chip, BASE_USB1, USB_DEVICEADDR), 0);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_URI));
    wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_URI));
    const uint32_t port = MASK(USB_PORTSC1_CCS) | BITS(USB_PORTSC1_PSPD, 2);
    expect_change(chip, BASE_USB1 + USB_PORTSC1, 0xffffffffu, port | MASK(USB_PORTSC1_PR), port, 10000);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_PCI));
    wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_PCI));
    wr(chip, BASE_USB1, USB_DEVICEADDR, 9u << 25);
}

static uint32_t bit_of(uint32_t endpoint, bool is_in)
{
    return 1u << (endpoint + (is_in ? 16 : 0));
}

static void put(rt_chip *chip, uint32_t address, uint32_t value)
{
    memcpy(chip->ocram + (address - RT_OCRAM_BEGIN), &value, sizeof value);
}

/* Arms a transfer of `bytes` in the buffer, in packets of 64 bytes. */
static void arm(rt_chip *chip, uint32_t endpoint, bool is_in, uint32_t bytes)
{
    uint32_t pipe = 2 * endpoint + (is_in ? 1 : 0), head = LIST + 64 * pipe, transfer = TRANSFER + 32 * pipe;
    put(chip, head, 64u << 16 | 1u << 29);
    put(chip, head + 8, transfer);
    put(chip, transfer, 1);
    put(chip, transfer + 4, bytes << 16 | 1u << 15 | 1u << 7);
    put(chip, transfer + 8, BUFFER);
    wr(chip, BASE_USB1, USB_ENDPTPRIME, bit_of(endpoint, is_in));
    expect_change(chip, BASE_USB1 + USB_ENDPTPRIME, 0xffffffffu, bit_of(endpoint, is_in), 0, 0.5);
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTSTAT), bit_of(endpoint, is_in));
}

static rt_usb_reply token_of(rt_chip *chip, rt_usb_token token, uint32_t endpoint, bool is_data1,
                             uint32_t bytes)
{
    static rt_usb_packet packet;
    packet = (rt_usb_packet){
        .token = token, .address = 9, .endpoint = (uint8_t)endpoint, .is_data1 = is_data1, .bytes = bytes};
    return rt_usb_transact(chip, &packet);
}

static void every_endpoint_moves_its_packets(void **state)
{
    rt_chip *chip = *state;
    start_controller(chip);
    for (uint32_t endpoint = 1; endpoint < RT_USB_ENDPOINTS; endpoint++) {
        uint32_t control = USB_ENDPTCTRL0 + 4 * endpoint;
        assert_int_equal(token_of(chip, RT_TOKEN_IN, endpoint, false, 0), RT_USB_SILENCE);
        assert_int_equal(token_of(chip, RT_TOKEN_OUT, endpoint, false, 3), RT_USB_SILENCE);
        wr(chip, BASE_USB1, control, 0xcc00ccu); /* bulk, both directions, toggles reset */
        assert_int_equal(rd(chip, BASE_USB1, control), 0x8c008c);
        assert_int_equal(token_of(chip, RT_TOKEN_IN, endpoint, false, 0), RT_USB_NAK);
        arm(chip, endpoint, true, 3);
        assert_int_equal(token_of(chip, RT_TOKEN_IN, endpoint, false, 0), RT_USB_DATA0);
        assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCOMPLETE), bit_of(endpoint, true));
        assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTSTAT), 0);
        assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_UI));
        wr(chip, BASE_USB1, USB_ENDPTCOMPLETE, bit_of(endpoint, true));
        wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_UI));
        arm(chip, endpoint, true, 3);
        assert_int_equal(token_of(chip, RT_TOKEN_IN, endpoint, false, 0), RT_USB_DATA1);
        wr(chip, BASE_USB1, USB_ENDPTCOMPLETE, bit_of(endpoint, true));
        arm(chip, endpoint, false, 64);
        assert_int_equal(token_of(chip, RT_TOKEN_OUT, endpoint, true, 3), RT_USB_ACK); /* a repeated one */
        assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCOMPLETE), 0);
        assert_int_equal(token_of(chip, RT_TOKEN_OUT, endpoint, false, 3), RT_USB_ACK);
        assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCOMPLETE), bit_of(endpoint, false));
        wr(chip, BASE_USB1, USB_ENDPTCOMPLETE, bit_of(endpoint, false));
        wr(chip, BASE_USB1, control, 0x8d008c); /* IN stalls */
        assert_int_equal(token_of(chip, RT_TOKEN_IN, endpoint, false, 0), RT_USB_STALL);
        wr(chip, BASE_USB1, control, 0x8c008d); /* OUT stalls */
        assert_int_equal(token_of(chip, RT_TOKEN_OUT, endpoint, true, 3), RT_USB_STALL);
        wr(chip, BASE_USB1, control, 0x8c00cc); /* the toggle of OUT alone */
        arm(chip, endpoint, false, 64);
        assert_int_equal(token_of(chip, RT_TOKEN_OUT, endpoint, false, 3), RT_USB_ACK);
        assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCOMPLETE), bit_of(endpoint, false));
        wr(chip, BASE_USB1, USB_ENDPTCOMPLETE, bit_of(endpoint, false));
        wr(chip, BASE_USB1, control, 0);
        wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_UI));
    }
}

static void flush_ends_what_is_primed(void **state)
{
    rt_chip *chip = *state;
    start_controller(chip);
    wr(chip, BASE_USB1, USB_ENDPTCTRL0 + 8, 0xcc00ccu);
    arm(chip, 2, true, 3);
    wr(chip, BASE_USB1, USB_ENDPTFLUSH, bit_of(2, true));
    expect_change(chip, BASE_USB1 + USB_ENDPTFLUSH, 0xffffffffu, bit_of(2, true), 0, 0.5);
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTSTAT), 0);
    assert_int_equal(token_of(chip, RT_TOKEN_IN, 2, false, 0), RT_USB_NAK);
}

/* The controller owns queue head and descriptor of an endpoint that is ready. */
static void priming_what_is_ready_is_a_finding(void **state)
{
    rt_chip *chip = *state;
    start_controller(chip);
    wr(chip, BASE_USB1, USB_ENDPTCTRL0 + 8, 0xcc00ccu);
    arm(chip, 2, true, 3);
    assert_int_equal(chip->findings_count, 0);
    arm(chip, 2, true, 3);
    assert_int_equal(chip->findings_count, 1);
    assert_non_null(strstr(chip->findings[0].text, "USB1 primes endpoints 0x00040000 anew"));
    chip->findings_count = 0;
}

static void setup_packet_waits_and_clears_the_trip_wire(void **state)
{
    rt_chip *chip = *state;
    start_controller(chip);
    put(chip, LIST, 64u << 16 | 1u << 15);
    wr(chip, BASE_USB1, USB_USBCMD, MASK(USB_USBCMD_RS) | MASK(USB_USBCMD_SUTW));
    assert_int_equal(rd(chip, BASE_USB1, USB_USBCMD), MASK(USB_USBCMD_RS) | MASK(USB_USBCMD_SUTW));
    wr(chip, BASE_USB1, USB_ENDPTCTRL0, 0x10001); /* both directions stall until the next setup packet */
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCTRL0), 0x810081);
    assert_int_equal(token_of(chip, RT_TOKEN_IN, 0, false, 0), RT_USB_STALL);
    assert_int_equal(token_of(chip, RT_TOKEN_SETUP, 0, false, 8), RT_USB_ACK);
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTCTRL0), 0x800080);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBCMD), MASK(USB_USBCMD_RS));
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTSETUPSTAT), 1);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_UI));
    assert_int_equal(token_of(chip, RT_TOKEN_IN, 0, true, 0), RT_USB_NAK);
    wr(chip, BASE_USB1, USB_ENDPTSETUPSTAT, 1);
    assert_int_equal(rd(chip, BASE_USB1, USB_ENDPTSETUPSTAT), 0);
}

static void suspend_is_reported_and_ends(void **state)
{
    rt_chip *chip = *state;
    start_controller(chip);
    rt_usb_suspend(chip, true);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_SLI));
    assert_int_equal(rd(chip, BASE_USB1, USB_PORTSC1) & MASK(USB_PORTSC1_SUSP), MASK(USB_PORTSC1_SUSP));
    wr(chip, BASE_USB1, USB_USBSTS, MASK(USB_USBSTS_SLI));
    rt_usb_suspend(chip, false);
    assert_int_equal(rd(chip, BASE_USB1, USB_PORTSC1) & MASK(USB_PORTSC1_SUSP), 0);
    assert_int_equal(rd(chip, BASE_USB1, USB_USBSTS), MASK(USB_USBSTS_PCI));
    wr(chip, BASE_USB1, USB_USBMODE, 3); /* no device */
    assert_false(rt_usb_is_attached(chip));
}

/* --- the core --- */
static void every_region_of_the_protection_works(void **state)
{
    rt_chip *chip = *state;
    const uint32_t rbar = 0xe000ed9cu, rasr = 0xe000eda0u, size_1_kB = 9 << 1 | 1;
    for (uint32_t i = 0; i < RT_MPU_REGIONS; i++) {
        wr(chip, rbar, 0, (0x20000000u + 1024 * i) | 1u << 4 | i);
        wr(chip, rasr, 0, 7u << 24 | size_1_kB); /* reading alone */
    }
    wr(chip, 0xe000ed94u, 0, 1);
    for (uint32_t i = 0; i < RT_MPU_REGIONS; i++) {
        uint32_t at = 0x20000000u + 1024 * i + 1023;
        assert_true(rt_mpu_allows(chip, at, RT_ACCESS_READ));
        assert_false(rt_mpu_allows(chip, at, RT_ACCESS_WRITE));
        wr(chip, rbar, 0, (at & ~1023u) | 1u << 4 | i);
        wr(chip, rasr, 0, 3u << 24 | 1u << 28 | size_1_kB);
        assert_true(rt_mpu_allows(chip, at, RT_ACCESS_WRITE));
        assert_false(rt_mpu_allows(chip, at, RT_ACCESS_CODE));
        wr(chip, rasr, 0, size_1_kB & ~1u);
        assert_false(rt_mpu_allows(chip, at, RT_ACCESS_READ));
    }
    wr(chip, 0xe000ed94u, 0, 5); /* the background map is there for the rest */
    assert_true(rt_mpu_allows(chip, 0x20000000u, RT_ACCESS_WRITE));
}

static void no_region_is_on_after_a_reset(void **state)
{
    rt_chip *chip = *state;
    wr(chip, 0xe000ed94u, 0, 1);
    assert_false(rt_mpu_allows(chip, 0, RT_ACCESS_READ));
    assert_int_equal(rt_chip_interrupt(chip), -1);
    for (uint32_t i = 0; i < RT_MPU_REGIONS; i++) {
        assert_int_equal(chip->core.size[i] & 1u, 0);
        wr(chip, 0xe000ed9cu, 0, 0x20000000u | 1u << 4 | i);
        assert_false(rt_mpu_allows(chip, 0x20000000u, RT_ACCESS_READ));
    }
}

static void cycle_counter_needs_its_key_and_counts_from_what_is_written(void **state)
{
    rt_chip *chip = *state;
    wr(chip, 0xe000edfcu, 0, 1u << 24);
    wr(chip, 0xe0001fb0u, 0, 0xc5acce55u);
    wr(chip, 0xe0001000u, 0, 1);
    assert_int_equal(rd(chip, 0xe0001000u, 0), 1);
    assert_int_equal(chip->findings_count, 0);
    wr(chip, 0xe0001004u, 0, 1000);
    chip->core.cycles += 77;
    assert_int_equal(rd(chip, 0xe0001004u, 0), 1077);
    wr(chip, 0xe0001fb0u, 0, 0);
    wr(chip, 0xe0001000u, 0, 1);
    assert_int_equal(chip->findings_count, 1);
}

/* 256 sets of 4 ways, and 512 sets of 2 ways; each line must be invalidated before the cache is turned on. */
static void caches_state_their_size_and_must_be_invalidated(void **state)
{
    rt_chip *chip = *state;
    assert_int_equal(rd(chip, 0xe000ed80u, 0), 0xf01fe019u);
    wr(chip, 0xe000ed84u, 0, 1);
    assert_int_equal(rd(chip, 0xe000ed80u, 0), 0xf03fe009u);
    for (uint32_t i = 0; i < 1024; i++)
        wr(chip, 0xe000ef60u, 0, (i & 3u) << 30); /* one set, again and again */
    wr(chip, 0xe000ed14u, 0, 1u << 16);
    assert_int_equal(chip->findings_count, 1);
    chip->findings_count = 0;
    wr(chip, 0xe000ed14u, 0, 0);
    for (uint32_t i = 0; i < 1024; i++) wr(chip, 0xe000ef60u, 0, (i & 3u) << 30 | i / 4 << 5);
    wr(chip, 0xe000ef50u, 0, 0);
    wr(chip, 0xe000ed14u, 0, 3u << 16);
    assert_int_equal(rd(chip, 0xe000ed14u, 0), 3u << 16);
    assert_int_equal(chip->findings_count, 0);
    chip->core.cfsr = 0x8200;
    assert_int_equal(rd(chip, 0xe000ed28u, 0), 0x8200);
    wr(chip, 0xe000ed28u, 0, 0x200);
    assert_int_equal(rd(chip, 0xe000ed28u, 0), 0x8000);
}

#define ON(test) cmocka_unit_test_setup_teardown(test, open_chip, close_chip)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON(every_pll_locks_after_its_periods_of_the_crystal),
        ON(handshakes_and_voltage_take_their_time),
        ON(clocks_follow_their_dividers),
        ON(reset_of_the_microsecond_timer_takes_half_a_microsecond),
        ON(millisecond_timer_stands_without_each_of_its_bits),
        ON(watchdogs_bite_after_their_time_and_name_themselves),
        ON(watchdog_stands_in_debug_if_its_bit_allows_it),
        ON(low_power_watchdog_bites_when_it_was_unlocked_and_turned_on),
        ON(controller_of_the_memory_takes_its_time),
        ON(console_sends_a_byte_in_ten_bits),
        ON(transceiver_needs_each_of_its_conditions),
        ON(every_endpoint_moves_its_packets),
        ON(flush_ends_what_is_primed),
        ON(priming_what_is_ready_is_a_finding),
        ON(setup_packet_waits_and_clears_the_trip_wire),
        ON(suspend_is_reported_and_ends),
        ON(every_region_of_the_protection_works),
        ON(no_region_is_on_after_a_reset),
        ON(cycle_counter_needs_its_key_and_counts_from_what_is_written),
        ON(caches_state_their_size_and_must_be_invalidated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
