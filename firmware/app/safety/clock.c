/* Late edges and ticks. */
#include "firmware/app/safety/clock.h"
#include "firmware/app/safety/limits.h"

enum {
    GAP_us = 5000, /* the processor stood still when two edges are farther apart */
    BACKLOG_us = 2000,
};

void crn_clock_restart(crn_clock *clock)
{
    clock->backlog_us = 0;
    clock->has_edge = false;
}

/* Requirement: SR-17 */
void crn_clock_begin(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings)
{
    const uint32_t gap = clock->has_edge ? now_us - clock->edge_us : 0;
    clock->edge_us = now_us;
    clock->has_edge = true;
    if (is_driving && gap > GAP_us)
        crn_findings_add(findings, CRN_FAULT_CODE_TICK_STALLED, (int32_t)gap, (int32_t)clock->backlog_us);
}

/* Requirement: SR-17 */
void crn_clock_end(crn_clock *clock, uint32_t now_us, bool is_driving, crn_findings *findings)
{
    const uint32_t took = now_us - clock->edge_us;
    const uint32_t spent = clock->backlog_us + took;
    if (took > clock->tick_us_max) clock->tick_us_max = took;
    clock->backlog_us = spent > CRN_APP_EDGE_us ? spent - CRN_APP_EDGE_us : 0;
    clock->was_late = clock->backlog_us > 0;
    if (!clock->was_late) return;
    clock->tick_overruns++;
    crn_findings_add(findings, CRN_FAULT_CODE_TICK_OVERRUN, (int32_t)took, (int32_t)clock->backlog_us);
    if (is_driving && clock->backlog_us > BACKLOG_us)
        crn_findings_add(findings, CRN_FAULT_CODE_TICK_STALLED, (int32_t)took, (int32_t)clock->backlog_us);
}
