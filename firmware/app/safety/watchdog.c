/* This file measures the host's silence in ticks. */
#include "firmware/app/safety/watchdog.h"
#include "firmware/app/safety/limits.h"

bool crn_watchdog_is_fading(const crn_watchdog *watchdog)
{
    return watchdog->silent_ticks >= CRN_APP_HOST_SILENT_ticks;
}

bool crn_watchdog_feed(crn_watchdog *watchdog)
{
    const bool was_fading = crn_watchdog_is_fading(watchdog);
    watchdog->silent_ticks = 0;
    return was_fading;
}

/* Requirement: SR-16 */
void crn_watchdog_tick(crn_watchdog *watchdog, crn_findings *findings)
{
    if (watchdog->silent_ticks >= CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks) return;
    if (++watchdog->silent_ticks != CRN_APP_HOST_SILENT_ticks) return;
    crn_findings_add(findings, CRN_FAULT_CODE_HOST_SILENT, CRN_APP_HOST_SILENT_ticks, 0);
}

uint32_t crn_watchdog_left_ticks(const crn_watchdog *watchdog)
{
    if (!crn_watchdog_is_fading(watchdog)) return CRN_APP_FADE_ticks;
    return CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks - watchdog->silent_ticks;
}
