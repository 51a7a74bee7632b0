/* This header declares the watchdog, which decides whether the host is still in control of the motors. While
 * FREE_RUN runs, every tick counts as silence until the next valid frame arrives. After
 * CRN_APP_HOST_SILENT_ticks of silence, the motors' forces fade to zero within CRN_APP_FADE_ticks. */
#ifndef CRN_WATCHDOG_H
#define CRN_WATCHDOG_H

#include "firmware/app/safety/finding.h"

typedef struct crn_watchdog {
    uint32_t silent_ticks; /* since the host's last valid frame; no longer counted when the fade has ended */
} crn_watchdog;

/* Records that a valid frame came from the host. Returns true if the frame ends a silence of the host that
 * had made the forces fade. */
bool crn_watchdog_feed(crn_watchdog *watchdog);

/* One tick of FREE_RUN begins. Counts a tick in which the host is silent, and reports a fault in the tick in
 * which the silence reaches its limit. */
void crn_watchdog_tick(crn_watchdog *watchdog, crn_findings *findings);

/* Returns whether the host is silent, so that the forces fade or have faded. */
bool crn_watchdog_is_fading(const crn_watchdog *watchdog);

/* Returns the number of ticks until no force is left; the number is CRN_APP_FADE_ticks while the host is
 * active. */
uint32_t crn_watchdog_left_ticks(const crn_watchdog *watchdog);

#endif
