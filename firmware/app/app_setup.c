/* Set-up requests: scene, tools, entry. Only in READY; what is refused leaves the old one in place.
 * Called by: app.c. */
#include "firmware/app/app_internal.h"

/* --- scene --- */

void seld_app_scene_begin(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_scene_begin;
    seld_wire_scene_begin begin;
    SELD_REJECT_IF(app, type, !seld_wire_decode_scene_begin(payload, length, &begin), SELD_REJECT_MALFORMED,
                   length, SELD_WIRE_BYTES_scene_begin);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, begin.scene_bytes > app->port->scene_slot_bytes, SELD_REJECT_SCENE_SIZE,
                   begin.scene_bytes, app->port->scene_slot_bytes);
    seld_upload *upload = &app->scene_upload;
    bool is_same =
        upload->open && upload->expected_bytes == begin.scene_bytes && upload->crc32 == begin.crc32;
    if (begin.scene_bytes == 0) app->has_scene = false;
    if (!is_same) *upload = (seld_upload){begin.scene_bytes, 0, begin.crc32, begin.scene_bytes > 0};
    seld_app_send_status(app, type);
}

/* Good chunks are not answered, so that an upload is not a ping-pong; a bad one is refused and scene_end fails too. */
void seld_app_scene_chunk(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_scene_chunk;
    seld_wire_scene_chunk *chunk = &app->request.scene_chunk;
    seld_upload *upload = &app->scene_upload;
    SELD_REJECT_IF(app, type, !seld_wire_decode_scene_chunk(payload, length, chunk), SELD_REJECT_MALFORMED,
                   length, SELD_WIRE_BYTES_scene_chunk);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type,
                   !upload->open || chunk->offset != upload->received_bytes ||
                       chunk->data_count > upload->expected_bytes - upload->received_bytes,
                   SELD_REJECT_SCENE_ORDER, upload->received_bytes, chunk->offset);
    uint8_t *staged = app->port->scene_slots[1 - app->scene_slot];
    for (uint16_t i = 0; i < chunk->data_count; i++) staged[upload->received_bytes++] = chunk->data[i];
}

/* The staged scene is checked as a whole; only then the slots change roles. */
void seld_app_scene_end(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_scene_end;
    seld_wire_scene_end end;
    SELD_REJECT_IF(app, type, !seld_wire_decode_scene_end(payload, length, &end), SELD_REJECT_MALFORMED,
                   length, SELD_WIRE_BYTES_scene_end);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    seld_upload upload = app->scene_upload;
    app->scene_upload.open = false;
    SELD_REJECT_IF(app, type,
                   !upload.open || upload.received_bytes != upload.expected_bytes ||
                       end.scene_bytes != upload.expected_bytes,
                   SELD_REJECT_SCENE_ORDER, upload.received_bytes, upload.expected_bytes);
    const uint8_t *staged = app->port->scene_slots[1 - app->scene_slot];
    uint32_t crc = seld_wire_crc32(0, staged, upload.received_bytes);
    SELD_REJECT_IF(app, type, crc != upload.crc32, SELD_REJECT_SCENE_CRC, crc, upload.crc32);
    uint32_t status =
        seld_app_lumen_open(staged, upload.received_bytes, &app->lumen, &app->motion, app->lesions);
    SELD_REJECT_IF(app, type, status != 0, SELD_REJECT_SCENE_INVALID, status, 0);
    app->scene_slot = (uint8_t)(1 - app->scene_slot);
    app->has_scene = true;
    app->scene_bytes = upload.expected_bytes;
    app->scene_crc32 = crc;
    seld_app_send_status(app, type);
}

/* --- tools and entry --- */

_Static_assert((int)SELD_WIRE_MAX_instrument_balloon == (int)SELD_BALLOON_POINT_MAX &&
                   (int)SELD_WIRE_MAX_nodes_balloon_radii_um == (int)SELD_BALLOON_BALL_MAX &&
                   (int)SELD_WIRE_MAX_nodes_lesions_open_q15 ==
                       (int)SELD_LESION_MAX * (int)SELD_LESION_STATION_MAX,
               "wire and core agree about balloons and lesions");

static seld_knot knot_from_wire(const seld_wire_knot *wire)
{
    return (seld_knot){
        .arc_um = wire->arc_um,
        .bend_stiffness_nN_m2 = wire->bend_stiffness_nN_m2,
        .twist_stiffness_nN_m2 = wire->twist_stiffness_nN_m2,
        .mass_mg_per_m = wire->mass_mg_per_m,
        .radius_outer_um = wire->radius_outer_um,
        .radius_inner_um = wire->radius_inner_um,
        .friction_kinetic_milli = wire->friction_kinetic_milli,
        .friction_static_milli = wire->friction_static_milli,
        .rest_curvature1_per_m_milli = wire->rest_curvature1_per_m_milli,
        .rest_curvature2_per_m_milli = wire->rest_curvature2_per_m_milli,
    };
}

static void tool_from_wire(const seld_wire_instrument *wire, seld_instrument *tool)
{
    *tool = (seld_instrument){
        .knot_count = wire->knots_count,
        .lumen_friction_milli = wire->lumen_friction_milli,
        .axial_stiffness_max_N = wire->axial_stiffness_max_N,
        .element_tip_um = wire->element_tip_um,
        .element_shaft_um = wire->element_shaft_um,
        .element_fine_um = wire->element_fine_um,
    };
    for (uint16_t i = 0; i < wire->knots_count; i++) tool->knots[i] = knot_from_wire(&wire->knots[i]);
    tool->balloon = (seld_balloon){
        .point_count = wire->balloon_count,
        .distal_um = wire->balloon_distal_um,
        .proximal_um = wire->balloon_proximal_um,
        .burst_kPa = wire->balloon_burst_kPa,
    };
    for (uint16_t i = 0; i < wire->balloon_count; i++) {
        tool->balloon.pressure_kPa[i] = wire->balloon[i].pressure_kPa;
        tool->balloon.diameter_um[i] = wire->balloon[i].diameter_um;
    }
}

/* Why the core takes no model of it, with the tool and knot at fault. */
void seld_app_reject_build(seld_app *app, uint16_t type, seld_build_status status,
                           const seld_build_place *place)
{
    static const uint16_t codes[] = {
        [SELD_BUILD_KNOTS] = SELD_REJECT_TOOL_KNOTS,     [SELD_BUILD_RANGE] = SELD_REJECT_TOOL_RANGE,
        [SELD_BUILD_LENGTH] = SELD_REJECT_TOOL_LENGTH,   [SELD_BUILD_ELEMENTS] = SELD_REJECT_TOOL_ELEMENTS,
        [SELD_BUILD_ENTRY] = SELD_REJECT_ENTRY_INVALID,  [SELD_BUILD_OVERFLOW] = SELD_REJECT_TOOL_OVERFLOW,
        [SELD_BUILD_NESTING] = SELD_REJECT_TOOL_NESTING, [SELD_BUILD_BALLOON] = SELD_REJECT_TOOL_BALLOON,
    };
    bool is_listed = status < sizeof codes / sizeof codes[0] && codes[status] != 0;
    SELD_REQUIRE(app, is_listed, status);
    seld_app_reject(app, type, is_listed ? codes[status] : SELD_REJECT_TOOL_RANGE, place->tool, place->knot);
}

static const seld_entry neutral_entry = {{{0, 0, 0}}, {{0, SELD_ONE_Q30, 0}}};

/* In READY the model's memory is free: building it in open space is the check of the whole table. */
void seld_app_tools(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_tools;
    seld_wire_tools *wire = &app->request.tools;
    SELD_REJECT_IF(app, type, !seld_wire_decode_tools(payload, length, wire), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_tools);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, wire->tools_count == 0, SELD_REJECT_TOOL_COUNT, 0, SELD_TOOL_MAX);
    seld_instrument *candidates = app->reply.tools;
    for (uint16_t k = 0; k < wire->tools_count; k++) tool_from_wire(&wire->tools[k], &candidates[k]);
    seld_build_place place = {0, 0};
    seld_build_status status =
        seld_model_build(&app->model, candidates, wire->tools_count, NULL, &neutral_entry, &place);
    if (status != SELD_BUILD_OK) {
        seld_app_reject_build(app, type, status, &place);
        return;
    }
    for (uint16_t k = 0; k < wire->tools_count; k++) app->tools[k] = candidates[k];
    app->tool_count = wire->tools_count;
    app->tools_crc32 = seld_wire_crc32(0, payload, length);
    if (app->inserted_count != app->tool_count) app->has_entry = false; /* its lengths were for other tools */
    seld_app_send_status(app, type);
}

void seld_app_entry(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_entry;
    seld_wire_entry wire;
    SELD_REJECT_IF(app, type, !seld_wire_decode_entry(payload, length, &wire), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_entry);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, app->tool_count == 0, SELD_REJECT_SET_UP_MISSING, 0, 0);
    SELD_REJECT_IF(app, type, wire.inserted_um_count != app->tool_count, SELD_REJECT_TOOL_COUNT,
                   wire.inserted_um_count, app->tool_count);
    const seld_entry candidate = {
        seld_vec3_make(wire.position_x_m_q30, wire.position_y_m_q30, wire.position_z_m_q30),
        seld_vec3_make(wire.direction_x_q30, wire.direction_y_q30, wire.direction_z_q30),
    };
    seld_build_place place = {0, 0};
    seld_build_status status =
        seld_model_build(&app->model, app->tools, app->tool_count, NULL, &candidate, &place);
    if (status != SELD_BUILD_OK) {
        seld_app_reject_build(app, type, status, &place);
        return;
    }
    app->entry = candidate;
    for (uint16_t k = 0; k < wire.inserted_um_count; k++) app->inserted_um[k] = wire.inserted_um[k];
    app->inserted_count = wire.inserted_um_count;
    app->has_entry = true;
    app->entry_crc32 = seld_wire_crc32(0, payload, length);
    seld_app_send_status(app, type);
}
