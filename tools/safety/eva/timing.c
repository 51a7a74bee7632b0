/* Calls the parts of the app's safety code that measure time and silence or manage the permission to power
 * the motors, in any order and any number of times, from power-up on. The asserted facts are proved for every
 * call. */
#include "firmware/app/safety/clock.h"
#include "firmware/app/safety/limits.h"
#include "firmware/app/safety/permission.h"
#include "firmware/app/safety/watchdog.h"
#include "tools/safety/eva/any.h"

static crn_watchdog watchdog;
static crn_clock clock_of_ticks;
static crn_permission permission;

static void measure_time(void)
{
    crn_findings findings = {.count = 0};
    if (any_bool()) crn_clock_restart(&clock_of_ticks);
    crn_clock_begin(&clock_of_ticks, any_u32(), any_bool(), &findings);
    crn_clock_end(&clock_of_ticks, any_u32(), any_bool(), &findings);
    if (any_bool()) crn_watchdog_feed(&watchdog);
    crn_watchdog_tick(&watchdog, &findings);
    /*@ assert silence_is_bounded: watchdog.silent_ticks <= 42; */
    crn_watchdog_left_ticks(&watchdog);
}

static void ask_permission(void)
{
    if (any_bool()) crn_permission_offer(&permission, any_u32());
    if (crn_permission_answer(&permission, any_u32())) crn_permission_give(&permission);
    crn_permission_age(&permission);
    /*@ assert a_permission_expires: permission.age_ticks <= 2001; */
    if (any_bool()) crn_permission_spend(&permission);
}

void eva_main(void)
{
    /*@ loop widen_hints "all", 42, 2001; */
    while (any_bool()) {
        if (any_bool()) {
            measure_time();
        } else {
            ask_permission();
        }
    }
}
