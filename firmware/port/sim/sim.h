/* The sim port: the firmware app as a library in the host's process, accessed by bytes only. It includes a
 * bench for the rig: the caller sets the sensor values, and a power stage behaves like a real one.
 *
 * Thread rules: one thread at a time per sim. Any number of sims may exist. C11 and C++20. */
#ifndef CRN_SIM_H
#define CRN_SIM_H

#include "firmware/port/port.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct crn_sim crn_sim;

/* Powers up a device with two scene slots of `scene_slot_bytes` each. Returns NULL when there is no
 * memory. */
crn_sim *crn_sim_create(uint32_t scene_slot_bytes);
void crn_sim_destroy(crn_sim *sim);

/* Brown-out: the processor restarts. Scene slots keep their contents, and the pipe is empty. */
void crn_sim_reset(crn_sim *sim);

/* Sends bytes to the device. All are accepted, and replies are ready when it returns. */
void crn_sim_write(crn_sim *sim, const uint8_t *bytes, size_t count);

/* Reads up to `capacity` bytes from the device; returns how many. The pipe holds `crn_sim_set_pipe` bytes,
 * initially CRN_SIM_PIPE_BYTES. What does not fit stays in the device, or is dropped there and counted. */
enum { CRN_SIM_PIPE_BYTES = 1 << 20 };
size_t crn_sim_read(crn_sim *sim, uint8_t *bytes, size_t capacity);
void crn_sim_set_pipe(crn_sim *sim, size_t bytes); /* at most CRN_SIM_PIPE_BYTES */

/* Lets `count` milliseconds pass on the device's timer; in FREE_RUN each is one tick. */
void crn_sim_timer(crn_sim *sim, uint32_t count);

/* Lets time pass while the processor is halted, as under a debugger: the power stage continues alone. */
void crn_sim_freeze(crn_sim *sim, uint32_t milliseconds);

/* Sets how long the device works on one tick from now on; initially 0. */
void crn_sim_set_tick_us(crn_sim *sim, uint32_t tick_us);

/* --- the rig -------------------------------------------------------------------------------------------- */

/* Connects a rig with these sensor values from now on; NULL removes the rig, which is the initial state. If
 * `stage_on` is true, the sim's own power stage supplies that signal. The hands hold still against the
 * motors: the motors' forces are added to every `force_raw`, 1 mN per count. */
void crn_sim_set_inputs(crn_sim *sim, const crn_port_inputs *inputs);

/* Connects a rig that is modelled outside, with its own power stage: the sample is used as it is. */
void crn_sim_set_plant(crn_sim *sim, const crn_port_inputs *inputs);

/* Makes the power stage unable to turn off, as if its transistors had melted. */
void crn_sim_weld_stage(crn_sim *sim, bool is_welded);

/* Damping of the rig itself that the sim's builder states; the lag of the motors is 0, with 1 um and 1/65,536
 * turn per count. A host needs the unlock to state more damping. */
enum { CRN_SIM_DAMPING_mN_s_per_m = 1000, CRN_SIM_DAMPING_nN_m_s_per_rad = 2000 };

/* Sensors are present and healthy, hands at 0, supply good, stop released, no unlock. */
crn_port_inputs crn_sim_healthy_inputs(void);

/* Returns the last outputs of the app. */
crn_port_outputs crn_sim_read_outputs(const crn_sim *sim);

/* Forces of the motors: a meter clamped to their leads, behind the power stage. */
enum { CRN_SIM_TOOL_MAX = CRN_PORT_TOOL_MAX };
typedef struct crn_sim_motors {
    int32_t axial_mN[CRN_SIM_TOOL_MAX]; /* from the innermost tool; 0 without power */
    int32_t torque_uN_m[CRN_SIM_TOOL_MAX];
    int32_t drive; /* 1: powered */
} crn_sim_motors;
crn_sim_motors crn_sim_read_motors(const crn_sim *sim);

#ifdef __cplusplus
}
#endif

#endif
