/* Cycles that a motor keeps up in a hand (docs/haptics.md, "Cycles"). From turn to turn of the carriage the
 * hand either puts work in, as in a tremor or a shake on purpose, or takes it, as in a cycle that the loop of
 * coupling and motor makes by itself. A carriage that goes forth and back without getting slower, faster than
 * any heart, while the hand takes work, is such a cycle. */
#include "firmware/app/app_internal.h"

enum {
    TURN_nm = 10000,       /* back by this much is a turn; at least two counts */
    CYCLE_ticks = 150,     /* forth and back; a heart of 200 a minute takes 300 */
    SPAN_mN = 100,         /* twice the 50 mN that no hand need feel */
    SPAN_UNFELT_mN = 1000, /* without a sensor nothing is known of the hand: a tremor gives less */
    LASTS_ticks = 25,      /* beyond the first cycle, which shows that it does not get slower */
};

/* Overflow: 10^7 nm per tick x 2^31 mN; sums are held to 2^44 (17 km, 17 J), a mean force that a sensor may
 * give is below 2^17. */
static int64_t limited(int64_t value)
{
    const int64_t most = (int64_t)1 << 44;
    return value > most ? most : value < -most ? -most : value;
}

static int64_t width_nm(const crn_app_swing *swing)
{
    return swing->way_nm < 0 ? -swing->way_nm : swing->way_nm;
}

/* What the hand put into two swings by more than its mean force: swings that grow do not end where they
 * began, and the force that holds against a wall would count. Overflow: ways below 2^41 nm, the mean below
 * 2^31 mN / CYCLE_ticks. */
static int64_t hand_pJ(const crn_app_swing *now, const crn_app_swing *last)
{
    const int64_t mean_mN = crn_app_quotient(now->hand_mN_ms + last->hand_mN_ms, now->ticks + last->ticks);
    return now->hand_pJ + last->hand_pJ - mean_mN * (now->way_nm + last->way_nm);
}

/* Two swings that are one cycle: as wide as each other (7/8, where the damping of an honest rig in the
 * softest hand leaves 0.81), fast, felt, and the hand took more than 1/64 of what the cycle's box of force
 * and way would hold (noise of the sensor: a fifth of that). */
static bool is_kept_up(const crn_app_swing *now, const crn_app_swing *last, bool is_felt)
{
    const int32_t low = now->low_mN < last->low_mN ? now->low_mN : last->low_mN,
                  high = now->high_mN > last->high_mN ? now->high_mN : last->high_mN;
    const int64_t span_mN = (int64_t)high - low;
    if (last->ticks == 0 || now->ticks > CYCLE_ticks || last->ticks > CYCLE_ticks - now->ticks) return false;
    if (width_nm(now) < width_nm(last) - width_nm(last) / 8) return false;
    if (!is_felt) return span_mN > SPAN_UNFELT_mN;
    return span_mN > SPAN_mN && hand_pJ(now, last) < -span_mN * width_nm(now) / 64;
}

static void turn(crn_app_cycle *cycle, bool is_felt, int32_t driven_mN)
{
    cycle->now.way_nm = cycle->far_nm;
    cycle->driven_ticks =
        is_kept_up(&cycle->now, &cycle->last, is_felt) ? cycle->driven_ticks + cycle->now.ticks : 0;
    cycle->last = cycle->now;
    cycle->now = (crn_app_swing){.low_mN = driven_mN, .high_mN = driven_mN};
    cycle->at_nm -= cycle->far_nm;
    cycle->far_nm = cycle->at_nm;
    cycle->direction = -cycle->direction;
}

bool crn_app_cycle_lasts(crn_app *app, uint32_t k, int32_t moved_counts)
{
    crn_app_cycle *cycle = &app->safety.watches[k].cycle;
    const bool is_felt = app->edge.rig.tracks[k].force_sensor == CRN_PORT_SENSOR_OK;
    const int32_t driven_mN = app->safety.driven[k].axial_mN, measured_mN = crn_app_force_measured(app, k);
    const int64_t pm = app->setup.tracks[k].wire.translation_pm_per_count;
    const int64_t moved_nm = crn_app_quotient(moved_counts * pm, 1000),
                  two_nm = crn_app_quotient(2 * pm, 1000);
    if (cycle->now.ticks < UINT32_MAX) cycle->now.ticks++;
    if (driven_mN < cycle->now.low_mN) cycle->now.low_mN = driven_mN;
    if (driven_mN > cycle->now.high_mN) cycle->now.high_mN = driven_mN;
    cycle->now.hand_pJ = limited(cycle->now.hand_pJ + moved_nm * measured_mN);
    cycle->now.hand_mN_ms = limited(cycle->now.hand_mN_ms + measured_mN);
    cycle->at_nm = limited(cycle->at_nm + moved_nm);
    if (cycle->direction == 0) cycle->direction = 1;
    if ((cycle->at_nm - cycle->far_nm) * cycle->direction > 0) cycle->far_nm = cycle->at_nm;
    const int64_t back_nm = (cycle->far_nm - cycle->at_nm) * cycle->direction;
    if (back_nm > (two_nm > TURN_nm ? two_nm : TURN_nm)) turn(cycle, is_felt, driven_mN);
    return cycle->driven_ticks >= LASTS_ticks;
}
