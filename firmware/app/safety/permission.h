/* Before START may power the motors, the host must take two steps: it sends ARM_MOTORS, to which the device
 * replies with a code, and then sends this code back in CONFIRM. Both the code and the permission to power
 * the motors expire, because they are meant for a person who is about to press START. */
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

/* Makes a new code for ARM_MOTORS. The code is never 0, and a stray or damaged frame is very unlikely to
 * contain it. `now_us` is the port's clock. */
void crn_permission_offer(crn_permission *permission, uint32_t now_us);

/* Checks the code that CONFIRM returned and returns whether it was right; any answer uses up the code, even a
 * wrong answer. */
bool crn_permission_answer(crn_permission *permission, uint32_t code);

/* Gives the permission to power the motors at the next START; the caller has checked that the answer was
 * right and that the rig is ready. */
void crn_permission_give(crn_permission *permission);

/* Counts one edge of the timer (1 ms). Both the confirmation code and the permission expire after a fixed
 * time. */
void crn_permission_age(crn_permission *permission);

/* Makes any code and any permission to power the motors invalid. */
void crn_permission_spend(crn_permission *permission);

#endif
