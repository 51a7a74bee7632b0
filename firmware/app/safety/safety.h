/* The functions of this header control the power of the motors and everything else that can injure the user's
 * hand. The files of the safety code use only one set of readings of the rig, a few plain numbers and their
 * own memory. The safety code uses neither the app, nor the wire protocol, nor the core.
 *
 *   sample, tool count, energies -> crn_safety_check -> findings
 *   forces that the haptics ask for -> crn_safety_drive -> what the port writes
 *
 * The file app_fault.c decides whether a fault stops the device; if it does, the app removes the motor power
 * by crn_safety_off. */
#ifndef CRN_SAFETY_H
#define CRN_SAFETY_H

#include "firmware/app/safety/finding.h"
#include "firmware/app/safety/limits.h"

/* Describes one track of the rig for the safety checks. */
typedef struct crn_safety_track {
    uint32_t translation_pm_per_count;
    uint32_t jump_counts; /* largest believable change of the translation in one tick */
    int32_t force_zero_counts;
    uint32_t force_uN_per_count;
    int32_t force_limit_mN;
    int32_t force_slew_mN_per_tick;
    bool is_reversed;                      /* the encoder counts up when the carriage moves outwards */
    bool is_driven_along, is_driven_about; /* through a coupling; the motor of an axis without one rests */
} crn_safety_track;

/* Holds the data about this timer edge that the other parts of the app give to the safety checks. */
typedef struct crn_safety_input {
    const crn_port_inputs *rig; /* this edge's sample; NULL: no rig */
    uint32_t tool_count;
    bool is_stopped;                      /* the app is in state FAULT */
    int64_t energy_pJ[CRN_PORT_TOOL_MAX]; /* put in by the hand less given back (haptics) */
} crn_safety_input;

/* Describes a swing of a carriage, from one reversal to the next. */
typedef struct crn_safety_swing {
    uint32_t ticks;
    int32_t low_mN, high_mN;    /* range of the motor's force */
    int64_t travel_nm, hand_pJ; /* + into the patient; work of the hand */
    int64_t hand_mN_ms;         /* sum of the hand's force */
} crn_safety_swing;

/* A carriage that oscillates. */
typedef struct crn_safety_cycle {
    crn_safety_swing now, last;
    int64_t at_nm, far_nm; /* since the last turn: present and farthest position */
    int32_t direction;     /* 0: not known yet */
    uint32_t driven_ticks; /* duration of the swings that the motor sustained */
} crn_safety_cycle;

/* Holds the state of the safety checks of one track, which is used only while a rig is attached. */
typedef struct crn_safety_watch {
    int32_t asked_mN[CRN_APP_ASKED_ticks]; /* ring of the forces given to the motor */
    uint32_t over_ticks, current_ticks, mismatch_ticks;
    uint32_t unbalance_ticks; /* of a force on the carriage that neither hand nor motor explains */
    int32_t unbalance_mN, speed_counts;
    int64_t moved_counts, speed_nm, travel_nm; /* what was measured, and what the force must have caused */
    bool is_still;
    bool had_force_sensor;
    crn_port_hand last;
    int32_t
        moved[CRN_APP_ASKED_ticks]; /* ring of the carriage's travel per tick, counts + into the patient */
    uint32_t loose_ticks; /* with a force that no hand holds, less those with one that a hand holds */
    uint32_t untouched_ticks, fast_ticks, passivity_ticks;
    int32_t speed_begin_um_s; /* when the hand released it */
    int64_t impulse_uN_s;     /* of the motor since then */
    crn_safety_cycle cycle;
} crn_safety_watch;

typedef struct crn_safety {
    crn_safety_track tracks[CRN_PORT_TOOL_MAX];
    bool is_driving;  /* the motors have power */
    bool drive_level; /* of the drive line, flipped once per edge while power is wanted */
    bool stage_was_on;
    bool stage_is_reported;                   /* STAGE_STUCK is in the log */
    uint32_t drive_ticks, idle_ticks;         /* since power was requested, or since it no longer is */
    uint32_t asked_at;                        /* place in the rings of the watches */
    crn_port_motor driven[CRN_PORT_TOOL_MAX]; /* given to the port at the last edge; 0 without power */
    crn_safety_watch watches[CRN_PORT_TOOL_MAX];
} crn_safety;

/* Returns the force that a track's sensor measures in the given readings, or 0 without readings or without a
 * working sensor. */
int32_t crn_safety_force_mN(const crn_safety *safety, const crn_port_inputs *rig, uint32_t track);

/* Checks signal lines, sensors, forces and carriages at every edge of the timer, with this edge's readings.
 * The function reports at most one fault for each timer edge. */
void crn_safety_check(crn_safety *safety, const crn_safety_input *input, crn_findings *findings);

/* May the motors be armed? The first reason against it, or CRN_FAULT_CODE_NONE. */
crn_fault_code crn_safety_ready(const crn_safety *safety, const crn_safety_input *input);

/* The power comes on. `input` contains the present readings of the rig; the function crn_safety_on forgets
 * all earlier readings. */
void crn_safety_on(crn_safety *safety, const crn_safety_input *input);

/* Removes the motor power at once: the motors give no force, and the signal on the drive line, which keeps
 * the power stage on, no longer changes. The caller of crn_safety_off sets the rig's lamp. */
void crn_safety_off(crn_safety *safety, crn_port_outputs *outputs);

/* Computes, once per edge of the timer, the motors' forces from the forces that the haptics request. While
 * the motors have power, the drive line changes its level at each timer edge, which keeps the power stage on
 * for another CRN_PORT_DRIVE_HOLD_ms. The caller of crn_safety_drive sets the rig's lamp. */
void crn_safety_drive(crn_safety *safety, const crn_safety_input *input,
                      const crn_port_motor asked[CRN_PORT_TOOL_MAX], crn_port_outputs *outputs);

#endif
