/* Set-up requests: scene, instrument, entry, rig. Only in READY; what is refused leaves the old one in place.
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
    if (begin.scene_bytes == 0) app->has_scene = false;
    app->scene_upload = (seld_upload){begin.scene_bytes, 0, begin.crc32, begin.scene_bytes > 0};
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
    seld_lumen lumen;
    uint32_t status = seld_app_lumen_open(staged, upload.received_bytes, &lumen);
    SELD_REJECT_IF(app, type, status != 0, SELD_REJECT_SCENE_INVALID, status, 0);
    app->lumen = lumen;
    app->scene_slot = (uint8_t)(1 - app->scene_slot);
    app->has_scene = true;
    seld_app_send_status(app, type);
}

/* --- instrument and entry --- */

static seld_knot knot_from_wire(const seld_wire_knot *wire)
{
    return (seld_knot){
        .arc_um = wire->arc_um,
        .bend_stiffness_nN_m2 = wire->bend_stiffness_nN_m2,
        .twist_stiffness_nN_m2 = wire->twist_stiffness_nN_m2,
        .mass_mg_per_m = wire->mass_mg_per_m,
        .radius_outer_um = wire->radius_outer_um,
        .friction_kinetic_milli = wire->friction_kinetic_milli,
        .friction_static_milli = wire->friction_static_milli,
        .rest_curvature1_per_m_milli = wire->rest_curvature1_per_m_milli,
        .rest_curvature2_per_m_milli = wire->rest_curvature2_per_m_milli,
    };
}

/* In READY the model's memory is free: building it in open space is the check of the whole table. */
static seld_build_status try_build(seld_app *app, const seld_instrument *instrument, const seld_entry *entry,
                                   uint32_t *field)
{
    seld_build_place place = {0, 0};
    seld_build_status status = seld_model_build(&app->model, instrument, 1, NULL, entry, &place);
    *field = place.knot;
    return status;
}

static const seld_entry neutral_entry = {{{0, 0, 0}}, {{0, SELD_ONE_Q30, 0}}};

void seld_app_instrument(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_instrument;
    seld_wire_instrument *wire = &app->request.instrument;
    SELD_REJECT_IF(app, type, !seld_wire_decode_instrument(payload, length, wire), SELD_REJECT_MALFORMED,
                   length, SELD_WIRE_BYTES_instrument);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    seld_instrument candidate = {
        .knot_count = wire->knots_count,
        .axial_stiffness_max_N = wire->axial_stiffness_max_N,
        .element_tip_um = wire->element_tip_um,
        .element_shaft_um = wire->element_shaft_um,
        .element_fine_um = wire->element_fine_um,
    };
    for (uint16_t i = 0; i < wire->knots_count; i++) candidate.knots[i] = knot_from_wire(&wire->knots[i]);
    uint32_t field = 0;
    seld_build_status status = try_build(app, &candidate, &neutral_entry, &field);
    SELD_REJECT_IF(app, type, status != SELD_BUILD_OK, SELD_REJECT_INSTRUMENT_INVALID, status, field);
    app->instrument = candidate;
    app->has_instrument = true;
    seld_app_send_status(app, type);
}

void seld_app_entry(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_entry;
    seld_wire_entry wire;
    SELD_REJECT_IF(app, type, !seld_wire_decode_entry(payload, length, &wire), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_entry);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, !app->has_instrument, SELD_REJECT_INSTRUMENT_MISSING, 0, 0);
    const seld_entry candidate = {
        seld_vec3_make(wire.position_x_m_q30, wire.position_y_m_q30, wire.position_z_m_q30),
        seld_vec3_make(wire.direction_x_q30, wire.direction_y_q30, wire.direction_z_q30),
    };
    uint32_t field = 0;
    seld_build_status status = try_build(app, &app->instrument, &candidate, &field);
    SELD_REJECT_IF(app, type, status != SELD_BUILD_OK, SELD_REJECT_ENTRY_INVALID, status, field);
    app->entry = candidate;
    app->inserted_um = wire.inserted_um;
    app->has_entry = true;
    seld_app_send_status(app, type);
}

/* --- rig --- */

void seld_app_rig(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_rig;
    seld_wire_rig wire;
    SELD_REJECT_IF(app, type, !seld_wire_decode_rig(payload, length, &wire), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_rig);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    const uint32_t values[] = {wire.translation_pm_per_count, wire.rotation_counts_per_turn,
                               wire.force_gain_milli, wire.force_limit_mN, wire.torque_limit_uN_m};
    uint32_t field = 0;
    bool ok = seld_rig_set(&app->rig, &wire, &field);
    SELD_REJECT_IF(app, type, !ok, SELD_REJECT_RIG_RANGE, field, values[field < 5 ? field : 0]);
    seld_app_send_status(app, type);
}
