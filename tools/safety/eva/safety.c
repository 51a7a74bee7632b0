/* Calls the checks and the drive of the app's safety code (firmware/app/safety) in any order and any number
 * of times, from the state at power-up on, with any reading of the rig, any time and any request of the
 * haptics. The settings of the tracks have the ranges that track_is_good() of firmware/app/app_rig.c accepts,
 * and stay as they are while the motors have power, as in the app. The asserted facts are proved for every
 * call. */
#include "firmware/app/safety/safety.h"
#include "tools/safety/eva/any.h"

enum {
    SCALE_LEAST_pm = 1000, /* of a count */
    SCALE_MOST_pm = 500000000,
    JUMP_pm = 1000000, /* times CRN_APP_JUMP_um */
    FORCE_MOST_uN = 1000000,
};

static crn_safety safety;
static crn_port_inputs rig;
static crn_safety_input input;
static crn_port_outputs outputs;

/* --- what the safety code reads --- */

static uint8_t any_sensor(void)
{
    return (uint8_t)any_from(CRN_PORT_SENSOR_OK, CRN_PORT_SENSOR_ERROR);
}

static void read_track(uint32_t k)
{
    rig.hands[k] = (crn_port_hand){any_i32(), any_i32()};
    rig.tracks[k] = (crn_port_track){.force_raw = any_i32(),
                                     .translation_sensor = any_sensor(),
                                     .rotation_sensor = any_sensor(),
                                     .force_sensor = any_sensor(),
                                     .over_current = any_bool()};
}

static void read_inputs(void)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        read_track(k);
        input.energy_pJ[k] = any_i64();
    }
    rig.emergency_stop = any_bool();
    rig.supply_good = any_bool();
    rig.stage_on = any_bool();
    rig.local_unlock = any_bool();
    input.rig = any_bool() ? &rig : NULL;
    input.tool_count = any_from(0, CRN_PORT_TOOL_MAX);
    input.is_stopped = any_bool();
}

static void set_track(uint32_t k)
{
    safety.tracks[k] = (crn_safety_track){
        .translation_pm_per_count = any_from(SCALE_LEAST_pm, SCALE_MOST_pm),
        .jump_counts = any_from((uint32_t)CRN_APP_JUMP_um * (JUMP_pm / SCALE_LEAST_pm) / 500000,
                                (uint32_t)CRN_APP_JUMP_um * (JUMP_pm / SCALE_LEAST_pm)),
        .force_zero_counts = any_i32(),
        .force_uN_per_count = any_from(1, FORCE_MOST_uN),
        .force_limit_mN = Frama_C_interval(0, CRN_APP_FORCE_LIMIT_mN),
        .force_slew_mN_per_tick = Frama_C_interval(0, CRN_APP_FORCE_SLEW_mN_per_tick),
        .is_reversed = any_bool(),
        .is_driven_along = any_bool(),
        .is_driven_about = any_bool(),
    };
}

/* --- one call of each part --- */

static void check(void)
{
    crn_findings findings = {.count = 0};
    crn_safety_check(&safety, &input, &findings);
    /*@ assert one_finding_at_most: findings.count <= 1; */
    crn_safety_ready(&safety, &input);
}

static void drive(void)
{
    crn_port_motor asked[CRN_PORT_TOOL_MAX];
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) asked[k] = (crn_port_motor){any_i32(), any_i32()};
    if (safety.is_driving) {
        crn_safety_drive(&safety, &input, asked, &outputs);
        /*@ assert force_within_limit: \forall integer k; 0 <= k < 3 ==>
                -8000 <= outputs.motors[k].axial_mN <= 8000; */
    } else {
        crn_safety_drive(&safety, &input, asked, &outputs);
        /*@ assert not_enabled: outputs.enable == 0; */
        /*@ assert no_force_without_power: \forall integer k; 0 <= k < 3 ==>
                outputs.motors[k].axial_mN == 0 && outputs.motors[k].torque_uN_m == 0; */
    }
}

static void stop(void)
{
    crn_safety_off(&safety, &outputs);
    /*@ assert no_power: outputs.enable == 0 && safety.is_driving == 0; */
    /*@ assert no_force: \forall integer k; 0 <= k < 3 ==>
            outputs.motors[k].axial_mN == 0 && outputs.motors[k].torque_uN_m == 0; */
}

/* The app powers the motors only with a rig (crn_safety_ready), and sets tracks only while they have no
 * power. */
static void start_or_set(void)
{
    if (safety.is_driving) return;
    if (any_bool() && input.rig != NULL) {
        crn_safety_on(&safety, &input);
    } else {
        set_track(any_from(0, CRN_PORT_TOOL_MAX - 1));
    }
}

void eva_main(void)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) set_track(k);
    /* Bounds that the variables keep, which the analysis tries first when a variable grows from call to call.
     */
    /*@ loop widen_hints "all", 7, 32, 42, 8000, -8000, 17592186044416, -17592186044416, 35184372088832,
            -35184372088832; */
    while (any_bool()) {
        read_inputs();
        switch (any_from(0, 3)) {
        case 0:
            check();
            break;
        case 1:
            drive();
            break;
        case 2:
            stop();
            break;
        default:
            start_or_set();
            break;
        }
    }
}
