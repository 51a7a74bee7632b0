/* How long edges and ticks take. A tick that took too long held the last force meanwhile. The time that the
 * next ticks leave unused makes up for it, and the state is the same as if the tick had been in time. */
#ifndef CRN_CLOCK_H
#define CRN_CLOCK_H

#include "firmware/app/safety/finding.h"

typedef struct crn_clock {
    uint32_t edge_us, backlog_us, tick_us_max, tick_overruns;
    bool has_edge, was_late;
} crn_clock;

/* The power comes on: earlier edges no longer count. */
void crn_clock_restart(crn_clock *clock);

/* Before a tick: a processor that stood still since the last edge is a finding while motors have power. */
void crn_clock_begin(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

/* After a tick. */
void crn_clock_end(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings);

#endif
