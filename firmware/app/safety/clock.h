/* This header declares functions that measure the time between timer edges and the duration of each tick.
 * While a tick takes too long, the motors keep their last force. The ticks after a late tick use their spare
 * time to make up for the delay, so the simulated state is the same as without the delay. */
#ifndef CRN_CLOCK_H
#define CRN_CLOCK_H

#include "firmware/app/safety/finding.h"

typedef struct crn_clock {
    uint32_t edge_us, backlog_us, tick_us_max, tick_overruns;
    bool has_edge, was_late;
} crn_clock;

/* Resets the time measurement when the motor power comes on: earlier timer edges no longer count. */
void crn_clock_restart(crn_clock *clock);

/* Runs before a tick. While the motors have power, a gap of more than 5 ms between two timer edges is
 * reported as a fault, because the processor has stood still. */
void crn_clock_begin(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

/* After a tick. */
void crn_clock_end(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

#endif
