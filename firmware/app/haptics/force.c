/* This file computes the forces that the haptics request from the motors. The code first computes the forces
 * of the virtual coupling, or takes the forces of the rod itself where a track has no coupling. To the forces
 * of coupling or rod, the code applies, in this order, the gain, the passivity limit, the slew limit, the
 * force limit and the fade (the fall to zero when the host is silent). */
#include "firmware/app/haptics/haptics.h"
#include "firmware/app/safety/arithmetic.h"
#include "firmware/core/fixed.h"

enum {
    STORED_MAX_mJ = 50, /* what tools and coupling may store and give back: 8 N on 1 N/mm is 32 mJ */
    SCALE_ONE = 1 << 16,
    SCALE_DOWN = SCALE_ONE / 32, /* per tick: gone in 32 ms */
    SCALE_UP = SCALE_ONE / 1024, /* back in a second */
};

static const int64_t stored_max_pJ = STORED_MAX_mJ * (int64_t)1000000000,
                     given_max_pJ = CRN_APP_GIVEN_MAX_mJ * (int64_t)1000000000;

/* --- passivity --- */

/* Returns the energy that the hand puts into the rig, computed from the motor's force since the last tick and
 * the hand's travel in this time. Format: mN x nm = pJ; Q30 m x 0.9313 nm, 2^-32 turn x 1.4629e-3 (uN m x 2
 * pi / 2^32 in pJ). Overflow is impossible, because 2^14 mN x 2^31 x 2^20 and 2^15 uN m x 2^30 x 2^11 are
 * below 2^63 after the first shift. */
static int64_t work_pJ(const crn_port_motor *motor, int32_t travel_m_q30, int32_t turn_turn32)
{
    int64_t along = (((int64_t)travel_m_q30 * 976562) >> 20) * motor->axial_mN;
    int64_t about = ((int64_t)motor->torque_uN_m * turn_turn32 * 1534) >> 20;
    return along + about;
}

/* Updates the fraction of the requested force that a motor may give so that the track stays passive. The
 * stored credit for energy that the hand has put in is limited, and an excess of energy that the hand has
 * received decays slowly. Because an excess of energy decays, a track never stays without force. The
 * permitted fraction of the force falls once the hand has received more energy than it put in, plus a margin.
 * If the hand on a powered track keeps receiving too much energy, the app stops the device
 * (safety/carriage.c). */
static void observe_energy(crn_haptics *haptics, uint32_t k, const crn_hand_position *hand,
                           crn_findings *findings)
{
    crn_haptics_energy *energy = &haptics->energies[k];
    const int32_t travel = crn_wrapped_difference(hand->feed_m_q30, energy->hand_m_q30);
    const int32_t turn = crn_i32_from_u32(hand->turn32 - energy->hand_turn32);
    const int64_t work = energy->is_set ? work_pJ(&haptics->motors[k], travel, turn) : 0;
    energy->is_set = true;
    energy->hand_m_q30 = hand->feed_m_q30;
    energy->hand_turn32 = hand->turn32;
    energy->taken_pJ += work;
    if (energy->taken_pJ > stored_max_pJ) energy->taken_pJ = stored_max_pJ;
    if (energy->taken_pJ < 0) energy->taken_pJ -= energy->taken_pJ / 4096;
    if (energy->taken_pJ >= -given_max_pJ) {
        energy->scale_q16 =
            energy->scale_q16 + SCALE_UP > SCALE_ONE ? SCALE_ONE : energy->scale_q16 + SCALE_UP;
        return;
    }
    if (energy->taken_pJ < -2 * given_max_pJ) energy->taken_pJ = -2 * given_max_pJ;
    if (work < 0) energy->scale_q16 = energy->scale_q16 > SCALE_DOWN ? energy->scale_q16 - SCALE_DOWN : 0;
    haptics->passivity_ticks++;
    crn_findings_add(findings, CRN_FAULT_CODE_PASSIVITY, (int32_t)k,
                     (int32_t)crn_quotient(energy->taken_pJ, 1000) / 1000);
}

/* --- the requested forces --- */

/* Format: Q22 N x 1/1000 -> mN: N x 1000 x gain/1000 = value x gain / 2^22; torque Q24 N m -> uN m likewise
 * with another factor 1000. Overflow is impossible: the value is below 2^31 and the gain at most 4000, so the
 * product is below 2^53. */
static void ask(crn_haptics *haptics, uint32_t k, const crn_haptics_tool *tool)
{
    const crn_haptics_track *track = &haptics->tracks[k];
    const crn_haptics_spring *springs = haptics->springs[k];
    crn_port_motor *motor = &haptics->motors[k];
    const bool has_along = track->axes[CRN_APP_ALONG].stiffness > 0,
               has_about = track->axes[CRN_APP_ABOUT].stiffness > 0;
    const int64_t gain = track->gain_milli, scale = haptics->energies[k].scale_q16;
    const int32_t felt_axial = tool->is_free ? 0 : tool->axial_N_q22;
    const int32_t felt_torque = tool->is_free ? 0 : tool->torque_N_m_q24;
    const int32_t axial = has_along ? springs[CRN_APP_ALONG].output : felt_axial;
    const int32_t torque = has_about ? springs[CRN_APP_ABOUT].output : felt_torque;
    int64_t axial_mN = crn_rshift_round64(axial * gain, 22);
    int64_t torque_uN_m = crn_rshift_round64(torque * gain * 1000, 24);
    if (has_along) axial_mN = axial_mN * scale / SCALE_ONE;
    if (has_about) torque_uN_m = torque_uN_m * scale / SCALE_ONE;
    motor->axial_mN =
        crn_approach(motor->axial_mN, axial_mN, track->force_slew_mN_per_tick, track->force_limit_mN);
    motor->torque_uN_m = crn_approach(motor->torque_uN_m, torque_uN_m, track->torque_slew_uN_m_per_tick,
                                      track->torque_limit_uN_m);
}

/* Limits the force of a motor while the host is silent. The largest permitted force falls linearly to zero,
 * from the force of the tick in which the host fell silent; this decrease is faster than any slew limit.
 * Overflow is impossible: the force `from` is within the limits and left_ticks <= CRN_APP_FADE_ticks while
 * the force fades, so the product is below 2^19. */
_Static_assert((int64_t)CRN_APP_TORQUE_LIMIT_uN_m *CRN_APP_FADE_ticks <= INT32_MAX,
               "a bound of a force in 32 bits");
static int32_t faded(int32_t value, int32_t from, uint32_t left_ticks)
{
    const int64_t bound = crn_quotient((from < 0 ? -(int64_t)from : from) * left_ticks, CRN_APP_FADE_ticks);
    return crn_limited(value, -bound, bound);
}

void crn_haptics_let_go(crn_haptics *haptics, uint32_t track)
{
    const crn_port_motor *motor = &haptics->motors[track];
    haptics->releases[track] =
        (crn_haptics_release){CRN_HAPTICS_RELEASE_ticks, {motor->axial_mN, motor->torque_uN_m}};
}

/* Overflow is impossible: a snapshot and crn_haptics_let_go keep the two forces within their limits. */
static void release(crn_haptics_release *released, crn_port_motor *motor)
{
    const int64_t left = --released->left_ticks;
    motor->axial_mN = (int32_t)crn_quotient(released->from[0] * left, CRN_HAPTICS_RELEASE_ticks);
    motor->torque_uN_m = (int32_t)crn_quotient(released->from[1] * left, CRN_HAPTICS_RELEASE_ticks);
}

void crn_haptics_after(crn_haptics *haptics, const crn_haptics_input *input, crn_findings *findings)
{
    crn_haptics_settle(haptics, input);
    for (uint32_t k = 0; k < input->tool_count; k++) {
        const crn_haptics_axis *axes = haptics->tracks[k].axes;
        crn_port_motor *motor = &haptics->motors[k];
        int32_t *from = haptics->fade_from[k];
        const bool has_coupling = axes[CRN_APP_ALONG].stiffness > 0 || axes[CRN_APP_ABOUT].stiffness > 0;
        if (has_coupling) observe_energy(haptics, k, &input->hands[k], findings);
        ask(haptics, k, &input->tools[k]);
        if (haptics->releases[k].left_ticks > 0) release(&haptics->releases[k], motor);
        if (!input->is_fading) {
            from[0] = motor->axial_mN;
            from[1] = motor->torque_uN_m;
            continue;
        }
        motor->axial_mN = faded(motor->axial_mN, from[0], input->fade_left_ticks);
        motor->torque_uN_m = faded(motor->torque_uN_m, from[1], input->fade_left_ticks);
    }
}

void crn_haptics_rest(crn_haptics *haptics)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) haptics->motors[k] = (crn_port_motor){0, 0};
}
