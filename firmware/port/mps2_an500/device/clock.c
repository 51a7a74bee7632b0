/* This file provides a free-running counter for measuring durations, the edge of a timer in every
 * millisecond, and the watchdog. */
#include "firmware/port/mps2_an500/device/board.h"
#include "firmware/port/mps2_an500/device/device.h"

enum {
    COUNTS_PER_us = BOARD_CLOCK_HZ / 1000000,
    COUNTS_PER_ms = BOARD_CLOCK_HZ / 1000,
    /* The watchdog's limit of 60 s is longer than the longest request takes, which is the validation of a
     * scene. The validation of a scene takes 0.2 s at 1,000 instructions per us, and 26 s if the emulator
     * counts 128 ns for each instruction. The power stage does not depend on the watchdog, because the stage
     * removes the power by itself after 5 ms. */
    WATCHDOG_s = 60,
};

static struct {
    uint32_t counts_last, counts_rest, us;
    volatile uint32_t edges; /* edges of the board's timer */
    uint32_t edges_done;
    bool follows_plant; /* the clock has been set to the plant's time */
} clock;

void clock_start(void)
{
    board_timer0->reload = UINT32_MAX;
    board_timer0->value = UINT32_MAX;
    board_timer0->control = BOARD_TIMER_ON;
    clock.counts_last = clock_counts();
    board_systick0->reload = COUNTS_PER_ms - 1;
    board_systick0->value = 0;
    board_systick0->control = BOARD_SYSTICK_ON_INTERRUPT_PROCESSOR_CLOCK;
    board_watchdog0->load = (uint32_t)WATCHDOG_s * BOARD_CLOCK_HZ;
    board_watchdog0->control = BOARD_WATCHDOG_INTERRUPT_AND_RESET;
    rig_write(&rig->device.edge_done, rig_read(&rig->host.edge)); /* edges from before power-up are skipped */
}

uint32_t clock_counts(void)
{
    return UINT32_MAX - board_timer0->value;
}

static void take_counts(uint32_t counts)
{
    clock.counts_rest += counts;
    clock.us += clock.counts_rest / COUNTS_PER_us;
    clock.counts_rest %= COUNTS_PER_us;
}

/* The time that clock_us() returns is correct if clock_us() is called at least every 171 s. */
uint32_t clock_us(void)
{
    uint32_t now = clock_counts();
    take_counts(now - clock.counts_last);
    clock.counts_last = now;
    return clock.us;
}

static bool is_plants(void)
{
    return rig_is_there() && rig_read(&rig->host.tick_source) == RIG_TICK_PLANT;
}

/* While the rig's model (the plant) provides the clock, the device's clock stops whenever the device waits
 * for the plant. The clock counts only the device's work, so the time that it shows does not depend on how
 * long the device waited. Returns the value of the counter, from which the caller later computes how long the
 * work took. */
uint32_t clock_work_begin(void)
{
    const uint32_t now = clock_counts();
    if (is_plants()) clock.counts_last = now;
    return now;
}

/* If the rig's model (the plant) provides the clock, sets the device's clock to the beginning of the plant's
 * present millisecond. From the second millisecond on the clock is never set back, so a device that is late
 * with its work stays late. The first one sets the clock in any case: the plant may have run for hours. */
void clock_edge_begin(void)
{
    clock_work_begin();
    const bool is_first = !clock.follows_plant;
    clock.follows_plant = is_plants();
    if (!clock.follows_plant) return;
    uint32_t begin_us = rig->host.milliseconds * 1000;
    if (!is_first && begin_us - clock.us > INT32_MAX) return;
    clock.us = begin_us;
    clock.counts_rest = 0;
}

void clock_tick(void)
{
    clock.edges++;
}

uint32_t clock_edges_due(void)
{
    if (is_plants()) {
        clock.edges_done = clock.edges; /* the timer continues from here when the plant disconnects */
        return rig_read(&rig->host.edge) - rig->device.edge_done;
    }
    return clock.edges - clock.edges_done;
}

bool clock_waits_for_plant(void)
{
    return is_plants() && clock_edges_due() == 0;
}

void clock_edge_done(void)
{
    if (is_plants()) {
        rig_write(&rig->device.edge_done, rig->device.edge_done + 1);
    } else {
        clock.edges_done++;
    }
}

void clock_feed_watchdog(void)
{
    board_watchdog0->load = (uint32_t)WATCHDOG_s * BOARD_CLOCK_HZ;
}
