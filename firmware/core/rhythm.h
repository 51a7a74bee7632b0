/* This header defines the rhythm of heartbeat and breath, that is, the phase of heart and chest in their
 * cycles at each tick (docs/heart.md, "rhythm").
 *
 * A phase of 2^32 stands for one whole cycle of heart or breath. The heart's phase 0 is the beginning of the
 * QRS complex (end of filling). At every heart rate, the aortic valve closes at the phase
 * CRN_PHASE_SYSTOLE_END. Systole and diastole have separate lengths, and within each of them the phase is
 * linear in time. Phase 0 of breath is the end of expiration, and phase 2^31 is the end of inspiration.
 * Keyframe k of a scene's motion belongs to the phase k / 24 of a cycle, so that keyframe 10 is the end of
 * systole. */
#ifndef CRN_RHYTHM_H
#define CRN_RHYTHM_H

#include "firmware/core/fixed.h"

#define CRN_PHASE_SYSTOLE_END 1789569707u /* 10 / 24 of a cycle: the share of QS2 at 60 /min */

/* Ranges of the orders. */
enum {
    CRN_HEART_RATE_MIN_per_min = 40,
    CRN_HEART_RATE_MAX_per_min = 160,
    CRN_HEART_VARIABILITY_MAX_milli = 100,
    CRN_HEART_COUPLING_MIN_milli = 400,
    CRN_HEART_COUPLING_MAX_milli = 900,
    CRN_BREATH_RATE_MIN_per_min = 10,
    CRN_BREATH_RATE_MAX_per_min = 20,
    /* at the start */
    CRN_HEART_RATE_START_per_min = 70,
    CRN_BREATH_RATE_START_per_min = 14,
};
#define CRN_RHYTHM_SEED 2463534242u /* of the beat-to-beat variability */

/* Lists the commands to heart and breath that the input of a tick may contain. The numbers of the commands to
 * heart and breath are used in the wire protocol and in recordings. */
typedef enum crn_rhythm_action {
    CRN_RHYTHM_KEEP = 0,        /* nothing; value 0 */
    CRN_RHYTHM_HEART_RATE = 1,  /* beats per minute, from the next beat on */
    CRN_RHYTHM_VARIABILITY = 2, /* standard deviation of the intervals, 1/1000 of their mean */
    CRN_RHYTHM_PREMATURE = 3, /* a ventricular beat that comes after this many 1/1000 of the mean interval */
    CRN_RHYTHM_ASYSTOLE = 4,  /* 1: no beat follows the present one; 0: beats again */
    CRN_RHYTHM_BREATH_RATE = 5, /* breaths per minute */
    CRN_RHYTHM_BREATH_HOLD = 6, /* 1: the chest holds its position; 0: breathing continues */
    CRN_RHYTHM_ACTION_COUNT
} crn_rhythm_action;

typedef struct crn_rhythm_order {
    uint32_t action; /* crn_rhythm_action */
    uint32_t value;
} crn_rhythm_order;

enum {
    CRN_RHYTHM_IS_PREMATURE = 1u << 0,   /* the present beat came too early */
    CRN_RHYTHM_NEXT_PREMATURE = 1u << 1, /* the next one will come too early */
    CRN_RHYTHM_WANTS_ASYSTOLE = 1u << 2,
    CRN_RHYTHM_IS_RESTING = 1u << 3, /* the last beat is over and none has begun: phase 0 */
    CRN_RHYTHM_HOLDS_BREATH = 1u << 4,
};

/* Holds the rhythm of heart and breath, which is part of the core's state and consists of 32-bit words only.
 */
typedef struct crn_rhythm {
    uint32_t heart_phase32;
    uint32_t breath_phase32;
    uint32_t beat_ms;      /* since the QRS of the present beat, held at 2^30 */
    uint32_t interval_ms;  /* time from that QRS to the next one */
    uint32_t systole_ms;   /* time from the QRS to the closure of the aortic valve; 0 < systole < interval */
    uint32_t beat_count;   /* beats begun */
    uint32_t rate_per_min; /* wanted */
    uint32_t variability_milli;
    uint32_t premature_milli; /* coupling of a premature beat that is ordered and not placed yet, else 0 */
    uint32_t breath_per_min;
    uint32_t random; /* xorshift32, never 0 */
    uint32_t bits;   /* CRN_RHYTHM_* */
} crn_rhythm;

/* Sets the rhythm to its initial values: a heartbeat and a breath have just begun. */
void crn_rhythm_init(crn_rhythm *rhythm);

/* Returns whether the command is a known action whose value is in its range. */
bool crn_rhythm_order_is_valid(const crn_rhythm_order *order);

/* Advances the rhythm of heart and breath by one tick of 1 ms. An invalid command to heart or breath has no
 * effect. */
void crn_rhythm_step(crn_rhythm *rhythm, const crn_rhythm_order *order);

/* Returns whether crn_rhythm_step could have produced the given rhythm. The check is meant for states that
 * come from outside the core. */
bool crn_rhythm_is_valid(const crn_rhythm *rhythm);

/* Returns the depth of inspiration, from 0 at the end of expiration to 1 at the end of inspiration. The depth
 * of inspiration is sin^4(pi phase), which stays near 0 around the end of expiration (Lujan et al., Med Phys
 * 1999;26:715, n = 2). Format: phase -> Q15. Error: 1 LSB. */
int32_t crn_breath_depth_q15(uint32_t breath_phase32);

/* Returns the time from the QRS complex to the closure of the aortic valve in ms, which is 540 - 2.1 rate (in
 * beats a minute). The formula 540 - 2.1 rate is the mean of the formulas for men and women (Boudoulas et
 * al., Chest 1981;80:613: 541 - 2.2 rate and 540 - 2.0 rate). */
static inline uint32_t crn_systole_ms(uint32_t rate_per_min)
{
    return (5400u - 21u * rate_per_min) / 10u;
}

#endif
