/* This header simulates one to three coaxial tools in a vessel that forks; random hand motions push and turn
 * the tools. The tools are pushed at up to 0.5 m/s and turned at up to 12 rad/s. Every tool sometimes reaches
 * farther than the other tools, and is sometimes withdrawn. The test uses these functions for a short run,
 * and `make bench` uses them for a million ticks. */
#ifndef CRN_REFERENCE_RANDOM_HANDS_H
#define CRN_REFERENCE_RANDOM_HANDS_H

#include <stdint.h>

/* From this session number on, the innermost tool is of nitinol and the others of a soft metal, and all of
 * them yield. */
enum { REFERENCE_HANDS_WITH_MATERIALS = 1000 };
/* From this session number on, the vessel's walls give way besides. */
enum { REFERENCE_HANDS_WITH_WALLS = 2000 };

typedef struct reference_hands_result {
    int ticks;
    int deep;     /* ticks with a tool more than 1 mm beyond the wall, where the wall has given way to, by the
                 core     or by the exact distance */
    int long_045; /* ticks with more than 0.45 % length error */
    double strain_max_pct, depth_max_mm;
    int saturated;      /* ticks with the fault CRN_FAULT_SATURATED */
    double way_max_mm;  /* longest way of a wall that gives way */
    uint32_t sets_bits; /* bit k: tool k kept a set in some session */
} reference_hands_result;

/* Simulates `ticks` ticks of session number `session` and adds their results to `result`. The stiffness, tip
 * and shape of the tools and the motion of the hands depend on the session's number alone. The first 300
 * ticks, in which the rest shapes are applied gradually, are not counted. */
void reference_random_hands(uint32_t tool_count, uint32_t session, int ticks, reference_hands_result *result);

#endif
