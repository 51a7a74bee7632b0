#include "firmware/tests/reference/client.h"

#include <string.h>

void client_open(client *c, uint32_t scene_slot_bytes)
{
    memset(c, 0, sizeof *c);
    c->sim = crn_sim_create(scene_slot_bytes);
    crn_wire_decoder_init(&c->decoder);
}

void client_open_pipe(client *c, const client_pipe *pipe)
{
    memset(c, 0, sizeof *c);
    c->pipe = *pipe;
    crn_wire_decoder_init(&c->decoder);
}

void client_close(client *c)
{
    crn_sim_destroy(c->sim);
    c->sim = NULL;
}

void client_send(client *c, uint16_t type, const uint8_t *payload, size_t length)
{
    c->sequence = c->sequence == UINT16_MAX ? 1 : (uint16_t)(c->sequence + 1);
    const crn_wire_header header = {c->sequence, 0, type};
    size_t bytes = crn_wire_frame_encode(&header, payload, length, c->frame, sizeof c->frame);
    if (c->sim != NULL)
        crn_sim_write(c->sim, c->frame, bytes);
    else
        c->pipe.write(c->pipe.context, c->frame, bytes);
}

static size_t read_byte(client *c, uint8_t *byte)
{
    return c->sim != NULL ? crn_sim_read(c->sim, byte, 1) : c->pipe.read(c->pipe.context, byte, 1);
}

uint16_t client_receive(client *c)
{
    uint8_t byte;
    while (read_byte(c, &byte) == 1) {
        if (crn_wire_decoder_push(&c->decoder, byte) == CRN_WIRE_FRAME) return c->decoder.header.type;
    }
    return 0;
}

#define SEND(c, name, value)                                                                                 \
    do {                                                                                                     \
        crn_wire_writer writer = crn_wire_writer_make((c)->payload, sizeof(c)->payload);                     \
        crn_wire_put_##name(&writer, value);                                                                 \
        client_send(c, CRN_WIRE_TYPE_##name, writer.bytes, writer.length);                                   \
    } while (0)

void client_hello(client *c, uint64_t schema_hash)
{
    const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR, schema_hash};
    SEND(c, hello, &hello);
}

void client_command(client *c, uint8_t action)
{
    const crn_wire_command command = {.action = action};
    SEND(c, command, &command);
}

void client_stop_at(client *c, uint32_t tick)
{
    const crn_wire_command command = {.action = CRN_WIRE_ACTION_STOP, .tick = tick};
    SEND(c, command, &command);
}

void client_confirm(client *c, uint32_t code)
{
    const crn_wire_command command = {.action = CRN_WIRE_ACTION_CONFIRM, .code = code};
    SEND(c, command, &command);
}

bool client_arm_motors(client *c)
{
    crn_wire_status status;
    client_command(c, CRN_WIRE_ACTION_ARM_MOTORS);
    if (!client_expect_status(c, &status) || status.arm_code == 0) return false;
    client_confirm(c, status.arm_code);
    return client_expect_status(c, &status) && status.motors_armed == 1;
}

void client_rig(client *c, const crn_wire_track *tracks, uint16_t count)
{
    crn_wire_rig rig = {.tracks_count = count};
    for (uint16_t k = 0; k < count; k++) rig.tracks[k] = tracks[k];
    SEND(c, rig, &rig);
}

crn_wire_track client_plain_track(void)
{
    return (crn_wire_track){.translation_pm_per_count = 1000000,
                            .rotation_counts_per_turn = 65536,
                            .force_gain_milli = 1000,
                            .force_limit_mN = 8000,
                            .torque_limit_uN_m = 20000,
                            .damping_mN_s_per_m = 1000,
                            .damping_nN_m_s_per_rad = 2000,
                            .coupling_N_per_m = 1000,
                            .coupling_uN_m_per_rad = 2000,
                            .coupling_mN_s_per_m = 200,
                            .coupling_nN_m_s_per_rad = 400};
}

void client_stream(client *c, uint8_t events, uint16_t nodes_every_ticks)
{
    const crn_wire_stream stream = {events, nodes_every_ticks};
    SEND(c, stream, &stream);
}

void client_get(client *c, uint8_t what)
{
    const crn_wire_get get = {what};
    SEND(c, get, &get);
}

void client_tools(client *c, const crn_wire_tools *tools)
{
    c->tool_count = tools->line_count > 0 ? tools->line_count : tools->tools_count;
    SEND(c, tools, tools);
}

void client_entry_each(client *c, const uint32_t *inserted_um, uint16_t count)
{
    crn_wire_entry entry = {.direction_y_q30 = 1 << 30, .inserted_um_count = count};
    for (uint16_t k = 0; k < count; k++) entry.inserted_um[k] = inserted_um[k];
    SEND(c, entry, &entry);
}

void client_entry(client *c, uint32_t inserted_um)
{
    const uint32_t each[CRN_WIRE_TOOL_MAX] = {inserted_um, inserted_um, inserted_um};
    client_entry_each(c, each, c->tool_count);
}

bool client_entry_along(client *c, int axis, uint32_t inserted_um)
{
    crn_wire_entry entry = {.inserted_um_count = c->tool_count};
    crn_wire_status status;
    int32_t *const directions[] = {&entry.direction_x_q30, &entry.direction_y_q30, &entry.direction_z_q30};
    *directions[axis] = 1 << 30;
    for (uint16_t k = 0; k < c->tool_count; k++) entry.inserted_um[k] = inserted_um;
    SEND(c, entry, &entry);
    return client_expect_status(c, &status);
}

bool client_load_scene(client *c, const uint8_t *bytes, uint32_t count)
{
    static crn_wire_scene_chunk chunk;
    const crn_wire_scene_begin begin = {count, crn_wire_crc32(0, bytes, count)};
    const crn_wire_scene_end end = {count};
    crn_wire_status status;
    SEND(c, scene_begin, &begin);
    if (!client_expect_status(c, &status)) return false;
    for (chunk.offset = 0; chunk.offset < count; chunk.offset += chunk.data_count) {
        uint32_t left = count - chunk.offset;
        chunk.data_count = (uint16_t)(left < sizeof chunk.data ? left : sizeof chunk.data);
        memcpy(chunk.data, bytes + chunk.offset, chunk.data_count);
        SEND(c, scene_chunk, &chunk);
    }
    SEND(c, scene_end, &end);
    return client_expect_status(c, &status);
}

/* The simulated encoder's counter wraps like that of the hardware. */
static int32_t counts_at(int32_t begin, int32_t per_tick, uint16_t i)
{
    return crn_wire_i32_from_u32((uint32_t)begin + (uint32_t)per_tick * i);
}

void client_step_each(client *c, uint32_t tick, uint16_t count, const int32_t *begin, const int32_t *per_tick)
{
    static crn_wire_step step;
    memset(&step, 0, sizeof step);
    step.tick = tick;
    step.inputs_count = count;
    for (uint16_t i = 0; i < count; i++) {
        step.inputs[i].hands_count = c->tool_count;
        for (uint16_t k = 0; k < c->tool_count; k++) {
            step.inputs[i].hands[k].translation_counts = counts_at(begin[k], per_tick[k], i);
        }
    }
    SEND(c, step, &step);
}

void client_step(client *c, uint32_t tick, uint16_t count, int32_t translation_begin,
                 int32_t translation_per_tick)
{
    const int32_t begin[CRN_WIRE_TOOL_MAX] = {translation_begin};
    const int32_t per_tick[CRN_WIRE_TOOL_MAX] = {translation_per_tick};
    client_step_each(c, tick, count, begin, per_tick);
}

void client_input(client *c, const int32_t *translation, const int32_t *rotation)
{
    crn_wire_input input = {.input.hands_count = c->tool_count};
    for (uint16_t k = 0; k < c->tool_count; k++) {
        input.input.hands[k] = (crn_wire_hand){translation[k], rotation[k]};
    }
    SEND(c, input, &input);
}

void client_orders(client *c, const crn_wire_order *orders, uint16_t count)
{
    crn_wire_orders message = {.orders = {.items_count = count}};
    for (uint16_t i = 0; i < count; i++) message.orders.items[i] = orders[i];
    SEND(c, orders, &message);
}

bool client_read_snapshot(client *c)
{
    static crn_wire_snapshot_chunk chunk;
    c->snapshot_bytes = 0;
    client_get(c, CRN_WIRE_GET_SNAPSHOT);
    if (client_receive(c) != CRN_WIRE_TYPE_snapshot_begin) return false;
    while (client_receive(c) == CRN_WIRE_TYPE_snapshot_chunk) {
        if (!crn_wire_decode_snapshot_chunk(c->decoder.payload, c->decoder.payload_bytes, &chunk))
            return false;
        if (chunk.offset + chunk.data_count > sizeof c->snapshot) return false;
        memcpy(c->snapshot + chunk.offset, chunk.data, chunk.data_count);
        c->snapshot_bytes += chunk.data_count;
    }
    return c->decoder.header.type == CRN_WIRE_TYPE_snapshot_end;
}

void client_write_snapshot(client *c)
{
    static crn_wire_snapshot_chunk chunk;
    const crn_wire_snapshot_begin begin = {0, c->snapshot_bytes,
                                           crn_wire_crc32(0, c->snapshot, c->snapshot_bytes)};
    crn_wire_status status;
    SEND(c, snapshot_begin, &begin);
    if (!client_expect_status(c, &status)) return;
    for (chunk.offset = 0; chunk.offset < c->snapshot_bytes; chunk.offset += chunk.data_count) {
        uint32_t left = c->snapshot_bytes - chunk.offset;
        chunk.data_count = (uint16_t)(left < sizeof chunk.data ? left : sizeof chunk.data);
        memcpy(chunk.data, c->snapshot + chunk.offset, chunk.data_count);
        SEND(c, snapshot_chunk, &chunk);
    }
    const crn_wire_snapshot_end end = {c->snapshot_bytes};
    SEND(c, snapshot_end, &end);
}

bool client_expect_status(client *c, crn_wire_status *status)
{
    return client_receive(c) == CRN_WIRE_TYPE_status &&
           crn_wire_decode_status(c->decoder.payload, c->decoder.payload_bytes, status);
}

bool client_expect_reject(client *c, crn_wire_reject *reject)
{
    return client_receive(c) == CRN_WIRE_TYPE_reject &&
           crn_wire_decode_reject(c->decoder.payload, c->decoder.payload_bytes, reject);
}

bool client_expect_ticks(client *c, crn_wire_ticks *ticks)
{
    static crn_wire_live live;
    uint16_t type = client_receive(c);
    while (type == CRN_WIRE_TYPE_hash64) type = client_receive(c);
    if (type == CRN_WIRE_TYPE_ticks)
        return crn_wire_decode_ticks(c->decoder.payload, c->decoder.payload_bytes, ticks);
    if (type != CRN_WIRE_TYPE_live ||
        !crn_wire_decode_live(c->decoder.payload, c->decoder.payload_bytes, &live))
        return false;
    ticks->states_count = live.ticks_count;
    for (uint16_t i = 0; i < live.ticks_count; i++) ticks->states[i] = live.ticks[i].state;
    return true;
}

bool client_expect_live(client *c, crn_wire_live *live)
{
    uint16_t type = client_receive(c);
    while (type == CRN_WIRE_TYPE_hash64) type = client_receive(c);
    return type == CRN_WIRE_TYPE_live &&
           crn_wire_decode_live(c->decoder.payload, c->decoder.payload_bytes, live);
}

void client_plain_tools(crn_wire_tools *tools, uint16_t count)
{
    static const struct {
        uint32_t bend_nN_m2, outer_um, inner_um;
    } kinds[CRN_WIRE_TOOL_MAX] = {{1000000, 445, 0}, {300000, 835, 500}, {2000000, 1100, 900}};
    memset(tools, 0, sizeof *tools);
    tools->tools_count = count;
    for (uint16_t k = 0; k < count; k++) {
        crn_wire_instrument *tool = &tools->tools[k];
        const crn_wire_knot tip = {.bend_stiffness_nN_m2 = kinds[k].bend_nN_m2,
                                   .twist_stiffness_nN_m2 = kinds[k].bend_nN_m2 / 5 * 4,
                                   .mass_mg_per_m = 4000,
                                   .radius_outer_um = kinds[k].outer_um,
                                   .radius_inner_um = kinds[k].inner_um,
                                   .friction_kinetic_milli = 100,
                                   .friction_static_milli = 120};
        tool->lumen_friction_milli = k > 0 ? 100 : 0;
        tool->axial_stiffness_max_N = 5000;
        tool->element_tip_um = 2000;
        tool->element_shaft_um = 4000;
        tool->element_fine_um = 20000;
        tool->knots_count = 2;
        tool->knots[0] = tip;
        tool->knots[1] = tip;
        tool->knots[1].arc_um = 300000;
    }
}

bool client_start_tools(client *c, uint16_t count)
{
    static crn_wire_tools tools;
    crn_wire_status status;
    client_plain_tools(&tools, count);
    client_hello(c, crn_wire_schema_hash());
    if (client_receive(c) != CRN_WIRE_TYPE_hello_reply) return false;
    client_tools(c, &tools);
    if (!client_expect_status(c, &status)) return false;
    client_entry(c, 50000);
    if (!client_expect_status(c, &status)) return false;
    client_command(c, CRN_WIRE_ACTION_ARM);
    if (!client_expect_status(c, &status)) return false;
    client_command(c, CRN_WIRE_ACTION_START);
    return client_expect_status(c, &status) && status.state == CRN_WIRE_STATE_RUNNING;
}

bool client_start_session(client *c)
{
    return client_start_tools(c, 1);
}
