/* This header models a rig and the hand that holds its handle, in double precision, for tests of the haptic
 * loop. The model consists of the app itself behind a test port, a carriage, an encoder with steps and
 * jitter, and a hand. The carriage has mass, damping, friction and a motor with lag. The hand is modelled as
 * a spring and a damper that pull towards the position that the hand aims at. The model computes 20 steps of
 * physics in each tick. */
#ifndef CRN_TEST_HAPTIC_RIG_H
#define CRN_TEST_HAPTIC_RIG_H

#include "firmware/app/app.h"

typedef struct haptic_hand {
    double stiffness_N_m, damping_N_s_m;
} haptic_hand;

typedef struct haptic_rig {
    crn_instrument tool_table[CRN_TABLE_MAX];
    crn_app app;
    crn_port port;
    crn_port_inputs inputs;
    crn_port_outputs outputs;
    uint32_t stage_hold_ms, time_us;
    crn_wire_decoder decoder;
    crn_wire_status status; /* last one heard */
    uint32_t refusals;      /* rejects heard */
    haptic_hand hand;
    double wanted_m, wanted_m_s; /* of the hand */
    double carriage_m, carriage_m_s, motor_N;
    double hand_N; /* the sensor: + pushes the hand out */
    uint32_t random;
} haptic_rig;

enum { HAPTIC_MASS_g = 80, HAPTIC_DAMPING_mN_s_m = 1000, HAPTIC_FRICTION_mN = 20, HAPTIC_MOTOR_LAG_us = 500 };

/* Begins a session in the vessel `lumen` (NULL: free space) with one wire on the given track, and powers the
 * track's motors. At the start of the session, the wire protrudes from the introducer sheath by
 * `inserted_um`. Returns false if the device refused one of the messages. */
bool haptic_begin(haptic_rig *rig, const crn_lumen *lumen, const crn_wire_instrument *wire,
                  uint32_t inserted_um, const crn_wire_track *track, const haptic_hand *hand);

/* Runs one millisecond, during which `wanted_m` is the position that the hand aims at. */
void haptic_tick(haptic_rig *rig, double wanted_m);

#endif
