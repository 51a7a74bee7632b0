/* This file sends replies. The app encodes each reply into app->buffers.payload, makes a frame of it, and
 * gives the frame to the port. */
#include "firmware/app/app_internal.h"

void crn_app_send(crn_app *app, uint16_t type, size_t payload_bytes)
{
    app->link.sequence_out++;
    if (app->link.sequence_out == 0)
        app->link.sequence_out = 1; /* in `answers`, 0 means that no request is answered */
    crn_wire_header header = {app->link.sequence_out, app->link.answers, type};
    size_t bytes = crn_wire_frame_encode(&header, app->buffers.payload, payload_bytes, app->buffers.frame,
                                         sizeof app->buffers.frame);
    CRN_REQUIRE(app, bytes > 0, type);
    if (bytes == 0 || !app->port->transmit(app->port->context, app->buffers.frame, bytes))
        app->link.transmit_dropped++;
}

/* Sends a message like crn_app_send. A message for which the pipe to the host had no space may be sent again,
 * because the message has not used up a frame number. */
bool crn_app_offer(crn_app *app, uint16_t type, size_t payload_bytes)
{
    uint16_t before = app->link.sequence_out;
    uint32_t dropped = app->link.transmit_dropped;
    crn_app_send(app, type, payload_bytes);
    if (app->link.transmit_dropped == dropped) return true;
    app->link.transmit_dropped = dropped;
    app->link.sequence_out = before;
    return false;
}

/* Encodes `value` as the message `name` and sends the message. */
#define SEND(app, name, value)                                                                               \
    do {                                                                                                     \
        crn_wire_writer writer = crn_wire_writer_make((app)->buffers.payload, sizeof(app)->buffers.payload); \
        bool is_encoded = crn_wire_put_##name(&writer, value);                                               \
        CRN_REQUIRE(app, is_encoded, CRN_WIRE_TYPE_##name);                                                  \
        if (is_encoded) crn_app_send(app, CRN_WIRE_TYPE_##name, writer.length);                              \
    } while (0)

void crn_app_reject(crn_app *app, uint16_t type, uint16_t code, uint32_t detail1, uint32_t detail2)
{
    const crn_wire_reject reject = {type, code, detail1, detail2};
    SEND(app, reject, &reject);
}

void crn_app_send_status(crn_app *app, uint16_t request_type)
{
    const uint32_t *counts = app->link.decoder.event_counts;
    const crn_wire_status status = {
        .request_type = request_type,
        .state = app->state,
        .mode = app->mode,
        .tick = app->core.words.tick,
        .fault_code = app->faults.stopped_by,
        .frames_bad = counts[CRN_WIRE_BAD_COBS] + counts[CRN_WIRE_BAD_SIZE] + counts[CRN_WIRE_BAD_CRC] +
                      counts[CRN_WIRE_BAD_LENGTH],
        .sequence_gaps = app->link.sequence_gaps,
        .transmit_dropped = app->link.transmit_dropped,
        .motors_armed = app->permission.is_given || app->safety.is_driving,
        .arm_code = app->permission.code,
        .tick_overruns = app->clock.tick_overruns,
        .tick_us_max = app->clock.tick_us_max,
        .ticks_lost = app->queue.ticks_lost,
        .pictures_dropped = app->queue.pictures_dropped,
        .events_lost = app->queue.events_lost,
        .passivity_ticks = app->haptics.passivity_ticks,
    };
    SEND(app, status, &status);
}

void crn_app_send_hello_reply(crn_app *app, bool accepted)
{
    crn_wire_hello_reply reply = {
        .accepted = accepted,
        .protocol_major = CRN_WIRE_PROTOCOL_MAJOR,
        .protocol_minor = CRN_WIRE_PROTOCOL_MINOR,
        .schema_hash = crn_wire_schema_hash(),
        .core_version = CRN_CORE_VERSION,
        .capabilities = CRN_WIRE_CAPABILITY_LOCKSTEP | CRN_WIRE_CAPABILITY_FREE_RUN |
                        CRN_WIRE_CAPABILITY_SNAPSHOTS | app->port->capabilities,
        .tick_us = CRN_TICK_us,
        .scene_bytes_max = crn_app_scene_bytes_max(app->port),
        .snapshot_bytes = CRN_APP_SNAPSHOT_BYTES,
    };
    const char *serial = app->port->serial;
    while (reply.serial_count < CRN_WIRE_MAX_hello_reply_serial && serial[reply.serial_count] != 0) {
        reply.serial[reply.serial_count] = (uint8_t)serial[reply.serial_count];
        reply.serial_count++;
    }
    SEND(app, hello_reply, &reply);
}

/* Balloon and lesions, for pictures. */
static void put_treatment(const crn_app *app, crn_wire_nodes *nodes)
{
    int32_t radii_m_q30[CRN_BALLOON_BALL_MAX];
    nodes->balloon_radii_um_count = (uint16_t)crn_state_balloon(
        &app->model, &app->core, radii_m_q30, &nodes->balloon_arc_m_q30, &nodes->balloon_spacing_m_q30);
    for (uint32_t j = 0; j < nodes->balloon_radii_um_count; j++)
        nodes->balloon_radii_um[j] = (uint16_t)(((int64_t)radii_m_q30[j] * 15625 + (1 << 23)) >> 24);
    uint32_t count = 0;
    for (uint32_t i = 0; i < CRN_LESION_MAX; i++) {
        for (uint32_t k = 0; k < crn_model_stations(&app->model, i); k++)
            nodes->lesions_open_q15[count++] = (uint16_t)(crn_state_open(&app->core, i, k) >> 15);
    }
    nodes->lesions_open_q15_count = (uint16_t)count;
}

_Static_assert((int)CRN_WIRE_MAX_nodes_walls == (int)CRN_WALL_STATION_MAX,
               "wire and core agree about walls that give way");

/* Format: Q30 m -> um, rounded; 15625 / 2^24 = 1e6 / 2^30. Each part of a way is at most 20 mm, so it fits 16
 * bits, and the way itself, of at most 35 mm, fits 16 bits without a sign. */
static int32_t um_of(int32_t m_q30)
{
    return (int32_t)(((int64_t)m_q30 * 15625 + (1 << 23)) >> 24);
}

static void put_walls(const crn_wall_state *wall, crn_wire_nodes *nodes)
{
    nodes->walls_count = (uint16_t)wall->used;
    for (uint32_t j = 0; j < wall->used && j < CRN_WIRE_MAX_nodes_walls; j++) {
        const crn_wall_give *at = &wall->stations[j];
        const int32_t *way = at->way_m_q30.v;
        nodes->walls[j] = (crn_wire_wall_way){(int16_t)um_of(way[0]), (int16_t)um_of(way[1]),
                                              (int16_t)um_of(way[2]), (uint16_t)um_of(at->widen_m_q30)};
    }
}

/* The message `nodes`, from which the host draws the tools, contains the nodes beyond the introducer sheath
 * and the first node inside the sheath. */
void crn_app_send_nodes(crn_app *app)
{
    crn_wire_nodes *nodes = &app->buffers.reply.nodes;
    uint32_t count = crn_state_free_count(&app->core) + 1;
    uint32_t total = crn_state_node_count(&app->model);
    if (count > total) count = total;
    if (count > CRN_WIRE_MAX_nodes_positions) count = CRN_WIRE_MAX_nodes_positions;
    nodes->tick = app->core.words.tick;
    nodes->heart_phase32 = crn_state_rhythm(&app->core)->heart_phase32;
    nodes->breath_phase32 = crn_state_rhythm(&app->core)->breath_phase32;
    nodes->inserted_m_q30_count = (uint16_t)app->setup.tool_count;
    for (uint32_t k = 0; k < app->setup.tool_count; k++)
        nodes->inserted_m_q30[k] = crn_state_inserted(&app->core, k);
    nodes->line_count = (uint16_t)app->setup.tool_count;
    for (uint32_t k = 0; k < app->setup.tool_count; k++)
        nodes->line[k] = (uint8_t)crn_state_tool_at(&app->core, k);
    put_treatment(app, nodes);
    put_walls(&app->core.words.wall, nodes);
    nodes->positions_count = (uint16_t)count;
    for (uint32_t i = 0; i < count; i++) {
        crn_vec3 p = crn_state_position(&app->core, i);
        nodes->positions[i] = (crn_wire_node_position){p.v[0], p.v[1], p.v[2]};
    }
    SEND(app, nodes, nodes);
}

void crn_app_send_node_table(crn_app *app)
{
    crn_wire_node_table *table = &app->buffers.reply.node_table;
    uint32_t count = crn_state_node_count(&app->model);
    CRN_REQUIRE(app, count <= CRN_WIRE_MAX_node_table_arcs_m_q30, count);
    if (count > CRN_WIRE_MAX_node_table_arcs_m_q30) count = CRN_WIRE_MAX_node_table_arcs_m_q30;
    table->arcs_m_q30_count = (uint16_t)count;
    for (uint32_t i = 0; i < count; i++) table->arcs_m_q30[i] = crn_model_arc(&app->model, i);
    SEND(app, node_table, table);
}

/* The farthest station of the walls, and the widest. */
static void put_wall_figures(const crn_wall_state *wall, crn_wire_contacts *contacts)
{
    contacts->wall_way_um = contacts->wall_widened_um = 0;
    for (uint32_t j = 0; j < wall->used; j++) {
        const crn_vec3 *way = &wall->stations[j].way_m_q30;
        const uint16_t um = (uint16_t)um_of(crn_sqrt64((uint64_t)crn_vec3_dot64(*way, *way)));
        const uint16_t widened_um = (uint16_t)um_of(wall->stations[j].widen_m_q30);
        contacts->wall_way_um = um > contacts->wall_way_um ? um : contacts->wall_way_um;
        contacts->wall_widened_um =
            widened_um > contacts->wall_widened_um ? widened_um : contacts->wall_widened_um;
    }
}

void crn_app_send_contacts(crn_app *app)
{
    crn_wire_contacts *contacts = &app->buffers.reply.contacts;
    uint32_t free_count = crn_state_free_count(&app->core);
    contacts->tick = crn_state_tick(&app->core);
    put_wall_figures(&app->core.words.wall, contacts);
    contacts->contacts_count = 0;
    for (uint32_t i = 0; i < free_count && contacts->contacts_count < CRN_WIRE_MAX_contacts_contacts; i++) {
        crn_vec3 f;
        if (!crn_state_contact_force(&app->model, &app->core, i, &f)) continue;
        contacts->contacts[contacts->contacts_count++] =
            (crn_wire_contact){(uint16_t)i, f.v[0], f.v[1], f.v[2]};
    }
    SEND(app, contacts, contacts);
}

void crn_app_send_hash64(crn_app *app)
{
    const crn_wire_hash64 hash = {app->core.words.tick, crn_state_hash64(&app->core)};
    SEND(app, hash64, &hash);
}

void crn_app_send_fault_log(crn_app *app)
{
    crn_wire_fault_log *log = &app->buffers.reply.fault_log;
    log->entries_count = app->faults.count;
    for (uint16_t i = 0; i < app->faults.count; i++) log->entries[i] = app->faults.entries[i];
    SEND(app, fault_log, log);
}

/* Sends the ticks gathered so far and starts a new batch. */
void crn_app_send_ticks(crn_app *app)
{
    SEND(app, ticks, &app->buffers.ticks);
    app->buffers.ticks.states_count = 0;
}

/* The configuration in force. */
void crn_app_send_rig(crn_app *app)
{
    crn_wire_rig rig = {.tracks_count = CRN_TOOL_MAX};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) rig.tracks[k] = app->setup.tracks[k].wire;
    SEND(app, rig, &rig);
}

void crn_app_send_set_up(crn_app *app)
{
    const crn_upload *upload = &app->setup.scene_upload;
    const crn_wire_set_up set_up = {
        .scene_bytes = app->setup.has_scene ? app->setup.scene_bytes : 0,
        .scene_crc32 = app->setup.has_scene ? app->setup.scene_crc32 : 0,
        .upload_bytes = upload->open ? upload->expected_bytes : 0,
        .upload_crc32 = upload->open ? upload->crc32 : 0,
        .upload_received = upload->open ? upload->received_bytes : 0,
        .tool_count = (uint16_t)app->setup.tool_count,
        .tools_crc32 = app->setup.tools_crc32,
        .has_entry = app->setup.has_entry,
        .entry_crc32 = app->setup.entry_crc32,
    };
    SEND(app, set_up, &set_up);
}

static crn_wire_track_sensors track_sensors(const crn_app *app, uint32_t k)
{
    const crn_port_track *track = &app->edge.rig.tracks[k];
    const crn_port_motor motor = app->safety.driven[k];
    return (crn_wire_track_sensors){
        .translation_counts = app->edge.rig.hands[k].translation_counts,
        .rotation_counts = app->edge.rig.hands[k].rotation_counts,
        .force_raw = track->force_raw,
        .force_mN = crn_app_force_measured(app, k),
        .translation_sensor = track->translation_sensor,
        .rotation_sensor = track->rotation_sensor,
        .force_sensor = track->force_sensor,
        .over_current = track->over_current,
        .motor_axial_mN = motor.axial_mN,
        .motor_torque_uN_m = motor.torque_uN_m,
    };
}

void crn_app_send_sensors(crn_app *app)
{
    const crn_port_inputs *rig = &app->edge.rig;
    crn_wire_sensors sensors = {
        .tick = app->core.words.tick,
        .has_rig = app->edge.has_rig,
        .tracks_count = CRN_TOOL_MAX,
        .syringe_counts = rig->syringe_counts,
        .inflator_raw = rig->inflator_raw,
        .syringe_sensor = rig->syringe_sensor,
        .inflator_sensor = rig->inflator_sensor,
        .buttons = rig->buttons,
        .lines = (uint8_t)((rig->emergency_stop ? CRN_WIRE_LINE_STOP : 0) |
                           (rig->supply_good ? CRN_WIRE_LINE_SUPPLY : 0) |
                           (rig->stage_on ? CRN_WIRE_LINE_STAGE : 0) |
                           (rig->local_unlock ? CRN_WIRE_LINE_UNLOCK : 0)),
    };
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) sensors.tracks[k] = track_sensors(app, k);
    SEND(app, sensors, &sensors);
}
