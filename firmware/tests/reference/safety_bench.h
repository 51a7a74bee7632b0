/* This header provides a test bench for the safety code (crn_safety): one sample of a rig, the requested
 * forces, and a function that runs single edges of the timer. The bench for the safety code has neither a
 * rod, nor a scene, nor the wire protocol. */
#ifndef CRN_TESTS_SAFETY_BENCH_H
#define CRN_TESTS_SAFETY_BENCH_H

#include "firmware/app/safety/safety.h"

typedef struct safety_bench {
    crn_safety safety;
    crn_port_inputs rig;
    crn_safety_input input;
    crn_port_motor asked[CRN_PORT_TOOL_MAX];
    crn_port_outputs outputs;
    crn_finding found; /* at the last edge */
} safety_bench;

/* Puts two tools on a rig at rest, where a count of an encoder is 1 um and a count of the force sensor is 1
 * mN. The motors have no power. */
static inline void safety_bench_rest(safety_bench *bench)
{
    *bench = (safety_bench){.rig = {.supply_good = true}, .input = {.tool_count = 2}};
    bench->input.rig = &bench->rig;
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        bench->safety.tracks[k] = (crn_safety_track){
            .translation_pm_per_count = 1000000,
            .jump_counts = CRN_APP_JUMP_um,
            .force_uN_per_count = 1000,
            .force_limit_mN = CRN_APP_FORCE_LIMIT_mN,
            .force_slew_mN_per_tick = CRN_APP_FORCE_SLEW_mN_per_tick,
            .is_driven_along = true,
            .is_driven_about = true,
        };
    }
}

/* Runs one edge of the timer: first the checks, then the outputs. If the checks find a fault, the power of
 * the motors is removed, as in the app. */
static inline crn_fault_code safety_bench_edge(safety_bench *bench)
{
    crn_findings findings = {.count = 0};
    crn_safety_check(&bench->safety, &bench->input, &findings);
    bench->found = findings.count > 0 ? findings.list[0] : (crn_finding){CRN_FAULT_CODE_NONE, 0, 0};
    if (findings.count > 0) crn_safety_off(&bench->safety, &bench->outputs);
    crn_safety_drive(&bench->safety, &bench->input, bench->asked, &bench->outputs);
    if (bench->safety.is_driving) bench->rig.stage_on = true;
    return bench->found.code;
}

/* Returns the number of timer edges after which a fault is found, or 0 when no fault is found within `edges`.
 */
static inline int safety_bench_find(safety_bench *bench, int edges)
{
    for (int i = 1; i <= edges; i++) {
        if (safety_bench_edge(bench) != CRN_FAULT_CODE_NONE) return i;
    }
    return 0;
}

/* Sets up the rig of safety_bench_rest, but with powered motors, and runs timer edges until the power stage
 * drives the motors. */
static inline void safety_bench_drive(safety_bench *bench)
{
    safety_bench_rest(bench);
    crn_safety_on(&bench->safety, &bench->input);
    for (int i = 0; i < 20; i++) (void)safety_bench_edge(bench);
}

/* Makes a simulated hand hold the carriage with exactly the force of the first motor. */
static inline int safety_bench_hold(safety_bench *bench, int32_t asked_mN, int edges)
{
    bench->asked[0].axial_mN = asked_mN;
    for (int i = 1; i <= edges; i++) {
        bench->rig.tracks[0].force_raw = bench->safety.driven[0].axial_mN;
        if (safety_bench_edge(bench) != CRN_FAULT_CODE_NONE) return i;
    }
    return 0;
}

#endif
