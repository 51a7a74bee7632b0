/* This header measures how long the edges of the timer and the ticks take. While a tick took too long, the
 * motors kept their last force. The following ticks make up for the delay in their unused time, and the state
 * is the same as if the tick had been in time. */
#ifndef CRN_CLOCK_H
#define CRN_CLOCK_H

#include "firmware/app/safety/finding.h"

typedef struct crn_clock {
    uint32_t edge_us, backlog_us, tick_us_max, tick_overruns;
    bool has_edge, was_late;
} crn_clock;

/* Resets the time measurement when the motor power comes on: earlier timer edges no longer count. */
void crn_clock_restart(crn_clock *clock);

/* Runs before a tick. While motors have power, a gap of more than 5 ms since the last timer edge is a
 * finding, because the processor stood still. */
void crn_clock_begin(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

/* After a tick. */
void crn_clock_end(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

#endif
