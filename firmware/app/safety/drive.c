/* This file switches the motor power on and off, and sets the forces of the motors. */
#include "firmware/app/safety/arithmetic.h"
#include "firmware/app/safety/carriage.h"
#include "firmware/app/safety/safety.h"

void crn_safety_on(crn_safety *safety, const crn_safety_input *input)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        crn_safety_watch *watch = &safety->watches[k];
        *watch = (crn_safety_watch){.last = input->rig->hands[k]};
        watch->had_force_sensor = input->rig->tracks[k].force_sensor != CRN_PORT_SENSOR_ABSENT;
    }
    safety->stage_was_on = false;
    safety->drive_ticks = 0;
    safety->is_driving = true;
}

/* Requirement: SR-03 */
void crn_safety_off(crn_safety *safety, crn_port_outputs *outputs)
{
    if (safety->is_driving) safety->idle_ticks = 0;
    safety->is_driving = false;
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) safety->driven[k] = (crn_port_motor){0, 0};
    *outputs = (crn_port_outputs){.drive = safety->drive_level};
}

/* A motor drives an axis of a track only through a virtual coupling, because the rod itself is stiffer than
 * any rig can render. Along the insertion axis, a motor exerts no more force than the hand that holds the
 * carriage resists. */
/* Requirement: SR-01, SR-02 */
static crn_port_motor driven(crn_safety *safety, const crn_safety_input *input, uint32_t k,
                             const crn_port_motor *asked)
{
    const crn_safety_track *track = &safety->tracks[k];
    if (!safety->is_driving || input->rig == NULL || k >= input->tool_count) return (crn_port_motor){0, 0};
    const int32_t limit_mN = track->is_driven_along ? track->force_limit_mN : 0;
    const int32_t asked_mN = crn_limited(asked->axial_mN, -limit_mN, limit_mN);
    const int32_t bound_mN = crn_carriage_bound_mN(safety, input->rig, k, asked_mN);
    return (crn_port_motor){crn_approach(safety->driven[k].axial_mN,
                                         crn_limited(asked_mN, -bound_mN, bound_mN),
                                         track->force_slew_mN_per_tick, limit_mN),
                            track->is_driven_about ? asked->torque_uN_m : 0};
}

/* Requirement: SR-03 */
void crn_safety_drive(crn_safety *safety, const crn_safety_input *input,
                      const crn_port_motor asked[CRN_PORT_TOOL_MAX], crn_port_outputs *outputs)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        outputs->motors[k] = safety->driven[k] = driven(safety, input, k, &asked[k]);
        safety->watches[k].asked_mN[safety->asked_at] = outputs->motors[k].axial_mN;
    }
    safety->asked_at = (safety->asked_at + 1) % CRN_APP_ASKED_ticks;
    if (safety->is_driving) safety->drive_level = !safety->drive_level;
    outputs->enable = safety->is_driving;
    outputs->drive = safety->drive_level;
}
