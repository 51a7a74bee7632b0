/* A snapshot contains, as bytes, all data on which the next tick depends. A snapshot consists of a header,
 * which the app writes, and the core's saved state.
 *
 *   version u32 | tick u32 | tool count u32                                                     = 12 bytes
 *   per tool, always three: hand known u32 | last translation, rotation i32 |
 *       summed translation, rotation i64 | motor axial mN, torque uN m i32                       = 36 bytes
 *       coupling along, then about: set u32 | reference, lead, force i32 | stiffness shown i64    = 24 bytes each
 *       energy: set u32 | taken pJ i64 | hand Q30 m i32, turn u32 | scale u32                     = 24 bytes
 *       release: left ticks u32 | axial mN, torque uN m i32                                       = 12 bytes
 */
#include "firmware/app/app_internal.h"

enum { SNAPSHOT_VERSION = 5 };

/* While a snapshot is sent or received, its bytes lie in the core's scratch memory, which holds nothing that
 * a later tick needs. If a tick runs while a snapshot is received, the snapshot's CRC no longer matches. */
_Static_assert((int)CRN_APP_SNAPSHOT_BYTES <= (int)sizeof(((crn_scratch *)0)->spare), "a snapshot fits");

/* --- to bytes --- */
static void save_tool(crn_wire_writer *writer, const crn_hand_counts *hand, const crn_port_motor *motor)
{
    crn_wire_write(writer, hand->is_known, 4);
    crn_wire_write(writer, (uint32_t)hand->last.translation_counts, 4);
    crn_wire_write(writer, (uint32_t)hand->last.rotation_counts, 4);
    crn_wire_write(writer, (uint64_t)hand->translation_counts, 8);
    crn_wire_write(writer, (uint64_t)hand->rotation_counts, 8);
    crn_wire_write(writer, (uint32_t)motor->axial_mN, 4);
    crn_wire_write(writer, (uint32_t)motor->torque_uN_m, 4);
}

static void save_coupling(crn_wire_writer *writer, const crn_haptics_spring springs[2],
                          const crn_haptics_energy *energy, const crn_haptics_release *release)
{
    for (int i = 0; i < 2; i++) {
        crn_wire_write(writer, springs[i].is_set, 4);
        crn_wire_write(writer, (uint32_t)springs[i].reference, 4);
        crn_wire_write(writer, (uint32_t)springs[i].lead, 4);
        crn_wire_write(writer, (uint32_t)springs[i].force, 4);
        crn_wire_write(writer, (uint64_t)springs[i].estimate, 8);
    }
    crn_wire_write(writer, energy->is_set, 4);
    crn_wire_write(writer, (uint64_t)energy->taken_pJ, 8);
    crn_wire_write(writer, (uint32_t)energy->hand_m_q30, 4);
    crn_wire_write(writer, energy->hand_turn32, 4);
    crn_wire_write(writer, energy->scale_q16, 4);
    crn_wire_write(writer, release->left_ticks, 4);
    for (int i = 0; i < 2; i++) crn_wire_write(writer, (uint32_t)release->from[i], 4);
}

static void save(crn_app *app, uint8_t *bytes)
{
    crn_wire_writer writer = crn_wire_writer_make(bytes, CRN_APP_SNAPSHOT_HEAD_BYTES);
    crn_wire_write(&writer, SNAPSHOT_VERSION, 4);
    crn_wire_write(&writer, crn_state_tick(&app->core), 4);
    crn_wire_write(&writer, app->setup.tool_count, 4);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        save_tool(&writer, &app->hands.counts[k], &app->haptics.motors[k]);
        save_coupling(&writer, app->haptics.springs[k], &app->haptics.energies[k], &app->haptics.releases[k]);
    }
    CRN_REQUIRE(app, !writer.overflowed && writer.length == CRN_APP_SNAPSHOT_HEAD_BYTES, writer.length);
    CRN_REQUIRE(app, crn_state_bytes() == sizeof(crn_state_words), crn_state_bytes());
    crn_state_save(&app->core, bytes + CRN_APP_SNAPSHOT_HEAD_BYTES);
}

static void send_chunk(crn_app *app, uint32_t offset)
{
    crn_wire_snapshot_chunk *chunk = &app->buffers.reply.snapshot_chunk;
    uint32_t left = CRN_APP_SNAPSHOT_BYTES - offset;
    uint32_t count = left < CRN_WIRE_MAX_snapshot_chunk_data ? left : CRN_WIRE_MAX_snapshot_chunk_data;
    chunk->offset = offset;
    chunk->data_count = (uint16_t)count;
    for (uint32_t i = 0; i < count; i++) chunk->data[i] = app->core.scratch.spare[offset + i];
    crn_wire_writer writer = crn_wire_writer_make(app->buffers.payload, sizeof app->buffers.payload);
    crn_wire_put_snapshot_chunk(&writer, chunk);
    crn_app_send(app, CRN_WIRE_TYPE_snapshot_chunk, writer.length);
}

void crn_app_snapshot_send(crn_app *app)
{
    app->session.snapshot_upload.open = false; /* an upload in progress uses the same buffer */
    save(app, app->core.scratch.spare);
    const crn_wire_snapshot_begin begin = {
        crn_state_tick(&app->core), CRN_APP_SNAPSHOT_BYTES,
        crn_wire_crc32(0, app->core.scratch.spare, CRN_APP_SNAPSHOT_BYTES)};
    crn_wire_writer writer = crn_wire_writer_make(app->buffers.payload, sizeof app->buffers.payload);
    crn_wire_put_snapshot_begin(&writer, &begin);
    crn_app_send(app, CRN_WIRE_TYPE_snapshot_begin, writer.length);
    for (uint32_t offset = 0; offset < CRN_APP_SNAPSHOT_BYTES; offset += CRN_WIRE_MAX_snapshot_chunk_data) {
        send_chunk(app, offset);
    }
    const crn_wire_snapshot_end end = {CRN_APP_SNAPSHOT_BYTES};
    writer = crn_wire_writer_make(app->buffers.payload, sizeof app->buffers.payload);
    crn_wire_put_snapshot_end(&writer, &end);
    crn_app_send(app, CRN_WIRE_TYPE_snapshot_end, writer.length);
}

/* --- from bytes: hostile until checked --- */
static bool may_restore(const crn_app *app)
{
    return app->mode == CRN_WIRE_MODE_LOCKSTEP && app->state == CRN_WIRE_STATE_ARMED;
}

void crn_app_snapshot_begin(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_snapshot_begin;
    crn_wire_snapshot_begin begin;
    CRN_REJECT_IF(app, type, !crn_wire_decode_snapshot_begin(payload, length, &begin), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_snapshot_begin);
    CRN_REJECT_IF(app, type, !may_restore(app), CRN_REJECT_WRONG_STATE, app->state, app->mode);
    CRN_REJECT_IF(app, type, begin.snapshot_bytes != CRN_APP_SNAPSHOT_BYTES, CRN_REJECT_SNAPSHOT_INVALID,
                  begin.snapshot_bytes, CRN_APP_SNAPSHOT_BYTES);
    app->session.snapshot_upload = (crn_upload){begin.snapshot_bytes, 0, begin.crc32, true};
    crn_app_send_status(app, type);
}

void crn_app_snapshot_chunk(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_snapshot_chunk;
    crn_wire_snapshot_chunk *chunk = &app->buffers.request.snapshot_chunk;
    crn_upload *upload = &app->session.snapshot_upload;
    CRN_REJECT_IF(app, type, !crn_wire_decode_snapshot_chunk(payload, length, chunk), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_snapshot_chunk);
    CRN_REJECT_IF(app, type,
                  !upload->open || chunk->offset != upload->received_bytes ||
                      chunk->data_count > upload->expected_bytes - upload->received_bytes,
                  CRN_REJECT_SNAPSHOT_ORDER, upload->received_bytes, chunk->offset);
    for (uint16_t i = 0; i < chunk->data_count; i++)
        app->core.scratch.spare[upload->received_bytes++] = chunk->data[i];
}

/* Returns the signed value of a 64-bit number in two's complement, without a cast whose result the C standard
 * leaves to the compiler. */
static int64_t i64_from_u64(uint64_t value)
{
    return value <= (uint64_t)INT64_MAX ? (int64_t)value : -(int64_t)(UINT64_MAX - value) - 1;
}

static int32_t read_i32(crn_wire_reader *reader)
{
    return crn_wire_i32_from_u32((uint32_t)crn_wire_read(reader, 4));
}

/* The head of a snapshot. */
typedef struct snapshot_head {
    uint32_t tick;
    crn_hand_counts hands[CRN_TOOL_MAX];
    crn_port_motor motors[CRN_TOOL_MAX];
    crn_haptics_spring springs[CRN_TOOL_MAX][2];
    crn_haptics_energy energies[CRN_TOOL_MAX];
    crn_haptics_release releases[CRN_TOOL_MAX];
} snapshot_head;

static bool is_within(int64_t value, int64_t limit)
{
    return value >= -limit && value <= limit;
}

/* The restored sums of encoder counts are bounded, so that no later sum of plausible readings can overflow.
 */
static bool read_tool(crn_wire_reader *reader, const crn_haptics_track *track, crn_hand_counts *hand,
                      crn_port_motor *motor)
{
    const int64_t sum_max = (int64_t)1 << 60;
    uint32_t is_known = (uint32_t)crn_wire_read(reader, 4);
    hand->is_known = is_known == 1;
    hand->last.translation_counts = read_i32(reader);
    hand->last.rotation_counts = read_i32(reader);
    hand->translation_counts = i64_from_u64(crn_wire_read(reader, 8));
    hand->rotation_counts = i64_from_u64(crn_wire_read(reader, 8));
    motor->axial_mN = read_i32(reader);
    motor->torque_uN_m = read_i32(reader);
    return is_known <= 1 && is_within(hand->translation_counts, sum_max) &&
           is_within(hand->rotation_counts, sum_max) && is_within(motor->axial_mN, track->force_limit_mN) &&
           is_within(motor->torque_uN_m, track->torque_limit_uN_m);
}

/* The app refuses a snapshot in which a hand is farther ahead of its tool than the coupling allows, or in
 * which the estimate of the tool's stiffness exceeds its largest value. Because the app limits the stiffness
 * and the hand's distance ahead of the tool in a snapshot, no product of a later tick can overflow. */
static bool read_spring(crn_wire_reader *reader, const crn_haptics_axis *axis, crn_haptics_spring *spring)
{
    uint32_t is_set = (uint32_t)crn_wire_read(reader, 4);
    *spring = (crn_haptics_spring){.is_set = is_set == 1};
    spring->reference = read_i32(reader);
    spring->lead = read_i32(reader);
    spring->force = read_i32(reader);
    spring->estimate = i64_from_u64(crn_wire_read(reader, 8));
    return is_set <= 1 && is_within(spring->lead, 2 * axis->lead_max) && spring->estimate >= 0 &&
           spring->estimate <= axis->estimate_max;
}

static bool read_energy(crn_wire_reader *reader, crn_haptics_energy *energy)
{
    uint32_t is_set = (uint32_t)crn_wire_read(reader, 4);
    energy->is_set = is_set == 1;
    energy->taken_pJ = i64_from_u64(crn_wire_read(reader, 8));
    energy->hand_m_q30 = read_i32(reader);
    energy->hand_turn32 = (uint32_t)crn_wire_read(reader, 4);
    energy->scale_q16 = (uint32_t)crn_wire_read(reader, 4);
    return is_set <= 1 && is_within(energy->taken_pJ, (int64_t)1 << 40) && energy->scale_q16 <= 1 << 16;
}

static bool read_release(crn_wire_reader *reader, const crn_haptics_track *track,
                         crn_haptics_release *release)
{
    release->left_ticks = (uint32_t)crn_wire_read(reader, 4);
    for (int i = 0; i < 2; i++) release->from[i] = read_i32(reader);
    return release->left_ticks <= CRN_HAPTICS_RELEASE_ticks &&
           is_within(release->from[0], track->force_limit_mN) &&
           is_within(release->from[1], track->torque_limit_uN_m);
}

static bool read_head(const crn_app *app, const uint8_t *bytes, snapshot_head *head)
{
    crn_wire_reader reader = crn_wire_reader_make(bytes, CRN_APP_SNAPSHOT_HEAD_BYTES);
    bool ok = crn_wire_read(&reader, 4) == SNAPSHOT_VERSION;
    head->tick = (uint32_t)crn_wire_read(&reader, 4);
    ok = ok && crn_wire_read(&reader, 4) == app->setup.tool_count;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_haptics_track *track = &app->haptics.tracks[k];
        ok = read_tool(&reader, track, &head->hands[k], &head->motors[k]) && ok;
        for (int i = 0; i < 2; i++) ok = read_spring(&reader, &track->axes[i], &head->springs[k][i]) && ok;
        ok = read_energy(&reader, &head->energies[k]) && ok;
        ok = read_release(&reader, track, &head->releases[k]) && ok;
    }
    return ok;
}

/* Restores a snapshot. Returns false, and changes nothing, if the bytes are not a valid snapshot of this
 * session. */
static bool restore(crn_app *app, const uint8_t *bytes)
{
    snapshot_head head;
    const uint8_t *words = bytes + CRN_APP_SNAPSHOT_HEAD_BYTES;
    crn_wire_reader core_tick = crn_wire_reader_make(words, 4); /* the state's first word */
    if (!read_head(app, bytes, &head) || crn_wire_read(&core_tick, 4) != head.tick ||
        !crn_state_restore(&app->model, &app->core, words))
        return false;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        app->hands.counts[k] = head.hands[k];
        app->haptics.motors[k] = head.motors[k];
        app->haptics.springs[k][0] = head.springs[k][0];
        app->haptics.springs[k][1] = head.springs[k][1];
        app->haptics.energies[k] = head.energies[k];
        app->haptics.releases[k] = head.releases[k];
    }
    app->faults.core_bits_seen = app->core.words.fault_bits;
    return true;
}

void crn_app_snapshot_end(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_snapshot_end;
    crn_wire_snapshot_end end;
    CRN_REJECT_IF(app, type, !crn_wire_decode_snapshot_end(payload, length, &end), CRN_REJECT_MALFORMED,
                  length, CRN_WIRE_BYTES_snapshot_end);
    CRN_REJECT_IF(app, type, !may_restore(app), CRN_REJECT_WRONG_STATE, app->state, app->mode);
    crn_upload upload = app->session.snapshot_upload;
    app->session.snapshot_upload.open = false;
    CRN_REJECT_IF(app, type, !upload.open || upload.received_bytes != upload.expected_bytes,
                  CRN_REJECT_SNAPSHOT_ORDER, upload.received_bytes, upload.expected_bytes);
    CRN_REJECT_IF(app, type,
                  crn_wire_crc32(0, app->core.scratch.spare, CRN_APP_SNAPSHOT_BYTES) != upload.crc32,
                  CRN_REJECT_SNAPSHOT_INVALID, upload.received_bytes, upload.expected_bytes);
    CRN_REJECT_IF(app, type, !restore(app, app->core.scratch.spare), CRN_REJECT_SNAPSHOT_INVALID,
                  upload.received_bytes, upload.expected_bytes);
    crn_app_send_status(app, type);
}

/* --- for a program that has the device in its own memory: without a copy in the scratch memory --- */
static bool has_lockstep_session(const crn_app *app)
{
    return app->mode == CRN_WIRE_MODE_LOCKSTEP &&
           (app->state == CRN_WIRE_STATE_ARMED || app->state == CRN_WIRE_STATE_RUNNING);
}

bool crn_app_snapshot_take(crn_app *app, uint8_t *bytes)
{
    if (!has_lockstep_session(app)) return false;
    app->session.snapshot_upload.open = false;
    save(app, bytes);
    return true;
}

bool crn_app_snapshot_put(crn_app *app, const uint8_t *bytes)
{
    if (!has_lockstep_session(app)) return false;
    app->session.snapshot_upload.open = false;
    if (!restore(app, bytes)) return false;
    app->session.has_stop = false;
    app->session.inflator_raw = 0;
    return true;
}
