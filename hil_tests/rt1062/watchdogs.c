/* Watchdogs WDOG1 and RTWDOG, the cause of the last reset (SRC), and the chip's number (OCOTP). The ROM has
 * turned RTWDOG off unless a fuse says otherwise; a test may leave it on (rtwdog_bites). Behaviour: reference
 * manual, chapters WDOG, RTWDOG and SRC, from memory. */
#include "hil_tests/rt1062/chip.h"

enum { UNLOCK_CLOCKS = 255, RTWDOG_RESET_CS = 0x2920, RTWDOG_TOVAL_RESET = 0x400 };
#define RTWDOG_KEY 0xd928c520u
static const double low_power_Hz = 32768.0;
static const uint32_t chip_number[2] = {0x4d2a1062u, 0x01234567u};

static uint64_t half_seconds(const rt_chip *chip, uint32_t count)
{
    return rt_mutant_time(chip, RT_TIME_WDOG, RT_INSTANTS_PER_s / 2 * count);
}

uint32_t rt_wdog_read(rt_chip *chip, uint32_t offset)
{
    const rt_watchdogs *dogs = &chip->watchdogs;
    if (offset == WDOG_WCR) return dogs->wcr;
    if (offset == WDOG_WMCR) return dogs->wmcr;
    rt_unmodelled(chip, "WDOG1", offset, false);
    return 0;
}

static void serve(rt_chip *chip)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    if (dogs->wdog_bites == RT_NEVER) return;
    dogs->wdog_bites = chip->now + half_seconds(chip, RT_FIELD(dogs->wcr, WDOG_WCR_WT) + 1);
    dogs->served++;
}

void rt_wdog_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    switch (offset) {
    case WDOG_WCR: {
        const uint32_t once = MASK(WDOG_WCR_WDE) | MASK(WDOG_WCR_WDBG); /* cannot be changed again */
        bool was_on = (dogs->wcr & MASK(WDOG_WCR_WDE)) != 0;
        if (dogs->is_locked) value = (value & ~once) | (dogs->wcr & once);
        if ((value & MASK(WDOG_WCR_SRS)) == 0) chip->reset = RT_RESET_WDOG1; /* a software reset */
        if ((value & MASK(WDOG_WCR_WDA)) == 0) rt_find(chip, "WDOG_WCR WDA 0 asserts the pin WDOG_B");
        dogs->wcr = value;
        dogs->is_locked = true;
        if (!was_on && (value & MASK(WDOG_WCR_WDE)) != 0)
            dogs->wdog_bites = chip->now + half_seconds(chip, RT_FIELD(value, WDOG_WCR_WT) + 1);
        break;
    }
    case WDOG_WSR:
        if (value == 0xaaaa && dogs->is_half_served) serve(chip);
        dogs->is_half_served = value == 0x5555;
        break;
    case WDOG_WMCR:
        dogs->wmcr = value;
        break;
    default:
        rt_unmodelled(chip, "WDOG1", offset, true);
    }
}

uint32_t rt_rtwdog_read(rt_chip *chip, uint32_t offset)
{
    if (offset == RTWDOG_CS) return chip->watchdogs.cs;
    if (offset == RTWDOG_TOVAL) return chip->watchdogs.toval;
    rt_unmodelled(chip, "RTWDOG", offset, false);
    return 0;
}

/* CS and TOVAL take a value only within 255 clocks of the bus after the key. */
void rt_rtwdog_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    if (offset == RTWDOG_CNT) {
        if (value == RTWDOG_KEY)
            dogs->unlocked_until =
                chip->now +
                rt_mutant_time(chip, RT_TIME_RTWDOG_UNLOCK,
                               (uint64_t)(UNLOCK_CLOCKS / rt_clock_ipg_Hz(chip) * RT_INSTANTS_PER_s));
        return;
    }
    if (offset != RTWDOG_CS && offset != RTWDOG_TOVAL) {
        rt_unmodelled(chip, "RTWDOG", offset, true);
        return;
    }
    if (chip->now > dogs->unlocked_until) {
        rt_find(chip, "RTWDOG is written while it is locked; the chip resets");
        chip->reset = RT_RESET_RTWDOG;
        return;
    }
    if (offset == RTWDOG_TOVAL) dogs->toval = value;
    if (offset == RTWDOG_CS) dogs->cs = value;
    bool is_on = (dogs->cs & MASK(RTWDOG_CS_EN)) != 0;
    uint64_t time = (uint64_t)(dogs->toval / low_power_Hz * RT_INSTANTS_PER_s);
    dogs->rtwdog_bites = is_on ? chip->now + rt_mutant_time(chip, RT_TIME_RTWDOG, time) : RT_NEVER;
}

uint64_t rt_watchdogs_run_due(rt_chip *chip)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    if (dogs->wdog_bites <= chip->now) chip->reset = RT_RESET_WDOG1;
    if (dogs->rtwdog_bites <= chip->now) chip->reset = RT_RESET_RTWDOG;
    return dogs->wdog_bites < dogs->rtwdog_bites ? dogs->wdog_bites : dogs->rtwdog_bites;
}

void rt_watchdogs_halt(rt_chip *chip, uint64_t instants)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    bool stands = (dogs->wcr & MASK(WDOG_WCR_WDBG)) != 0 && dogs->wdog_bites != RT_NEVER;
    if (stands) dogs->wdog_bites += instants;
}

uint32_t rt_src_read(rt_chip *chip, uint32_t offset)
{
    if (offset == SRC_SRSR) return chip->watchdogs.srsr;
    rt_unmodelled(chip, "SRC", offset, false);
    return 0;
}

void rt_src_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    if (offset == SRC_SRSR) {
        chip->watchdogs.srsr &= ~value;
    } else {
        rt_unmodelled(chip, "SRC", offset, true);
    }
}

uint32_t rt_ocotp_read(rt_chip *chip, uint32_t offset)
{
    if (offset == OCOTP_CFG0) return chip_number[0];
    if (offset == OCOTP_CFG1) return chip_number[1];
    rt_unmodelled(chip, "OCOTP", offset, false);
    return 0;
}

void rt_watchdogs_reset(rt_chip *chip, bool is_power_up)
{
    rt_watchdogs *dogs = &chip->watchdogs;
    uint32_t cause = is_power_up                      ? MASK(SRC_SRSR_IPP_RESET_B)
                     : chip->reset == RT_RESET_RTWDOG ? MASK(SRC_SRSR_WDOG3_RST_B)
                                                      : MASK(SRC_SRSR_WDOG_RST_B);
    *dogs = (rt_watchdogs){.wcr = MASK(WDOG_WCR_SRS) | MASK(WDOG_WCR_WDA),
                           .wmcr = MASK(WDOG_WMCR_PDE),
                           .srsr = cause,
                           .wdog_bites = RT_NEVER,
                           .cs = RTWDOG_RESET_CS,
                           .toval = RTWDOG_TOVAL_RESET,
                           .rtwdog_bites = RT_NEVER};
}
