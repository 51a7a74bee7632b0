/* This header moves one to three coaxial tools by random hands in a vessel that forks. Tools are pushed at up
 * to 0.5 m/s and turned at up to 12 rad/s, and every tool leads at some times and is withdrawn at others. The
 * test uses this header for a short run, and `make bench` for a million ticks. */
#ifndef CRN_REFERENCE_RANDOM_HANDS_H
#define CRN_REFERENCE_RANDOM_HANDS_H

#include <stdint.h>

typedef struct reference_hands_result {
    int ticks;
    int deep;     /* ticks with a tool more than 1 mm beyond the wall, by the core or by the exact distance */
    int long_045; /* ticks with more than 0.45 % length error */
    double strain_max_pct, depth_max_mm;
} reference_hands_result;

/* Adds `ticks` ticks of session number `session` to the result. Stiffness, tip, shape and hands depend on the
 * session's number alone. The first 300 ticks, in which the rest shapes are applied gradually, are not
 * counted. */
void reference_random_hands(uint32_t tool_count, uint32_t session, int ticks, reference_hands_result *result);

#endif
