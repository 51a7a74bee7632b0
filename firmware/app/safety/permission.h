/* Two steps are required before START may power the motors: the device answers ARM_MOTORS with a code, and
 * CONFIRM returns it. Code and permission are meant for a person who is about to press START, so both
 * expire. */
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

/* Makes a new code for ARM_MOTORS. The code is never 0, and no frame contains it by chance. `now_us` is the
 * port's clock. */
void crn_permission_offer(crn_permission *permission, uint32_t now_us);

/* Checks the answer of CONFIRM and returns whether it was right; any answer spends the code, even a wrong
 * one. */
bool crn_permission_answer(crn_permission *permission, uint32_t code);

/* Gives the permission, because the answer was right and the rig is ready: the next START may power the
 * motors. */
void crn_permission_give(crn_permission *permission);

/* Counts one edge of the timer. */
void crn_permission_age(crn_permission *permission);

/* Makes any code and any permission invalid. */
void crn_permission_spend(crn_permission *permission);

#endif
