/* This file handles the set-up requests for scene, tools and entry (the place where the tools enter). The app
 * accepts the requests for scene, tools and entry only in the state READY; a refused request leaves the old
 * data unchanged. */
#include "firmware/app/app_internal.h"

/* --- scene --- */

/* The largest scene that the port's memory holds. */
uint32_t crn_app_scene_bytes_max(const crn_port *port)
{
    return port->scene_large_bytes > port->scene_slot_bytes ? port->scene_large_bytes
                                                            : port->scene_slot_bytes;
}

/* A scene that is larger than a slot takes both, from the first one on. */
static bool takes_both(const crn_app *app, uint32_t scene_bytes)
{
    return scene_bytes > app->port->scene_slot_bytes;
}

static uint8_t slot_for(const crn_app *app, uint32_t scene_bytes)
{
    const bool is_first = takes_both(app, scene_bytes) || takes_both(app, app->setup.scene_bytes);
    return is_first ? 0 : (uint8_t)(1 - app->setup.scene_slot);
}

void crn_app_scene_begin(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_scene_begin;
    crn_wire_scene_begin begin;
    CRN_REJECT_IF(app, type, !crn_wire_decode_scene_begin(payload, length, &begin), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_scene_begin);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    const uint32_t bytes_max = crn_app_scene_bytes_max(app->port);
    CRN_REJECT_IF(app, type, begin.scene_bytes > bytes_max, CRN_REJECT_SCENE_SIZE, begin.scene_bytes,
                  bytes_max);
    crn_upload *upload = &app->setup.scene_upload;
    bool is_same =
        upload->open && upload->expected_bytes == begin.scene_bytes && upload->crc32 == begin.crc32;
    /* If either scene takes both slots, the old one goes first. */
    if (begin.scene_bytes == 0 || takes_both(app, begin.scene_bytes) ||
        takes_both(app, app->setup.scene_bytes)) {
        app->setup.has_scene = false;
    }
    if (!is_same) *upload = (crn_upload){begin.scene_bytes, 0, begin.crc32, begin.scene_bytes > 0};
    crn_app_send_status(app, type);
}

/* The app does not reply to a valid chunk of an upload, so that the host can send the next chunk without
 * waiting. The app refuses an invalid chunk of an upload, and then also refuses the message scene_end that
 * follows. */
void crn_app_scene_chunk(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_scene_chunk;
    crn_wire_scene_chunk *chunk = &app->buffers.request.scene_chunk;
    crn_upload *upload = &app->setup.scene_upload;
    CRN_REJECT_IF(app, type, !crn_wire_decode_scene_chunk(payload, length, chunk), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_scene_chunk);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type,
                  !upload->open || chunk->offset != upload->received_bytes ||
                      chunk->data_count > upload->expected_bytes - upload->received_bytes,
                  CRN_REJECT_SCENE_ORDER, upload->received_bytes, chunk->offset);
    uint8_t *staged = app->port->scene_slots[slot_for(app, upload->expected_bytes)];
    for (uint16_t i = 0; i < chunk->data_count; i++) staged[upload->received_bytes++] = chunk->data[i];
}

/* Without near memory, the core reads the scene in place. */
static uint32_t near_bytes_needed(const crn_app *app, const crn_opened_scene *scene)
{
    return app->port->near_bytes == 0 ? 0 : crn_lumen_near_bytes(&scene->lumen);
}

static void take_scene(crn_app *app, const crn_opened_scene *scene, uint32_t scene_bytes, uint32_t crc32)
{
    crn_app_setup *setup = &app->setup;
    setup->motion = scene->motion;
    for (uint32_t i = 0; i < scene->lumen.lesion_count; i++) setup->lesions[i] = scene->lesions[i];
    setup->lumen = scene->lumen;
    setup->lumen.lesions = setup->lesions;
    if (scene->lumen.motion != NULL) setup->lumen.motion = &setup->motion;
    setup->walls = scene->walls;
    if (scene->lumen.walls != NULL) setup->lumen.walls = &setup->walls;
    if (app->port->near_bytes != 0) {
        crn_lumen_near_begin(&setup->lumen, &setup->motion, setup->lesions, app->port->near_memory,
                             app->port->near_bytes);
    }
    setup->has_scene = true;
    setup->scene_bytes = scene_bytes;
    setup->scene_crc32 = crc32;
}

/* The app checks the uploaded scene as a whole before the scene replaces the present one. */
void crn_app_scene_end(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_scene_end;
    crn_wire_scene_end end;
    CRN_REJECT_IF(app, type, !crn_wire_decode_scene_end(payload, length, &end), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_scene_end);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    crn_upload upload = app->setup.scene_upload;
    app->setup.scene_upload.open = false;
    CRN_REJECT_IF(app, type,
                  !upload.open || upload.received_bytes != upload.expected_bytes ||
                      end.scene_bytes != upload.expected_bytes,
                  CRN_REJECT_SCENE_ORDER, upload.received_bytes, upload.expected_bytes);
    const uint8_t slot = slot_for(app, upload.expected_bytes);
    const uint8_t *staged = app->port->scene_slots[slot];
    uint32_t crc = crn_wire_crc32(0, staged, upload.received_bytes);
    CRN_REJECT_IF(app, type, crc != upload.crc32, CRN_REJECT_SCENE_CRC, crc, upload.crc32);
    crn_opened_scene scene;
    uint32_t status = crn_app_lumen_open(staged, upload.received_bytes, &scene);
    CRN_REJECT_IF(app, type, status != 0, CRN_REJECT_SCENE_INVALID, status, 0);
    const uint32_t near_bytes = near_bytes_needed(app, &scene);
    CRN_REJECT_IF(app, type, near_bytes > app->port->near_bytes, CRN_REJECT_SCENE_NEAR, near_bytes,
                  app->port->near_bytes);
    app->setup.scene_slot = slot;
    take_scene(app, &scene, upload.expected_bytes, crc);
    crn_app_send_status(app, type);
}

bool crn_app_scene_share(crn_app *app, const uint8_t *bytes, uint32_t byte_count, uint32_t crc32)
{
    if (app->state != CRN_WIRE_STATE_READY || byte_count == 0) return false;
    app->setup.scene_upload.open = false;
    crn_opened_scene scene;
    if (crn_app_lumen_open(bytes, byte_count, &scene) != 0 ||
        near_bytes_needed(app, &scene) > app->port->near_bytes) {
        app->setup.has_scene = false;
        return false;
    }
    take_scene(app, &scene, byte_count, crc32);
    return true;
}

/* --- tools and entry --- */

_Static_assert((int)CRN_WIRE_MAX_instrument_balloon == (int)CRN_BALLOON_POINT_MAX &&
                   (int)CRN_WIRE_MAX_nodes_balloon_radii_um == (int)CRN_BALLOON_BALL_MAX &&
                   (int)CRN_WIRE_MAX_nodes_lesions_open_q15 ==
                       (int)CRN_LESION_MAX * (int)CRN_LESION_STATION_MAX,
               "wire and core agree about balloons and lesions");

static crn_knot knot_from_wire(const crn_wire_knot *wire)
{
    return (crn_knot){
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

static void tool_from_wire(const crn_wire_instrument *wire, crn_instrument *tool)
{
    *tool = (crn_instrument){
        .knot_count = wire->knots_count,
        .lumen_friction_milli = wire->lumen_friction_milli,
        .axial_stiffness_max_N = wire->axial_stiffness_max_N,
        .element_tip_um = wire->element_tip_um,
        .element_shaft_um = wire->element_shaft_um,
        .element_fine_um = wire->element_fine_um,
        .whole_um = wire->whole_um,
        .rail_um = wire->rail_um,
        .material = {.kind = wire->material_kind,
                     .yield_strain_micro = wire->yield_strain_micro,
                     .core_modulus_MPa = wire->core_modulus_MPa,
                     .hardening_milli = wire->hardening_milli,
                     .unload_milli = wire->unload_milli,
                     .limit_milli = wire->limit_milli},
    };
    for (uint16_t i = 0; i < wire->knots_count; i++) tool->knots[i] = knot_from_wire(&wire->knots[i]);
    tool->balloon = (crn_balloon){
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

/* Refuses a set-up request because the core could not build a model; the reply names the core's reason, the
 * tool, and the knot (entry of the tool's table of properties). */
void crn_app_reject_build(crn_app *app, uint16_t type, crn_build_status status, const crn_build_place *place)
{
    static const uint16_t codes[] = {
        [CRN_BUILD_KNOTS] = CRN_REJECT_TOOL_KNOTS,     [CRN_BUILD_RANGE] = CRN_REJECT_TOOL_RANGE,
        [CRN_BUILD_LENGTH] = CRN_REJECT_TOOL_LENGTH,   [CRN_BUILD_ELEMENTS] = CRN_REJECT_TOOL_ELEMENTS,
        [CRN_BUILD_ENTRY] = CRN_REJECT_ENTRY_INVALID,  [CRN_BUILD_OVERFLOW] = CRN_REJECT_TOOL_OVERFLOW,
        [CRN_BUILD_NESTING] = CRN_REJECT_TOOL_NESTING, [CRN_BUILD_BALLOON] = CRN_REJECT_TOOL_BALLOON,
        [CRN_BUILD_TOOLS] = CRN_REJECT_TOOL_LINE,
    };
    bool is_listed = status < sizeof codes / sizeof codes[0] && codes[status] != 0;
    CRN_REQUIRE(app, is_listed, status);
    crn_app_reject(app, type, is_listed ? codes[status] : CRN_REJECT_TOOL_RANGE, place->tool, place->knot);
}

static const crn_entry neutral_entry = {{{0, 0, 0}}, {{0, CRN_ONE_Q30, 0}}, CRN_BLOOD_kg_m3};

/* If a message does not say which tools are nested at the start, all tools of the table are nested, in the
 * table's order. Returns the number of places for nested tools, or 0 if this number would exceed
 * CRN_TOOL_MAX. */
static uint32_t line_from_wire(const crn_wire_tools *wire, uint32_t line[CRN_TOOL_MAX])
{
    const uint16_t count = wire->line_count > 0 ? wire->line_count : wire->tools_count;
    if (count > CRN_TOOL_MAX) return 0;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const uint32_t number = wire->line_count > 0 ? wire->line[k] : k + 1;
        line[k] = k < count ? number : 0;
    }
    return count;
}

/* In the state READY no model is in use, so the model's memory is free. To check the table of tools and the
 * line (the tools that are nested at the start) as a whole, the app builds a model that has these tools but
 * no vessel. */
void crn_app_tools(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_tools;
    crn_wire_tools *wire = &app->buffers.request.tools;
    uint32_t line[CRN_TOOL_MAX];
    CRN_REJECT_IF(app, type, !crn_wire_decode_tools(payload, length, wire), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_tools);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    const uint32_t line_count = line_from_wire(wire, line);
    CRN_REJECT_IF(app, type, wire->tools_count == 0 || line_count == 0, CRN_REJECT_TOOL_COUNT,
                  wire->tools_count, CRN_TOOL_MAX);
    crn_instrument *candidates = app->buffers.reply.tools;
    for (uint16_t k = 0; k < wire->tools_count; k++) tool_from_wire(&wire->tools[k], &candidates[k]);
    crn_build_place place = {0, 0};
    crn_build_status status = crn_model_build_table(&app->model, candidates, wire->tools_count, line,
                                                    line_count, NULL, &neutral_entry, &place);
    if (status == CRN_BUILD_TOOLS) place = (crn_build_place){wire->tools_count, line_count};
    if (status != CRN_BUILD_OK) {
        crn_app_reject_build(app, type, status, &place);
        return;
    }
    for (uint16_t k = 0; k < wire->tools_count; k++) app->port->tool_table[k] = candidates[k];
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) app->setup.line[k] = line[k];
    app->setup.table_count = wire->tools_count;
    app->setup.tool_count = line_count;
    app->setup.tools_crc32 = crn_wire_crc32(0, payload, length);
    if (app->setup.inserted_count != app->setup.tool_count)
        app->setup.has_entry = false; /* its lengths were for other tools */
    crn_app_send_status(app, type);
}

crn_build_status crn_app_build(crn_app *app, const crn_lumen *lumen, const crn_entry *entry,
                               crn_build_place *place)
{
    const crn_app_setup *setup = &app->setup;
    return crn_model_build_table(&app->model, app->port->tool_table, setup->table_count, setup->line,
                                 setup->tool_count, lumen, entry, place);
}

void crn_app_entry(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_entry;
    crn_wire_entry wire;
    CRN_REJECT_IF(app, type, !crn_wire_decode_entry(payload, length, &wire), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_entry);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type, app->setup.tool_count == 0, CRN_REJECT_SET_UP_MISSING, 0, 0);
    CRN_REJECT_IF(app, type, wire.inserted_um_count != app->setup.tool_count, CRN_REJECT_TOOL_COUNT,
                  wire.inserted_um_count, app->setup.tool_count);
    const crn_entry candidate = {
        crn_vec3_make(wire.position_x_m_q30, wire.position_y_m_q30, wire.position_z_m_q30),
        crn_vec3_make(wire.direction_x_q30, wire.direction_y_q30, wire.direction_z_q30),
        CRN_BLOOD_kg_m3,
    };
    crn_build_place place = {0, 0};
    crn_build_status status = crn_app_build(app, NULL, &candidate, &place);
    if (status != CRN_BUILD_OK) {
        crn_app_reject_build(app, type, status, &place);
        return;
    }
    app->setup.entry = candidate;
    for (uint16_t k = 0; k < wire.inserted_um_count; k++) app->setup.inserted_um[k] = wire.inserted_um[k];
    app->setup.inserted_count = wire.inserted_um_count;
    app->setup.has_entry = true;
    app->setup.entry_crc32 = crn_wire_crc32(0, payload, length);
    crn_app_send_status(app, type);
}
