/* The simulated port ("sim") runs the firmware app as a library in the host's process; the caller reaches the
 * app through bytes only. The simulated port includes a simple test rig: the caller sets the sensor values,
 * and a power stage behaves like a real one.
 *
 * Only one thread at a time may use a simulated device. Any number of simulated devices may exist at the same
 * time. C11 and C++20. */
#ifndef CRN_SIM_H
#define CRN_SIM_H

#include "firmware/port/port.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct crn_sim crn_sim;

/* Powers up a simulated device with two scene slots of `scene_slot_bytes` each. Returns NULL if there is not
 * enough memory. */
crn_sim *crn_sim_create(uint32_t scene_slot_bytes);
void crn_sim_destroy(crn_sim *sim);

/* Gives the device the memories of a board, before its first scene: a scene larger than a slot may take both,
 * and parts of a scene are kept in `near_memory`, which the caller owns (crn_port). */
void crn_sim_set_memory(crn_sim *sim, bool joins_slots, void *near_memory, uint32_t near_bytes);

/* Gives the device the processor of a board, which has this many cycles in a tick; 0: a processor that
 * computes any set-up in time. */
void crn_sim_set_tick_cycles(crn_sim *sim, uint32_t tick_cycles);

/* Lets the device use a scene in the caller's memory, without an upload (crn_app_scene_share()). */
bool crn_sim_share_scene(crn_sim *sim, const uint8_t *bytes, uint32_t byte_count, uint32_t crc32);

/* Brown-out: the processor restarts. After crn_sim_reset the scene slots still have their contents, and the
 * byte pipe to the host is empty. */
void crn_sim_reset(crn_sim *sim);

/* Sends bytes to the device. The device accepts all bytes, and its replies are ready when the function
 * returns. */
void crn_sim_write(crn_sim *sim, const uint8_t *bytes, size_t count);

/* Reads up to `capacity` bytes from the device and returns the number of bytes read. The pipe to the host
 * holds as many bytes as crn_sim_set_pipe has set, initially CRN_SIM_PIPE_BYTES. The device keeps messages
 * that do not fit into the pipe, or drops and counts them. */
enum { CRN_SIM_PIPE_BYTES = 1 << 20 };
size_t crn_sim_read(crn_sim *sim, uint8_t *bytes, size_t capacity);
void crn_sim_set_pipe(crn_sim *sim, size_t bytes); /* at most CRN_SIM_PIPE_BYTES */

/* Lets `count` milliseconds pass on the device's timer; in FREE_RUN each millisecond is one tick. */
void crn_sim_timer(crn_sim *sim, uint32_t count);

/* Lets time pass while the simulated processor is halted, as under a debugger; only the power stage
 * continues. */
void crn_sim_freeze(crn_sim *sim, uint32_t milliseconds);

/* Sets how much time the device spends on each following tick; the initial value is 0. */
void crn_sim_set_tick_us(crn_sim *sim, uint32_t tick_us);

/* These functions copy the state of a LOCKSTEP session as a snapshot, and set the device to the state of a
 * snapshot, without messages over the pipe. The bytes of a snapshot are those of the snapshot messages in the
 * wire protocol (docs/wire.md). These two functions return false, and leave the session as it is, in three
 * cases: the device has no session in LOCKSTEP, `count` is not crn_sim_snapshot_bytes(), or the bytes are not
 * a valid snapshot of this session. */
size_t crn_sim_snapshot_bytes(void);
bool crn_sim_take_snapshot(crn_sim *sim, uint8_t *bytes, size_t count);
bool crn_sim_put_snapshot(crn_sim *sim, const uint8_t *bytes, size_t count);

/* --- the rig -------------------------------------------------------------------------------------------- */

/* Connects a rig that has the given sensor values from now on; NULL removes the rig. Initially there is no
 * rig. If `stage_on` is true in the given inputs, the simulated power stage of the device determines the
 * value of `stage_on` that the app reads. The simulated hands hold still against the motors: the motors'
 * forces are added to every `force_raw`, with 1 mN per count. */
void crn_sim_set_inputs(crn_sim *sim, const crn_port_inputs *inputs);

/* Connects a rig that the caller models, including its power stage; the device uses the readings unchanged.
 */
void crn_sim_set_plant(crn_sim *sim, const crn_port_inputs *inputs);

/* Makes the power stage unable to turn off, as when its transistors have failed as short circuits. */
void crn_sim_weld_stage(crn_sim *sim, bool is_welded);

/* Gives the damping that the simulated rig itself has, according to its builder's data. According to the data
 * of the simulated rig's builder, the motors have no lag, and an encoder count is 1 um or 1/65,536 turn. To
 * set a larger damping than the rig itself has, a host needs the local unlock (a switch inside the rig). */
enum { CRN_SIM_DAMPING_mN_s_per_m = 1000, CRN_SIM_DAMPING_nN_m_s_per_rad = 2000 };

/* Returns rig inputs with all sensors present and healthy, hands at position 0, a good supply voltage, the
 * stop button released, and the local unlock open. */
crn_port_inputs crn_sim_healthy_inputs(void);

/* Returns the last outputs that the app wrote. */
crn_port_outputs crn_sim_read_outputs(const crn_sim *sim);

/* Holds the forces of the motors behind the power stage, as a meter at the motors' leads would show them. */
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
