/* The state of one instrument. `seld_state_words` is everything that matters from one tick to the next:
 * 32-bit words without pointers or padding, hashed, saved and compared as such. `seld_scratch` lives beside
 * it so that the core needs neither heap nor a deep stack; its contents are dead between ticks.
 *
 * May include: core_model.h. Called by: this folder, and owners of state memory.
 */
#ifndef SELD_CORE_STATE_H
#define SELD_CORE_STATE_H

#include "firmware/core/core_model.h"

typedef struct seld_node_state {
    seld_vec3 position_m_q30;
    seld_vec3 step_m_q33;    /* displacement of the last tick (velocity x h) */
    seld_vec3 tangent_q30;   /* edge i: unit vector towards node i + 1, at the last predicted configuration */
    seld_vec3 bristle_m_q33; /* friction: elastic tangential displacement at the wall */
    uint32_t angle_turn32; /* edge i: material axis d1 against the reference axis carried from the inserter */
    uint32_t contact;      /* SELD_CONTACT_* */
} seld_node_state;

enum { SELD_CONTACT_NONE = 0, SELD_CONTACT_SLIPS = 1, SELD_CONTACT_STICKS = 2 };

typedef struct seld_state_words {
    uint32_t tick;
    uint32_t fault_bits;
    uint32_t free_count;       /* na: nodes beyond the inserter */
    int32_t inserted_m_q30;    /* s */
    int32_t hand_offset_m_q30; /* hand position + offset = wanted s; changes only when the hand slips */
    int32_t feed_m_q33;        /* ds of the last tick */
    uint32_t base_turn32;      /* angle of the inserter's material frame */
    int32_t handle_axial_N_q22;
    int32_t
        release_q30; /* share of the rest shape that is in force: 0 in the introducer, 1 after 256 ticks */
    seld_node_state nodes[SELD_ARRAY_NODES];
} seld_state_words;

/* Symmetric 3x3: xx, xy, xz, yy, yz, zz. */
typedef struct seld_sym3 {
    int32_t m[6];
} seld_sym3;

typedef struct seld_work {
    /* predicted configuration x* = x - T ds: the rod slid along itself by this tick's feed */
    seld_vec3 position_m_q30;
    seld_vec3 slide_m_q33;  /* x* - x */
    seld_vec3 drift_m_q33;  /* last step minus slide: what inertia carries beyond sliding */
    seld_vec3 stretch_q30;  /* edge: (x*[i+1] - x*[i]) / length */
    seld_vec3 axis1_q30;    /* edge: d1, where the rest shape needs it */
    int32_t strain_q30;     /* edge, at x* */
    int32_t torque_N_m_q30; /* joint: twisting moment */
    seld_sym3 spring;       /* edge matrix S, Q(a) */
    seld_vec3 force_N_q22;  /* right side */
    seld_sym3 wall;         /* contact matrix, Q(a) */
    seld_vec3 normal_q30;
    int32_t depth_m_q30; /* at x*; meaningful while touching */
    uint32_t touching;
    int32_t distance_m_q30; /* cull distance at x* */
    int32_t diagonal, off_diagonal, off_second;
    int32_t w_q29[9]; /* block LDL^T: W = D^-1 U */
    seld_sym3 p_q29;  /* P = D^-1 kb */
    seld_vec3 solution_m_q33;
    int32_t twist_ratio_q30, twist_angle_q30;
} seld_work;

typedef struct seld_scratch {
    union {
        seld_work nodes[SELD_ARRAY_NODES];
        seld_state_words incoming; /* a state being restored, until it has passed its checks */
    };
    seld_joint mouth[2]; /* joints na-1 and na with their cells clipped at the inserter's mouth */
    int32_t feed_m_q33;
} seld_scratch;

struct seld_state {
    seld_state_words words;
    seld_scratch scratch;
};

#endif
