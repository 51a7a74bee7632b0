/* This file manages the permission to power the motors. */
#include "firmware/app/safety/permission.h"
#include "firmware/app/safety/limits.h"

/* Scrambles a 32-bit number that was made from the clock and a counter; different inputs give different
 * results. */
static uint32_t mixed(uint32_t code)
{
    code = (code ^ (code >> 16)) * 0x7feb352du;
    code = (code ^ (code >> 15)) * 0x846ca68bu;
    return code ^ code >> 16;
}

void crn_permission_offer(crn_permission *permission, uint32_t now_us)
{
    const uint32_t code = mixed(now_us ^ (++permission->code_count * 0x9e3779b9u));
    permission->code = code == 0 ? 1 : code;
    permission->age_ticks = 0;
}

/* Requirement: SR-08 */
bool crn_permission_answer(crn_permission *permission, uint32_t code)
{
    const uint32_t wanted = permission->code;
    crn_permission_spend(permission);
    return wanted != 0 && code == wanted;
}

void crn_permission_give(crn_permission *permission)
{
    permission->is_given = true;
    permission->age_ticks = 0;
}

/* Requirement: SR-08 */
void crn_permission_age(crn_permission *permission)
{
    if (permission->code == 0 && !permission->is_given) return;
    if (++permission->age_ticks > CRN_APP_CODE_ticks) crn_permission_spend(permission);
}

void crn_permission_spend(crn_permission *permission)
{
    permission->code = 0;
    permission->is_given = false;
}
