/* This file moves bytes between device and host through the two ring buffers in the memory page of the
 * emulated rig. The heads and tails of the ring buffers are byte counts, which wrap at 2^32. If a ring's head
 * is ahead of its tail by more than the ring's length, the other side has made an error; the device then
 * empties this ring. */
#include "firmware/port/mps2_an500/device/device.h"

enum {
    RING_MASK = RIG_RING_BYTES - 1,
    /* a packet of USB: a host that floods the ring must not keep the device from its milliseconds */
    PIECE_BYTES = 512,
};

/* At its start, the device drops the bytes that the host sent before, and the bytes that the device itself
 * had not yet sent. */
void pipe_start(void)
{
    rig_write(&rig->device.to_device_tail, rig_read(&rig->host.to_device_head));
    rig_write(&rig->device.to_host_head, rig_read(&rig->host.to_host_tail));
}

size_t pipe_received(const uint8_t **bytes)
{
    uint32_t tail = rig->device.to_device_tail;
    uint32_t count = rig_read(&rig->host.to_device_head) - tail;
    if (count > RIG_RING_BYTES) {
        pipe_release(count);
        return 0;
    }
    if (count > PIECE_BYTES) count = PIECE_BYTES;
    uint32_t at = tail & RING_MASK;
    *bytes = &rig->to_device[at];
    return count <= RIG_RING_BYTES - at ? count : RIG_RING_BYTES - at;
}

void pipe_release(size_t count)
{
    rig_write(&rig->device.to_device_tail, rig->device.to_device_tail + (uint32_t)count);
}

size_t pipe_room(void *context)
{
    (void)context;
    uint32_t used = rig->device.to_host_head - rig_read(&rig->host.to_host_tail);
    return used <= RIG_RING_BYTES ? RIG_RING_BYTES - used : 0;
}

/* The function first copies whole words, aligned or not, because the PSRAM allows unaligned access. */
static void copy(uint8_t *to, const uint8_t *from, size_t count)
{
    size_t i = 0;
    for (; i + 4 <= count; i += 4) __builtin_memcpy(&to[i], &from[i], 4);
    for (; i < count; i++) to[i] = from[i];
}

bool pipe_transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    if (frame_bytes > pipe_room(context)) return false;
    uint32_t at = rig->device.to_host_head & RING_MASK;
    size_t first = RIG_RING_BYTES - at;
    if (first > frame_bytes) first = frame_bytes;
    copy(&rig->to_host[at], frame, first);
    copy(rig->to_host, frame + first, frame_bytes - first);
    rig_write(&rig->device.to_host_head, rig->device.to_host_head + (uint32_t)frame_bytes);
    return true;
}
