/* This file is the simulated port, which consists of memory, a byte pipe and a timer around the app. */
#include "firmware/port/sim/sim.h"
#include "firmware/app/app.h"

#include <stdlib.h>
#include <string.h>

struct crn_sim {
    crn_port port;
    bool has_rig, is_welded, is_plant;
    crn_port_inputs inputs;
    crn_port_outputs outputs;
    uint32_t stage_hold_ms; /* 0: the power stage is off */
    uint32_t time_us, edge_us, tick_us;
    size_t pipe_begin, pipe_end, pipe_bytes;
    uint8_t pipe[CRN_SIM_PIPE_BYTES];
    crn_instrument tool_table[CRN_TABLE_MAX];
    crn_app app;
};

/* --- the pipe --- */
static size_t sim_transmit_room(void *context)
{
    const crn_sim *sim = context;
    size_t used = sim->pipe_end - sim->pipe_begin;
    return used < sim->pipe_bytes ? sim->pipe_bytes - used : 0;
}

static bool sim_transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    crn_sim *sim = context;
    if (frame_bytes > sim_transmit_room(sim)) return false;
    if (frame_bytes > sizeof sim->pipe - sim->pipe_end) {
        memmove(sim->pipe, sim->pipe + sim->pipe_begin, sim->pipe_end - sim->pipe_begin);
        sim->pipe_end -= sim->pipe_begin;
        sim->pipe_begin = 0;
    }
    memcpy(sim->pipe + sim->pipe_end, frame, frame_bytes);
    sim->pipe_end += frame_bytes;
    return true;
}

/* --- the rig --- */

/* Every tick begins with a call of sim_inputs, which reads the rig. The function sim_inputs also advances the
 * simulated time by the duration of one tick. */
static bool sim_inputs(void *context, crn_port_inputs *inputs)
{
    crn_sim *sim = context;
    sim->time_us += sim->tick_us;
    if (!sim->has_rig) return false;
    *inputs = sim->inputs;
    if (sim->is_plant) return true;
    inputs->stage_on = inputs->stage_on && (sim->stage_hold_ms > 0 || sim->is_welded);
    crn_sim_motors motors = crn_sim_read_motors(sim);
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) inputs->tracks[k].force_raw += motors.axial_mN[k];
    return true;
}

static bool stage_may_drive(const crn_sim *sim)
{
    return sim->has_rig && sim->inputs.supply_good && !sim->inputs.emergency_stop;
}

static void sim_outputs(void *context, const crn_port_outputs *outputs)
{
    crn_sim *sim = context;
    bool is_flipped = outputs->drive != sim->outputs.drive;
    sim->outputs = *outputs;
    if (is_flipped) sim->stage_hold_ms = CRN_PORT_DRIVE_HOLD_ms;
    if (!outputs->enable || !stage_may_drive(sim)) sim->stage_hold_ms = 0;
}

static uint32_t sim_now_us(void *context)
{
    const crn_sim *sim = context;
    return sim->time_us;
}

static void pass_millisecond(crn_sim *sim)
{
    sim->edge_us += 1000;
    bool is_late = (int32_t)(sim->time_us - sim->edge_us) > 0;
    if (!is_late) sim->time_us = sim->edge_us;
    if (sim->stage_hold_ms > 0) sim->stage_hold_ms--;
    if (!stage_may_drive(sim)) sim->stage_hold_ms = 0;
}

/* --- life --- */
crn_sim *crn_sim_create(uint32_t scene_slot_bytes)
{
    crn_sim *sim = calloc(1, sizeof *sim);
    /* One byte more than requested, because slots of 0 bytes must also be a valid allocation. */
    uint8_t *slots = malloc(2 * (size_t)scene_slot_bytes + 1);
    if (sim == NULL || slots == NULL) {
        free(slots);
        free(sim);
        return NULL;
    }
    sim->pipe_bytes = sizeof sim->pipe;
    sim->port = (crn_port){
        .context = sim,
        .transmit = sim_transmit,
        .transmit_room = sim_transmit_room,
        .inputs = sim_inputs,
        .outputs = sim_outputs,
        .now_us = sim_now_us,
        .serial = "sim",
        .tool_table = sim->tool_table,
        .scene_slots = {slots, slots + scene_slot_bytes},
        .scene_slot_bytes = scene_slot_bytes,
        .capabilities = 0,
        .built = {.damping_mN_s_per_m = CRN_SIM_DAMPING_mN_s_per_m,
                  .damping_nN_m_s_per_rad = CRN_SIM_DAMPING_nN_m_s_per_rad},
    };
    crn_app_init(&sim->app, &sim->port);
    return sim;
}

void crn_sim_destroy(crn_sim *sim)
{
    if (sim == NULL) return;
    free(sim->port.scene_slots[0]);
    free(sim);
}

void crn_sim_set_memory(crn_sim *sim, bool joins_slots, void *near_memory, uint32_t near_bytes)
{
    sim->port.scene_large_bytes = joins_slots ? 2 * sim->port.scene_slot_bytes : 0;
    sim->port.near_memory = near_memory;
    sim->port.near_bytes = near_bytes;
}

void crn_sim_set_tick_cycles(crn_sim *sim, uint32_t tick_cycles)
{
    sim->port.tick_cycles = tick_cycles;
}

void crn_sim_write(crn_sim *sim, const uint8_t *bytes, size_t count)
{
    crn_app_receive(&sim->app, bytes, count);
}

size_t crn_sim_read(crn_sim *sim, uint8_t *bytes, size_t capacity)
{
    size_t count = sim->pipe_end - sim->pipe_begin;
    if (count > capacity) count = capacity;
    memcpy(bytes, sim->pipe + sim->pipe_begin, count);
    sim->pipe_begin += count;
    if (sim->pipe_begin == sim->pipe_end) sim->pipe_begin = sim->pipe_end = 0;
    return count;
}

bool crn_sim_share_scene(crn_sim *sim, const uint8_t *bytes, uint32_t byte_count, uint32_t crc32)
{
    return crn_app_scene_share(&sim->app, bytes, byte_count, crc32);
}

size_t crn_sim_snapshot_bytes(void)
{
    return CRN_APP_SNAPSHOT_BYTES;
}

bool crn_sim_take_snapshot(crn_sim *sim, uint8_t *bytes, size_t count)
{
    return count == CRN_APP_SNAPSHOT_BYTES && crn_app_snapshot_take(&sim->app, bytes);
}

bool crn_sim_put_snapshot(crn_sim *sim, const uint8_t *bytes, size_t count)
{
    return count == CRN_APP_SNAPSHOT_BYTES && crn_app_snapshot_put(&sim->app, bytes);
}

void crn_sim_set_pipe(crn_sim *sim, size_t bytes)
{
    sim->pipe_bytes = bytes < sizeof sim->pipe ? bytes : sizeof sim->pipe;
}

void crn_sim_timer(crn_sim *sim, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        pass_millisecond(sim);
        crn_app_timer(&sim->app);
    }
}

void crn_sim_freeze(crn_sim *sim, uint32_t milliseconds)
{
    for (uint32_t i = 0; i < milliseconds; i++) pass_millisecond(sim);
}

void crn_sim_set_tick_us(crn_sim *sim, uint32_t tick_us)
{
    sim->tick_us = tick_us;
}

void crn_sim_reset(crn_sim *sim)
{
    sim->pipe_begin = sim->pipe_end = 0;
    crn_app_init(&sim->app, &sim->port);
}

void crn_sim_set_inputs(crn_sim *sim, const crn_port_inputs *inputs)
{
    sim->has_rig = inputs != NULL;
    sim->port.capabilities = sim->has_rig ? CRN_WIRE_CAPABILITY_ENCODERS | CRN_WIRE_CAPABILITY_MOTORS : 0;
    if (inputs != NULL) sim->inputs = *inputs;
}

void crn_sim_set_plant(crn_sim *sim, const crn_port_inputs *inputs)
{
    crn_sim_set_inputs(sim, inputs);
    sim->is_plant = true;
}

void crn_sim_weld_stage(crn_sim *sim, bool is_welded)
{
    sim->is_welded = is_welded;
}

crn_port_inputs crn_sim_healthy_inputs(void)
{
    return (crn_port_inputs){.supply_good = true, .stage_on = true};
}

crn_port_outputs crn_sim_read_outputs(const crn_sim *sim)
{
    return sim->outputs;
}

crn_sim_motors crn_sim_read_motors(const crn_sim *sim)
{
    crn_sim_motors motors = {.drive = sim->stage_hold_ms > 0 || sim->is_welded};
    for (int k = 0; k < CRN_SIM_TOOL_MAX && motors.drive; k++) {
        motors.axial_mN[k] = sim->outputs.motors[k].axial_mN;
        motors.torque_uN_m[k] = sim->outputs.motors[k].torque_uN_m;
    }
    return motors;
}
