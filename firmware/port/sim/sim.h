/* The sim port: the firmware app as a library in the host's process, reached by bytes only.
 *
 * Thread rules: one thread at a time per sim. Any number of sims may exist.
 * May include: nothing. Called by: host/link, hil_tests, fuzzers. C11 and C++20.
 */
#ifndef SELD_SIM_H
#define SELD_SIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct seld_sim seld_sim;

/* Power up a device with two scene slots of `scene_slot_bytes` each. NULL when there is no memory. */
seld_sim *seld_sim_create(uint32_t scene_slot_bytes);
void seld_sim_destroy(seld_sim *sim);

/* Bytes to the device; all are taken, and replies are ready when it returns. */
void seld_sim_write(seld_sim *sim, const uint8_t *bytes, size_t count);

/* Bytes from the device: up to `capacity`; returns how many. The pipe holds SELD_SIM_PIPE_BYTES; frames that do not fit
 * are dropped by the device and counted in its status. */
enum { SELD_SIM_PIPE_BYTES = 1 << 20 };
size_t seld_sim_read(seld_sim *sim, uint8_t *bytes, size_t capacity);

/* Let `count` milliseconds pass on the device's timer; in FREE_RUN each is one tick. */
void seld_sim_timer(seld_sim *sim, uint32_t count);

/* What the actuators were last asked for: a meter clamped to the motor leads, for tests. */
enum { SELD_SIM_TOOL_MAX = 3 };
typedef struct seld_sim_motors {
    int32_t axial_mN[SELD_SIM_TOOL_MAX]; /* from the innermost tool */
    int32_t torque_uN_m[SELD_SIM_TOOL_MAX];
    int32_t drive; /* 1: powered */
} seld_sim_motors;
seld_sim_motors seld_sim_read_motors(const seld_sim *sim);

#ifdef __cplusplus
}
#endif

#endif
