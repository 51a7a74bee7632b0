/* A host in this process, on the bus of the emulated board: it enumerates the device, and carries the byte
 * stream of the bulk pair in microframes of 125 us, as a high-speed host does. */
#ifndef CRN_RT1062_STREAM_H
#define CRN_RT1062_STREAM_H

#include "hil_tests/rt1062/engine.h"
#include "hil_tests/rt1062/usb_bus.h"
#include "hil_tests/usb/usb_host.h"

enum { RT_STREAM_BYTES = 1 << 20, RT_MICROFRAMES_PER_ms = 8 };

typedef struct rt_queue {
    uint8_t bytes[RT_STREAM_BYTES];
    uint32_t begin, end;
} rt_queue;

typedef struct rt_stream {
    rt_engine *engine;
    rt_bus bus;
    crn_mailbox mailbox;
    usb_host host;
    uint64_t deadline;
    bool is_open, has_restarted, was_idle; /* was_idle: nothing was left to do in the last microframe */
    rt_queue out, in;
} rt_stream;

rt_stream *rt_stream_create(rt_engine *engine);
void rt_stream_destroy(rt_stream *stream);
/* Lets the device boot, resets the bus, and sets address and configuration; otherwise says what failed. */
const char *rt_stream_open(rt_stream *stream);
/* Runs the chip for a microframe, then exchanges packets. */
void rt_stream_microframe(rt_stream *stream);
/* Power was switched off and on. */
void rt_stream_restarted(rt_stream *stream);
bool rt_stream_write(rt_stream *stream, const uint8_t *bytes, uint32_t count);
uint32_t rt_stream_read(rt_stream *stream, uint8_t *bytes, uint32_t capacity);

#endif
