/* While the pipe to the host has space, this file sends the messages that answer no request: first the ticks
 * of FREE_RUN, then notices, then pictures of the tools. Ticks and notices wait in queues; a newer picture of
 * the tools replaces an older picture for which there was no space. */
#include "firmware/app/app_internal.h"

enum {
    FRAMES_PER_EDGE = 2, /* so that a host that reconnects does not delay a tick */
    OVERHEAD_BYTES = CRN_WIRE_FRAME_MAX - CRN_WIRE_PAYLOAD_MAX,
    LIVE_HEAD_BYTES = (int)CRN_WIRE_BYTES_live - (int)CRN_WIRE_MAX_live_ticks * (int)CRN_WIRE_BYTES_live_tick,
};

static bool has_room(const crn_app *app, size_t payload_bytes)
{
    return app->port->transmit_room(app->port->context) >= payload_bytes + OVERHEAD_BYTES;
}

/* --- ticks --- */

/* Appends bytes to the ring buffer, in at most two pieces. */
static void push_bytes(crn_app_queue *queue, const uint8_t *bytes, uint32_t count)
{
    const uint32_t end = (queue->begin + queue->used) % CRN_APP_LIVE_QUEUE_BYTES;
    const uint32_t whole = CRN_APP_LIVE_QUEUE_BYTES - end, first = count < whole ? count : whole;
    for (uint32_t i = 0; i < first; i++) queue->ticks[end + i] = bytes[i];
    for (uint32_t i = first; i < count; i++) queue->ticks[i - first] = bytes[i];
    queue->used += count;
}

/* Copies the oldest bytes of the ring buffer without removing them. */
static void peek_bytes(const crn_app_queue *queue, uint8_t *bytes, uint32_t count)
{
    const uint32_t whole = CRN_APP_LIVE_QUEUE_BYTES - queue->begin, first = count < whole ? count : whole;
    for (uint32_t i = 0; i < first; i++) bytes[i] = queue->ticks[queue->begin + i];
    for (uint32_t i = first; i < count; i++) bytes[i] = queue->ticks[i - first];
}

static uint32_t bytes_of(const crn_app_queue *queue, uint32_t ticks)
{
    uint32_t bytes = 0;
    for (uint32_t i = 0; i < ticks; i++)
        bytes += queue->tick_bytes[(queue->first + i) % CRN_APP_LIVE_QUEUE_ticks];
    return bytes;
}

static void forget_ticks(crn_app_queue *queue, uint32_t ticks, uint32_t bytes)
{
    queue->first = (queue->first + ticks) % CRN_APP_LIVE_QUEUE_ticks;
    queue->count -= ticks;
    queue->begin = (queue->begin + bytes) % CRN_APP_LIVE_QUEUE_BYTES;
    queue->used -= bytes;
}

static void lose_oldest(crn_app *app)
{
    crn_app_queue *queue = &app->queue;
    uint8_t number[4]; /* the first field of an encoded tick */
    peek_bytes(queue, number, sizeof number);
    crn_wire_reader reader = crn_wire_reader_make(number, sizeof number);
    forget_ticks(queue, 1, bytes_of(queue, 1));
    queue->ticks_lost++;
    crn_app_fault(app, CRN_FAULT_CODE_TICKS_LOST, (int32_t)crn_wire_read(&reader, 4), 0);
}

/* Puts a tick into the queue for the host; a full queue drops its oldest ticks. */
void crn_app_stream_live(crn_app *app, const crn_wire_live_tick *live)
{
    crn_app_queue *queue = &app->queue;
    crn_wire_writer writer = crn_wire_writer_make(app->buffers.payload, sizeof app->buffers.payload);
    bool is_encoded = crn_wire_put_live_tick(&writer, live);
    CRN_REQUIRE(app, is_encoded, writer.length);
    const uint32_t bytes = (uint32_t)writer.length;
    while (queue->count == CRN_APP_LIVE_QUEUE_ticks || CRN_APP_LIVE_QUEUE_BYTES - queue->used < bytes)
        lose_oldest(app);
    queue->tick_bytes[(queue->first + queue->count++) % CRN_APP_LIVE_QUEUE_ticks] = (uint16_t)bytes;
    push_bytes(queue, app->buffers.payload, bytes);
}

/* Sends a `live` message made of ticks that are already encoded. */
static bool send_ticks(crn_app *app)
{
    crn_app_queue *queue = &app->queue;
    const uint32_t count = queue->count < CRN_APP_LIVE_BATCH_ticks ? queue->count : CRN_APP_LIVE_BATCH_ticks;
    const uint32_t bytes = bytes_of(queue, count);
    if (count == 0 || !has_room(app, LIVE_HEAD_BYTES + bytes)) return false;
    crn_wire_writer writer = crn_wire_writer_make(app->buffers.payload, LIVE_HEAD_BYTES);
    crn_wire_write(&writer, queue->ticks_lost, 4);
    crn_wire_write(&writer, count, 2);
    peek_bytes(queue, app->buffers.payload + LIVE_HEAD_BYTES, bytes);
    if (!crn_app_offer(app, CRN_WIRE_TYPE_live, LIVE_HEAD_BYTES + bytes)) return false;
    forget_ticks(queue, count, bytes);
    return true;
}

/* --- notices --- */

void crn_app_notice(crn_app *app, uint16_t kind, uint16_t code, int32_t value1, int32_t value2)
{
    crn_app_queue *queue = &app->queue;
    queue->event_number++;
    if (!queue->wants_events) return;
    if (queue->event_count == CRN_APP_EVENT_QUEUE) {
        queue->event_first = (queue->event_first + 1) % CRN_APP_EVENT_QUEUE;
        queue->event_count--;
        queue->events_lost++;
        crn_app_fault_log(app, CRN_FAULT_CODE_EVENTS_LOST, (int32_t)queue->event_number, 0);
    }
    uint32_t place = (queue->event_first + queue->event_count++) % CRN_APP_EVENT_QUEUE;
    queue->events[place] =
        (crn_wire_notice){queue->event_number, app->core.words.tick, kind, code, value1, value2};
}

static bool send_notice(crn_app *app)
{
    crn_app_queue *queue = &app->queue;
    if (queue->event_count == 0 || !has_room(app, CRN_WIRE_BYTES_notice)) return false;
    crn_wire_writer writer = crn_wire_writer_make(app->buffers.payload, sizeof app->buffers.payload);
    bool is_encoded = crn_wire_put_notice(&writer, &queue->events[queue->event_first]);
    CRN_REQUIRE(app, is_encoded, queue->event_count);
    if (!crn_app_offer(app, CRN_WIRE_TYPE_notice, writer.length)) return false;
    queue->event_first = (queue->event_first + 1) % CRN_APP_EVENT_QUEUE;
    queue->event_count--;
    return true;
}

/* --- pictures --- */

/* The function crn_app_stream_tick runs after each tick of FREE_RUN. If an older picture of the tools still
 * waits for space in the pipe, the picture that is due now replaces the older one. */
void crn_app_stream_tick(crn_app *app)
{
    crn_app_queue *queue = &app->queue;
    if (queue->nodes_every_ticks == 0 || --queue->nodes_due_in > 0) return;
    queue->nodes_due_in = queue->nodes_every_ticks;
    if (queue->is_picture_due) queue->pictures_dropped++;
    queue->is_picture_due = true;
}

/* The app sends a picture of the tools only if enough space remains for the next ticks. A picture of the
 * tools shows the core's state at the moment when the picture is sent. */
static void send_picture(crn_app *app)
{
    if (!app->queue.is_picture_due || app->state != CRN_WIRE_STATE_RUNNING) return;
    if (!has_room(app, CRN_WIRE_BYTES_nodes + CRN_WIRE_BYTES_live + OVERHEAD_BYTES)) return;
    app->queue.is_picture_due = false;
    crn_app_send_nodes(app);
}

void crn_app_stream_hash64(crn_app *app)
{
    if (has_room(app, CRN_WIRE_BYTES_hash64 + CRN_WIRE_BYTES_live + OVERHEAD_BYTES)) crn_app_send_hash64(app);
}

/* --- the stream --- */

/* The function crn_app_stream_flush runs once per edge of the timer, after the outputs are written. A batch
 * of ticks waits until the batch is full or no further tick will come. */
void crn_app_stream_flush(crn_app *app)
{
    bool is_last = app->state != CRN_WIRE_STATE_RUNNING || app->mode != CRN_WIRE_MODE_FREE_RUN;
    app->link.answers = 0;
    for (int i = 0; i < FRAMES_PER_EDGE; i++) {
        if (app->queue.count < CRN_APP_LIVE_BATCH_ticks && !is_last) break;
        if (!send_ticks(app)) break;
    }
    for (int i = 0; i < FRAMES_PER_EDGE; i++) {
        if (!send_notice(app)) break;
    }
    send_picture(app);
}

/* Discards all messages of an old session that wait in the queues, when a new session begins. */
void crn_app_stream_clear(crn_app *app)
{
    crn_app_queue *queue = &app->queue;
    queue->count = queue->used = queue->ticks_lost = 0;
    queue->is_picture_due = false;
    queue->nodes_due_in = queue->nodes_every_ticks;
}

void crn_app_stream(crn_app *app, const uint8_t *payload, size_t length)
{
    crn_wire_stream stream;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_stream, !crn_wire_decode_stream(payload, length, &stream),
                  CRN_REJECT_MALFORMED, length, CRN_WIRE_BYTES_stream);
    crn_app_queue *queue = &app->queue;
    queue->wants_events = stream.events != 0;
    if (!queue->wants_events) queue->event_count = 0;
    queue->nodes_every_ticks = stream.nodes_every_ticks;
    queue->nodes_due_in = stream.nodes_every_ticks;
    queue->is_picture_due = false;
    crn_app_send_status(app, CRN_WIRE_TYPE_stream);
}
