/* This file detects oscillations ("cycles") that a motor sustains in a hand (docs/haptics.md, "Cycles").
 * Between two reversals of the carriage, the hand may do work on the carriage, as in a tremor or a deliberate
 * shake. The hand may also absorb work from the carriage, as in an oscillation that the control loop of
 * coupling and motor produces by itself. In an oscillation that the motor sustains, the carriage swings
 * faster than any heart beats and does not slow down, although the hand absorbs work. */
#include "firmware/app/safety/arithmetic.h"
#include "firmware/app/safety/carriage.h"

enum {
    TURN_nm = 10000,       /* back by this much is a turn; at least two counts */
    CYCLE_ticks = 150,     /* there and back; a heart of 200 a minute takes 300 */
    SPAN_mN = 100,         /* twice the 50 mN that no hand need feel */
    SPAN_UNFELT_mN = 1000, /* without a sensor nothing is known of the hand: a tremor gives less */
    LASTS_ticks = 25,      /* beyond the first cycle, which shows that the carriage does not slow down */
};

/* Limits a sum that was formed over one oscillation. Overflow is impossible: one tick adds at most 10^7 nm
 * times 2^31 mN, and each sum is limited to 2^44, that is, 17 km of travel or 17 J of work. The mean force
 * that a sensor may measure is below 2^17 mN. */
static int64_t limited(int64_t value)
{
    const int64_t most = (int64_t)1 << 44;
    return value > most ? most : value < -most ? -most : value;
}

static int64_t width_nm(const crn_safety_swing *swing)
{
    return swing->travel_nm < 0 ? -swing->travel_nm : swing->travel_nm;
}

/* Returns the hand's work in two swings of the carriage, computed from the hand's force less the mean force.
 * The mean force must be subtracted, because a growing oscillation does not return to the position
 * where it began. Without the subtraction of the mean force, the steady force with which the hand presses
 * against a wall would count as work. Overflow is impossible, because travels are below 2^41 nm and the mean
 * is below 2^31 mN / CYCLE_ticks. */
static int64_t hand_pJ(const crn_safety_swing *now, const crn_safety_swing *last)
{
    const int64_t mean_mN = crn_quotient(now->hand_mN_ms + last->hand_mN_ms, now->ticks + last->ticks);
    return now->hand_pJ + last->hand_pJ - mean_mN * (now->travel_nm + last->travel_nm);
}

/* Returns whether two successive swings of the carriage are one oscillation that the motor sustains. The two
 * swings must be fast, strong enough to be felt, and equally wide within a factor of 7/8. When the softest
 * hand holds the handle, the damping of a rig whose settings are correct reduces each swing to 0.81 of the
 * previous swing. The hand must also have absorbed more work than 1/64 of the oscillation's force range times
 * its travel range; the noise of the sensor alone reaches a fifth of this work. */
static bool is_sustained(const crn_safety_swing *now, const crn_safety_swing *last, bool is_felt)
{
    const int32_t low = now->low_mN < last->low_mN ? now->low_mN : last->low_mN,
                  high = now->high_mN > last->high_mN ? now->high_mN : last->high_mN;
    const int64_t span_mN = (int64_t)high - low;
    if (last->ticks == 0 || now->ticks > CYCLE_ticks || last->ticks > CYCLE_ticks - now->ticks) return false;
    if (width_nm(now) < width_nm(last) - width_nm(last) / 8) return false;
    if (!is_felt) return span_mN > SPAN_UNFELT_mN;
    return span_mN > SPAN_mN && hand_pJ(now, last) < -span_mN * width_nm(now) / 64;
}

static void turn(crn_safety_cycle *cycle, bool is_felt, int32_t driven_mN)
{
    cycle->now.travel_nm = cycle->far_nm;
    cycle->driven_ticks =
        is_sustained(&cycle->now, &cycle->last, is_felt) ? cycle->driven_ticks + cycle->now.ticks : 0;
    cycle->last = cycle->now;
    cycle->now = (crn_safety_swing){.low_mN = driven_mN, .high_mN = driven_mN};
    cycle->at_nm = limited(cycle->at_nm - cycle->far_nm);
    cycle->far_nm = cycle->at_nm;
    cycle->direction = -cycle->direction;
}

/* Requirement: SR-06 */
bool crn_cycle_lasts(crn_safety_cycle *cycle, const crn_carriage_edge *edge)
{
    const int32_t driven_mN = edge->driven_mN;
    const int64_t pm = edge->pm_per_count;
    const int64_t moved_nm = crn_quotient(edge->moved_counts * pm, 1000), two_nm = crn_quotient(2 * pm, 1000);
    if (cycle->now.ticks < UINT32_MAX) cycle->now.ticks++;
    if (driven_mN < cycle->now.low_mN) cycle->now.low_mN = driven_mN;
    if (driven_mN > cycle->now.high_mN) cycle->now.high_mN = driven_mN;
    cycle->now.hand_pJ = limited(cycle->now.hand_pJ + moved_nm * edge->measured_mN);
    cycle->now.hand_mN_ms = limited(cycle->now.hand_mN_ms + edge->measured_mN);
    cycle->at_nm = limited(cycle->at_nm + moved_nm);
    if (cycle->direction == 0) cycle->direction = 1;
    if ((cycle->at_nm - cycle->far_nm) * cycle->direction > 0) cycle->far_nm = cycle->at_nm;
    const int64_t back_nm = (cycle->far_nm - cycle->at_nm) * cycle->direction;
    if (back_nm > (two_nm > TURN_nm ? two_nm : TURN_nm)) turn(cycle, edge->is_felt, driven_mN);
    return cycle->driven_ticks >= LASTS_ticks;
}
