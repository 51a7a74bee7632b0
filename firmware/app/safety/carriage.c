/* This file protects the user from a carriage (the moving handle) that nobody holds. The code ends the force
 * of the carriage's motor before the carriage becomes faster than a hand would move it (docs/haptics.md, "A
 * carriage that nobody holds"). The carriage checks run once per edge of the timer, with this edge's sensor
 * readings. The carriage checks run after all code that decides the requested force. The requested force
 * depends on encoder counts and the core alone, so a session can be replayed. */
#include "firmware/app/safety/carriage.h"
#include "firmware/app/safety/arithmetic.h"

enum {
    LOOSE_mN = 40, /* allowed on a carriage without a hand: below the 50 mN of a cycle that a hand may feel */
    LOOSE_GRACE_ticks = 12, /* a hand meets a wall with as much: the force that brakes it is not held yet */
    LOOSE_FADE_ticks = 20,
    /* When a carriage moves in the direction of its motor's force, the motor gives the full requested force
     * up to the speed DRIVEN_FULL_um_s. At the speed DRIVEN_NONE_um_s and above, the motor gives only as much
     * force as the hand resists. During the tick and the motor lag that pass before the force ends, the
     * carriage may still accelerate to 0.25 m/s. */
    DRIVEN_FULL_um_s = 30000,
    DRIVEN_NONE_um_s = 100000,
    /* If a carriage moves against its motor's force and the encoder works correctly, the limits
     * BRAKED_FULL_um_s and BRAKED_NONE_um_s replace DRIVEN_FULL_um_s and DRIVEN_NONE_um_s. */
    BRAKED_FULL_um_s = 80000,
    BRAKED_NONE_um_s = 180000,
    SPEED_MAX_um_s = 250000,
    SPEED_GAINED_um_s = 150000,
    SPEED_MOST_um_s = 10000000,
    IMPULSE_uN_s = 2500, /* gives 0.15 m/s to 17 g */
    TOUCH_mN = 100,      /* inertia and friction of a handle */
    FAST_ticks = 2,
    PASSIVITY_ticks = 100,
};

static const int64_t given_max_pJ = CRN_APP_GIVEN_MAX_mJ * (int64_t)1000000000;

/* A change of the counts that is larger than twice the largest plausible jump is not a motion, so the code
 * limits it, and no sum of the safety checks can overflow. */
int32_t crn_carriage_moved(const crn_safety *safety, const crn_port_inputs *rig, uint32_t k)
{
    const uint32_t now = (uint32_t)rig->hands[k].translation_counts,
                   last = (uint32_t)safety->watches[k].last.translation_counts;
    const int32_t most = 2 * (int32_t)safety->tracks[k].jump_counts;
    return crn_limited(crn_i32_from_u32(safety->tracks[k].is_reversed ? last - now : now - last), -most,
                       most);
}

/* Returns the smallest speed of the carriage that agrees with its encoder counts, wherever the carriage
 * stands between two counts. The speed is computed over one tick, or over eight ticks where counts are
 * coarse. Format: counts x pm / 1000 per ms = um/s. Overflow is impossible: 8 times twice 5 mm, in pm, is
 * below 2^37, and the speed is limited to 10 m/s. */
static int32_t speed_um_s(const crn_safety *safety, uint32_t k)
{
    const crn_safety_watch *watch = &safety->watches[k];
    const int64_t pm = safety->tracks[k].translation_pm_per_count;
    int64_t sum = 0, fastest = 0;
    for (uint32_t i = 0; i < CRN_APP_ASKED_ticks; i++) sum += watch->moved[i];
    const int64_t travels[2] = {watch->moved[safety->asked_at], sum};
    for (uint32_t i = 0; i < 2; i++) {
        const int64_t sure = (travels[i] < 0 ? -travels[i] : travels[i]) - 1;
        const int64_t size =
            sure <= 0 ? 0 : crn_quotient(sure * pm, i == 0 ? 1000 : 1000 * CRN_APP_ASKED_ticks);
        if (size > (fastest < 0 ? -fastest : fastest)) fastest = travels[i] < 0 ? -size : size;
    }
    return crn_limited(fastest, -SPEED_MOST_um_s, SPEED_MOST_um_s);
}

/* --- how much --- */

enum { SHARE_ONE = 4096 };

/* If no hand balances a force, only a fraction of the force may remain. The function computes the permitted
 * fraction of the force from `value`, which is a speed or a time. The permitted fraction is one (the whole
 * force) up to the value `full`, and zero at the value `none` and above. */
static int32_t share_of(int32_t value, int32_t full, int32_t none)
{
    if (value <= full) return SHARE_ONE;
    return value >= none ? 0 : (none - value) / 16 * SHARE_ONE / ((none - full) / 16);
}

/* Returns the fraction of the force that the carriage's speed permits. To estimate the speed that the
 * carriage will have when the force acts, the code assumes that the carriage gains as much speed in this tick
 * as in the last tick. */
static int32_t speed_share(const crn_safety *safety, uint32_t k, int32_t asked_mN)
{
    const crn_safety_watch *watch = &safety->watches[k];
    const uint32_t before = (safety->asked_at + CRN_APP_ASKED_ticks - 1) % CRN_APP_ASKED_ticks;
    const int32_t speed = speed_um_s(safety, k);
    const int64_t gained = (int64_t)watch->moved[safety->asked_at] - watch->moved[before];
    const int64_t gained_um_s = crn_quotient(gained * safety->tracks[k].translation_pm_per_count, 1000);
    const bool is_faster = (gained_um_s > 0) == (speed > 0);
    const int32_t size = crn_size_of(speed + (is_faster ? (int32_t)gained_um_s : 0)); /* both below 2^25 */
    const bool is_braked = (speed > 0) == (asked_mN > 0) && speed != 0; /* + pushes out, + moves in */
    return is_braked ? share_of(size, BRAKED_FULL_um_s, BRAKED_NONE_um_s)
                     : share_of(size, DRIVEN_FULL_um_s, DRIVEN_NONE_um_s);
}

/* The force sensor measures the force of a hand that holds the carriage; the reading may be wrong by up to a
 * quarter. For a track without a force sensor, the hand's force is unknown, and the limit depends on the
 * carriage's speed alone. */
/* Requirement: SR-04 */
int32_t crn_carriage_bound_mN(crn_safety *safety, const crn_port_inputs *rig, uint32_t k, int32_t asked_mN)
{
    crn_safety_watch *watch = &safety->watches[k];
    const int32_t measured = crn_safety_force_mN(safety, rig, k), most = 2 * CRN_APP_FORCE_LIMIT_mN;
    const int32_t by_speed = speed_share(safety, k, asked_mN), size = crn_size_of(asked_mN);
    const int32_t held = crn_limited(asked_mN < 0 ? -measured : measured, 0, most);
    const int32_t sure = LOOSE_mN + held + held / 3;
    const bool has_sensor = rig->tracks[k].force_sensor == CRN_PORT_SENSOR_OK;
    if (has_sensor && size > sure) {
        if (watch->loose_ticks < LOOSE_GRACE_ticks + LOOSE_FADE_ticks) watch->loose_ticks++;
    } else if (held > LOOSE_mN) {
        watch->loose_ticks = watch->loose_ticks > 2 ? watch->loose_ticks - 2 : 0;
    }
    if (size <= sure) return size;
    const int32_t by_time = share_of((int32_t)watch->loose_ticks * 1000, LOOSE_GRACE_ticks * 1000,
                                     (LOOSE_GRACE_ticks + LOOSE_FADE_ticks) * 1000);
    return sure + (size - sure) * (by_speed < by_time ? by_speed : by_time) / SHARE_ONE;
}

/* --- what stops --- */

/* Detects a carriage whose motor drives it too fast. A carriage is also fast if a hand throws it, although
 * its motor does not drive it. If a hand moves the carriage, at any speed, the sensor measures the hand's
 * force. The check reports a fault only if a carriage gained its speed while no hand touched it and its motor
 * pushed it. */
/* Requirement: SR-05 */
static bool is_driven_fast(crn_safety *safety, const crn_port_inputs *rig, uint32_t k)
{
    crn_safety_watch *watch = &safety->watches[k];
    const int32_t speed = crn_size_of(speed_um_s(safety, k));
    const bool is_touched = crn_size_of(crn_safety_force_mN(safety, rig, k)) >= TOUCH_mN ||
                            rig->tracks[k].force_sensor != CRN_PORT_SENSOR_OK;
    if (is_touched) {
        watch->untouched_ticks = watch->fast_ticks = 0;
        watch->speed_begin_um_s = speed;
        watch->impulse_uN_s = 0;
        return false;
    }
    if (watch->untouched_ticks < UINT32_MAX) watch->untouched_ticks++;
    if (speed < watch->speed_begin_um_s) {
        watch->speed_begin_um_s = speed;
        watch->impulse_uN_s = 0;
    }
    watch->impulse_uN_s += crn_size_of(safety->driven[k].axial_mN);
    const bool is_fast = speed > SPEED_MAX_um_s && speed - watch->speed_begin_um_s >= SPEED_GAINED_um_s &&
                         watch->impulse_uN_s >= IMPULSE_uN_s;
    watch->fast_ticks = is_fast ? watch->fast_ticks + 1 : 0;
    return watch->fast_ticks >= FAST_ticks;
}

static bool cycle_lasts(crn_safety *safety, const crn_port_inputs *rig, uint32_t k, int32_t moved)
{
    const crn_carriage_edge edge = {
        .moved_counts = moved,
        .driven_mN = safety->driven[k].axial_mN,
        .measured_mN = crn_safety_force_mN(safety, rig, k),
        .pm_per_count = safety->tracks[k].translation_pm_per_count,
        .is_felt = rig->tracks[k].force_sensor == CRN_PORT_SENSOR_OK,
    };
    return crn_cycle_lasts(&safety->watches[k].cycle, &edge);
}

/* Requirement: SR-06 */
crn_fault_code crn_carriage_check(crn_safety *safety, const crn_safety_input *input, uint32_t k,
                                  int32_t *value)
{
    crn_safety_watch *watch = &safety->watches[k];
    const int32_t moved = crn_carriage_moved(safety, input->rig, k);
    watch->moved[safety->asked_at] = moved;
    if (is_driven_fast(safety, input->rig, k)) {
        *value = crn_size_of(speed_um_s(safety, k)) / 1000;
        return CRN_FAULT_CODE_CARRIAGE_FAST;
    }
    *value = (int32_t)crn_quotient(input->energy_pJ[k], 1000) / 1000;
    const bool gives_energy = input->energy_pJ[k] < -given_max_pJ;
    watch->passivity_ticks = gives_energy ? watch->passivity_ticks + 1 : 0;
    const bool lasts = watch->passivity_ticks >= PASSIVITY_ticks;
    return cycle_lasts(safety, input->rig, k, moved) || lasts ? CRN_FAULT_CODE_PASSIVITY_LASTS
                                                              : CRN_FAULT_CODE_NONE;
}
