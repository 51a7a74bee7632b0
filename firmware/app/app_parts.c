/* This file runs the parts of the app that move the motors and protect the user's hand. The code gives the
 * haptics and the safety checks their inputs, reports the faults that they find, and writes the resulting
 * forces to the port. Neither the haptics nor the safety checks access the app or each other.
 *
 *   encoders -> hands -> haptics -> core -> haptics -> requested forces -> safety -> the port's outputs
 *   the rig's sample -> safety -> findings -> crn_app_report (app_fault.c) */
#include "firmware/app/app_internal.h"

_Static_assert((int)CRN_APP_EDGE_us == (int)CRN_TICK_us, "core and clock agree about the length of a tick");

static uint32_t clock_us(const crn_app *app)
{
    return app->port->now_us(app->port->context);
}

/* --- configuration --- */

static crn_haptics_track haptics_track(const crn_wire_track *wire)
{
    crn_haptics_track track = {
        .gain_milli = wire->force_gain_milli,
        .force_limit_mN = (int32_t)wire->force_limit_mN,
        .force_slew_mN_per_tick = (int32_t)wire->force_slew_mN_per_tick,
        .torque_limit_uN_m = (int32_t)wire->torque_limit_uN_m,
        .torque_slew_uN_m_per_tick = (int32_t)wire->torque_slew_uN_m_per_tick,
    };
    const crn_haptics_coupling along = {wire->coupling_N_per_m, wire->coupling_mN_s_per_m, wire->seal_mN};
    const crn_haptics_coupling about = {wire->coupling_uN_m_per_rad, wire->coupling_nN_m_s_per_rad,
                                        wire->seal_uN_m};
    crn_haptics_axis_set(&track.axes[CRN_APP_ALONG], CRN_APP_ALONG, &along);
    crn_haptics_axis_set(&track.axes[CRN_APP_ABOUT], CRN_APP_ABOUT, &about);
    return track;
}

static crn_hand_track hand_track(const crn_wire_track *wire)
{
    return (crn_hand_track){
        /* One picometre is 2^46 / 10^12 = 2^34 / 5^12 units of 2^-46 m. The product cannot overflow, because
         * at most 5e8 pm per count times 2^34 is below 2^63. */
        .translation_m_q46_per_count =
            crn_divide_u64(((uint64_t)wire->translation_pm_per_count << 34) + 122070312u, 244140625u),
        .rotation_turn48_per_count = crn_divide_u64(((uint64_t)1 << 48) + wire->rotation_counts_per_turn / 2,
                                                    wire->rotation_counts_per_turn),
        .translation_jump_counts =
            (uint32_t)crn_divide_u64((uint64_t)CRN_APP_JUMP_um * 1000000u, wire->translation_pm_per_count),
        .rotation_jump_counts = wire->rotation_counts_per_turn / 4,
        .is_translation_reversed = (wire->options & CRN_WIRE_OPTION_TRANSLATION_REVERSED) != 0,
        .is_rotation_reversed = (wire->options & CRN_WIRE_OPTION_ROTATION_REVERSED) != 0,
    };
}

void crn_app_track_apply(crn_app *app, uint32_t k)
{
    const crn_wire_track *wire = &app->setup.tracks[k].wire;
    app->hands.tracks[k] = hand_track(wire);
    app->haptics.tracks[k] = haptics_track(wire);
    app->safety.tracks[k] = (crn_safety_track){
        .translation_pm_per_count = wire->translation_pm_per_count,
        .jump_counts = app->hands.tracks[k].translation_jump_counts,
        .force_zero_counts = wire->force_zero_counts,
        .force_uN_per_count = wire->force_uN_per_count,
        .force_limit_mN = (int32_t)wire->force_limit_mN,
        .force_slew_mN_per_tick = (int32_t)wire->force_slew_mN_per_tick,
        .is_reversed = app->hands.tracks[k].is_translation_reversed,
        .is_driven_along = wire->coupling_N_per_m > 0,
        .is_driven_about = wire->coupling_uN_m_per_rad > 0,
    };
}

uint32_t crn_app_driven_tracks(const crn_app *app)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        if (app->safety.tracks[k].is_driven_along || app->safety.tracks[k].is_driven_about) count++;
    }
    return count;
}

/* --- hands and haptics: around the core's tick --- */

bool crn_app_hands_update(crn_app *app, const crn_app_encoders *now)
{
    crn_findings findings = {.count = 0};
    const bool is_taken = crn_hands_update(&app->hands, app->setup.tool_count, now->hands, &findings);
    crn_app_report(app, &findings);
    return is_taken;
}

static void see_tools(const crn_app *app, crn_haptics_input *input)
{
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        const crn_tool_state *state = &app->core.words.tools[k];
        crn_haptics_tool *tool = &input->tools[k];
        tool->inserted_m_q30 = state->inserted_m_q30;
        tool->hand_offset_m_q30 = state->hand_offset_m_q30;
        tool->base_turn32 = state->base_turn32;
        tool->is_free = crn_state_tool_at(&app->core, k) == 0;
    }
}

void crn_app_haptics_before(crn_app *app, crn_haptics_input *felt, crn_input *input)
{
    crn_hand_position followed[CRN_TOOL_MAX];
    felt->tool_count = app->setup.tool_count;
    felt->is_fading = app->mode == CRN_WIRE_MODE_FREE_RUN && crn_watchdog_is_fading(&app->watchdog);
    felt->fade_left_ticks = crn_watchdog_left_ticks(&app->watchdog);
    for (uint32_t k = 0; k < felt->tool_count; k++) felt->hands[k] = crn_hands_position(&app->hands, k);
    see_tools(app, felt);
    crn_haptics_before(&app->haptics, felt, followed);
    for (uint32_t k = 0; k < felt->tool_count; k++)
        input->hands[k] = (crn_hand_pose){followed[k].feed_m_q30, followed[k].turn32};
}

void crn_app_haptics_after(crn_app *app, crn_haptics_input *felt, const crn_output *output)
{
    crn_findings findings = {.count = 0};
    see_tools(app, felt);
    for (uint32_t k = 0; k < felt->tool_count; k++) {
        felt->tools[k].axial_N_q22 = output->tools[k].axial_N_q22;
        felt->tools[k].torque_N_m_q24 = output->tools[k].torque_N_m_q24;
    }
    crn_haptics_after(&app->haptics, felt, &findings);
    crn_app_report(app, &findings);
}

/* --- safety: every edge --- */

static crn_safety_input safety_input(const crn_app *app)
{
    crn_safety_input input = {
        .rig = app->edge.has_rig ? &app->edge.rig : NULL,
        .tool_count = app->setup.tool_count,
        .is_stopped = app->state == CRN_WIRE_STATE_FAULT,
    };
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) input.energy_pJ[k] = app->haptics.energies[k].taken_pJ;
    return input;
}

int32_t crn_app_force_measured(const crn_app *app, uint32_t k)
{
    return crn_safety_force_mN(&app->safety, app->edge.has_rig ? &app->edge.rig : NULL, k);
}

void crn_app_safety_check(crn_app *app)
{
    crn_findings findings = {.count = 0};
    const crn_safety_input input = safety_input(app);
    crn_permission_age(&app->permission);
    crn_safety_check(&app->safety, &input, &findings);
    crn_app_report(app, &findings);
}

crn_fault_code crn_app_safety_ready(const crn_app *app)
{
    const crn_safety_input input = safety_input(app);
    return crn_safety_ready(&app->safety, &input);
}

void crn_app_motors_on(crn_app *app)
{
    const crn_safety_input input = safety_input(app);
    crn_clock_restart(&app->clock);
    crn_safety_on(&app->safety, &input);
}

static uint8_t lamp(uint8_t state)
{
    if (state == CRN_WIRE_STATE_FAULT) return CRN_PORT_LAMP_FAULT;
    if (state == CRN_WIRE_STATE_RUNNING) return CRN_PORT_LAMP_RUNNING;
    return state == CRN_WIRE_STATE_ARMED ? CRN_PORT_LAMP_ARMED : CRN_PORT_LAMP_IDLE;
}

void crn_app_outputs_write(crn_app *app)
{
    const crn_safety_input input = safety_input(app);
    crn_port_outputs outputs = {.lamp = lamp(app->state)};
    crn_safety_drive(&app->safety, &input, app->haptics.motors, &outputs);
    app->port->outputs(app->port->context, &outputs);
}

/* Removes the power of the motors. The forces that the app reports in LOCKSTEP belong to the session, not to
 * the motors, so they stay the same when the motor power is removed. */
void crn_app_motors_off(crn_app *app)
{
    crn_port_outputs outputs;
    crn_permission_spend(&app->permission);
    crn_safety_off(&app->safety, &outputs);
    outputs.lamp = lamp(app->state);
    app->port->outputs(app->port->context, &outputs);
}

/* --- the clock and the host's silence --- */

void crn_app_clock_begin(crn_app *app)
{
    crn_findings findings = {.count = 0};
    crn_clock_begin(&app->clock, clock_us(app), app->safety.is_driving, &findings);
    crn_app_report(app, &findings);
}

void crn_app_clock_end(crn_app *app)
{
    crn_findings findings = {.count = 0};
    crn_clock_end(&app->clock, clock_us(app), app->safety.is_driving, &findings);
    crn_app_report(app, &findings);
}

void crn_app_silence_count(crn_app *app)
{
    crn_findings findings = {.count = 0};
    crn_watchdog_tick(&app->watchdog, &findings);
    crn_app_report(app, &findings);
    if (findings.count > 0) crn_app_notice(app, CRN_WIRE_EVENT_HOST, 1, 0, 0);
}
