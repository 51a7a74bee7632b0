/* The constants of one instrument in one lumen: everything seld_step() reads and never writes.
 *
 *      tip                                                         inserter
 *   node 0 --edge 0-- node 1 --edge 1-- node 2  ...  node na-1 --edge na-1-- node na --edge na-- node na+1
 *                     joint 1           joint 2                              joint na
 *
 * A joint sits on the node between two edges and owns the cell half an edge to either side. Stiffness entries
 * of the matrix are in Q(a) N/m with one exponent a for the whole rod (`stiffness_exponent`), chosen so that
 * no assembled diagonal can reach 2^29.
 *
 * May include: core.h. Called by: this folder, and owners of model memory.
 */
#ifndef SELD_CORE_MODEL_H
#define SELD_CORE_MODEL_H

#include "firmware/core/core.h"

enum { SELD_ARRAY_NODES = SELD_NODE_MAX + 4 };

/* Physical constants of the contact and the hand; docs/rod.md states where each comes from. */
enum {
    SELD_CONTACT_STIFFNESS_N_m = 5000,       /* normal penalty; 2e4 chatters at r = 1.5 mm */
    SELD_CONTACT_STIFFNESS_DEEP_N_m = 20000, /* added beyond SELD_CONTACT_DEEP */
    SELD_FRICTION_STIFFNESS_N_m = 2000,      /* bristle */
    SELD_CONTACT_DEEP_M_Q30 = 214748,        /* 0.2 mm */
    SELD_MISSED_CONTACT_M_Q30 = 107374,      /* 0.1 mm: an unseen contact deeper than this is solved again */
    SELD_FEED_MAX_M_Q30 = 536871,            /* 0.5 mm per tick = 0.5 m/s */
    SELD_TURN_MAX_TURN32 = 13671000,         /* 0.02 rad per tick = 20 rad/s */
    SELD_DAMPING_KEEP_Q30 = 21474836,        /* 20/s x 1 ms = 0.02: blood's drag, mass proportional */
    SELD_POSITION_MAX_M_Q30 = 2126008811,    /* 1.98 m */
    SELD_STEP_CAP_M_Q33 = 4294967,           /* 0.5 mm of motion per tick besides the feed */
    SELD_RELEASE_STEP_Q30 = 1 << 22, /* a shaped tip leaves the introducer over 256 ticks, not in one */
    SELD_SPIN_DRAG_N_M_Q26 = 6711,   /* 1e-7 N m s / 1 ms per edge: keeps the twist solve regular */
};

/* Constants of the joint at a node. */
typedef struct seld_joint {
    int32_t bend_N_m_q26;  /* W = 1 / integral ds/EI over the cell */
    int32_t twist_N_m_q26; /* the same with GJ */
    int32_t p, q, r;       /* W a^2, W a c, W c^2 in Q(a) N/m; a, c = 1 / edge before and after */
    int32_t turn1_q30;     /* rest turning over the cell towards d1, radians */
    int32_t turn2_q30;
} seld_joint;

/* Constants of an edge between node i and node i + 1. */
typedef struct seld_edge {
    int32_t length_m_q30;
    int32_t inverse_length_per_m_q18;
    int32_t axial_stiffness_N_q17; /* EA */
    int32_t spring;                /* EA / length in Q(a) N/m */
} seld_edge;

/* Constants of a node. */
typedef struct seld_node {
    int32_t arc_m_q30;
    int32_t radius_m_q30;
    int32_t mass_kg_q40;
    int32_t inertia; /* mass / h^2 in Q(a) N/m */
    int32_t friction_kinetic_q30;
    int32_t friction_static_q30;
    seld_vec3 weight_N_q22;
    int32_t diagonal, off_diagonal, off_second; /* matrix rows without edges: see rod_solve.c */
} seld_node;

struct seld_model {
    const seld_lumen *lumen;
    seld_entry entry;
    uint32_t node_count;
    uint32_t stiffness_exponent;
    int32_t contact, contact_deep, friction;  /* Q(a) N/m */
    int32_t stall_N_q22;                      /* handle force at which the feed stops */
    seld_vec3 tip_load_N_q22;                 /* dead load on node 0, for validation */
    seld_vec3 base_axis1_q30, base_axis2_q30; /* material axes of the inserter at hand angle 0 */
    seld_joint joints[SELD_ARRAY_NODES];
    seld_edge edges[SELD_ARRAY_NODES];
    seld_node nodes[SELD_ARRAY_NODES];
    uint32_t compliance_m_N_q40[SELD_ARRAY_NODES]; /* sum of length/EA of edges 0 .. i-1 */
};

/* Dead load on the tip in newtons (Q22), patient frame; for validation cases. */
void seld_model_set_tip_load(seld_model *model, seld_vec3 load_N_q22);

#endif
