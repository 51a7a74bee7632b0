/* The sim port: memory, a byte pipe and a timer around the app. Called by: sim.h's users. */
#include "firmware/port/sim/sim.h"
#include "firmware/app/app.h"

#include <stdlib.h>
#include <string.h>

struct seld_sim {
    seld_port port;
    seld_sim_motors motors;
    size_t pipe_begin, pipe_end;
    uint8_t pipe[SELD_SIM_PIPE_BYTES];
    seld_app app;
};

static bool sim_transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    seld_sim *sim = context;
    if (frame_bytes > sizeof sim->pipe - sim->pipe_end && sim->pipe_begin > 0) {
        memmove(sim->pipe, sim->pipe + sim->pipe_begin, sim->pipe_end - sim->pipe_begin);
        sim->pipe_end -= sim->pipe_begin;
        sim->pipe_begin = 0;
    }
    if (frame_bytes > sizeof sim->pipe - sim->pipe_end) return false;
    memcpy(sim->pipe + sim->pipe_end, frame, frame_bytes);
    sim->pipe_end += frame_bytes;
    return true;
}

/* No rig is attached: the app uses the host's `input` messages. */
static bool sim_encoders(void *context, seld_port_encoders *encoders)
{
    (void)context;
    (void)encoders;
    return false;
}

static void sim_motors(void *context, const seld_port_motor motors[SELD_PORT_TOOL_MAX], bool drive)
{
    seld_sim *sim = context;
    for (int k = 0; k < SELD_SIM_TOOL_MAX; k++) {
        sim->motors.axial_mN[k] = motors[k].axial_mN;
        sim->motors.torque_uN_m[k] = motors[k].torque_uN_m;
    }
    sim->motors.drive = drive;
}

seld_sim *seld_sim_create(uint32_t scene_slot_bytes)
{
    seld_sim *sim = calloc(1, sizeof *sim);
    /* One byte more, so that slots of 0 bytes are slots too. */
    uint8_t *slots[2] = {malloc((size_t)scene_slot_bytes + 1), malloc((size_t)scene_slot_bytes + 1)};
    if (sim == NULL || slots[0] == NULL || slots[1] == NULL) {
        free(slots[0]);
        free(slots[1]);
        free(sim);
        return NULL;
    }
    sim->port = (seld_port){
        .context = sim,
        .transmit = sim_transmit,
        .encoders = sim_encoders,
        .motors = sim_motors,
        .scene_slots = {slots[0], slots[1]},
        .scene_slot_bytes = scene_slot_bytes,
        .capabilities = 0,
    };
    seld_app_init(&sim->app, &sim->port);
    return sim;
}

void seld_sim_destroy(seld_sim *sim)
{
    if (sim == NULL) return;
    free(sim->port.scene_slots[0]);
    free(sim->port.scene_slots[1]);
    free(sim);
}

void seld_sim_write(seld_sim *sim, const uint8_t *bytes, size_t count)
{
    seld_app_receive(&sim->app, bytes, count);
}

size_t seld_sim_read(seld_sim *sim, uint8_t *bytes, size_t capacity)
{
    size_t count = sim->pipe_end - sim->pipe_begin;
    if (count > capacity) count = capacity;
    memcpy(bytes, sim->pipe + sim->pipe_begin, count);
    sim->pipe_begin += count;
    if (sim->pipe_begin == sim->pipe_end) sim->pipe_begin = sim->pipe_end = 0;
    return count;
}

void seld_sim_timer(seld_sim *sim, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) seld_app_timer(&sim->app);
}

seld_sim_motors seld_sim_read_motors(const seld_sim *sim)
{
    return sim->motors;
}
