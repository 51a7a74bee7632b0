/* From the coupling (or the rod itself, where a track has none) to what the actuators are asked for: gain ->
 * passivity -> slew limit -> force limit -> fade. */
#include "firmware/app/app_internal.h"

enum {
    STORED_MAX_mJ = 50, /* what wires and coupling may store and give back: 8 N on 1 N/mm is 32 mJ */
    GIVEN_MAX_mJ = 10,  /* what they may give that they held before START */
    SCALE_ONE = 1 << 16,
    SCALE_DOWN = SCALE_ONE / 32, /* per tick: gone in 32 ms */
    SCALE_UP = SCALE_ONE / 1024, /* back in a second */
};

static const int64_t stored_max_pJ = STORED_MAX_mJ * (int64_t)1000000000,
                     given_max_pJ = GIVEN_MAX_mJ * (int64_t)1000000000;

static int32_t limited(int64_t value, int64_t low, int64_t high)
{
    if (value < low) return (int32_t)low;
    if (value > high) return (int32_t)high;
    return (int32_t)value;
}

/* Move from `present` towards `target`: the size grows by no more than `slew` per tick and never beyond the
 * limit; it may fall at once, because a force that is still there when its cause is gone drives the hand (a
 * hand that had released it at 4 N was thrown back at 1.2 m/s while the slew limit took 80 ms to end the
 * force). The target may be far out of range. */
static int32_t approach(int32_t present, int64_t target, int32_t slew, int32_t limit)
{
    const int64_t low = present < 0 ? present : 0, high = present > 0 ? present : 0;
    int32_t slewed = limited(target, low - slew, high + slew);
    return limited(slewed, -limit, limit);
}

/* --- passivity --- */

/* Energy that the hand puts in, from the force held since the last tick and the hand's way since then.
 * Format: mN x nm = pJ; Q30 m x 0.9313 nm, 2^-32 turn x 1.4629e-3 (uN m x 2 pi / 2^32 in pJ).
 * Overflow: 2^14 mN x 2^31 and 2^15 uN m x 2^30, times 2^20 and 2^11, below 2^63 after the first shift. */
static int64_t work_pJ(const crn_port_motor *motor, int32_t way_m_q30, int32_t turn_turn32)
{
    int64_t along = (((int64_t)way_m_q30 * 976562) >> 20) * motor->axial_mN;
    int64_t about = ((int64_t)motor->torque_uN_m * turn_turn32 * 1534) >> 20;
    return along + about;
}

/* The hand got more than it put in and what may have been stored. */
bool crn_app_gives_energy(const crn_app_energy *energy)
{
    return energy->taken_pJ < -given_max_pJ;
}

/* Share of the force that keeps the track passive. What was put in long ago is not credited without bound,
 * and what was given without reason is forgiven slowly, so that a track never stays dead. A track with power
 * that stays there stops (app_carriage.c). */
static void observe_energy(crn_app *app, uint32_t k, const crn_hand_pose *hand)
{
    crn_app_energy *energy = &app->haptics.energies[k];
    int32_t way = crn_wire_i32_from_u32((uint32_t)hand->feed_m_q30 - (uint32_t)energy->hand_m_q30);
    int32_t turn = crn_wire_i32_from_u32(hand->turn32 - energy->hand_turn32);
    int64_t work = energy->is_set ? work_pJ(&app->haptics.motors[k], way, turn) : 0;
    energy->is_set = true;
    energy->hand_m_q30 = hand->feed_m_q30;
    energy->hand_turn32 = hand->turn32;
    energy->taken_pJ += work;
    if (energy->taken_pJ > stored_max_pJ) energy->taken_pJ = stored_max_pJ;
    if (energy->taken_pJ < 0) energy->taken_pJ -= energy->taken_pJ / 4096;
    if (!crn_app_gives_energy(energy)) {
        energy->scale_q16 =
            energy->scale_q16 + SCALE_UP > SCALE_ONE ? SCALE_ONE : energy->scale_q16 + SCALE_UP;
        return;
    }
    if (energy->taken_pJ < -2 * given_max_pJ) energy->taken_pJ = -2 * given_max_pJ;
    if (work < 0) energy->scale_q16 = energy->scale_q16 > SCALE_DOWN ? energy->scale_q16 - SCALE_DOWN : 0;
    app->haptics.passivity_ticks++;
    crn_app_fault(app, CRN_FAULT_CODE_PASSIVITY, (int32_t)k,
                  (int32_t)crn_app_quotient(energy->taken_pJ, 1000) / 1000);
}

/* --- what is asked for --- */

/* Format: Q22 N x 1/1000 -> mN: N x 1000 x gain/1000 = value x gain / 2^22; torque Q24 N m -> uN m likewise
 * with another factor 1000. Overflow: |value| < 2^31, gain <= 4000: below 2^53. */
static void ask(crn_app *app, uint32_t k, const crn_handle *handle)
{
    const crn_app_track *track = &app->setup.tracks[k];
    const crn_app_spring *springs = app->haptics.springs[k];
    crn_port_motor *motor = &app->haptics.motors[k];
    bool has_along = track->axes[CRN_APP_ALONG].stiffness > 0,
         has_about = track->axes[CRN_APP_ABOUT].stiffness > 0;
    const int64_t gain = track->wire.force_gain_milli, scale = app->haptics.energies[k].scale_q16;
    int32_t axial = has_along ? springs[CRN_APP_ALONG].output : handle->axial_N_q22;
    int32_t torque = has_about ? springs[CRN_APP_ABOUT].output : handle->torque_N_m_q24;
    int64_t axial_mN = crn_rshift_round64(axial * gain, 22);
    int64_t torque_uN_m = crn_rshift_round64(torque * gain * 1000, 24);
    if (has_along) axial_mN = axial_mN * scale / SCALE_ONE;
    if (has_about) torque_uN_m = torque_uN_m * scale / SCALE_ONE;
    motor->axial_mN = approach(motor->axial_mN, axial_mN, (int32_t)track->wire.force_slew_mN_per_tick,
                               track->force_limit_mN);
    motor->torque_uN_m = approach(motor->torque_uN_m, torque_uN_m,
                                  (int32_t)track->wire.torque_slew_uN_m_per_tick, track->torque_limit_uN_m);
}

/* A silent host: from what was asked for when it fell silent to nothing, in a straight line, faster than any
 * slew limit. Overflow: |from| <= the limits, and left_ticks <= CRN_APP_FADE_ticks while it fades: below
 * 2^19. */
_Static_assert((int64_t)CRN_APP_TORQUE_LIMIT_uN_m *CRN_APP_FADE_ticks <= INT32_MAX,
               "a bound of a force in 32 bits");
static int32_t faded(int32_t value, int32_t from, uint32_t left_ticks)
{
    int64_t bound = crn_app_quotient((from < 0 ? -(int64_t)from : from) * left_ticks, CRN_APP_FADE_ticks);
    return limited(value, -bound, bound);
}

/* `hands` are where the hands are, before the coupling. */
void crn_app_motors_update(crn_app *app, const crn_input *hands, const crn_output *output)
{
    bool is_fading =
        app->mode == CRN_WIRE_MODE_FREE_RUN && app->link.silent_ticks >= CRN_APP_HOST_SILENT_ticks;
    uint32_t left = CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks - app->link.silent_ticks;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        bool has_coupling = app->setup.tracks[k].axes[CRN_APP_ALONG].stiffness > 0 ||
                            app->setup.tracks[k].axes[CRN_APP_ABOUT].stiffness > 0;
        if (has_coupling) observe_energy(app, k, &hands->hands[k]);
        ask(app, k, &output->tools[k]);
        if (!is_fading) {
            app->haptics.fade_from[k][0] = app->haptics.motors[k].axial_mN;
            app->haptics.fade_from[k][1] = app->haptics.motors[k].torque_uN_m;
            continue;
        }
        app->haptics.motors[k].axial_mN =
            faded(app->haptics.motors[k].axial_mN, app->haptics.fade_from[k][0], left);
        app->haptics.motors[k].torque_uN_m =
            faded(app->haptics.motors[k].torque_uN_m, app->haptics.fade_from[k][1], left);
    }
}

/* What is asked for begins at nothing again. */
void crn_app_motors_reset(crn_app *app)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app->haptics.motors[k] = (crn_port_motor){0, 0};
}

/* --- outputs --- */

static uint8_t lamp(uint8_t state)
{
    if (state == CRN_WIRE_STATE_FAULT) return CRN_PORT_LAMP_FAULT;
    if (state == CRN_WIRE_STATE_RUNNING) return CRN_PORT_LAMP_RUNNING;
    return state == CRN_WIRE_STATE_ARMED ? CRN_PORT_LAMP_ARMED : CRN_PORT_LAMP_IDLE;
}

/* A track is driven along or about its line only through a coupling: the rod itself is stiffer than any rig
 * renders. And it is driven only as far as somebody holds it. */
static crn_port_motor drive(crn_app *app, uint32_t k)
{
    const crn_app_track *track = &app->setup.tracks[k];
    if (!app->safety.is_driving || k >= app->setup.tool_count) return (crn_port_motor){0, 0};
    const int32_t asked_mN = track->axes[CRN_APP_ALONG].stiffness > 0 ? app->haptics.motors[k].axial_mN : 0;
    const int32_t bound_mN = crn_app_carriage_bound(app, k, asked_mN);
    return (crn_port_motor){approach(app->safety.driven[k].axial_mN, limited(asked_mN, -bound_mN, bound_mN),
                                     (int32_t)track->wire.force_slew_mN_per_tick, track->force_limit_mN),
                            track->axes[CRN_APP_ABOUT].stiffness > 0 ? app->haptics.motors[k].torque_uN_m
                                                                     : 0};
}

/* Once per edge. While driving: the forces, and one flip of the drive line, which keeps the power stage on
 * for another CRN_PORT_DRIVE_HOLD_ms. */
void crn_app_outputs_write(crn_app *app)
{
    crn_port_outputs outputs = {.enable = app->safety.is_driving, .lamp = lamp(app->state)};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        outputs.motors[k] = app->safety.driven[k] = drive(app, k);
        app->safety.watches[k].asked_mN[app->safety.asked_at] = outputs.motors[k].axial_mN;
    }
    app->safety.asked_at = (app->safety.asked_at + 1) % CRN_APP_ASKED_ticks;
    if (app->safety.is_driving) app->safety.drive_level = !app->safety.drive_level;
    outputs.drive = app->safety.drive_level;
    app->port->outputs(app->port->context, &outputs);
}

/* No power, now. What LOCKSTEP reports is part of the session, not of the motors, and goes on from where it
 * was. */
void crn_app_motors_off(crn_app *app)
{
    const crn_port_outputs outputs = {.drive = app->safety.drive_level, .lamp = lamp(app->state)};
    if (app->safety.is_driving) app->safety.idle_ticks = 0;
    app->safety.is_driving = app->permission.is_given = false;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app->safety.driven[k] = (crn_port_motor){0, 0};
    app->permission.code = 0;
    app->port->outputs(app->port->context, &outputs);
}
