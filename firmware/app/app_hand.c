/* From encoder counts to where the hands are, one per tool. Counts are absolute and may wrap, so changes are
 * summed in 64 bits; the position is scaled from the sum, never summed itself, so that rounding does not
 * drift. */
#include "firmware/app/app_internal.h"

void crn_app_hands_reset(crn_app *app)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app->session.hands[k] = (crn_app_hand){false, {0, 0}, 0, 0};
}

void crn_app_hands_take_reference(crn_app *app)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app->session.hands[k].is_known = false;
}

/* Difference of two wrapping counters. Format: exact as long as the counter moved by less than 2^31. */
static int32_t count_difference(int32_t now, int32_t last)
{
    return crn_wire_i32_from_u32((uint32_t)now - (uint32_t)last);
}

static bool exceeds(int32_t difference, uint32_t limit)
{
    int64_t wide = difference;
    return (wide < 0 ? -wide : wide) > (int64_t)limit;
}

/* What one hand did since the last reading, or the fault that this would be. */
static crn_fault_code hand_moved(const crn_app_hand *hand, const crn_app_track *track,
                                 const crn_port_hand *now, int32_t moved[2])
{
    moved[0] = moved[1] = 0;
    if (!hand->is_known) return CRN_FAULT_CODE_NONE;
    moved[0] = count_difference(now->translation_counts, hand->last.translation_counts);
    moved[1] = count_difference(now->rotation_counts, hand->last.rotation_counts);
    if (exceeds(moved[0], track->translation_jump_counts)) return CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION;
    if (exceeds(moved[1], track->rotation_jump_counts)) return CRN_FAULT_CODE_ENCODER_JUMP_ROTATION;
    if (track->wire.options & CRN_WIRE_OPTION_TRANSLATION_REVERSED) moved[0] = -moved[0];
    if (track->wire.options & CRN_WIRE_OPTION_ROTATION_REVERSED) moved[1] = -moved[1];
    return CRN_FAULT_CODE_NONE;
}

/* Take a reading of every tool. After one unbelievable jump all hands stay where they were: false. */
bool crn_app_hands_update(crn_app *app, const crn_app_encoders *now)
{
    int32_t moved[CRN_TOOL_MAX][2];
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        crn_fault_code jump =
            hand_moved(&app->session.hands[k], &app->setup.tracks[k], &now->hands[k], moved[k]);
        if (jump != CRN_FAULT_CODE_NONE) {
            bool is_turn = jump == CRN_FAULT_CODE_ENCODER_JUMP_ROTATION;
            crn_app_fault(app, jump, (int32_t)k, moved[k][is_turn]);
            return false;
        }
    }
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        app->session.hands[k].translation_counts += moved[k][0];
        app->session.hands[k].rotation_counts += moved[k][1];
        app->session.hands[k].last = now->hands[k];
        app->session.hands[k].is_known = true;
    }
    return true;
}

/* Format: counts (int64) x Q46 m -> Q30 m, rounded; beyond +-1.9 m the hand is held there, which the core
 * treats as fully inserted or withdrawn. Overflow: counts are bounded first, so that the product fits 63
 * bits. */
static int32_t feed_m_q30(int64_t counts, uint64_t m_q46_per_count)
{
    const int64_t limit_m_q46 = (int64_t)19 << 43; /* 2.375 m, above what is kept below */
    int64_t counts_max = (int64_t)crn_divide_u64((uint64_t)limit_m_q46, m_q46_per_count);
    if (counts > counts_max) counts = counts_max;
    if (counts < -counts_max) counts = -counts_max;
    int64_t feed = crn_rshift_round64(counts * (int64_t)m_q46_per_count, 16);
    const int64_t feed_max = 2040109466; /* 1.9 m */
    if (feed > feed_max) feed = feed_max;
    if (feed < -feed_max) feed = -feed_max;
    return (int32_t)feed;
}

/* Format: counts x 2^-48 turn -> 2^-32 turn modulo one turn. Overflow: wraps on purpose, whole turns drop
 * out. */
static uint32_t turn32(int64_t counts, uint64_t turn48_per_count)
{
    uint64_t turn48 = (uint64_t)counts * turn48_per_count;
    return (uint32_t)((turn48 + (1u << 15)) >> 16);
}

void crn_app_hands_input(const crn_app *app, crn_input *input)
{
    *input = (crn_input){0};
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        const crn_app_hand *hand = &app->session.hands[k];
        const crn_app_track *track = &app->setup.tracks[k];
        input->hands[k].feed_m_q30 = feed_m_q30(hand->translation_counts, track->translation_m_q46_per_count);
        input->hands[k].turn32 = turn32(hand->rotation_counts, track->rotation_turn48_per_count);
    }
}
