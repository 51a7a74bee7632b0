/* This header declares a test bench with a simulated rig, for tests of safety. The test bench consists of a
 * simulated device whose sensor values the test sets, a session in FREE_RUN with powered motors, and a meter
 * that measures the motors' forces. */
#ifndef CRN_TEST_BENCH_H
#define CRN_TEST_BENCH_H

#include "firmware/tests/reference/client.h"

typedef struct bench {
    client host;
    crn_port_inputs rig; /* sensor values from the next bench_tick on */
    uint32_t edge;       /* milliseconds since bench_open */
    bool host_speaks;    /* the host sends a frame per edge, so that it is not silent */
} bench;

/* Opens a simulated device with a healthy rig. After bench_open, the device has answered HELLO, one coupled
 * tool is inserted by 50 mm, and the motors are not armed. */
bool bench_open(bench *b);
void bench_close(bench *b);

/* Sends ARM, the two messages that arm the motors, and START, and runs the few timer edges after which the
 * motors have power. Returns false if the device refused one of the messages. */
bool bench_power(bench *b);

/* Runs one millisecond with the present sensor values. */
void bench_tick(bench *b);

/* Makes the hand push the tool forward until the motor gives at least `axial_mN`, the force that the device
 * must later remove. Returns false if the motor never gave the requested force. */
bool bench_push(bench *b, int32_t axial_mN);

/* Returns true if the motors of the first track give neither a force nor a torque. The force is measured at
 * the leads, behind the power stage. */
bool bench_is_safe(const bench *b);

/* Returns the number of milliseconds until no motor gives a force and the device reports `code`, or -1 if
 * this takes more than 200 ms. */
int bench_time_to_safe(bench *b, crn_fault_code code);

/* Returns how often the fault log has counted the fault `code`, and the values of this fault; returns 0 if
 * the log has no such fault. */
uint32_t bench_fault(bench *b, crn_fault_code code, crn_wire_fault_entry *entry);

/* Reads the device's status; frames that arrive before the status are dropped. */
crn_wire_status bench_status(bench *b);
void bench_drain(bench *b);

#endif
