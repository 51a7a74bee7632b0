/* What a motor may do to a carriage that nobody holds (docs/haptics.md, "A carriage that nobody holds"): its
 * force goes, and it makes the carriage no faster than a hand would. Looked at once per edge in this edge's
 * sample, behind everything that decides the force that is asked for: what is asked for stays a matter of
 * encoder counts and core alone, and a session replays. */
#include "firmware/app/app_internal.h"

enum {
    LOOSE_mN =
        40, /* that a carriage may be given without a hand: below the 50 mN of a cycle that a hand may feel */
    LOOSE_GRACE_ticks = 12, /* a hand meets a wall with as much: what brakes it is not held yet */
    LOOSE_FADE_ticks = 20,
    DRIVEN_FULL_um_s =
        30000, /* a carriage that moves along its motor's force: up to here all that is asked for, ... */
    DRIVEN_NONE_um_s =
        100000, /* ... from here on what the hand holds: a tick and a motor's lag later it has 0.25 m/s */
    BRAKED_FULL_um_s = 80000, /* against it, as far as its encoder is right */
    BRAKED_NONE_um_s = 180000,
    SPEED_MAX_um_s = 250000,
    SPEED_GAINED_um_s = 150000,
    IMPULSE_uN_s = 2500, /* what gives 0.15 m/s to 17 g */
    TOUCH_mN = 100,      /* inertia and friction of a handle */
    FAST_ticks = 2,
    PASSIVITY_ticks = 100,
};

static int32_t size_of(int32_t value)
{
    return value < 0 ? -value : value;
}

/* Counts since the last edge, + into the patient. */
int32_t crn_app_carriage_moved(const crn_app *app, uint32_t k)
{
    const uint32_t now = (uint32_t)app->edge.rig.hands[k].translation_counts,
                   last = (uint32_t)app->safety.watches[k].last.translation_counts;
    const bool is_reversed = (app->setup.tracks[k].wire.options & CRN_WIRE_OPTION_TRANSLATION_REVERSED) != 0;
    return crn_wire_i32_from_u32(is_reversed ? last - now : now - last);
}

/* Speed that the carriage has at least, whatever lies between two counts: over one tick or over eight, where
 * counts are coarse. Format: counts x pm / 1000 per ms = um/s. Overflow: 8 x twice 5 mm in pm is below 2^37;
 * held to 10 m/s. */
static int32_t speed_um_s(const crn_app *app, uint32_t k)
{
    const crn_app_watch *watch = &app->safety.watches[k];
    const int64_t pm = app->setup.tracks[k].wire.translation_pm_per_count;
    int64_t sum = 0, fastest = 0;
    for (uint32_t i = 0; i < CRN_APP_ASKED_ticks; i++) sum += watch->moved[i];
    const int64_t ways[2] = {watch->moved[app->safety.asked_at], sum};
    for (uint32_t i = 0; i < 2; i++) {
        const int64_t sure = (ways[i] < 0 ? -ways[i] : ways[i]) - 1;
        const int64_t size =
            sure <= 0 ? 0 : crn_app_quotient(sure * pm, i == 0 ? 1000 : 1000 * CRN_APP_ASKED_ticks);
        if (size > (fastest < 0 ? -fastest : fastest)) fastest = ways[i] < 0 ? -size : size;
    }
    const int64_t most = 10000000;
    return (int32_t)(fastest > most ? most : fastest < -most ? -most : fastest);
}

/* --- how much --- */

enum { SHARE_ONE = 4096 };

/* Share of what nobody holds, from all of it at `full` to nothing at `none`. */
static int32_t share_of(int32_t value, int32_t full, int32_t none)
{
    if (value <= full) return SHARE_ONE;
    return value >= none ? 0 : (none - value) / 16 * SHARE_ONE / ((none - full) / 16);
}

/* By the speed that the carriage will have when the force is there: now it gains as much per tick as in the
 * last one. */
static int32_t speed_share(const crn_app *app, uint32_t k, int32_t asked_mN)
{
    const crn_app_watch *watch = &app->safety.watches[k];
    const uint32_t before = (app->safety.asked_at + CRN_APP_ASKED_ticks - 1) % CRN_APP_ASKED_ticks;
    const int32_t speed = speed_um_s(app, k);
    const int64_t gained = (int64_t)watch->moved[app->safety.asked_at] - watch->moved[before];
    const int64_t gained_um_s =
        crn_app_quotient(gained * app->setup.tracks[k].wire.translation_pm_per_count, 1000);
    const bool is_faster = (gained_um_s > 0) == (speed > 0);
    const int32_t size = size_of(speed + (is_faster ? (int32_t)gained_um_s : 0)); /* both below 2^25 */
    const bool is_braked = (speed > 0) == (asked_mN > 0) && speed != 0; /* + pushes out, + moves in */
    return is_braked ? share_of(size, BRAKED_FULL_um_s, BRAKED_NONE_um_s)
                     : share_of(size, DRIVEN_FULL_um_s, DRIVEN_NONE_um_s);
}

/* The largest force that the track may be given now. A hand that holds is felt by the force sensor, which may
 * be wrong by a quarter. Of a track without one nothing is known of the hand, and the speed alone counts. */
int32_t crn_app_carriage_bound(crn_app *app, uint32_t k, int32_t asked_mN)
{
    crn_app_watch *watch = &app->safety.watches[k];
    const int32_t measured = crn_app_force_measured(app, k), most = 2 * CRN_APP_FORCE_LIMIT_mN;
    const int32_t by_speed = speed_share(app, k, asked_mN), size = size_of(asked_mN);
    int32_t held = asked_mN < 0 ? -measured : measured;
    held = held < 0 ? 0 : held > most ? most : held;
    const int32_t sure = LOOSE_mN + held + held / 3;
    const bool has_sensor = app->edge.rig.tracks[k].force_sensor == CRN_PORT_SENSOR_OK;
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

/* A hand may throw a carriage, and then it is fast without a motor; it may move it as fast as it likes, and
 * then it is felt. What is left is a carriage that gained its speed while nobody touched it and a motor
 * pushed. */
static bool is_driven_fast(crn_app *app, uint32_t k)
{
    crn_app_watch *watch = &app->safety.watches[k];
    const int32_t speed = size_of(speed_um_s(app, k));
    const bool is_touched = size_of(crn_app_force_measured(app, k)) >= TOUCH_mN ||
                            app->edge.rig.tracks[k].force_sensor != CRN_PORT_SENSOR_OK;
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
    watch->impulse_uN_s += size_of(app->safety.driven[k].axial_mN);
    const bool is_fast = speed > SPEED_MAX_um_s && speed - watch->speed_begin_um_s >= SPEED_GAINED_um_s &&
                         watch->impulse_uN_s >= IMPULSE_uN_s;
    watch->fast_ticks = is_fast ? watch->fast_ticks + 1 : 0;
    return watch->fast_ticks >= FAST_ticks;
}

/* Of a track that is driven, in this edge's sample. */
crn_fault_code crn_app_carriage_check(crn_app *app, uint32_t k, int32_t *value)
{
    crn_app_watch *watch = &app->safety.watches[k];
    /* More than twice what is a jump is no motion, and sums of it fit. */
    const int32_t most = 2 * (int32_t)app->setup.tracks[k].translation_jump_counts;
    const int32_t told = crn_app_carriage_moved(app, k), moved = told > most    ? most
                                                                 : told < -most ? -most
                                                                                : told;
    watch->moved[app->safety.asked_at] = moved;
    if (is_driven_fast(app, k)) {
        *value = size_of(speed_um_s(app, k)) / 1000;
        return CRN_FAULT_CODE_CARRIAGE_FAST;
    }
    *value = (int32_t)crn_app_quotient(app->haptics.energies[k].taken_pJ, 1000) / 1000;
    watch->passivity_ticks = crn_app_gives_energy(&app->haptics.energies[k]) ? watch->passivity_ticks + 1 : 0;
    const bool lasts = watch->passivity_ticks >= PASSIVITY_ticks;
    return crn_app_cycle_lasts(app, k, moved) || lasts ? CRN_FAULT_CODE_PASSIVITY_LASTS : CRN_FAULT_CODE_NONE;
}
