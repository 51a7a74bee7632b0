/* Claim: the image that would be flashed boots on the model with every wait answered and no finding, ticks
 * every millisecond, serves its watchdog, and is restarted by it when it does not. A single wrong write to a
 * register keeps it waiting, and the model names the wait or the fault. Time is the chip's own, counted in
 * instructions. */
#define _POSIX_C_SOURCE 200809L
#include "hil_tests/rt1062/tests/image_room.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { BOOT_ms = 200, STEP_ms = 5, UNDEFINED_INSTRUCTION = 0xde00 };

typedef struct rt_board {
    rt_chip *chip;
    rt_engine *engine;
} rt_board;

static void open_board(rt_board *board)
{
    assert_true(begin_image(&board->chip, &board->engine));
    rt_usb_plug(board->chip, true);
}

static void close_board(rt_board *board)
{
    end_image(board->chip, board->engine);
}

static rt_stop run_ms(rt_board *board, double ms)
{
    return rt_engine_run_us(board->engine, ms * 1000);
}

static uint32_t value_of(rt_board *board, const char *name)
{
    return rt_engine_word(board->engine, rt_engine_symbol(board->engine, name));
}

static void image_boots_and_ticks_with_every_wait_answered(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    assert_int_equal(run_ms(&board, BOOT_ms), RT_STOP_TIME);
    uint32_t edges = value_of(&board, "edges"), served = (uint32_t)board.chip->watchdogs.served;
    assert_int_equal(run_ms(&board, 1000), RT_STOP_TIME);
    if (rt_report(board.chip, stderr, rt_engine_place, board.engine) != 0)
        fail_msg("waits or findings are left");
    assert_true(console_says(board.chip, "cournand on imxrt1062: core "));
    assert_true(console_says(board.chip, "serial RT1062-012345674D2A1062\n"));
    assert_false(console_says(board.chip, "PSRAM"));
    assert_int_equal(value_of(&board, "edges"), edges + 1000);
    assert_int_equal(value_of(&board, "edges_done"), edges + 1000);
    assert_int_equal(board.chip->watchdogs.served, served + 1000);
    assert_true(rt_usb_is_attached(board.chip));
    close_board(&board);
}

static void two_runs_are_equal_to_the_last_instruction(void **state)
{
    (void)state;
    uint64_t instructions[2], now[2];
    for (int run = 0; run < 2; run++) {
        rt_board board;
        open_board(&board);
        run_ms(&board, BOOT_ms); /* the same time twice */
        instructions[run] = rt_engine_instructions(board.engine);
        now[run] = board.chip->now;
        close_board(&board);
    }
    assert_true(instructions[0] == instructions[1] && now[0] == now[1]);
}

static void board_without_psram_says_so_and_runs(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    board.chip->psram.is_fitted = false;
    run_ms(&board, BOOT_ms + 20);
    assert_true(console_says(board.chip, "no PSRAM answers"));
    assert_true(value_of(&board, "edges_done") > 0);
    close_board(&board);
}

/* Without its interrupt no edge is done, so nothing serves the watchdog. */
/* Requirement: SR-21 */
static void lost_timer_interrupt_ends_in_the_watchdogs_reset(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    rt_chip_tamper(board.chip, BASE_PIT + PIT_TCTRL_0, MASK(PIT_TCTRL_0_TIE), 0);
    assert_int_equal(run_ms(&board, 2300), RT_STOP_RESET);
    rt_chip_tamper(board.chip, 0, 0, 0);
    assert_int_equal(run_ms(&board, BOOT_ms + 20), RT_STOP_TIME);
    assert_true(console_says(board.chip, "the last start ended by the watchdog\n"));
    assert_true(value_of(&board, "edges_done") > 0);
    close_board(&board);
}

/* The first instruction of the tick's interrupt becomes an undefined one, after the self-test and before the
 * first tick. */
/* Requirement: SR-22 */
static void fault_in_the_image_is_reported_and_ends_in_a_reset(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    for (int ms = 0; ms < BOOT_ms && !console_says(board.chip, "cournand"); ms++)
        assert_int_equal(run_ms(&board, 1), RT_STOP_TIME);
    assert_int_equal(value_of(&board, "edges"), 0);
    const uint32_t at = rt_engine_symbol(board.engine, "clocks_tick") & ~1u, shift = 8 * (at & 2u);
    const uint32_t there = rt_engine_word(board.engine, at & ~3u) >> shift & 0xffffu;
    const rt_fault fault = {.kind = RT_FAULT_MEMORY,
                            .begin = board.chip->now,
                            .end = RT_NEVER,
                            .address = at,
                            .flip = (there ^ UNDEFINED_INSTRUCTION) << shift};
    rt_fault_set(board.chip, &fault);
    assert_int_equal(run_ms(&board, 2300), RT_STOP_RESET);
    assert_true(console_says(board.chip, "fault: exception 6 at pc 0x"));
    assert_true(console_says(board.chip, "status 0x00010000; power off, waiting for the watchdog's reset\n"));
    close_board(&board);
}

static rt_usb_reply token(rt_board *board, rt_usb_token kind, bool is_data1, const uint8_t *bytes)
{
    static rt_usb_packet packet;
    packet = (rt_usb_packet){.token = kind, .is_data1 = is_data1, .bytes = bytes != NULL ? 8 : 0};
    if (bytes != NULL) memcpy(packet.data, bytes, 8);
    return rt_usb_transact(board->chip, &packet);
}

/* A host asks the device to leave the bus. When the status stage has ended and the image has not seen that
 * yet, the next setup packet comes. The device must still leave: what the host saw acknowledged has happened.
 */
static void setup_packet_overtakes_no_transfer_that_ended_before(void **state)
{
    (void)state;
    static const uint8_t leave_for_1_s[8] = {0x40, 0x21, 0xe8, 0x03},
                         get_status[8] = {0x80, 0, 0, 0, 0, 0, 2};
    rt_board board;
    open_board(&board);
    assert_int_equal(run_ms(&board, BOOT_ms), RT_STOP_TIME);
    rt_usb_bus_reset(board.chip, true);
    assert_int_equal(run_ms(&board, 20), RT_STOP_TIME);
    assert_int_equal(token(&board, RT_TOKEN_SETUP, false, leave_for_1_s), RT_USB_ACK);
    assert_int_equal(run_ms(&board, STEP_ms), RT_STOP_TIME);
    assert_int_equal(token(&board, RT_TOKEN_IN, true, NULL), RT_USB_DATA1);
    assert_int_equal(token(&board, RT_TOKEN_SETUP, false, get_status), RT_USB_ACK);
    assert_true(rt_usb_is_attached(board.chip));
    assert_int_equal(run_ms(&board, STEP_ms), RT_STOP_TIME);
    assert_false(rt_usb_is_attached(board.chip));
    close_board(&board);
}

/* --- wrong writes --- */
static const struct {
    const char *what;
    uint32_t address, clear, set;
    const char *named; /* in the report */
} wrongs[] = {
    {"ARM PLL with a multiplier out of range", BASE_CCM_ANALOG + CCM_ANALOG_PLL_ARM,
     MASK(CCM_ANALOG_PLL_ARM_DIV_SELECT), 1,
     "CCM_ANALOG_PLL_ARM LOCK: the PLL is powered down, or its divider is out of range"},
    {"core voltage not raised", BASE_DCDC + DCDC_REG3, MASK(DCDC_REG3_TRG), 12,
     "CCM_CDHIPR: the core's voltage is too low for more than 528 MHz"},
    {"USB PLL not powered", BASE_CCM_ANALOG + CCM_ANALOG_PLL_USB1, MASK(CCM_ANALOG_PLL_USB1_POWER), 0,
     "CCM_ANALOG_PLL_USB1 LOCK: the PLL is powered down"},
    {"USB transceiver's gate left closed", BASE_USBPHY1 + USBPHY_CTRL_CLR, MASK(USBPHY_CTRL_CLKGATE), 0,
     "USB1_USBCMD RST: the transceiver does not run"},
    {"a data line of the PSRAM on another function", BASE_IOMUXC + 0x84, 0xf, 5,
     "FLEXSPI2_INTR IPCMDDONE: a pin of the PSRAM is not connected"},
    {"FlexSPI2 left off", BASE_FLEXSPI2 + FLEXSPI_MCR0, 0, MASK(FLEXSPI_MCR0_MDIS),
     "FLEXSPI2_MCR0 SWRESET: the controller is off (MDIS)"},
    {"clock of FlexSPI2 from a PLL that is off", BASE_CCM + CCM_CBCMR, 0, BITS(CCM_CBCMR_FLEXSPI2_CLK_SEL, 3),
     "FLEXSPI2_MCR0 SWRESET: its serial clock does not run"},
    {"gate of FlexSPI2 closed", BASE_CCM + CCM_CCGR7, 3u << 2, 0,
     "is accessed while its clock gate CCGR7 CG1 is closed"},
    {"ADC clock of 75 MHz", BASE_ADC2 + ADC_CFG, MASK(ADC_CFG_ADIV), 0,
     "ADC2_GC CAL: the converter's clock stands or is over 40 MHz"},
};

static char *report_of(rt_board *board)
{
    char *text = NULL;
    size_t bytes = 0;
    FILE *report = open_memstream(&text, &bytes);
    rt_report(board->chip, report, rt_engine_place, board->engine);
    fclose(report);
    return text;
}

/* The reasons in the table never pass with time, so the run ends when one is named. */
static void judge_wrong(size_t i)
{
    rt_board board;
    bool is_named = false;
    open_board(&board);
    rt_chip_tamper(board.chip, wrongs[i].address, wrongs[i].clear, wrongs[i].set);
    for (int ms = 0; ms < BOOT_ms && !is_named; ms += STEP_ms) {
        run_ms(&board, STEP_ms);
        char *text = report_of(&board);
        is_named = strstr(text, wrongs[i].named) != NULL;
        if (!is_named && ms + STEP_ms >= BOOT_ms) print_error("%s: the report is\n%s", wrongs[i].what, text);
        free(text);
    }
    close_board(&board);
    assert_true(is_named);
}

static void every_wrong_write_is_named_by_the_model(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof wrongs / sizeof wrongs[0]; i++) judge_wrong(i);
}

static void image_without_its_banks_of_memory_stops(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    rt_chip_tamper(board.chip, BASE_IOMUXC_GPR + IOMUXC_GPR_GPR17, 0xffffffffu,
                   0xaaaaaaaau); /* none for code */
    assert_int_equal(run_ms(&board, BOOT_ms), RT_STOP_LOCKUP);
    assert_non_null(strstr(rt_engine_trouble(board.engine), "locks up"));
    close_board(&board);
}

static void rom_refuses_a_flash_without_its_header(void **state)
{
    (void)state;
    rt_board board;
    open_board(&board);
    rt_engine_patch(board.engine, RT_FLASH_BEGIN + 0x80, 0); /* the sequence that reads the flash */
    rt_engine_power_cycle(board.engine);
    assert_int_equal(run_ms(&board, 1), RT_STOP_LOCKUP);
    assert_non_null(strstr(rt_engine_trouble(board.engine), "the read sequence does not read this flash"));
    close_board(&board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(image_boots_and_ticks_with_every_wait_answered),
        cmocka_unit_test(two_runs_are_equal_to_the_last_instruction),
        cmocka_unit_test(board_without_psram_says_so_and_runs),
        cmocka_unit_test(lost_timer_interrupt_ends_in_the_watchdogs_reset),
        cmocka_unit_test(fault_in_the_image_is_reported_and_ends_in_a_reset),
        cmocka_unit_test(setup_packet_overtakes_no_transfer_that_ended_before),
        cmocka_unit_test(every_wrong_write_is_named_by_the_model),
        cmocka_unit_test(image_without_its_banks_of_memory_stops),
        cmocka_unit_test(rom_refuses_a_flash_without_its_header),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
