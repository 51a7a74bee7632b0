/* This program runs a LOCKSTEP session with three tools through the whole app and its wire protocol, in this
 * process. After every batch of ticks, the program prints the state hash that arrives over the wire protocol.
 * The program also prints the hash of the protocol's schema. The printed lines are equal on every machine,
 * whatever its byte order. */
#include <stdio.h>

#include "firmware/tests/reference/client.h"

enum { TICKS = 640, BATCH = 64 };

int main(void)
{
    static client device;
    static crn_wire_ticks ticks;
    client_open(&device, 0);
    client_hello(&device, crn_wire_schema_hash());
    if (client_receive(&device) != CRN_WIRE_TYPE_hello_reply || !client_start_tools(&device, 3)) return 1;
    for (uint32_t tick = 0; tick < TICKS; tick += BATCH) {
        const int32_t step = tick < TICKS / 2 ? 25 : -25;
        const int32_t begin = tick < TICKS / 2 ? (int32_t)tick * 25 : (int32_t)(TICKS - tick) * 25;
        client_step(&device, tick, BATCH, begin, step);
        if (!client_expect_ticks(&device, &ticks) || ticks.states_count != BATCH) return 1;
        const crn_wire_tick_state *last = &ticks.states[BATCH - 1];
        printf("%u %08x %08x\n", (unsigned)last->tick, (unsigned)last->hash_lane0,
               (unsigned)last->hash_lane1);
    }
    printf("schema %016llx\n", (unsigned long long)crn_wire_schema_hash());
    client_close(&device);
    return 0;
}
