/* The length of each heartbeat is chosen when the beat begins. The phase of the heart advances evenly from
 * the beginning of a beat to the end of systole, and evenly from there to the next beat. Commands from the
 * host change the lengths of heartbeats, never the phase itself, so the phase has no jumps. */
#include "firmware/core/rhythm.h"

enum {
    MINUTE_ms = 60000,
    INTERVAL_MIN_ms = 300, /* shortest beat with variability */
    INTERVAL_MAX_ms = 2400,
    DIASTOLE_MIN_ms = 60, /* however early the next beat comes */
    NOTICE_ms = 40,       /* a premature beat comes no sooner than this after its order */
    BEAT_MAX_ms = 1 << 30,
    BREATH_PER_MIN = 71583, /* 2^32 / 60 000: phase of one tick at one breath a minute */
};

static uint32_t bounded(uint32_t value, uint32_t low, uint32_t high)
{
    return value < low ? low : (value > high ? high : value);
}

static uint32_t mean_interval_ms(const crn_rhythm *rhythm)
{
    return (uint32_t)crn_divide_u64(MINUTE_ms, rhythm->rate_per_min);
}

/* Returns a random number in the range -32 768 .. 32 767, by xorshift32 (Marsaglia 2003, 13-17-5). */
static int32_t next_random_q15(crn_rhythm *rhythm)
{
    uint32_t x = rhythm->random;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    rhythm->random = x;
    return (int32_t)(x >> 16) - 32768;
}

/* The sum of three uniform random numbers in the range -1 .. 1 has a variance of 1, and never exceeds three
 * standard deviations. */
static uint32_t varied_interval_ms(crn_rhythm *rhythm)
{
    uint32_t mean = mean_interval_ms(rhythm);
    if (rhythm->variability_milli == 0) {
        return mean;
    }
    int32_t deviate_q15 = next_random_q15(rhythm) + next_random_q15(rhythm) + next_random_q15(rhythm);
    int32_t scale_ms = (int32_t)(mean * rhythm->variability_milli / 1000u);
    int32_t interval = (int32_t)mean + crn_asr32(deviate_q15 * scale_ms, 15);
    return bounded(interval < 0 ? 0 : (uint32_t)interval, INTERVAL_MIN_ms, INTERVAL_MAX_ms);
}

/* Shortens the present interval between two heartbeats to the coupling interval of a commanded premature
 * beat, if enough of the present interval is left. */
static void place_premature(crn_rhythm *rhythm)
{
    uint32_t cut = mean_interval_ms(rhythm) * rhythm->premature_milli / 1000u;
    uint32_t least = rhythm->systole_ms + DIASTOLE_MIN_ms;
    cut = cut < least ? least : cut;
    if (cut >= rhythm->interval_ms) { /* the next beat comes at least as early anyway */
        cut = rhythm->interval_ms;
    }
    if (rhythm->beat_ms + NOTICE_ms > cut) {
        return; /* too late for this beat: it follows the next one */
    }
    rhythm->interval_ms = cut;
    rhythm->premature_milli = 0;
    rhythm->bits |= CRN_RHYTHM_NEXT_PREMATURE;
}

/* The interval before a premature beat is short and the pause after this beat is long: the two intervals
 * together are as long as two mean intervals. */
static void begin_premature(crn_rhythm *rhythm)
{
    uint32_t before = rhythm->interval_ms;
    uint32_t mean = mean_interval_ms(rhythm);
    uint32_t pause = 2 * mean > before ? 2 * mean - before : mean;
    uint32_t rate = bounded((uint32_t)crn_divide_u64(MINUTE_ms, before), rhythm->rate_per_min,
                            CRN_HEART_RATE_MAX_per_min);
    rhythm->systole_ms = crn_systole_ms(rate);
    rhythm->interval_ms = bounded(pause, rhythm->systole_ms + DIASTOLE_MIN_ms, 2 * INTERVAL_MAX_ms);
    rhythm->bits |= CRN_RHYTHM_IS_PREMATURE;
}

static void begin_beat(crn_rhythm *rhythm)
{
    const uint32_t was = rhythm->bits;
    rhythm->bits &= ~(uint32_t)(CRN_RHYTHM_IS_PREMATURE | CRN_RHYTHM_NEXT_PREMATURE | CRN_RHYTHM_IS_RESTING);
    rhythm->heart_phase32 = 0;
    rhythm->beat_ms = 0;
    rhythm->beat_count++;
    if ((was & CRN_RHYTHM_NEXT_PREMATURE) != 0) {
        begin_premature(rhythm);
        return;
    }
    rhythm->interval_ms = varied_interval_ms(rhythm);
    rhythm->systole_ms = crn_systole_ms(rhythm->rate_per_min);
    if (rhythm->systole_ms + DIASTOLE_MIN_ms > rhythm->interval_ms) {
        rhythm->systole_ms = rhythm->interval_ms - DIASTOLE_MIN_ms;
    }
    if (rhythm->premature_milli != 0) {
        place_premature(rhythm);
    }
}

/* Each remaining tick of systole or diastole advances the phase by an equal part of the remaining phase; the
 * last tick takes all of the remainder. Format: 2^-32 cycle. Overflow: impossible, 2^32 x 2^31. Error: 4 LSB.
 */
static uint32_t share_of(uint32_t left, uint32_t ticks)
{
    if (ticks <= 1) {
        return left;
    }
    unsigned lead = crn_clz32(ticks) - 1;
    uint64_t inverse = (uint32_t)crn_reciprocal_q30(ticks << lead); /* 2^61 / (ticks 2^lead) */
    return (uint32_t)((left * inverse) >> (61 - lead));
}

/* Advances the heartbeat's phase by one tick. Overflow is impossible, because 2^32 less a positive phase fits
 * 32 bits. */
static void go_on(crn_rhythm *rhythm)
{
    uint32_t *phase = &rhythm->heart_phase32;
    rhythm->beat_ms++;
    if (rhythm->beat_ms >= rhythm->interval_ms) {
        *phase = 0;
        if ((rhythm->bits & CRN_RHYTHM_WANTS_ASYSTOLE) != 0) {
            rhythm->bits |= CRN_RHYTHM_IS_RESTING;
            rhythm->bits &= ~(uint32_t)CRN_RHYTHM_NEXT_PREMATURE;
            rhythm->premature_milli = 0;
        } else {
            begin_beat(rhythm);
        }
    } else if (rhythm->beat_ms <= rhythm->systole_ms) {
        *phase += share_of(CRN_PHASE_SYSTOLE_END - *phase, rhythm->systole_ms - rhythm->beat_ms + 1);
    } else {
        *phase += share_of(0u - *phase, rhythm->interval_ms - rhythm->beat_ms + 1);
    }
}

bool crn_rhythm_order_is_valid(const crn_rhythm_order *order)
{
    static const struct {
        uint32_t low, high;
    } ranges[CRN_RHYTHM_ACTION_COUNT] = {
        [CRN_RHYTHM_KEEP] = {0, 0},
        [CRN_RHYTHM_HEART_RATE] = {CRN_HEART_RATE_MIN_per_min, CRN_HEART_RATE_MAX_per_min},
        [CRN_RHYTHM_VARIABILITY] = {0, CRN_HEART_VARIABILITY_MAX_milli},
        [CRN_RHYTHM_PREMATURE] = {CRN_HEART_COUPLING_MIN_milli, CRN_HEART_COUPLING_MAX_milli},
        [CRN_RHYTHM_ASYSTOLE] = {0, 1},
        [CRN_RHYTHM_BREATH_RATE] = {CRN_BREATH_RATE_MIN_per_min, CRN_BREATH_RATE_MAX_per_min},
        [CRN_RHYTHM_BREATH_HOLD] = {0, 1},
    };
    return order->action < CRN_RHYTHM_ACTION_COUNT && order->value >= ranges[order->action].low &&
           order->value <= ranges[order->action].high;
}

static void set_bit(crn_rhythm *rhythm, uint32_t bit, uint32_t value)
{
    rhythm->bits = value != 0 ? rhythm->bits | bit : rhythm->bits & ~bit;
}

static void obey(crn_rhythm *rhythm, const crn_rhythm_order *order)
{
    switch (order->action) {
    case CRN_RHYTHM_HEART_RATE:
        rhythm->rate_per_min = order->value;
        break;
    case CRN_RHYTHM_VARIABILITY:
        rhythm->variability_milli = order->value;
        break;
    case CRN_RHYTHM_PREMATURE:
        if ((rhythm->bits & (CRN_RHYTHM_IS_RESTING | CRN_RHYTHM_NEXT_PREMATURE)) == 0) {
            rhythm->premature_milli = order->value;
            place_premature(rhythm);
        }
        break;
    case CRN_RHYTHM_ASYSTOLE:
        set_bit(rhythm, CRN_RHYTHM_WANTS_ASYSTOLE, order->value);
        break;
    case CRN_RHYTHM_BREATH_RATE:
        rhythm->breath_per_min = order->value;
        break;
    case CRN_RHYTHM_BREATH_HOLD:
        set_bit(rhythm, CRN_RHYTHM_HOLDS_BREATH, order->value);
        break;
    default:
        break;
    }
}

void crn_rhythm_init(crn_rhythm *rhythm)
{
    *rhythm = (crn_rhythm){.rate_per_min = CRN_HEART_RATE_START_per_min,
                           .breath_per_min = CRN_BREATH_RATE_START_per_min,
                           .random = CRN_RHYTHM_SEED};
    begin_beat(rhythm);
}

void crn_rhythm_step(crn_rhythm *rhythm, const crn_rhythm_order *order)
{
    if (order->action != CRN_RHYTHM_KEEP && crn_rhythm_order_is_valid(order)) {
        obey(rhythm, order);
    }
    if ((rhythm->bits & CRN_RHYTHM_HOLDS_BREATH) == 0) {
        rhythm->breath_phase32 += rhythm->breath_per_min * BREATH_PER_MIN;
    }
    if ((rhythm->bits & CRN_RHYTHM_IS_RESTING) == 0) {
        go_on(rhythm);
    } else if ((rhythm->bits & CRN_RHYTHM_WANTS_ASYSTOLE) == 0) {
        begin_beat(rhythm);
    } else if (rhythm->beat_ms < BEAT_MAX_ms) {
        rhythm->beat_ms++;
    }
}

/* Checks that the phase lies in the part of the heart's cycle (systole or diastole) that belongs to the time
 * beat_ms after the beginning of the beat. */
static bool phase_is_valid(const crn_rhythm *rhythm)
{
    if ((rhythm->bits & CRN_RHYTHM_IS_RESTING) != 0) {
        return rhythm->heart_phase32 == 0 && rhythm->beat_ms <= BEAT_MAX_ms;
    }
    if (rhythm->beat_ms >= rhythm->interval_ms) {
        return false;
    }
    return rhythm->beat_ms <= rhythm->systole_ms ? rhythm->heart_phase32 <= CRN_PHASE_SYSTOLE_END
                                                 : rhythm->heart_phase32 >= CRN_PHASE_SYSTOLE_END;
}

bool crn_rhythm_is_valid(const crn_rhythm *rhythm)
{
    const crn_rhythm_order wants[] = {
        {CRN_RHYTHM_HEART_RATE, rhythm->rate_per_min},
        {CRN_RHYTHM_VARIABILITY, rhythm->variability_milli},
        {rhythm->premature_milli == 0 ? CRN_RHYTHM_KEEP : CRN_RHYTHM_PREMATURE, rhythm->premature_milli},
        {CRN_RHYTHM_BREATH_RATE, rhythm->breath_per_min},
    };
    for (size_t i = 0; i < sizeof wants / sizeof wants[0]; i++) {
        if (!crn_rhythm_order_is_valid(&wants[i])) {
            return false;
        }
    }
    return rhythm->interval_ms <= 2 * INTERVAL_MAX_ms && rhythm->systole_ms > 0 &&
           rhythm->systole_ms < rhythm->interval_ms && rhythm->random != 0 && rhythm->bits < 32 &&
           phase_is_valid(rhythm);
}

int32_t crn_breath_depth_q15(uint32_t breath_phase32)
{
    int32_t sine_q30, cosine_q30;
    crn_sincos_turn32(breath_phase32 >> 1, &sine_q30, &cosine_q30);
    int32_t square_q30 = crn_mul_q30(sine_q30, sine_q30);
    return (int32_t)crn_rshift_round64(crn_product(square_q30, square_q30), 45);
}
