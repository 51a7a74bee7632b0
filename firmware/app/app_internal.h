/* This header has the declarations that the files of the app share. The declarations of functions are grouped
 * by the file that defines the functions. */
#ifndef CRN_APP_INTERNAL_H
#define CRN_APP_INTERNAL_H

#include "firmware/app/app.h"

/* If the check CRN_REQUIRE finds an error in the app itself, the app logs the error, switches the motors off,
 * and goes to the state FAULT. Release builds contain this check, too. */
#define CRN_REQUIRE(app, condition, value)                                                                   \
    do {                                                                                                     \
        if (!(condition)) crn_app_internal_error(app, __LINE__, (int32_t)(value));                           \
    } while (0)

/* If the host has made an error, the macro CRN_REJECT_IF refuses the message with an error code, changes
 * nothing, and returns from the function that handles the message. */
#define CRN_REJECT_IF(app, type, condition, code, detail1, detail2)                                          \
    do {                                                                                                     \
        if (condition) {                                                                                     \
            crn_app_reject(app, type, code, (uint32_t)(detail1), (uint32_t)(detail2));                       \
            return;                                                                                          \
        }                                                                                                    \
    } while (0)

/* app_reply.c: what goes out */
void crn_app_send(crn_app *app, uint16_t type, size_t payload_bytes);
void crn_app_reject(crn_app *app, uint16_t type, uint16_t code, uint32_t detail1, uint32_t detail2);
void crn_app_send_status(crn_app *app, uint16_t request_type);
void crn_app_send_hello_reply(crn_app *app, bool accepted);
void crn_app_send_nodes(crn_app *app);
void crn_app_send_node_table(crn_app *app);
void crn_app_send_contacts(crn_app *app);
void crn_app_send_hash64(crn_app *app);
void crn_app_send_fault_log(crn_app *app);
void crn_app_send_ticks(crn_app *app);
void crn_app_send_rig(crn_app *app);
void crn_app_send_set_up(crn_app *app);
void crn_app_send_sensors(crn_app *app);
bool crn_app_offer(crn_app *app, uint16_t type, size_t payload_bytes);

/* app_setup.c: scene, tools, entry; only in READY */
void crn_app_scene_begin(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_scene_chunk(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_scene_end(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_tools(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_entry(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_reject_build(crn_app *app, uint16_t type, crn_build_status status, const crn_build_place *place);
/* Builds the model from the table of tools, the line (the tools inserted one inside another), the lumen and
 * the place of entry. */
crn_build_status crn_app_build(crn_app *app, const crn_lumen *lumen, const crn_entry *entry,
                               crn_build_place *place);

/* A scene that was checked, before it takes the place of the present one. */
typedef struct crn_opened_scene {
    crn_lumen lumen;
    crn_motion motion;
    crn_lesion lesions[CRN_LESION_MAX];
    crn_walls walls;
} crn_opened_scene;

/* Converts the bytes of a scene to the form in which the core reads the lumen (app_lumen.c). After the call,
 * the lumen points to the other members: to `motion` if the vessel moves, to `lesions`, and to `walls` if
 * they give way. The function returns 0, or the scene status that names the error; in case of an error all
 * outputs are unchanged. */
uint32_t crn_app_lumen_open(const uint8_t *bytes, uint32_t byte_count, crn_opened_scene *opened);

/* app_rig.c: configuration of the tracks */
void crn_app_rig(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_rig_take(crn_app *app, const crn_wire_rig *wire);
void crn_app_track_default(crn_app_track *track, const crn_port *port);

/* app_budget.c: whether the processor can compute a tick of the set-up in time */
typedef enum crn_app_place {
    CRN_APP_PLACE_FREE, /* no scene: no wall */
    CRN_APP_PLACE_STILL,
    CRN_APP_PLACE_BEATING,
} crn_app_place;
typedef struct crn_app_load {
    uint32_t nodes; /* that can lie in the vessel */
    uint32_t positions;
    crn_app_place place;
} crn_app_load;
crn_app_load crn_app_load_of(const crn_app *app); /* of the model that was built */
uint32_t crn_app_load_cycles(const crn_app_load *load);
bool crn_app_is_in_time(crn_app *app); /* false: the request was refused */

/* app_command.c: states and modes */
void crn_app_command(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_command_take(crn_app *app, const crn_wire_command *command);
void crn_app_stop(crn_app *app);
void crn_app_set_state(crn_app *app, uint8_t state);

/* app_session.c: ticks */
void crn_app_step(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_input(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_log_core_faults(crn_app *app, uint32_t bits);

/* app_orders.c: the orders of a tick besides the hands */
void crn_app_orders(crn_app *app, const uint8_t *payload, size_t length);
/* Checks the commands to the core for one tick and converts them for the core. Returns a refusal code. The
 * output `place` receives the index of the faulty command in the list. */
uint16_t crn_app_orders_take(const crn_app *app, const crn_wire_order_list *list, crn_app_order_set *taken,
                             uint32_t *place);
/* Returns the commands for this tick of FREE_RUN; they are valid until the next message. */
const crn_app_tick_orders *crn_app_orders_next(crn_app *app);
/* Before the tick runs, carries out the exchange of a tool that the host ordered for this tick, if any, and
 * keeps the answer for the host. */
void crn_app_exchange(crn_app *app, const crn_app_order_set *orders);

/* app_stream.c: what the device sends unasked, with back-pressure */
void crn_app_stream(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_stream_live(crn_app *app, const crn_wire_live_tick *live);
void crn_app_stream_tick(crn_app *app);
void crn_app_stream_hash64(crn_app *app);
void crn_app_stream_flush(crn_app *app);
void crn_app_stream_clear(crn_app *app);
void crn_app_notice(crn_app *app, uint16_t kind, uint16_t code, int32_t value1, int32_t value2);

/* app_snapshot.c */
void crn_app_snapshot_send(crn_app *app);
void crn_app_snapshot_begin(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_snapshot_chunk(crn_app *app, const uint8_t *payload, size_t length);
void crn_app_snapshot_end(crn_app *app, const uint8_t *payload, size_t length);

/* app_parts.c: hands, haptics, safety, clock, watchdog: their inputs and findings */
void crn_app_track_apply(crn_app *app, uint32_t track); /* a new configuration, to the parts */
uint32_t crn_app_driven_tracks(const crn_app *app);     /* how many tracks of the tools could be driven */
bool crn_app_hands_update(crn_app *app, const crn_app_encoders *now);
void crn_app_haptics_before(crn_app *app, crn_haptics_input *felt, crn_input *input);
void crn_app_haptics_after(crn_app *app, crn_haptics_input *felt, const crn_output *output);
void crn_app_safety_check(crn_app *app);
crn_fault_code crn_app_safety_ready(const crn_app *app);
void crn_app_motors_on(crn_app *app);     /* power, which needs a rig */
void crn_app_motors_off(crn_app *app);    /* no power, now */
void crn_app_outputs_write(crn_app *app); /* once per edge */
void crn_app_clock_begin(crn_app *app);
void crn_app_clock_end(crn_app *app);
void crn_app_silence_count(crn_app *app);

/* app_fault.c */
void crn_app_fault_log(crn_app *app, crn_fault_code code, int32_t value1, int32_t value2);
void crn_app_fault(crn_app *app, crn_fault_code code, int32_t value1, int32_t value2);
void crn_app_report(crn_app *app, const crn_findings *findings);
void crn_app_internal_error(crn_app *app, int line, int32_t value);

#endif
