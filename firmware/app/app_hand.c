/* From encoder counts to where the hands are, one per tool. Counts are absolute and may wrap, so changes are summed in 64 bits; the
 * position is scaled from the sum, never summed itself, so that rounding does not drift. Called by: app_session.c. */
#include "firmware/app/app_internal.h"

enum {
    TRANSLATION_MIN_pm = 1000,
    TRANSLATION_MAX_pm = 500000000,
    ROTATION_MIN_counts = 16,
    ROTATION_MAX_counts = 16777216,
    GAIN_MAX_milli = 4000,
};

void seld_app_hands_reset(seld_app *app)
{
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) app->hands[k] = (seld_app_hand){false, {0, 0}, 0, 0};
}

void seld_app_hands_take_reference(seld_app *app)
{
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) app->hands[k].is_known = false;
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

/* What one hand did since the last reading, or the fault that this would be. */
static seld_fault_code hand_moved(const seld_app_hand *hand, const seld_app_track *track,
                                  const seld_port_hand *now, int32_t moved[2])
{
    moved[0] = moved[1] = 0;
    if (!hand->is_known) return SELD_FAULT_CODE_NONE;
    moved[0] = count_difference(now->translation_counts, hand->last.translation_counts);
    moved[1] = count_difference(now->rotation_counts, hand->last.rotation_counts);
    if (exceeds(moved[0], track->translation_jump_counts)) return SELD_FAULT_CODE_ENCODER_JUMP_TRANSLATION;
    if (exceeds(moved[1], track->rotation_jump_counts)) return SELD_FAULT_CODE_ENCODER_JUMP_ROTATION;
    return SELD_FAULT_CODE_NONE;
}

/* Take a reading of every tool. After one unbelievable jump all hands stay where they were: false. */
bool seld_app_hands_update(seld_app *app, const seld_app_encoders *now)
{
    int32_t moved[SELD_TOOL_MAX][2];
    for (uint32_t k = 0; k < app->tool_count; k++) {
        seld_fault_code jump = hand_moved(&app->hands[k], &app->tracks[k], &now->hands[k], moved[k]);
        if (jump != SELD_FAULT_CODE_NONE) {
            bool is_turn = jump == SELD_FAULT_CODE_ENCODER_JUMP_ROTATION;
            seld_app_fault(app, jump, (int32_t)k, moved[k][is_turn]);
            return false;
        }
    }
    for (uint32_t k = 0; k < app->tool_count; k++) {
        app->hands[k].translation_counts += moved[k][0];
        app->hands[k].rotation_counts += moved[k][1];
        app->hands[k].last = now->hands[k];
        app->hands[k].is_known = true;
    }
    return true;
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

void seld_app_hands_input(const seld_app *app, seld_input *input)
{
    *input = (seld_input){0};
    for (uint32_t k = 0; k < app->tool_count; k++) {
        const seld_app_hand *hand = &app->hands[k];
        const seld_app_track *track = &app->tracks[k];
        input->hands[k].feed_m_q30 = feed_m_q30(hand->translation_counts, track->translation_m_q46_per_count);
        input->hands[k].turn32 = turn32(hand->rotation_counts, track->rotation_turn48_per_count);
    }
}

static bool in_range(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

/* Check everything, then take it over. Limits are lowered, never raised. False: *field names the offender. */
bool seld_app_track_set(seld_app_track *track, const seld_wire_track *wire, uint32_t *field)
{
    const bool ok[] = {
        in_range(wire->translation_pm_per_count, TRANSLATION_MIN_pm, TRANSLATION_MAX_pm),
        in_range(wire->rotation_counts_per_turn, ROTATION_MIN_counts, ROTATION_MAX_counts),
        wire->force_gain_milli <= GAIN_MAX_milli,
        wire->force_limit_mN <= (uint32_t)track->force_limit_mN,
        wire->torque_limit_uN_m <= (uint32_t)track->torque_limit_uN_m,
    };
    for (*field = 0; *field < sizeof ok / sizeof ok[0]; ++*field) {
        if (!ok[*field]) return false;
    }
    /* 2^46 m / 10^12 = 2^34 / 5^12 per picometre; 5e8 x 2^34 < 2^63. */
    track->translation_m_q46_per_count =
        seld_divide_u64(((uint64_t)wire->translation_pm_per_count << 34) + 122070312u, 244140625u);
    track->rotation_turn48_per_count = seld_divide_u64(
        ((uint64_t)1 << 48) + wire->rotation_counts_per_turn / 2, wire->rotation_counts_per_turn);
    track->translation_jump_counts =
        (uint32_t)seld_divide_u64((uint64_t)SELD_APP_JUMP_um * 1000000u, wire->translation_pm_per_count);
    track->rotation_jump_counts = wire->rotation_counts_per_turn / 4;
    track->force_gain_milli = wire->force_gain_milli;
    track->force_limit_mN = (int32_t)wire->force_limit_mN;
    track->torque_limit_uN_m = (int32_t)wire->torque_limit_uN_m;
    return true;
}

/* 1 um and 1/65 536 turn per count, true force. */
void seld_app_track_default(seld_app_track *track)
{
    const seld_wire_track wire = {1000000, 65536, 1000, SELD_APP_FORCE_LIMIT_mN, SELD_APP_TORQUE_LIMIT_uN_m};
    uint32_t field;
    track->force_limit_mN = SELD_APP_FORCE_LIMIT_mN;
    track->torque_limit_uN_m = SELD_APP_TORQUE_LIMIT_uN_m;
    seld_app_track_set(track, &wire, &field);
}
