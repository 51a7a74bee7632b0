/* This header has a bench with a rig for tests of safety. The bench consists of a sim whose sensors the test
 * sets, a session in FREE_RUN with powered motors, and a meter at the port's outputs. */
#ifndef CRN_TEST_BENCH_H
#define CRN_TEST_BENCH_H

#include "firmware/tests/reference/client.h"

typedef struct bench {
    client host;
    crn_port_inputs rig; /* sensor values from the next bench_tick on */
    uint32_t edge;       /* milliseconds since bench_open */
    bool host_speaks;    /* the host sends a frame per edge, so that it is not silent */
} bench;

/* Opens a sim with a healthy rig. Afterwards HELLO is done, one coupled tool is 50 mm inserted, and the
 * motors are not armed. */
bool bench_open(bench *b);
void bench_close(bench *b);

/* Sends ARM, both steps of arming and START, and runs the few edges after which the motors have power.
 * Returns false when the device refused. */
bool bench_power(bench *b);

/* Runs one millisecond with the present sensor values. */
void bench_tick(bench *b);

/* Makes the hand push the tool forward until the motor gives at least `axial_mN`, the force that a test then
 * makes safe. Returns false when the motor never gave that force. */
bool bench_push(bench *b, int32_t axial_mN);

/* Returns whether any motor gives, or may give, a force. The force is measured at the leads, behind the power
 * stage. */
bool bench_is_safe(const bench *b);

/* Returns the milliseconds until no motor gives a force and the device reports `code`, or -1 when that takes
 * more than 200 ms. */
int bench_time_to_safe(bench *b, crn_fault_code code);

/* Returns the number of entries of `code` in the fault log, and their values; returns 0 when there is
 * none. */
uint32_t bench_fault(bench *b, crn_fault_code code, crn_wire_fault_entry *entry);

/* Reads the device's status; frames before the answer are dropped. */
crn_wire_status bench_status(bench *b);
void bench_drain(bench *b);

#endif
