/* From the rod's reaction to what the actuators are asked for: gain -> slew limit -> force limit. Called by: app_session.c. */
#include "firmware/app/app_internal.h"

static int32_t limited(int64_t value, int32_t low, int32_t high)
{
    if (value < low) return low;
    if (value > high) return high;
    return (int32_t)value;
}

/* Move from `present` towards `target`, by no more than `slew` per tick and never beyond +-limit. The target may be
 * far out of range; both limits hold whatever it is. */
static int32_t approach(int32_t present, int64_t target, int32_t slew, int32_t limit)
{
    int32_t slewed = limited(target, present - slew, present + slew);
    return limited(slewed, -limit, limit);
}

/* Format: Q22 N x 1/1000 -> mN: N x 1000 x gain/1000 = value x gain / 2^22; torque Q24 N m -> uN m likewise with
 * another factor 1000. Overflow: |value| < 2^31, gain <= 4000: below 2^53. */
void seld_app_motor_update(seld_port_motor *motor, const seld_app_track *track, const seld_handle *handle,
                           bool fade)
{
    int64_t gain = fade ? 0 : (int64_t)track->force_gain_milli;
    int64_t axial_mN = seld_rshift_round64((int64_t)handle->axial_N_q22 * gain, 22);
    int64_t torque_uN_m = seld_rshift_round64((int64_t)handle->torque_N_m_q24 * gain * 1000, 24);
    motor->axial_mN =
        approach(motor->axial_mN, axial_mN, SELD_APP_FORCE_SLEW_mN_per_tick, track->force_limit_mN);
    motor->torque_uN_m = approach(motor->torque_uN_m, torque_uN_m, SELD_APP_TORQUE_SLEW_uN_m_per_tick,
                                  track->torque_limit_uN_m);
}

/* What is asked for begins at nothing again. */
void seld_app_motors_reset(seld_app *app)
{
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) app->motors[k] = (seld_port_motor){0, 0};
}

static uint8_t lamp(uint8_t state)
{
    if (state == SELD_WIRE_STATE_FAULT) return SELD_PORT_LAMP_FAULT;
    if (state == SELD_WIRE_STATE_RUNNING) return SELD_PORT_LAMP_RUNNING;
    return state == SELD_WIRE_STATE_ARMED ? SELD_PORT_LAMP_ARMED : SELD_PORT_LAMP_IDLE;
}

/* The forces asked for, and one flip of the drive line: the power stage stays on for another SELD_PORT_DRIVE_HOLD_ms. */
void seld_app_motors_drive(seld_app *app)
{
    seld_port_outputs outputs = {.enable = true, .lamp = lamp(app->state)};
    for (uint32_t k = 0; k < app->tool_count; k++) outputs.motors[k] = app->motors[k];
    app->drive_level = !app->drive_level;
    outputs.drive = app->drive_level;
    app->port->outputs(app->port->context, &outputs);
}

/* No power. What LOCKSTEP reports is part of the session, not of the motors, and goes on from where it was. */
void seld_app_motors_off(seld_app *app)
{
    const seld_port_outputs outputs = {.drive = app->drive_level, .lamp = lamp(app->state)};
    app->port->outputs(app->port->context, &outputs);
}
