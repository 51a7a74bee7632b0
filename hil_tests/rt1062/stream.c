#include "hil_tests/rt1062/stream.h"
#include <stdlib.h>
#include <string.h>

enum {
    STREAM = 2,
    IN_SHIFT = 16, /* of the controller's bit maps */
    PACKET_BYTES = 512,
    PACKETS_PER_MICROFRAME = 13, /* the most bulk packets that fit */
    TOKEN_us = 2,
    BOOT_MAX_ms = 1000,
    DEADLINE_ms = 100, /* of a token or a change of the bus */
    NAKS_MAX = 2000,
};

/* Between two looks at the mailbox the chip runs for some microseconds. */
static bool host_wait(void *context)
{
    rt_stream *stream = context;
    rt_chip *chip = stream->bus.chip;
    if (chip->now >= stream->deadline) return false;
    if (!rt_bus_serve(&stream->bus) || stream->bus.change_until != 0)
        stream->has_restarted |= rt_engine_run_us(stream->engine, TOKEN_us) == RT_STOP_RESET;
    return true;
}

static void host_begin_wait(void *context)
{
    rt_stream *stream = context;
    stream->deadline = stream->bus.chip->now + DEADLINE_ms * 1000 * RT_INSTANTS_PER_us;
}

rt_stream *rt_stream_create(rt_engine *engine)
{
    rt_stream *stream = calloc(1, sizeof *stream);
    if (stream == NULL) return NULL;
    stream->engine = engine;
    stream->host = (usb_host){.mailbox = &stream->mailbox,
                              .wait = host_wait,
                              .begin_wait = host_begin_wait,
                              .context = stream,
                              .packet_bytes = 64};
    rt_bus_start(&stream->bus, rt_engine_chip(engine), &stream->mailbox);
    return stream;
}

void rt_stream_destroy(rt_stream *stream)
{
    free(stream);
}

static usb_result control(rt_stream *stream, uint8_t request, uint16_t value)
{
    const usb_request setup = {0x00, request, value, 0, 0};
    uint32_t none;
    return usb_host_control(&stream->host, &setup, NULL, &none);
}

const char *rt_stream_open(rt_stream *stream)
{
    rt_chip *chip = stream->bus.chip;
    stream->out.begin = stream->out.end = stream->in.begin = stream->in.end = 0;
    if (chip->usb.bus == RT_BUS_UNPLUGGED) rt_usb_plug(chip, true);
    for (int ms = 0; ms < BOOT_MAX_ms && !rt_usb_is_attached(chip); ms++)
        rt_engine_run_us(stream->engine, 1000);
    if (!rt_usb_is_attached(chip)) return "the device does not connect to the bus";
    rt_bus_serve(&stream->bus);
    stream->host.naks_max = NAKS_MAX;
    if (usb_host_bus(&stream->host, CRN_MAILBOX_RESET_HIGH) != USB_OK)
        return "the reset of the bus does not end";
    if (control(stream, 5, 1) != USB_OK) return "SET_ADDRESS fails";
    rt_engine_run_us(stream->engine, 2000); /* the time that a device has to take its address */
    stream->host.address = 1;
    if (control(stream, 9, 1) != USB_OK) return "SET_CONFIGURATION fails";
    uint8_t zero[PACKET_BYTES];
    uint32_t count = 0;
    if (usb_host_packet_in(&stream->host, STREAM, zero, sizeof zero, &count) != USB_OK || count != 1 ||
        zero[0] != 0)
        return "the byte stream does not begin with a zero";
    stream->host.naks_max = 1;
    stream->is_open = true;
    return NULL;
}

void rt_stream_restarted(rt_stream *stream)
{
    stream->is_open = false;
    stream->has_restarted = false;
    rt_bus_start(&stream->bus, stream->bus.chip, &stream->mailbox);
}

/* --- queues --- */
static void compact(rt_queue *queue)
{
    memmove(queue->bytes, queue->bytes + queue->begin, queue->end - queue->begin);
    queue->end -= queue->begin;
    queue->begin = 0;
}

bool rt_stream_write(rt_stream *stream, const uint8_t *bytes, uint32_t count)
{
    rt_queue *queue = &stream->out;
    if (count > RT_STREAM_BYTES - queue->end) compact(queue);
    if (count > RT_STREAM_BYTES - queue->end) return false;
    memcpy(queue->bytes + queue->end, bytes, count);
    queue->end += count;
    return true;
}

uint32_t rt_stream_read(rt_stream *stream, uint8_t *bytes, uint32_t capacity)
{
    rt_queue *queue = &stream->in;
    uint32_t count = queue->end - queue->begin;
    if (count > capacity) count = capacity;
    memcpy(bytes, queue->bytes + queue->begin, count);
    queue->begin += count;
    return count;
}

/* --- microframes --- */
static bool send_packet(rt_stream *stream)
{
    rt_queue *queue = &stream->out;
    uint32_t count = queue->end - queue->begin;
    if (count == 0) return false;
    if (count > PACKET_BYTES) count = PACKET_BYTES;
    if (usb_host_packet_out(&stream->host, STREAM, queue->bytes + queue->begin, count) != USB_OK)
        return false;
    queue->begin += count;
    return true;
}

static bool receive_packet(rt_stream *stream)
{
    rt_queue *queue = &stream->in;
    uint32_t count = 0;
    if (queue->end + PACKET_BYTES > RT_STREAM_BYTES) compact(queue);
    if (queue->end + PACKET_BYTES > RT_STREAM_BYTES) return false;
    usb_result result =
        usb_host_packet_in(&stream->host, STREAM, queue->bytes + queue->end, PACKET_BYTES, &count);
    if (result != USB_OK) return false;
    queue->end += count;
    return true;
}

void rt_stream_microframe(rt_stream *stream)
{
    rt_chip *chip = stream->bus.chip;
    uint64_t end = chip->now + RT_INSTANTS_PER_s / 1000 / RT_MICROFRAMES_PER_ms,
             jumps = rt_engine_idle_jumps(stream->engine);
    bool moved = false;
    for (int i = 0; stream->is_open && i < PACKETS_PER_MICROFRAME; i++) {
        bool sent = send_packet(stream), received = receive_packet(stream);
        moved = moved || sent || received;
        if (!sent && !received) break;
    }
    if (chip->now < end && rt_engine_run(stream->engine, end) == RT_STOP_RESET) stream->has_restarted = true;
    bool has_rested = rt_engine_idle_jumps(stream->engine) != jumps;
    bool has_answer = (chip->usb.ready >> (IN_SHIFT + STREAM) & 1u) != 0;
    stream->was_idle = !moved && has_rested && !has_answer && stream->out.begin == stream->out.end;
}
