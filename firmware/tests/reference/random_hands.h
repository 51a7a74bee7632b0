/* Random hands on one to three coaxial tools in a vessel that forks: pushed at up to 0.5 m/s, turned at up to
 * 12 rad/s, every tool now leading, now withdrawn. Used by the test (short) and by `make bench` (a million
 * ticks). */
#ifndef CRN_REFERENCE_RANDOM_HANDS_H
#define CRN_REFERENCE_RANDOM_HANDS_H

#include <stdint.h>

typedef struct reference_hands_result {
    int ticks;
    int deep; /* ticks with more than 1 mm of a tool beyond the wall, by the core or by the exact distance */
    int long_045; /* ticks with more than 0.45 % length error */
    double strain_max_pct, depth_max_mm;
} reference_hands_result;

/* Adds `ticks` ticks of session number `session` to the result. Stiffness, tip, shape and hands depend on the
 * number alone. The first 300 ticks, in which shapes are released, are not counted. */
void reference_random_hands(uint32_t tool_count, uint32_t session, int ticks, reference_hands_result *result);

#endif
