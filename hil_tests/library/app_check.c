/* This program runs a LOCKSTEP session with three tools over libusb on the complete device application. The
 * program compares the state hashes with those of the same session on a simulated device in this process,
 * which is reached through the simulator's pipe. Prints TAP. */
#include <stdlib.h>
#include <string.h>

#include <libusb-1.0/libusb.h>

#include "firmware/tests/reference/client.h"
#include "hil_tests/library/check.h"

enum {
    STREAM_OUT = 0x02,
    STREAM_IN = 0x82,
    STREAM_INTERFACE = 1,
    TIMEOUT_ms = 5000,
    TICKS = 1280,
    BATCH = 64
};

typedef struct bulk {
    libusb_context *usb;
    libusb_device_handle *device;
    unsigned char bytes[1 << 14];
    int begin, end;
    bool is_broken;
} bulk;

static void bulk_write(void *context, const uint8_t *bytes, size_t count)
{
    bulk *b = context;
    static unsigned char copy[CRN_WIRE_FRAME_MAX];
    int done = 0;
    memcpy(copy, bytes, count);
    if (libusb_bulk_transfer(b->device, STREAM_OUT, copy, (int)count, &done, TIMEOUT_ms) != 0 ||
        done != (int)count)
        b->is_broken = true;
}

/* Waits for bytes from the device; returns no bytes if the wait ends by a time-out. */
static size_t bulk_read(void *context, uint8_t *bytes, size_t capacity)
{
    bulk *b = context;
    while (b->begin == b->end && !b->is_broken) {
        b->begin = b->end = 0;
        if (libusb_bulk_transfer(b->device, STREAM_IN, b->bytes, sizeof b->bytes, &b->end, TIMEOUT_ms) != 0)
            b->is_broken = true;
    }
    size_t count = (size_t)(b->end - b->begin);
    if (count > capacity) count = capacity;
    memcpy(bytes, b->bytes + b->begin, count);
    b->begin += (int)count;
    return count;
}

static bool bulk_open(bulk *b)
{
    if (libusb_init(&b->usb) != 0) return false;
    b->device = libusb_open_device_with_vid_pid(b->usb, CHECK_VENDOR_ID, CHECK_PRODUCT_ID);
    if (b->device == NULL || libusb_claim_interface(b->device, STREAM_INTERFACE) != 0) return false;
    return libusb_clear_halt(b->device, STREAM_OUT) == 0 && libusb_clear_halt(b->device, STREAM_IN) == 0;
}

/* The tools move back and forth, so that the session covers motion of the nested tools in both directions. */
static bool run_session(client *c, crn_wire_tick_state *last)
{
    static crn_wire_ticks ticks;
    client_hello(c, crn_wire_schema_hash());
    if (client_receive(c) != CRN_WIRE_TYPE_hello_reply) return false;
    client_command(
        c, CRN_WIRE_ACTION_RESET); /* clears what the session before left; refused when there was none */
    if (client_receive(c) == 0 || !client_start_tools(c, 3)) return false;
    for (uint32_t tick = 0; tick < TICKS; tick += BATCH) {
        const int32_t step = tick < TICKS / 2 ? 25 : -25;
        const int32_t begin = tick < TICKS / 2 ? (int32_t)tick * 25 : (int32_t)(TICKS - tick) * 25;
        client_step(c, tick, BATCH, begin, step);
        if (!client_expect_ticks(c, &ticks) || ticks.states_count != BATCH) return false;
    }
    *last = ticks.states[BATCH - 1];
    return true;
}

int main(void)
{
    static bulk b;
    static client usb, sim;
    static crn_wire_tick_state over_usb, over_sim;
    const client_pipe pipe = {&b, bulk_write, bulk_read};
    if (!check(bulk_open(&b), "the device is opened and a new stream begins")) return check_end();
    client_open_pipe(&usb, &pipe);
    const int64_t begin = check_now_us();
    const bool is_run =
        check(run_session(&usb, &over_usb) && !b.is_broken, "a session of 1 280 ticks runs over USB");
    const int64_t us = check_now_us() - begin;
    check_note("link.lockstep_ticks_per_s %lld", (long long)TICKS * 1000000 / us);
    client_open(&sim, 0);
    check(run_session(&sim, &over_sim) && is_run && over_usb.tick == TICKS &&
              over_usb.hash_lane0 == over_sim.hash_lane0 && over_usb.hash_lane1 == over_sim.hash_lane1,
          "its last state has the hashes of the same session without USB");
    check_note("hashes %08x %08x", (unsigned)over_usb.hash_lane0, (unsigned)over_usb.hash_lane1);
    client_close(&sim);
    libusb_close(b.device);
    libusb_exit(b.usb);
    return check_end();
}
