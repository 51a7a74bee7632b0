/* The core's public header: one centreline instrument in one lumen, advanced by one 1 ms tick.
 *
 *   seld_model_build()  instrument + lumen + entry -> constants            (set-up, once)
 *   seld_state_init()   rest state with the instrument in the inserter
 *   seld_step()         (model, state, input) -> state', output            (exactly one tick)
 *   seld_state_save/restore/hash                                           (31 kB of 32-bit words)
 *
 * Node 0 is the tip; indices grow towards the hand. Patient frame: +x patient left, +y head, +z anterior.
 * May include: this folder. Called by: firmware/app, tools, host (by this header only).
 */
#ifndef SELD_CORE_H
#define SELD_CORE_H

#include "firmware/core/lumen.h"
#include "firmware/core/vector.h"

enum {
    SELD_CORE_VERSION = 1, /* changes whenever the same inputs may give another hash */
    SELD_NODE_MAX = 384,   /* nodes of one line */
    SELD_KNOT_MAX = 32,    /* knots of one instrument */
    SELD_TICK_us = 1000,
};

/* One knot of an instrument's profile. Properties are linear between knots by arc length from the distal tip;
 * two knots at the same arc length make a step. All values are checked by seld_model_build. */
typedef struct seld_knot {
    uint32_t arc_um;                 /* 0 .. 2 000 000 from the tip, non-decreasing, first is 0 */
    uint32_t bend_stiffness_nN_m2;   /* EI: 100 (1e-7 N m^2) .. 30 000 000 (3e-2 N m^2) */
    uint32_t twist_stiffness_nN_m2;  /* GJ: same range */
    uint32_t mass_mg_per_m;          /* 500 .. 100 000 */
    uint32_t radius_outer_um;        /* 100 .. 2 000 */
    uint32_t friction_kinetic_milli; /* 0 .. 1 000 */
    uint32_t friction_static_milli;  /* >= kinetic, 0 .. 1 000 */
    int32_t
        rest_curvature1_per_m_milli; /* about material axis d2, turning towards d1; +-1 000 000 (R = 1 mm) */
    int32_t rest_curvature2_per_m_milli; /* turning towards d2 */
} seld_knot;

typedef struct seld_instrument {
    uint32_t knot_count; /* 2 .. SELD_KNOT_MAX */
    seld_knot knots[SELD_KNOT_MAX];
    uint32_t axial_stiffness_max_N; /* cap of EA, 100 .. 10 000 */
    uint32_t element_tip_um;        /* shortest element, 200 .. 8 000 (1 000 usual) */
    uint32_t element_shaft_um;      /* longest element, >= element_tip_um, <= 8 000 (4 000 usual) */
    uint32_t element_fine_um;       /* arc length from the tip meshed with element_tip_um */
} seld_instrument;

/* Where the instrument enters: an inserter (sheath) that ends inside the lumen. */
typedef struct seld_entry {
    seld_vec3 position_m_q30; /* centre of the sheath's distal mouth */
    seld_vec3 direction_q30;  /* unit vector into the vessel */
} seld_entry;

typedef struct seld_model seld_model; /* complete type in core_model.h for those who own the memory */
typedef struct seld_state seld_state; /* complete type in core_state.h */

typedef enum seld_build_status {
    SELD_BUILD_OK = 0,
    SELD_BUILD_KNOTS,    /* number or order of knots */
    SELD_BUILD_RANGE,    /* a property out of its range */
    SELD_BUILD_LENGTH,   /* shorter than 20 mm, or more than SELD_NODE_MAX nodes */
    SELD_BUILD_ELEMENTS, /* element lengths out of range */
    SELD_BUILD_ENTRY,    /* direction is no unit vector, or position outside +-1.9 m */
    SELD_BUILD_OVERFLOW, /* stiffness and element length together exceed the number format */
} seld_build_status;

/* Input of one tick: where the hand is, not how fast. */
typedef struct seld_input {
    int32_t hand_feed_m_q30; /* hand position along the inserter axis since the start, + into the patient */
    uint32_t hand_turn32; /* hand angle, one turn = 2^32, + right-handed about the direction of insertion */
} seld_input;

/* Output of one tick. */
typedef struct seld_output {
    uint32_t tick;                 /* ticks done, including this one */
    uint32_t hash_lane[2];         /* cheap hash of the state after this tick */
    int32_t handle_axial_N_q22;    /* force the instrument exerts on the hand, + pushes the hand back out */
    int32_t handle_torque_N_m_q24; /* torque on the hand, + opposes positive rotation */
    int32_t inserted_m_q30;        /* length beyond the inserter's mouth */
    int32_t penetration_max_m_q30; /* deepest contact depth after the step */
    int32_t strain_max_q30;        /* largest |length error| of the free part, relative, whole length */
    uint16_t contact_count;
    uint16_t solve_count; /* 1, or 2 when a missed contact was re-solved */
    uint32_t fault_bits;  /* sticky SELD_FAULT_* of the state */
} seld_output;

enum {
    SELD_FAULT_SATURATED = 1u << 0,   /* a physical quantity reached its format's limit */
    SELD_FAULT_FEED_LIMIT = 1u << 1,  /* the hand moved faster than the feed limit; the rest was dropped */
    SELD_FAULT_STEP_CAPPED = 1u << 2, /* the motion of one tick was scaled down */
    SELD_FAULT_INSERT_END = 1u << 3,  /* fully inserted or fully withdrawn; the hand slips */
};

/* Sizes for owners that allocate by bytes. */
size_t seld_model_size(void);
size_t seld_state_size(void);

/* Derive all constants. `lumen` may be NULL (free space) and must outlive the model. On any status but OK the
 * model is unusable and *field names the offending knot or field for the message (0-based knot index, or 0).
 */
seld_build_status seld_model_build(seld_model *model, const seld_instrument *instrument,
                                   const seld_lumen *lumen, const seld_entry *entry, uint32_t *field);

/* Gravity of the model, mm/s^2 along each axis (patient frame). Default (0, 0, -9810): the patient lies on
 * the back. */
void seld_model_set_gravity(seld_model *model, int32_t x_mm_s2, int32_t y_mm_s2, int32_t z_mm_s2);

/* State with `inserted_um` of the instrument outside the inserter, straight along its axis, at rest. */
void seld_state_init(const seld_model *model, seld_state *state, uint32_t inserted_um);

/* One tick. Never fails: what cannot be represented saturates and sets a fault bit. */
void seld_step(const seld_model *model, seld_state *state, const seld_input *input, seld_output *output);

/* Save to and restore from 32-bit words, little end first in bytes. restore checks range and structure
 * (hostile until checked) and leaves the state alone when it returns false. */
size_t seld_state_bytes(void);
void seld_state_save(const seld_state *state, uint8_t *bytes);
bool seld_state_restore(const seld_model *model, seld_state *state, const uint8_t *bytes);

/* Full 64-bit hash (FNV-1a over the state's words). */
uint64_t seld_state_hash64(const seld_state *state);

/* Reading the state for pictures and tests. */
uint32_t seld_state_node_count(const seld_model *model); /* nodes of the whole instrument */
uint32_t seld_state_free_count(const seld_state *state); /* nodes beyond the inserter: 0 .. free_count-1 */
seld_vec3 seld_state_position(const seld_state *state, uint32_t node);
int32_t seld_model_edge_length(const seld_model *model, uint32_t edge); /* rest length, Q30 m */
int32_t seld_model_arc(const seld_model *model, uint32_t node);    /* rest arc length from the tip, Q30 m */
int32_t seld_model_radius(const seld_model *model, uint32_t node); /* outer radius at the node, Q30 m */

/* Deepest contact depth of the free nodes, Q30 m: negative while all are inside the lumen, INT32_MIN without a lumen.
 * For set-up (is the start possible?) and tests; a step reports its own in the output. */
int32_t seld_state_depth(const seld_model *model, const seld_state *state);
uint32_t seld_state_tick(const seld_state *state);

#endif
