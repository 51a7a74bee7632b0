/* Encoder counts as positions. */
#include "firmware/app/haptics/hands.h"
#include "firmware/app/safety/arithmetic.h"
#include "firmware/core/fixed.h"

void crn_hands_reset(crn_hands *hands)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++)
        hands->counts[k] = (crn_hand_counts){false, {0, 0}, 0, 0};
}

void crn_hands_take_reference(crn_hands *hands)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) hands->counts[k].is_known = false;
}

static bool exceeds(int32_t difference, uint32_t limit)
{
    int64_t wide = difference;
    return (wide < 0 ? -wide : wide) > (int64_t)limit;
}

/* Computes the travel of one hand since the last reading, or returns the fault that an implausible travel
 * indicates. */
static crn_fault_code hand_moved(const crn_hand_counts *hand, const crn_hand_track *track,
                                 const crn_port_hand *now, int32_t moved[2])
{
    moved[0] = moved[1] = 0;
    if (!hand->is_known) return CRN_FAULT_CODE_NONE;
    moved[0] = crn_wrapped_difference(now->translation_counts, hand->last.translation_counts);
    moved[1] = crn_wrapped_difference(now->rotation_counts, hand->last.rotation_counts);
    if (exceeds(moved[0], track->translation_jump_counts)) return CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION;
    if (exceeds(moved[1], track->rotation_jump_counts)) return CRN_FAULT_CODE_ENCODER_JUMP_ROTATION;
    if (track->is_translation_reversed) moved[0] = -moved[0];
    if (track->is_rotation_reversed) moved[1] = -moved[1];
    return CRN_FAULT_CODE_NONE;
}

/* Requirement: SR-12 */
bool crn_hands_update(crn_hands *hands, uint32_t tool_count, const crn_port_hand now[CRN_PORT_TOOL_MAX],
                      crn_findings *findings)
{
    int32_t moved[CRN_PORT_TOOL_MAX][2];
    for (uint32_t k = 0; k < tool_count; k++) {
        const crn_fault_code jump = hand_moved(&hands->counts[k], &hands->tracks[k], &now[k], moved[k]);
        if (jump == CRN_FAULT_CODE_NONE) continue;
        crn_findings_add(findings, jump, (int32_t)k, moved[k][jump == CRN_FAULT_CODE_ENCODER_JUMP_ROTATION]);
        return false;
    }
    for (uint32_t k = 0; k < tool_count; k++) {
        crn_hand_counts *hand = &hands->counts[k];
        hand->translation_counts += moved[k][0];
        hand->rotation_counts += moved[k][1];
        hand->last = now[k];
        hand->is_known = true;
    }
    return true;
}

/* Format: counts (int64) x Q46 m -> Q30 m, rounded. A hand position beyond +-1.9 m is replaced by this limit,
 * at which the core regards the tool as fully inserted or withdrawn. Overflow is impossible: the encoder
 * counts are bounded first, so that the product fits 63 bits. */
static int32_t feed_m_q30(int64_t counts, uint64_t m_q46_per_count)
{
    const int64_t limit_m_q46 = (int64_t)19 << 43; /* 2.375 m, above the limit below */
    int64_t counts_max = (int64_t)crn_divide_u64((uint64_t)limit_m_q46, m_q46_per_count);
    if (counts > counts_max) counts = counts_max;
    if (counts < -counts_max) counts = -counts_max;
    const int64_t feed_max = 2040109466; /* 1.9 m */
    return crn_limited(crn_rshift_round64(counts * (int64_t)m_q46_per_count, 16), -feed_max, feed_max);
}

/* Format: counts x 2^-48 turn -> 2^-32 turn modulo one turn. Overflow: the angle wraps around on purpose,
 * because whole turns do not matter. */
static uint32_t turn32(int64_t counts, uint64_t turn48_per_count)
{
    uint64_t turn48 = (uint64_t)counts * turn48_per_count;
    return (uint32_t)((turn48 + (1u << 15)) >> 16);
}

crn_hand_position crn_hands_position(const crn_hands *hands, uint32_t k)
{
    const crn_hand_counts *hand = &hands->counts[k];
    const crn_hand_track *track = &hands->tracks[k];
    return (crn_hand_position){feed_m_q30(hand->translation_counts, track->translation_m_q46_per_count),
                               turn32(hand->rotation_counts, track->rotation_turn48_per_count)};
}
