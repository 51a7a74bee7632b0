/* What can hurt a finger, looked for once per edge of the timer in this edge's sample of the rig: lines,
 * sensors, forces, carriages, clock. Every finding is a fault of shared/wire/wire_faults.def, with its time
 * to safe and its test there. */
#include "firmware/app/app_internal.h"

enum {
    FORCE_PLAUSIBLE_mN = 50000, /* no sensor of such a rig reads more */
    FORCE_REST_mN = 1000,       /* friction and inertia of a carriage of 0.1 kg in a brisk hand */
    OVER_ticks = 2,
    CURRENT_ticks = 2, /* one may be a spike on the line */
    MISMATCH_ticks = 3,
    STAGE_ticks = CRN_PORT_DRIVE_HOLD_ms + 3,
    UNBALANCE_mN = 900,
    CARRIAGE_FRICTION_mN = 300,
    CARRIAGE_PER_kg = 4, /* the heaviest carriage has 0.25 kg */
    CARRIAGE_WAY_nm = 20000,
    GAP_us = 5000, /* two edges farther apart: the processor stood still */
    BACKLOG_us = 2000,
};

/* --- forces --- */

/* Format: counts x uN / 1000 -> mN. Overflow: 2^32 x 2^20. */
int32_t crn_app_force_measured(const crn_app *app, uint32_t k)
{
    const crn_wire_track *wire = &app->setup.tracks[k].wire;
    if (!app->edge.has_rig || app->edge.rig.tracks[k].force_sensor != CRN_PORT_SENSOR_OK) return 0;
    int64_t counts = (int64_t)app->edge.rig.tracks[k].force_raw - wire->force_zero_counts;
    int64_t force = crn_app_quotient(counts * wire->force_uN_per_count, 1000);
    return force > INT32_MAX ? INT32_MAX : force < -INT32_MAX ? -INT32_MAX : (int32_t)force;
}

static int32_t size_of(int32_t value)
{
    return value < 0 ? -value : value;
}

/* The smallest and largest force asked for within CRN_APP_ASKED_ticks: an actuator answers late. */
typedef struct asked_range {
    int32_t low, high;
} asked_range;

static asked_range range_asked(const crn_app_watch *watch)
{
    asked_range range = {watch->asked_mN[0], watch->asked_mN[0]};
    for (int i = 1; i < CRN_APP_ASKED_ticks; i++) {
        if (watch->asked_mN[i] < range.low) range.low = watch->asked_mN[i];
        if (watch->asked_mN[i] > range.high) range.high = watch->asked_mN[i];
    }
    return range;
}

/* Count ticks in a row. */
static bool lasts(uint32_t *ticks, bool is_so, uint32_t limit)
{
    *ticks = is_so ? *ticks + 1 : 0;
    return *ticks >= limit;
}

/* In every state: a force that nobody asked for comes from a driver that is broken. One that was asked for
 * and is missing may be a hand that lets go; that is for check_carriage to judge. */
static crn_fault_code check_force(crn_app *app, uint32_t k, int32_t measured)
{
    crn_app_watch *watch = &app->safety.watches[k];
    const asked_range asked = range_asked(watch);
    int32_t largest = size_of(asked.low) > size_of(asked.high) ? size_of(asked.low) : size_of(asked.high);
    int32_t margin = FORCE_REST_mN + largest / 4, limit = app->setup.tracks[k].force_limit_mN;
    bool is_strange = measured > (asked.high > 0 ? asked.high : 0) + margin ||
                      measured < (asked.low < 0 ? asked.low : 0) - margin;
    bool is_over = app->safety.is_driving && size_of(measured) > limit + limit / 8 + 200;
    if (lasts(&watch->over_ticks, is_over, OVER_ticks)) return CRN_FAULT_CODE_FORCE_OVER;
    if (!lasts(&watch->mismatch_ticks, is_strange, MISMATCH_ticks)) return CRN_FAULT_CODE_NONE;
    return largest == 0 ? CRN_FAULT_CODE_ACTUATOR_STUCK_ON : CRN_FAULT_CODE_FORCE_MISMATCH;
}

/* --- carriages --- */

/* The force on the carriage that neither motor nor hand explains, + into the patient. */
static int32_t unbalance(const crn_app_watch *watch, int32_t measured)
{
    const asked_range asked = range_asked(watch);
    if (measured > asked.high) return measured - asked.high;
    return measured < asked.low ? measured - asked.low : 0;
}

static void restart_watch(crn_app_watch *watch, int32_t speed_counts)
{
    watch->unbalance_ticks = 0;
    watch->way_nm = watch->speed_nm = watch->moved_counts = 0;
    watch->speed_counts = speed_counts;
}

/* An unbalanced force must move the heaviest carriage by CARRIAGE_WAY_nm against its friction before anything
 * is said. Its encoder then stands, or has gained speed the other way, or all is well. Format: mN / kg = nm /
 * ms^2; ways in nm. */
static crn_fault_code check_carriage(crn_app *app, uint32_t k, int32_t measured)
{
    crn_app_watch *watch = &app->safety.watches[k];
    int32_t moved = crn_app_carriage_moved(app, k), force = unbalance(watch, measured);
    bool turns = watch->unbalance_ticks > 0 && (force > 0) != (watch->unbalance_mN > 0);
    if (size_of(force) < UNBALANCE_mN || turns) {
        restart_watch(watch, moved);
        return CRN_FAULT_CODE_NONE;
    }
    watch->unbalance_ticks++;
    watch->unbalance_mN = force;
    watch->moved_counts += moved;
    watch->stands = moved == 0 && (watch->unbalance_ticks == 1 || watch->stands);
    watch->speed_nm += (int64_t)(size_of(force) - CARRIAGE_FRICTION_mN) * CARRIAGE_PER_kg;
    watch->way_nm += watch->speed_nm;
    const int64_t count_pm = app->setup.tracks[k].wire.translation_pm_per_count;
    if (watch->way_nm < CARRIAGE_WAY_nm || watch->way_nm * 250 < count_pm) return CRN_FAULT_CODE_NONE;
    int64_t gained = watch->moved_counts - (int64_t)watch->speed_counts * watch->unbalance_ticks;
    int64_t gained_nm = crn_app_quotient(gained * count_pm, 1000), way_nm = watch->way_nm;
    bool stood = watch->stands && watch->speed_counts == 0;
    restart_watch(watch, moved);
    if (stood) return CRN_FAULT_CODE_ENCODER_STUCK;
    return (force > 0 ? -gained_nm : gained_nm) > way_nm / 2 ? CRN_FAULT_CODE_ENCODER_REVERSED
                                                             : CRN_FAULT_CODE_NONE;
}

/* --- one track, the lines, everything --- */

static bool force_sensor_is_lost(const crn_app *app, uint32_t k)
{
    uint8_t sensor = app->edge.rig.tracks[k].force_sensor;
    if (sensor == CRN_PORT_SENSOR_ABSENT) return app->safety.watches[k].had_force_sensor;
    return sensor != CRN_PORT_SENSOR_OK || size_of(crn_app_force_measured(app, k)) > FORCE_PLAUSIBLE_mN;
}

static bool encoder_is_lost(const crn_app *app, uint32_t k)
{
    return app->edge.rig.tracks[k].translation_sensor != CRN_PORT_SENSOR_OK ||
           app->edge.rig.tracks[k].rotation_sensor != CRN_PORT_SENSOR_OK;
}

static crn_fault_code check_track(crn_app *app, uint32_t k, int32_t *value)
{
    const crn_port_track *track = &app->edge.rig.tracks[k];
    int32_t measured = crn_app_force_measured(app, k);
    crn_fault_code code = CRN_FAULT_CODE_NONE;
    *value = measured;
    if (app->safety.is_driving && k < app->setup.tool_count) {
        *value = track->translation_sensor == CRN_PORT_SENSOR_OK;
        if (encoder_is_lost(app, k)) return CRN_FAULT_CODE_ENCODER_LOST;
        *value = measured;
        if (force_sensor_is_lost(app, k)) return CRN_FAULT_CODE_FORCE_SENSOR_LOST;
        if (lasts(&app->safety.watches[k].current_ticks, track->over_current, CURRENT_ticks))
            return CRN_FAULT_CODE_OVER_CURRENT;
    }
    if (track->force_sensor == CRN_PORT_SENSOR_OK) code = check_force(app, k, measured);
    if (code != CRN_FAULT_CODE_NONE || !app->safety.is_driving || k >= app->setup.tool_count) return code;
    if (track->force_sensor == CRN_PORT_SENSOR_OK) code = check_carriage(app, k, measured);
    return code != CRN_FAULT_CODE_NONE ? code : crn_app_carriage_check(app, k, value);
}

static bool stage_is_stuck(const crn_app *app)
{
    return !app->safety.is_driving && app->edge.has_rig && app->edge.rig.stage_on &&
           app->safety.idle_ticks > STAGE_ticks;
}

static crn_fault_code check_lines(crn_app *app)
{
    const crn_port_inputs *rig = &app->edge.rig;
    if (!app->safety.is_driving)
        return stage_is_stuck(app) ? CRN_FAULT_CODE_STAGE_STUCK : CRN_FAULT_CODE_NONE;
    if (rig->emergency_stop) return CRN_FAULT_CODE_EMERGENCY_STOP;
    if (!rig->supply_good) return CRN_FAULT_CODE_SUPPLY_LOST;
    if (!rig->stage_on && (app->safety.stage_was_on || app->safety.drive_ticks > STAGE_ticks))
        return CRN_FAULT_CODE_STAGE_LOST;
    app->safety.stage_was_on = app->safety.stage_was_on || rig->stage_on;
    return CRN_FAULT_CODE_NONE;
}

/* A code and the permission that it gave are for somebody who is about to press START, not for whoever comes
 * later. */
static void age_permission(crn_app *app)
{
    if (app->permission.code == 0 && !app->permission.is_given) return;
    if (++app->permission.age_ticks <= CRN_APP_CODE_ticks) return;
    app->permission.code = 0;
    app->permission.is_given = false;
}

/* Every edge, with this edge's sample. A fault is latched once: in FAULT nothing is left to take away, but
 * that the stage does not obey must be told, whatever led there. */
void crn_app_safety_check(crn_app *app)
{
    app->safety.drive_ticks = app->safety.is_driving ? app->safety.drive_ticks + 1 : 0;
    app->safety.idle_ticks = app->safety.is_driving || app->safety.idle_ticks == UINT32_MAX
                                 ? app->safety.idle_ticks
                                 : app->safety.idle_ticks + 1;
    age_permission(app);
    const bool is_stuck = stage_is_stuck(app), is_told = app->safety.stage_is_reported;
    app->safety.stage_is_reported = is_stuck;
    if (app->state == CRN_WIRE_STATE_FAULT) {
        if (is_stuck && !is_told) crn_app_fault(app, CRN_FAULT_CODE_STAGE_STUCK, 0, 0);
        return;
    }
    if (!app->edge.has_rig) {
        if (app->safety.is_driving) crn_app_fault(app, CRN_FAULT_CODE_RIG_LOST, 0, 0);
        return;
    }
    crn_fault_code code = check_lines(app);
    if (code != CRN_FAULT_CODE_NONE) {
        crn_app_fault(app, code, 0, 0);
        return;
    }
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        int32_t value = 0;
        code = check_track(app, k, &value);
        app->safety.watches[k].last = app->edge.rig.hands[k];
        if (code == CRN_FAULT_CODE_NONE) continue;
        crn_app_fault(app, code, (int32_t)k, value);
        return;
    }
}

/* May the motors be armed? The first thing that says no. */
crn_fault_code crn_app_safety_ready(const crn_app *app)
{
    const crn_port_inputs *rig = &app->edge.rig;
    if (!app->edge.has_rig) return CRN_FAULT_CODE_RIG_LOST;
    if (rig->emergency_stop) return CRN_FAULT_CODE_EMERGENCY_STOP;
    if (!rig->supply_good) return CRN_FAULT_CODE_SUPPLY_LOST;
    if (rig->stage_on && app->safety.idle_ticks > STAGE_ticks) return CRN_FAULT_CODE_STAGE_STUCK;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        const crn_port_track *track = &rig->tracks[k];
        if (encoder_is_lost(app, k)) return CRN_FAULT_CODE_ENCODER_LOST;
        /* Without a sensor no force is checked: for somebody who stands at the rig and knows. */
        bool has_none = track->force_sensor == CRN_PORT_SENSOR_ABSENT;
        if (has_none ? !rig->local_unlock : force_sensor_is_lost(app, k))
            return CRN_FAULT_CODE_FORCE_SENSOR_LOST;
        if (size_of(crn_app_force_measured(app, k)) > FORCE_REST_mN) return CRN_FAULT_CODE_ACTUATOR_STUCK_ON;
        if (track->over_current) return CRN_FAULT_CODE_OVER_CURRENT;
    }
    return CRN_FAULT_CODE_NONE;
}

/* The power comes on: everything remembered is about an earlier time. */
void crn_app_safety_begin(crn_app *app)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        crn_app_watch *watch = &app->safety.watches[k];
        *watch = (crn_app_watch){.last = app->edge.rig.hands[k]};
        watch->had_force_sensor = app->edge.rig.tracks[k].force_sensor != CRN_PORT_SENSOR_ABSENT;
    }
    app->safety.stage_was_on = false;
    app->safety.drive_ticks = 0;
    app->clock.backlog_us = 0;
    app->clock.has_edge = false;
}

/* --- the clock --- */

/* Before a tick: did the processor stand still since the last edge? */
void crn_app_clock_begin(crn_app *app)
{
    uint32_t now = app->port->now_us(app->port->context);
    uint32_t gap = app->clock.has_edge ? now - app->clock.edge_us : 0;
    app->clock.edge_us = now;
    app->clock.has_edge = true;
    if (app->safety.is_driving && gap > GAP_us)
        crn_app_fault(app, CRN_FAULT_CODE_TICK_STALLED, (int32_t)gap, (int32_t)app->clock.backlog_us);
}

/* After a tick. One that took too long held the last force meanwhile; what is left of the time of the next
 * ones makes up for it, and the state is the same as if it had been in time. */
void crn_app_clock_end(crn_app *app)
{
    uint32_t took = app->port->now_us(app->port->context) - app->clock.edge_us;
    uint32_t spent = app->clock.backlog_us + took;
    if (took > app->clock.tick_us_max) app->clock.tick_us_max = took;
    app->clock.backlog_us = spent > CRN_TICK_us ? spent - CRN_TICK_us : 0;
    app->clock.was_late = app->clock.backlog_us > 0;
    if (!app->clock.was_late) return;
    app->clock.tick_overruns++;
    crn_app_fault(app, CRN_FAULT_CODE_TICK_OVERRUN, (int32_t)took, (int32_t)app->clock.backlog_us);
    if (app->safety.is_driving && app->clock.backlog_us > BACKLOG_us)
        crn_app_fault(app, CRN_FAULT_CODE_TICK_STALLED, (int32_t)took, (int32_t)app->clock.backlog_us);
}
