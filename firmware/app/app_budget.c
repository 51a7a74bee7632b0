/* This file estimates how many cycles a tick of the present set-up takes, and refuses FREE_RUN on a processor
 * that cannot compute such a tick within its millisecond. In LOCKSTEP the host waits for the device and no
 * motor has power, so that a slow tick harms nobody. docs/budget.md, "What a board refuses", has the sources
 * of the coefficients and their errors. */
#include "firmware/app/app_internal.h"

/* The cycles of a Cortex-M7 with near memory: of the core's tick, and of the app and the port around it.
 * firmware/bench/tests/test_app_budget.c compares them with the priced sessions of firmware/bench/budget.tsv.
 */
typedef struct cost {
    uint32_t core, node, position; /* of a tick; of each node; of each position behind the first */
    uint32_t around;               /* app (the largest chip.app_cycles), and 15,000 to sample the rig */
} cost;

static const cost costs[] = {
    [CRN_APP_PLACE_FREE] = {30000, 1280, 45000, 105000},
    [CRN_APP_PLACE_STILL] = {150000, 1150, 45000, 105000},
    [CRN_APP_PLACE_BEATING] = {465000, 3565, 139500, 150000},
};

uint32_t crn_app_load_cycles(const crn_app_load *load)
{
    const cost *one = &costs[load->place];
    return one->core + one->node * load->nodes + one->position * (load->positions - 1) + one->around;
}

/* How far tools reach beyond the introducer: one metre in free space; in a vessel, as far as the box around
 * the vessel is long. What tools reach farther by loops is not counted. */
static int32_t reach_m_q30(const crn_app_setup *setup)
{
    if (!setup->has_scene) return CRN_ONE_Q30;
    const crn_lumen *lumen = &setup->lumen;
    uint32_t bricks = 0;
    for (int k = 0; k < 3; k++)
        bricks = lumen->brick_count_xyz[k] > bricks ? lumen->brick_count_xyz[k] : bricks;
    const uint64_t reach = (uint64_t)bricks * CRN_LUMEN_BRICK_EDGE << CRN_LUMEN_VOXEL_LOG2_Q30;
    return reach < INT32_MAX ? (int32_t)reach : INT32_MAX;
}

crn_app_load crn_app_load_of(const crn_app *app)
{
    const crn_app_setup *setup = &app->setup;
    crn_app_load load = {crn_state_node_count(&app->model), setup->tool_count, CRN_APP_PLACE_FREE};
    const int32_t reach = reach_m_q30(setup);
    while (load.nodes > 1 && crn_model_arc(&app->model, load.nodes - 1) > reach) load.nodes--;
    if (!setup->has_scene) return load;
    load.place = setup->lumen.motion != NULL ? CRN_APP_PLACE_BEATING : CRN_APP_PLACE_STILL;
    return load;
}

/* Requirement: SR-27 */
bool crn_app_is_in_time(crn_app *app)
{
    const crn_app_load load = crn_app_load_of(app);
    const uint32_t needed = crn_app_load_cycles(&load), given = app->port->tick_cycles;
    if (given == 0 || needed <= given) return true;
    crn_app_reject(app, CRN_WIRE_TYPE_command, CRN_REJECT_TOO_SLOW, needed, given);
    return false;
}
