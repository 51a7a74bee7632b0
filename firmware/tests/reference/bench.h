/* A bench with a rig for tests of safety: a sim whose sensors the test sets, a session in FREE_RUN with
 * powered motors, and a meter at the port's outputs. */
#ifndef CRN_TEST_BENCH_H
#define CRN_TEST_BENCH_H

#include "firmware/tests/reference/client.h"

typedef struct bench {
    client host;
    crn_port_inputs rig; /* what the sensors say from the next bench_tick on */
    uint32_t edge;       /* milliseconds since bench_open */
    bool host_speaks;    /* a frame per edge, so that the host is not silent */
} bench;

/* A sim with a healthy rig, greeted, with one coupled tool, 50 mm inserted, motors not armed. */
bool bench_open(bench *b);
void bench_close(bench *b);

/* ARM, both steps, START: powered after a few edges, which are done here. False when the device refused. */
bool bench_power(bench *b);

/* One millisecond with the present sensors. */
void bench_tick(bench *b);

/* The hand pushes the tool forward until the motor gives at least `axial_mN`: a force to be made safe. False:
 * it never did. */
bool bench_push(bench *b, int32_t axial_mN);

/* Does any motor give, or may it give, a force? At the leads, behind the power stage. */
bool bench_is_safe(const bench *b);

/* Milliseconds until it is safe and the device says `code`; -1 when that takes more than 200. */
int bench_time_to_safe(bench *b, crn_fault_code code);

/* Number of entries of `code` in the fault log, and its values; 0 when there is none. */
uint32_t bench_fault(bench *b, crn_fault_code code, crn_wire_fault_entry *entry);

/* What the device says of itself; frames before the answer are taken and dropped. */
crn_wire_status bench_status(bench *b);
void bench_drain(bench *b);

#endif
