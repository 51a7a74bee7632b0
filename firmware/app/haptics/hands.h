/* This header converts encoder counts to the positions of the user's hands, one hand per tool. The encoders'
 * counts are absolute and may wrap, so the code sums their changes in 64 bits. The position of a hand is
 * computed from the sum of its encoder counts and is never summed itself, so that rounding errors do not
 * accumulate. */
#ifndef CRN_HANDS_H
#define CRN_HANDS_H

#include "firmware/app/safety/finding.h"

/* Holds the scales of one track's encoders. */
typedef struct crn_hand_track {
    uint64_t translation_m_q46_per_count;
    uint64_t rotation_turn48_per_count; /* one turn = 2^48 */
    uint32_t translation_jump_counts;   /* largest believable change in one tick */
    uint32_t rotation_jump_counts;
    bool is_translation_reversed, is_rotation_reversed;
} crn_hand_track;

/* Holds one hand's encoder counts; these counts are part of the snapshot. */
typedef struct crn_hand_counts {
    bool is_known; /* false until the first reading, which only sets the zero */
    crn_port_hand last;
    int64_t translation_counts; /* since the start */
    int64_t rotation_counts;
} crn_hand_counts;

typedef struct crn_hands {
    crn_hand_track tracks[CRN_PORT_TOOL_MAX];
    crn_hand_counts counts[CRN_PORT_TOOL_MAX];
} crn_hands;

/* Holds the position of a user's hand, or the position that the virtual coupling gives to the core in place
 * of the hand's position. */
typedef struct crn_hand_position {
    int32_t feed_m_q30; /* along the line, + into the patient */
    uint32_t turn32;    /* about it, one turn = 2^32 */
} crn_hand_position;

/* Sets the positions of all hands to zero; later positions are measured from the next encoder reading. */
void crn_hands_reset(crn_hands *hands);

/* Takes the next reading as the present positions of the hands, not as a motion. */
void crn_hands_take_reference(crn_hands *hands);

/* Takes one encoder reading for every tool. If one encoder reading is an implausible jump, the function
 * reports a fault and returns false, and all hands keep their positions. */
bool crn_hands_update(crn_hands *hands, uint32_t tool_count, const crn_port_hand now[CRN_PORT_TOOL_MAX],
                      crn_findings *findings);

crn_hand_position crn_hands_position(const crn_hands *hands, uint32_t track);

#endif
