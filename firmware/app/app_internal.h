/* What the files of the app share. Top to bottom: wire -> requests -> session -> hand, coupling, force, safety, stream,
 * faults.
 * May include: app.h. Called by: this folder only. */
#ifndef SELD_APP_INTERNAL_H
#define SELD_APP_INTERNAL_H

#include "firmware/app/app.h"

/* Our own error: log it, motors off, state FAULT. Stays on in release. */
#define SELD_REQUIRE(app, condition, value)                                                                  \
    do {                                                                                                     \
        if (!(condition)) seld_app_internal_error(app, __LINE__, (int32_t)(value));                          \
    } while (0)

/* The other side's error: refuse with a typed code, change nothing, leave the handler. */
#define SELD_REJECT_IF(app, type, condition, code, detail1, detail2)                                         \
    do {                                                                                                     \
        if (condition) {                                                                                     \
            seld_app_reject(app, type, code, (uint32_t)(detail1), (uint32_t)(detail2));                      \
            return;                                                                                          \
        }                                                                                                    \
    } while (0)

/* value / divisor towards zero, for divisors of at most 65 535 and |value| < 2^63. A 32-bit processor divides 64 bits only by a
 * helper of hundreds of instructions; this is three divisions of 32 bits, digits of 16 bits from the top: a rest is below the
 * divisor, so that rest and next digit fit 32 bits and their quotient fits 16. */
static inline int64_t seld_app_quotient(int64_t value, uint32_t divisor)
{
    const uint64_t size = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    const uint32_t high = (uint32_t)(size >> 32);
    const uint32_t middle = (high % divisor) << 16 | (uint32_t)(size >> 16 & 0xffff);
    const uint32_t low = (middle % divisor) << 16 | (uint32_t)(size & 0xffff);
    const uint64_t quotient =
        (uint64_t)(high / divisor) << 32 | (uint64_t)(middle / divisor) << 16 | low / divisor;
    return value < 0 ? -(int64_t)quotient : (int64_t)quotient;
}

/* app_reply.c: what goes out */
void seld_app_send(seld_app *app, uint16_t type, size_t payload_bytes);
void seld_app_reject(seld_app *app, uint16_t type, uint16_t code, uint32_t detail1, uint32_t detail2);
void seld_app_send_status(seld_app *app, uint16_t request_type);
void seld_app_send_hello_reply(seld_app *app, bool accepted);
void seld_app_send_nodes(seld_app *app);
void seld_app_send_node_table(seld_app *app);
void seld_app_send_contacts(seld_app *app);
void seld_app_send_hash64(seld_app *app);
void seld_app_send_fault_log(seld_app *app);
void seld_app_send_ticks(seld_app *app);
void seld_app_send_rig(seld_app *app);
void seld_app_send_set_up(seld_app *app);
void seld_app_send_sensors(seld_app *app);
bool seld_app_offer(seld_app *app, uint16_t type, size_t payload_bytes);

/* app_setup.c: scene, tools, entry; only in READY */
void seld_app_scene_begin(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_scene_chunk(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_scene_end(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_tools(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_entry(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_reject_build(seld_app *app, uint16_t type, seld_build_status status,
                           const seld_build_place *place);

/* app_lumen.c: scene bytes -> the core's view of them; `lumen` then points to `motion` when it moves, and to `lesions` when some give way. 0,
 * or the scene status that says what is wrong: all are as they were. */
uint32_t seld_app_lumen_open(const uint8_t *bytes, uint32_t byte_count, seld_lumen *lumen,
                             seld_motion *motion, seld_lesion lesions[SELD_LESION_MAX]);

/* app_rig.c: configuration of the tracks */
void seld_app_rig(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_rig_take(seld_app *app, const seld_wire_rig *wire);
void seld_app_track_default(seld_app_track *track, const seld_port *port);

/* app_command.c: states and modes */
void seld_app_command(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_command_take(seld_app *app, const seld_wire_command *command);
void seld_app_stop(seld_app *app);
void seld_app_set_state(seld_app *app, uint8_t state);

/* app_session.c: ticks */
void seld_app_step(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_input(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_rhythm(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_scaffold(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_strut(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_log_core_faults(seld_app *app, uint32_t bits);

/* app_stream.c: what goes out by itself, with back-pressure */
void seld_app_stream(seld_app *app, const uint8_t *payload, size_t length);
seld_wire_live_tick *seld_app_stream_next(seld_app *app);
void seld_app_stream_tick(seld_app *app);
void seld_app_stream_hash64(seld_app *app);
void seld_app_stream_flush(seld_app *app);
void seld_app_stream_clear(seld_app *app);
void seld_app_notice(seld_app *app, uint16_t kind, uint16_t code, int32_t value1, int32_t value2);

/* app_snapshot.c */
void seld_app_snapshot_send(seld_app *app);
void seld_app_snapshot_begin(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_snapshot_chunk(seld_app *app, const uint8_t *payload, size_t length);
void seld_app_snapshot_end(seld_app *app, const uint8_t *payload, size_t length);

/* app_hand.c: encoder counts -> hand positions */
void seld_app_hands_reset(seld_app *app);
void seld_app_hands_take_reference(seld_app *app); /* the next reading is where the hands are, not a motion */
bool seld_app_hands_update(seld_app *app, const seld_app_encoders *now);
void seld_app_hands_input(const seld_app *app, seld_input *input);

/* app_coupling.c: between hands and tools */
void seld_app_axis_set(seld_app_axis *axis, int which, const seld_wire_track *wire);
void seld_app_coupling_before(seld_app *app, seld_input *input);
void seld_app_coupling_after(seld_app *app, const seld_output *output);
void seld_app_coupling_reset(seld_app *app);

/* app_force.c: gain -> passivity -> slew limit -> force limit -> fade, and the outputs */
void seld_app_motors_update(seld_app *app, const seld_input *hands, const seld_output *output);
bool seld_app_gives_energy(const seld_app_energy *energy);
void seld_app_motors_reset(seld_app *app);
void seld_app_motors_off(seld_app *app);
void seld_app_outputs_write(seld_app *app);

/* app_safety.c: what can hurt a finger */
void seld_app_safety_check(seld_app *app);
seld_fault_code seld_app_safety_ready(const seld_app *app);
void seld_app_safety_begin(seld_app *app);
void seld_app_clock_begin(seld_app *app);
void seld_app_clock_end(seld_app *app);

/* app_carriage.c: what a motor may do to a carriage that nobody holds */
int32_t seld_app_carriage_moved(const seld_app *app, uint32_t track);
int32_t seld_app_carriage_bound(seld_app *app, uint32_t track, int32_t asked_mN);
seld_fault_code seld_app_carriage_check(seld_app *app, uint32_t track, int32_t *value);

/* app_cycle.c: cycles that a motor keeps up in a hand */
bool seld_app_cycle_lasts(seld_app *app, uint32_t track, int32_t moved_counts);

/* app_fault.c */
void seld_app_fault_log(seld_app *app, seld_fault_code code, int32_t value1, int32_t value2);
void seld_app_fault(seld_app *app, seld_fault_code code, int32_t value1, int32_t value2);
void seld_app_internal_error(seld_app *app, int line, int32_t value);

#endif
