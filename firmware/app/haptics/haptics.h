/* The haptics consist of a virtual coupling between hands and tools, and of the forces requested from the
 * motors (docs/haptics.md). The files of the haptics use only positions, forces and their own memory. The
 * haptics use neither the app, nor the wire protocol, nor the rod. All results of the haptics depend only on
 * encoder counts and the core's results, so a replay computes exactly the same forces. The memory of the
 * haptics is part of the snapshot.
 *
 *   hands, tools before the tick -> crn_haptics_before -> what the core takes for the hands
 *   hands, tools after the tick  -> crn_haptics_after  -> motors (requested), findings
 *
 * The function crn_safety_drive decides how much of the requested forces the motors are commanded to give. */
#ifndef CRN_HAPTICS_H
#define CRN_HAPTICS_H

#include "firmware/app/haptics/hands.h"
#include "firmware/app/safety/finding.h"
#include "firmware/app/safety/limits.h"

/* Holds spring, damper and friction of one axis of the coupling in the units of a rig's settings. The units
 * are N/m, mN s/m and mN along the insertion axis, and uN m/rad, nN m s/rad and uN m about the insertion
 * axis. */
typedef struct crn_haptics_coupling {
    uint32_t stiffness, damping, seal;
} crn_haptics_coupling;

/* Holds spring, damper and friction of one axis in internal units: travel in Q30 m and force in Q22 N, or
 * travel in 2^-32 turn and torque in Q24 N m. The spring's force per travel is stiffness / 2^shift. */
typedef struct crn_haptics_axis {
    int64_t stiffness; /* 0: no coupling */
    int64_t damping;   /* the same format, per travel of one tick */
    int64_t estimate_max;
    int64_t lead_max; /* travel at the force limit: beyond it the hand slips */
    int32_t seal;     /* friction of sheath and valve */
    int32_t force_max;
    int32_t step_max;   /* travel of the tool in one tick */
    int32_t sense_step; /* shorter travel says nothing about stiffness */
    uint32_t shift;
    uint32_t relax_shift; /* the stiffness shown is forgotten within 2^this of travel */
} crn_haptics_axis;

typedef struct crn_haptics_track {
    crn_haptics_axis axes[2]; /* CRN_APP_ALONG and CRN_APP_ABOUT the line */
    uint32_t gain_milli;
    int32_t force_limit_mN, force_slew_mN_per_tick;
    int32_t torque_limit_uN_m, torque_slew_uN_m_per_tick;
} crn_haptics_track;

/* Holds the state of one axis of the coupling; this state is part of the snapshot. */
typedef struct crn_haptics_spring {
    bool is_set;       /* false: the first tick takes hand and tool as they are */
    int32_t reference; /* hand less tool without force; modulo 2^32 */
    int32_t lead;      /* travel of the hand beyond the tool after the last tick */
    int32_t lead_before;
    int32_t force;    /* of the tool on the hand, last tick */
    int32_t position; /* of the tool at the last tick's end; modulo 2^32 */
    int64_t estimate; /* stiffness that the tool has shown */
    int32_t output;   /* the force that the coupling asks the motor for */
} crn_haptics_spring;

/* Holds the energy that motor and hand have exchanged; this energy is part of the snapshot. */
typedef struct crn_haptics_energy {
    int64_t taken_pJ;   /* put in by the hand less given back, at most what may be stored */
    int32_t hand_m_q30; /* where the hand was */
    uint32_t hand_turn32;
    uint32_t scale_q16; /* share of the force, 65 536 while passive */
    bool is_set;
} crn_haptics_energy;

/* Holds the inserted length, the angle, the force and the torque of one tool, for the forces on the hand that
 * holds it. */
typedef struct crn_haptics_tool {
    int32_t inserted_m_q30, hand_offset_m_q30;
    uint32_t base_turn32;
    int32_t axial_N_q22, torque_N_m_q24; /* on the hand; of the last tick */
    bool is_free;                        /* no tool is at this position of the line */
} crn_haptics_tool;

typedef struct crn_haptics_input {
    uint32_t tool_count;
    bool is_fading;           /* the host is silent */
    uint32_t fade_left_ticks; /* until no force is left */
    crn_hand_position hands[CRN_PORT_TOOL_MAX];
    crn_haptics_tool tools[CRN_PORT_TOOL_MAX];
} crn_haptics_input;

/* Describes how the force of a track ends when the track's tool is exchanged. Part of the snapshot. */
typedef struct crn_haptics_release {
    uint32_t left_ticks; /* until no force is left; 0: the track is not being released */
    int32_t from[2];     /* the motor's force and torque at the exchange */
} crn_haptics_release;

enum { CRN_HAPTICS_RELEASE_ticks = 32 };

typedef struct crn_haptics {
    crn_haptics_track tracks[CRN_PORT_TOOL_MAX];
    crn_haptics_spring springs[CRN_PORT_TOOL_MAX][2];
    crn_haptics_energy energies[CRN_PORT_TOOL_MAX];
    crn_port_motor motors[CRN_PORT_TOOL_MAX]; /* requested; in LOCKSTEP only reported */
    int32_t fade_from[CRN_PORT_TOOL_MAX][2];  /* forces when the host fell silent */
    crn_haptics_release releases[CRN_PORT_TOOL_MAX];
    uint32_t passivity_ticks;
} crn_haptics;

/* The constants of one axis; `which` is CRN_APP_ALONG or CRN_APP_ABOUT. */
void crn_haptics_axis_set(crn_haptics_axis *axis, int which, const crn_haptics_coupling *coupling);

/* Resets the virtual coupling, so that it gives no force at the present positions of hands and tools. */
void crn_haptics_reset(crn_haptics *haptics);

/* Sets the forces requested from the motors to zero. */
void crn_haptics_rest(crn_haptics *haptics);

/* When the tool of a track is exchanged, the track's force goes to zero within CRN_HAPTICS_RELEASE_ticks, as
 * when a hand lets go, and the new tool rests meanwhile. After the force has ended, the coupling takes the
 * present positions of hand and new tool as its zero position. */
void crn_haptics_let_go(crn_haptics *haptics, uint32_t track);

/* Runs before the core's tick. The caller fills `followed` with the hands' positions; for each track with a
 * coupling, the function replaces the hand's position by the position to which the coupling moves the tool.
 */
void crn_haptics_before(crn_haptics *haptics, const crn_haptics_input *input,
                        crn_hand_position followed[CRN_PORT_TOOL_MAX]);

/* Runs after the core's tick. The function crn_haptics_after computes the forces of the virtual coupling and
 * applies gain, passivity, slew limit, force limit and fade. */
void crn_haptics_after(crn_haptics *haptics, const crn_haptics_input *input, crn_findings *findings);

/* Computes the forces of the virtual coupling from the motion of the tools (coupling.c). The function
 * crn_haptics_settle is the first half of crn_haptics_after. */
void crn_haptics_settle(crn_haptics *haptics, const crn_haptics_input *input);

#endif
