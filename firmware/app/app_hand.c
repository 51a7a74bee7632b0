/* From encoder counts to where the hand is. Counts are absolute and may wrap, so changes are summed in 64 bits; the
 * position is scaled from the sum, never summed itself, so that rounding does not drift. Called by: app_session.c. */
#include "firmware/app/app_internal.h"

enum {
    TRANSLATION_MIN_pm = 1000,
    TRANSLATION_MAX_pm = 500000000,
    ROTATION_MIN_counts = 16,
    ROTATION_MAX_counts = 16777216,
    GAIN_MAX_milli = 4000,
};

void seld_hand_reset(seld_hand *hand)
{
    *hand = (seld_hand){false, {0, 0, 0}, 0, 0};
}

/* Difference of two wrapping counters. Format: exact as long as the counter moved by less than 2^31. */
static int32_t count_difference(int32_t now, int32_t last)
{
    return seld_wire_i32_from_u32((uint32_t)now - (uint32_t)last);
}

static bool exceeds(int32_t difference, uint32_t limit)
{
    int64_t wide = difference;
    return (wide < 0 ? -wide : wide) > (int64_t)limit;
}

/* Take a reading. An unbelievable jump is refused: the hand stays where it was and value = {counts, limit}. */
seld_fault_code seld_hand_update(seld_hand *hand, const seld_rig *rig, const seld_port_encoders *now,
                                 int32_t value[2])
{
    if (!hand->is_known) {
        hand->is_known = true;
        hand->last = *now;
    }
    int32_t translation = count_difference(now->translation_counts, hand->last.translation_counts);
    int32_t rotation = count_difference(now->rotation_counts, hand->last.rotation_counts);
    if (exceeds(translation, rig->translation_jump_counts)) {
        value[0] = translation;
        value[1] = (int32_t)rig->translation_jump_counts;
        return SELD_FAULT_CODE_ENCODER_JUMP_TRANSLATION;
    }
    if (exceeds(rotation, rig->rotation_jump_counts)) {
        value[0] = rotation;
        value[1] = (int32_t)rig->rotation_jump_counts;
        return SELD_FAULT_CODE_ENCODER_JUMP_ROTATION;
    }
    hand->translation_counts += translation;
    hand->rotation_counts += rotation;
    hand->last = *now;
    return SELD_FAULT_CODE_NONE;
}

/* Format: counts (int64) x Q46 m -> Q30 m, rounded; beyond +-1.9 m the hand is held there, which the core treats as
 * fully inserted or withdrawn. Overflow: counts are bounded first, so that the product fits 63 bits. */
static int32_t feed_m_q30(int64_t counts, uint64_t m_q46_per_count)
{
    const int64_t limit_m_q46 = (int64_t)19 << 43; /* 2.375 m, above what is kept below */
    int64_t counts_max = (int64_t)seld_divide_u64((uint64_t)limit_m_q46, m_q46_per_count);
    if (counts > counts_max) counts = counts_max;
    if (counts < -counts_max) counts = -counts_max;
    int64_t feed = seld_rshift_round64(counts * (int64_t)m_q46_per_count, 16);
    const int64_t feed_max = 2040109466; /* 1.9 m */
    if (feed > feed_max) feed = feed_max;
    if (feed < -feed_max) feed = -feed_max;
    return (int32_t)feed;
}

/* Format: counts x 2^-48 turn -> 2^-32 turn modulo one turn. Overflow: wraps on purpose, whole turns drop out. */
static uint32_t turn32(int64_t counts, uint64_t turn48_per_count)
{
    uint64_t turn48 = (uint64_t)counts * turn48_per_count;
    return (uint32_t)((turn48 + (1u << 15)) >> 16);
}

void seld_hand_input(const seld_hand *hand, const seld_rig *rig, seld_input *input)
{
    input->hands[0].feed_m_q30 = feed_m_q30(hand->translation_counts, rig->translation_m_q46_per_count);
    input->hands[0].turn32 = turn32(hand->rotation_counts, rig->rotation_turn48_per_count);
}

static bool in_range(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

/* Check everything, then take it over. Limits are lowered, never raised. False: *field names the offender. */
bool seld_rig_set(seld_rig *rig, const seld_wire_rig *wire, uint32_t *field)
{
    const bool ok[] = {
        in_range(wire->translation_pm_per_count, TRANSLATION_MIN_pm, TRANSLATION_MAX_pm),
        in_range(wire->rotation_counts_per_turn, ROTATION_MIN_counts, ROTATION_MAX_counts),
        wire->force_gain_milli <= GAIN_MAX_milli,
        wire->force_limit_mN <= (uint32_t)rig->force_limit_mN,
        wire->torque_limit_uN_m <= (uint32_t)rig->torque_limit_uN_m,
    };
    for (*field = 0; *field < sizeof ok / sizeof ok[0]; ++*field) {
        if (!ok[*field]) return false;
    }
    /* 2^46 m / 10^12 = 2^34 / 5^12 per picometre; 5e8 x 2^34 < 2^63. */
    rig->translation_m_q46_per_count =
        seld_divide_u64(((uint64_t)wire->translation_pm_per_count << 34) + 122070312u, 244140625u);
    rig->rotation_turn48_per_count = seld_divide_u64(((uint64_t)1 << 48) + wire->rotation_counts_per_turn / 2,
                                                     wire->rotation_counts_per_turn);
    rig->translation_jump_counts =
        (uint32_t)seld_divide_u64((uint64_t)SELD_APP_JUMP_um * 1000000u, wire->translation_pm_per_count);
    rig->rotation_jump_counts = wire->rotation_counts_per_turn / 4;
    rig->force_gain_milli = wire->force_gain_milli;
    rig->force_limit_mN = (int32_t)wire->force_limit_mN;
    rig->torque_limit_uN_m = (int32_t)wire->torque_limit_uN_m;
    return true;
}

/* 1 um and 1/65 536 turn per count, true force. */
void seld_rig_default(seld_rig *rig)
{
    const seld_wire_rig wire = {1000000, 65536, 1000, SELD_APP_FORCE_LIMIT_mN, SELD_APP_TORQUE_LIMIT_uN_m};
    uint32_t field;
    rig->force_limit_mN = SELD_APP_FORCE_LIMIT_mN;
    rig->torque_limit_uN_m = SELD_APP_TORQUE_LIMIT_uN_m;
    seld_rig_set(rig, &wire, &field);
}
