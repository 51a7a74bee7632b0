/* Checks the readings of the rig (signal lines, sensors and forces) at every edge of the timer. Every fault
 * that the safety checks can report is listed in shared/wire/wire_faults.def, with the longest time until the
 * rig is safe and the name of the test for this fault. */
#include "firmware/app/safety/safety.h"
#include "firmware/app/safety/arithmetic.h"
#include "firmware/app/safety/carriage.h"

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
    CARRIAGE_TRAVEL_nm = 20000,
};

/* --- forces --- */

/* Format: counts x uN / 1000 -> mN. Overflow: 2^32 x 2^20. */
int32_t crn_safety_force_mN(const crn_safety *safety, const crn_port_inputs *rig, uint32_t k)
{
    const crn_safety_track *track = &safety->tracks[k];
    if (rig == NULL || rig->tracks[k].force_sensor != CRN_PORT_SENSOR_OK) return 0;
    const int64_t counts = (int64_t)rig->tracks[k].force_raw - track->force_zero_counts;
    return crn_limited(crn_quotient(counts * track->force_uN_per_count, 1000), -INT32_MAX, INT32_MAX);
}

/* Holds the smallest and the largest force requested within the last CRN_APP_ASKED_ticks, because an actuator
 * reacts late. */
typedef struct asked_range {
    int32_t low, high;
} asked_range;

static asked_range range_asked(const crn_safety_watch *watch)
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

/* The check for forces that nobody requested runs in every state, because such a force comes from a broken
 * driver. If a requested force is missing, the hand may have released the carriage; the function
 * check_balance finds out whether this is the reason. */
/* Requirement: SR-10, SR-11 */
static crn_fault_code check_force(crn_safety *safety, uint32_t k, int32_t measured)
{
    crn_safety_watch *watch = &safety->watches[k];
    const asked_range asked = range_asked(watch);
    const int32_t low = crn_size_of(asked.low), high = crn_size_of(asked.high);
    const int32_t largest = low > high ? low : high;
    const int32_t margin = FORCE_REST_mN + largest / 4, limit = safety->tracks[k].force_limit_mN;
    const bool is_strange = measured > (asked.high > 0 ? asked.high : 0) + margin ||
                            measured < (asked.low < 0 ? asked.low : 0) - margin;
    const bool is_over = safety->is_driving && crn_size_of(measured) > limit + limit / 8 + 200;
    if (lasts(&watch->over_ticks, is_over, OVER_ticks)) return CRN_FAULT_CODE_FORCE_OVER;
    if (!lasts(&watch->mismatch_ticks, is_strange, MISMATCH_ticks)) return CRN_FAULT_CODE_NONE;
    return largest == 0 ? CRN_FAULT_CODE_ACTUATOR_STUCK_ON : CRN_FAULT_CODE_FORCE_MISMATCH;
}

/* --- balance of forces on a carriage --- */

/* Returns the force on the carriage that neither motor nor hand explains; the force is positive into the
 * patient. */
static int32_t unbalance(const crn_safety_watch *watch, int32_t measured)
{
    const asked_range asked = range_asked(watch);
    if (measured > asked.high) return measured - asked.high;
    return measured < asked.low ? measured - asked.low : 0;
}

static void restart_watch(crn_safety_watch *watch, int32_t speed_counts)
{
    watch->unbalance_ticks = 0;
    watch->travel_nm = watch->speed_nm = watch->moved_counts = 0;
    watch->speed_counts = speed_counts;
}

/* The function check_balance waits until the unbalanced force must have moved even the heaviest carriage by
 * CARRIAGE_TRAVEL_nm against its friction. After a travel of CARRIAGE_TRAVEL_nm, the check reports a fault if
 * the encoder has not moved, or if the encoder shows a motion against the force. Format: mN / kg = nm / ms^2;
 * travel in nm. */
/* Requirement: SR-12 */
static crn_fault_code check_balance(crn_safety *safety, const crn_port_inputs *rig, uint32_t k,
                                    int32_t measured)
{
    crn_safety_watch *watch = &safety->watches[k];
    const int32_t moved = crn_carriage_moved(safety, rig, k), force = unbalance(watch, measured);
    const bool turns = watch->unbalance_ticks > 0 && (force > 0) != (watch->unbalance_mN > 0);
    if (crn_size_of(force) < UNBALANCE_mN || turns) {
        restart_watch(watch, moved);
        return CRN_FAULT_CODE_NONE;
    }
    watch->unbalance_ticks++;
    watch->unbalance_mN = force;
    watch->moved_counts += moved;
    watch->is_still = moved == 0 && (watch->unbalance_ticks == 1 || watch->is_still);
    watch->speed_nm += (int64_t)(crn_size_of(force) - CARRIAGE_FRICTION_mN) * CARRIAGE_PER_kg;
    watch->travel_nm += watch->speed_nm;
    const int64_t count_pm = safety->tracks[k].translation_pm_per_count;
    if (watch->travel_nm < CARRIAGE_TRAVEL_nm || watch->travel_nm * 250 < count_pm)
        return CRN_FAULT_CODE_NONE;
    const int64_t gained = watch->moved_counts - (int64_t)watch->speed_counts * watch->unbalance_ticks;
    const int64_t gained_nm = crn_quotient(gained * count_pm, 1000), travel_nm = watch->travel_nm;
    const bool stood = watch->is_still && watch->speed_counts == 0;
    restart_watch(watch, moved);
    if (stood) return CRN_FAULT_CODE_ENCODER_STUCK;
    return (force > 0 ? -gained_nm : gained_nm) > travel_nm / 2 ? CRN_FAULT_CODE_ENCODER_REVERSED
                                                                : CRN_FAULT_CODE_NONE;
}

/* --- one track, the lines, everything --- */

/* Requirement: SR-13 */
static bool force_sensor_is_lost(const crn_safety *safety, const crn_port_inputs *rig, uint32_t k)
{
    const uint8_t sensor = rig->tracks[k].force_sensor;
    if (sensor == CRN_PORT_SENSOR_ABSENT) return safety->watches[k].had_force_sensor;
    return sensor != CRN_PORT_SENSOR_OK ||
           crn_size_of(crn_safety_force_mN(safety, rig, k)) > FORCE_PLAUSIBLE_mN;
}

static bool encoder_is_lost(const crn_port_track *track)
{
    return track->translation_sensor != CRN_PORT_SENSOR_OK || track->rotation_sensor != CRN_PORT_SENSOR_OK;
}

static crn_fault_code check_track(crn_safety *safety, const crn_safety_input *input, uint32_t k,
                                  int32_t *value)
{
    const crn_port_track *track = &input->rig->tracks[k];
    const bool is_driven = safety->is_driving && k < input->tool_count;
    const bool has_sensor = track->force_sensor == CRN_PORT_SENSOR_OK;
    const int32_t measured = crn_safety_force_mN(safety, input->rig, k);
    crn_fault_code code = CRN_FAULT_CODE_NONE;
    *value = measured;
    if (is_driven) {
        *value = track->translation_sensor == CRN_PORT_SENSOR_OK;
        if (encoder_is_lost(track)) return CRN_FAULT_CODE_ENCODER_LOST;
        *value = measured;
        if (force_sensor_is_lost(safety, input->rig, k)) return CRN_FAULT_CODE_FORCE_SENSOR_LOST;
        if (lasts(&safety->watches[k].current_ticks, track->over_current, CURRENT_ticks))
            return CRN_FAULT_CODE_OVER_CURRENT;
    }
    if (has_sensor) code = check_force(safety, k, measured);
    if (code != CRN_FAULT_CODE_NONE || !is_driven) return code;
    if (has_sensor) code = check_balance(safety, input->rig, k, measured);
    return code != CRN_FAULT_CODE_NONE ? code : crn_carriage_check(safety, input, k, value);
}

/* Requirement: SR-15 */
static bool stage_is_stuck(const crn_safety *safety, const crn_safety_input *input)
{
    return !safety->is_driving && input->rig != NULL && input->rig->stage_on &&
           safety->idle_ticks > STAGE_ticks;
}

/* Requirement: SR-14, SR-15 */
static crn_fault_code check_lines(crn_safety *safety, const crn_safety_input *input)
{
    const crn_port_inputs *rig = input->rig;
    if (!safety->is_driving)
        return stage_is_stuck(safety, input) ? CRN_FAULT_CODE_STAGE_STUCK : CRN_FAULT_CODE_NONE;
    if (rig->emergency_stop) return CRN_FAULT_CODE_EMERGENCY_STOP;
    if (!rig->supply_good) return CRN_FAULT_CODE_SUPPLY_LOST;
    if (!rig->stage_on && (safety->stage_was_on || safety->drive_ticks > STAGE_ticks))
        return CRN_FAULT_CODE_STAGE_LOST;
    safety->stage_was_on = safety->stage_was_on || rig->stage_on;
    return CRN_FAULT_CODE_NONE;
}

static void check_rig(crn_safety *safety, const crn_safety_input *input, crn_findings *findings)
{
    crn_fault_code code = check_lines(safety, input);
    if (code != CRN_FAULT_CODE_NONE) {
        crn_findings_add(findings, code, 0, 0);
        return;
    }
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        int32_t value = 0;
        code = check_track(safety, input, k, &value);
        safety->watches[k].last = input->rig->hands[k];
        if (code == CRN_FAULT_CODE_NONE) continue;
        crn_findings_add(findings, code, (int32_t)k, value);
        return;
    }
}

/* A fault is reported once. In the state FAULT the motors have no power that could be removed, but the check
 * still reports a power stage that does not switch off, whatever the cause. */
void crn_safety_check(crn_safety *safety, const crn_safety_input *input, crn_findings *findings)
{
    safety->drive_ticks = safety->is_driving ? safety->drive_ticks + 1 : 0;
    if (!safety->is_driving && safety->idle_ticks < UINT32_MAX) safety->idle_ticks++;
    const bool is_stuck = stage_is_stuck(safety, input), is_reported = safety->stage_is_reported;
    safety->stage_is_reported = is_stuck;
    if (input->is_stopped) {
        if (is_stuck && !is_reported) crn_findings_add(findings, CRN_FAULT_CODE_STAGE_STUCK, 0, 0);
        return;
    }
    if (input->rig == NULL) {
        if (safety->is_driving) crn_findings_add(findings, CRN_FAULT_CODE_RIG_LOST, 0, 0);
        return;
    }
    check_rig(safety, input, findings);
}

/* Requirement: SR-13 */
crn_fault_code crn_safety_ready(const crn_safety *safety, const crn_safety_input *input)
{
    const crn_port_inputs *rig = input->rig;
    if (rig == NULL) return CRN_FAULT_CODE_RIG_LOST;
    if (rig->emergency_stop) return CRN_FAULT_CODE_EMERGENCY_STOP;
    if (!rig->supply_good) return CRN_FAULT_CODE_SUPPLY_LOST;
    if (rig->stage_on && safety->idle_ticks > STAGE_ticks) return CRN_FAULT_CODE_STAGE_STUCK;
    for (uint32_t k = 0; k < input->tool_count; k++) {
        const crn_port_track *track = &rig->tracks[k];
        if (encoder_is_lost(track)) return CRN_FAULT_CODE_ENCODER_LOST;
        /* For a track without a force sensor, no force is checked. For a track without a force sensor, motor
         * power needs the permission of a person at the rig, who knows that no forces are checked. */
        const bool has_none = track->force_sensor == CRN_PORT_SENSOR_ABSENT;
        if (has_none ? !rig->local_unlock : force_sensor_is_lost(safety, rig, k))
            return CRN_FAULT_CODE_FORCE_SENSOR_LOST;
        if (crn_size_of(crn_safety_force_mN(safety, rig, k)) > FORCE_REST_mN)
            return CRN_FAULT_CODE_ACTUATOR_STUCK_ON;
        if (track->over_current) return CRN_FAULT_CODE_OVER_CURRENT;
    }
    return CRN_FAULT_CODE_NONE;
}
