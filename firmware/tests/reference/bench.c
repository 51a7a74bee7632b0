#include "firmware/tests/reference/bench.h"

#include <string.h>

bool bench_open(bench *b)
{
    static crn_wire_tools tools;
    crn_wire_status status;
    const crn_wire_track track = client_plain_track();
    memset(b, 0, sizeof *b);
    client_open(&b->host, 4096);
    if (b->host.sim == NULL) return false;
    b->rig = crn_sim_healthy_inputs();
    b->host_speaks = true;
    client_hello(&b->host, crn_wire_schema_hash());
    if (client_receive(&b->host) != CRN_WIRE_TYPE_hello_reply) return false;
    client_rig(&b->host, &track, 1);
    if (!client_expect_status(&b->host, &status)) return false;
    client_plain_tools(&tools, 1);
    client_tools(&b->host, &tools);
    if (!client_expect_status(&b->host, &status)) return false;
    client_entry(&b->host, 50000);
    if (!client_expect_status(&b->host, &status)) return false;
    client_command(&b->host, CRN_WIRE_ACTION_FREE_RUN);
    bool is_set = client_expect_status(&b->host, &status);
    bench_tick(b);
    return is_set;
}

void bench_close(bench *b)
{
    client_close(&b->host);
}

bool bench_power(bench *b)
{
    crn_wire_status status = bench_status(b);
    if (status.state == CRN_WIRE_STATE_READY) {
        client_command(&b->host, CRN_WIRE_ACTION_ARM);
        if (!client_expect_status(&b->host, &status)) return false;
    }
    if (!client_arm_motors(&b->host)) return false;
    client_command(&b->host, CRN_WIRE_ACTION_START);
    if (!client_expect_status(&b->host, &status)) return false;
    for (int i = 0; i < 10; i++) bench_tick(b);
    return crn_sim_read_motors(b->host.sim).drive == 1;
}

void bench_tick(bench *b)
{
    if (b->host_speaks && b->edge % 4 == 0) {
        client_get(&b->host, CRN_WIRE_GET_STATUS);
        bench_drain(b);
    }
    crn_sim_set_inputs(b->host.sim, &b->rig);
    crn_sim_timer(b->host.sim, 1);
    b->edge++;
}

/* The hand moves 1 mm per tick, which is faster than the tool may be fed, so the coupling between hand and
 * tool exerts a force. */
bool bench_push(bench *b, int32_t axial_mN)
{
    for (int i = 0; i < 400; i++) {
        b->rig.hands[0].translation_counts += 1000;
        bench_tick(b);
        if (crn_sim_read_motors(b->host.sim).axial_mN[0] >= axial_mN) return true;
    }
    return false;
}

bool bench_is_safe(const bench *b)
{
    const crn_sim_motors motors = crn_sim_read_motors(b->host.sim);
    return motors.axial_mN[0] == 0 && motors.torque_uN_m[0] == 0;
}

int bench_time_to_safe(bench *b, crn_fault_code code)
{
    for (int edges = 1; edges <= 200; edges++) {
        bench_tick(b);
        if (bench_is_safe(b)) return bench_fault(b, code, NULL) > 0 ? edges : -1;
    }
    return -1;
}

uint32_t bench_fault(bench *b, crn_fault_code code, crn_wire_fault_entry *entry)
{
    static crn_wire_fault_log log;
    bench_drain(b);
    client_get(&b->host, CRN_WIRE_GET_FAULT_LOG);
    if (client_receive(&b->host) != CRN_WIRE_TYPE_fault_log) return 0;
    if (!crn_wire_decode_fault_log(b->host.decoder.payload, b->host.decoder.payload_bytes, &log)) return 0;
    for (uint16_t i = 0; i < log.entries_count; i++) {
        if (log.entries[i].code != code) continue;
        if (entry != NULL) *entry = log.entries[i];
        return log.entries[i].count;
    }
    return 0;
}

crn_wire_status bench_status(bench *b)
{
    crn_wire_status status = {0};
    bench_drain(b);
    client_get(&b->host, CRN_WIRE_GET_STATUS);
    client_expect_status(&b->host, &status);
    return status;
}

void bench_drain(bench *b)
{
    while (client_receive(&b->host) != 0) {
    }
}
