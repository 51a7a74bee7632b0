/* Two steps are required before START may power the motors: the device answers ARM_MOTORS with a code, and
 * CONFIRM returns it. Code and permission are for a person who is about to press START, so both expire. */
#ifndef CRN_PERMISSION_H
#define CRN_PERMISSION_H

#include <stdbool.h>
#include <stdint.h>

typedef struct crn_permission {
    bool is_given;      /* CONFIRM came: the next START powers the motors */
    uint32_t code;      /* 0: none is valid */
    uint32_t age_ticks; /* of the code, or of the permission */
    uint32_t code_count;
} crn_permission;

/* ARM_MOTORS: a new code, never 0, which no frame holds by chance. `now_us` is the port's clock. */
void crn_permission_offer(crn_permission *permission, uint32_t now_us);

/* CONFIRM: any answer spends the code, the wrong one too. True: it was the right one. */
bool crn_permission_answer(crn_permission *permission, uint32_t code);

/* The answer was right and the rig is ready: the next START may power the motors. */
void crn_permission_give(crn_permission *permission);

/* One edge of the timer has passed. */
void crn_permission_age(crn_permission *permission);

/* No code and no permission is valid any more. */
void crn_permission_spend(crn_permission *permission);

#endif
