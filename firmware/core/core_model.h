/* The model holds the constants of one set of nested tools in one lumen, that is, all data that crn_step()
 * reads and never writes. Only crn_exchange() and crn_state_restore() change a model that has been built:
 * they copy tools of the table to the line (the set of nested tools).
 *
 *      leading tip                                                 inserter
 *   node 0 --edge 0-- node 1 --edge 1-- node 2  ...  node na-1 --edge na-1-- node na --edge na-- node na+1
 *                     joint 1           joint 2                              joint na
 *
 * One mesh serves all tools: node i lies at the unstretched arc length S[i] behind the leading tip, whichever
 * tool leads. The tip of tool k lies `offset` behind the leading tip. At node i, tool k has the properties at
 * its own arc length S[i] - offset (rod_line.c). A joint lies on the node between two edges, and the joint's
 * cell reaches half an edge to either side. The stiffness entries of the matrix are in Q(a) N/m with one
 * exponent a for the whole mesh (`stiffness_exponent`). The exponent is chosen so that no assembled diagonal
 * entry can reach 2^29, for any positions of the tools. */
#ifndef CRN_CORE_MODEL_H
#define CRN_CORE_MODEL_H

#include "firmware/core/core.h"
#include "firmware/core/lanes.h"
#include "firmware/core/motion.h"

enum { CRN_ARRAY_NODES = CRN_NODE_MAX + 4 };

/* Gives the physical constants of the contact and of the user's hand; docs/rod.md states their sources. */
enum {
    CRN_CONTACT_STIFFNESS_N_m = 5000,       /* normal penalty; 2e4 chatters at r = 1.5 mm */
    CRN_CONTACT_STIFFNESS_DEEP_N_m = 20000, /* added beyond CRN_CONTACT_DEEP */
    CRN_FRICTION_STIFFNESS_N_m = 2000,      /* bristle */
    CRN_CREEP_M_Q33 = 8590,  /* 1 um in a tick, 1 mm/s: up to this speed static friction acts */
    CRN_FRICTION_GROWTH = 8, /* growth of friction while a node does not stick, relative to its last force:
                                0.2 mN become 0.8 N after four ticks */
    CRN_FRICTION_FRESH_N_Q22 = 839, /* 0.2 mN: friction of a node that has just touched */
    CRN_WALL_ROUND_PER_m = 1000,    /* 1 / 1 mm: curvature of the wall that the matrix allows for */
    CRN_WALL_ROUND_MAX_N = 20,
    CRN_HOLD_STIFFNESS_N_m = 200000, /* spring of a held tip; within LOAD_RESERVE_N_m of core_build.c */
    CRN_CONTACT_DEEP_M_Q30 = 214748, /* 0.2 mm */
    /* 0.1 mm: a missed contact gets no deeper than this, in the first tick of several */
    CRN_MISSED_CONTACT_M_Q30 = 107374,
    CRN_FEED_MAX_M_Q30 = 536871,         /* 0.5 mm per tick = 0.5 m/s */
    CRN_TURN_MAX_TURN32 = 13671000,      /* 0.02 rad per tick = 20 rad/s */
    CRN_DAMPING_KEEP_Q30 = 21474836,     /* 20/s x 1 ms = 0.02: drag of the blood, proportional to mass */
    CRN_POSITION_MAX_M_Q30 = 2126008811, /* 1.98 m */
    CRN_STEP_CAP_M_Q33 = 4294967,        /* 0.5 mm of motion per tick in addition to the predicted motion */
    /* a shaped tip regains its shape over 256 ticks as it leaves the introducer, not in one */
    CRN_RELEASE_STEP_Q30 = 1 << 22,
    /* 40 mm: within this distance of the tip a tight curve counts as the tip's */
    CRN_TIP_CURVES_M_Q30 = 42949673,
    CRN_TIP_CURVE_PER_m = 110, /* tight: a radius below 9 mm */
    CRN_SPIN_DRAG_N_M_Q26 = 7, /* 1e-10 N m s / 1 ms per edge: about the drag of blood on a turning wire */
    CRN_TWIST_MAX_N_m = 16,    /* twist stiffness of one joint: 0.03 N m^2 in 2 mm */
    CRN_TURN_OF_CELL_MAX_Q30 = 1288490189, /* 1.2 rad: largest rest turning of one cell */
    /* a cell clipped at the inserter's distal end may always keep only this part of its length, */
    CRN_CLIP_SURE = 10,
    CRN_CLIP_MAX = 32,                  /* or only this part, where the number format has room for it */
    CRN_BEARING_BEND_M_Q30 = 42949673,  /* R 40 mm: bend for which the bearing length of two tools is taken */
    CRN_BEARING_MIN_M_Q30 = 536871,     /* 0.5 mm */
    CRN_TENSION_MAX_N_Q22 = 240 << 22,  /* force of an edge, clamped: forty times the force of a hand */
    CRN_GRIP_STIFFNESS_N_M_Q26 = 26844, /* 4e-4 N m: bristle between one tool and another that it turns in */
    CRN_GRIP_COMPLIANCE_PER_N_M = 2500, /* its inverse */
    /* -5 mm: how far a tool that does not lead may be withdrawn into the inserter */
    CRN_WITHDRAWN_M_Q30 = -5368709,
};

/* Lists the properties of a tool at an arc length; the values of this list are indices into the arrays of a
 * span. */
typedef enum crn_property {
    CRN_BEND_N_M2_Q35,    /* EI */
    CRN_TWIST_N_M2_Q35,   /* GJ */
    CRN_CURVE1_PER_M_Q20, /* rest curvature towards d1 */
    CRN_CURVE2_PER_M_Q20,
    CRN_MASS_KG_PER_M_Q34, /* less the mass of the blood that the tool displaces */
    CRN_RADIUS_M_Q30,
    CRN_KINETIC_Q30,
    CRN_STATIC_Q30,
    CRN_PROPERTY_COUNT
} crn_property;

/* A span is the part of a tool between two knots of different arc length; all properties are linear in a
 * span. */
typedef struct crn_span {
    int32_t begin_m_q30, end_m_q30;
    int32_t inverse_mantissa; /* 1 / length = mantissa 2^-shift in units of 1 / LSB */
    uint32_t shift;
    uint32_t flat; /* 1: every property is the same at both ends of the span */
    int32_t from[CRN_PROPERTY_COUNT];
    int32_t delta[CRN_PROPERTY_COUNT];
} crn_span;

/* crn_material, ready for a tick. */
typedef struct crn_material_law {
    uint32_t kind;      /* CRN_ELASTIC .. */
    int32_t yield_q20;  /* strain at yield times (pi E / 2)^(1/4), E in Pa */
    int32_t slope_q24;  /* g = h / (1 - h), h: hardening; at most 9 */
    int32_t follow_q30; /* 1 / (1 + g) */
    int32_t unload_q30, limit_q20;
} crn_material_law;

typedef struct crn_tool {
    crn_material_law material;
    uint32_t span_count;
    int32_t length_m_q30;
    int32_t inserted_max_m_q30;
    int32_t lumen_friction_q30; /* friction of the lumen on the tool inside */
    int32_t shaft_radius_m_q30; /* radius at the proximal end: lever of the friction inside the next tool */
    int32_t bore_m_q30;         /* smallest radius of the lumen; 0: none */
    crn_span spans[CRN_KNOT_MAX - 1];
} crn_tool;

/* Holds the geometry of node i, of the edge behind the node, and of the node's cell, which ends in the middle
 * of that edge. */
typedef struct crn_mesh_node {
    int32_t arc_m_q30;
    int32_t length_m_q30; /* length of the edge to node i + 1 */
    int32_t inverse_length_per_m_q18;
    int32_t cell_end_m_q30; /* arc + length / 2 */
    int32_t inverse_cell_per_m_q18;
} crn_mesh_node;

/* Springs of 2e5 N/m hold the tip in those validation cases (Euler and Greenhill buckling) in which the tip
 * must not move. */
typedef struct crn_tip_hold {
    bool pinned;     /* node 0 is held at position_m_q30[0] */
    uint32_t second; /* when not 0: this node is held too, at position_m_q30[1]; the farther away it is, the
                        stiffer the clamp */
    bool axial_free; /* both nodes are free along `axis` */
    bool turn;       /* tool 0's first edge is held at `turn32` against the reference axis */
    crn_vec3 axis_q30;
    crn_vec3 position_m_q30[2];
    uint32_t turn32;
} crn_tip_hold;

enum { CRN_BALLOON_UNFOLD_Pa = 50000 }; /* at this pressure the balloon is unfolded */

/* Describes the balloon of one of the tools; a ball_count of 0 means that no tool has a balloon. */
typedef struct crn_balloon_model {
    uint32_t tool, ball_count;
    int32_t distal_m_q30, spacing_m_q30;
    int32_t burst_Pa;
    uint32_t point_count; /* the folded and the unfolded radius, then the maker's table */
    int32_t pressure_Pa[CRN_BALLOON_POINT_MAX + 2];
    int32_t radius_m_q30[CRN_BALLOON_POINT_MAX + 2];
} crn_balloon_model;

/* Holds a tool of the table, ready to be put on the line (the set of nested tools). */
typedef struct crn_table_tool {
    uint32_t outer_um, bore_um; /* largest outer radius; smallest radius of the lumen, 0: none */
    uint32_t whole_um, rail_um; /* as crn_instrument */
    crn_balloon_model balloon;
    crn_tool tool;
} crn_table_tool;

/* A law, ready for a tick, for a station between others (k = 1 / (k l): l is the spacing) and for the station
 * at the tip, to which half a spacing of the vessel and what the vessel carries ahead belong. */
typedef struct crn_wall_ready {
    int32_t way_q16[2], widen_q16[2]; /* m in Q30 per N in Q22, with 16 more bits; [1]: at the tip */
    int32_t wait_q8;                  /* tau, in ticks */
    int32_t bed_q24[2];               /* 1, and at the tip 1 + 2 carry / l: how strongly the bed draws back */
    int32_t carry_q24;                /* (carry / l)^2 */
    int32_t way_share_q30[2], widen_share_q30; /* how much a station moves in a tick without contact */
    int32_t way_max_m_q30, widen_max_m_q30;
} crn_wall_ready;

struct crn_model {
    const crn_lumen *lumen;
    crn_motion_steepness steepness;             /* for a lumen that moves */
    crn_wall_ready walls[CRN_WALL_LAW_MAX + 1]; /* for walls that give way; 0: rigid */
    crn_entry entry;
    uint32_t tool_count; /* positions of the line; each has a tool or is free */
    uint32_t table_count;
    uint32_t line[CRN_TOOL_MAX]; /* number of the tool at each position in the state at the start; 0: free */
    uint32_t node_count;
    uint32_t stiffness_exponent;
    int32_t contact, contact_deep, friction; /* Q(a) N/m */
    int32_t axial_max_N_q17;                 /* cap of EA */
    int32_t stall_N_q22;                     /* handle force at which the feed stops */
    int32_t gravity_m_s2_q20[3];
    /* 2 pi times the density of the blood: times the square of the outer radius, the blood that a tool
     * replaces and the blood that it pushes aside, per length */
    int32_t added_kg_m3;
    crn_vec3 tip_load_N_q22; /* dead load on node 0, for validation */
    crn_tip_hold hold;
    crn_vec3 base_axis1_q30, base_axis2_q30; /* material axes of the inserter at hand angle 0 */
    uint32_t on_line[CRN_TOOL_MAX];          /* the table's tool at each position; of a free one, any */
    crn_balloon_model balloon;               /* of the line */
    crn_mesh_node mesh[CRN_ARRAY_NODES];
    crn_table_tool table[CRN_TABLE_MAX];
#if CRN_HAS_LANES
    bool has_lanes; /* this processor computes with lanes */
#endif
};

/* Returns the tool at a position of the line. A free position has some tool, of which no length is in use. */
static inline const crn_tool *crn_tool_on(const crn_model *model, uint32_t position)
{
    return &model->table[model->on_line[position]].tool;
}

/* Returns where the cell of node i begins, behind the leading tip. */
static inline int32_t crn_cell_begin(const crn_model *model, uint32_t i)
{
    return i > 0 ? model->mesh[i - 1].cell_end_m_q30 : 0;
}

/* The function crn_model_set_tip_load, for validation cases, puts a constant force on the tip. The force is
 * given in newtons (Q22), in the patient frame, and is at most 100 N along each axis. */
void crn_model_set_tip_load(crn_model *model, crn_vec3 load_N_q22);
void crn_model_set_tip_hold(crn_model *model, const crn_tip_hold *hold);

/* --- checks of the input of crn_model_build_table() (core_check.c) ---------------------------------------
 */

enum {
    CRN_TOOL_MIN_um = 20000,
    CRN_TOOL_MAX_um = 1600000,
    CRN_WHOLE_MAX_um = 4000000,
    CRN_ELEMENT_MAX_um = 8000,
};

/* The functions of this header check the tools of the table (number and ranges of their values), the tools
 * that the line begins with (their numbers, nesting and balloons) and the place of entry. *place receives the
 * tool and the knot (entry of its table of properties) that caused a refusal. The nested tools are checked
 * after the tools of the table. */
crn_build_status crn_check_table(const crn_instrument *table, uint32_t table_count, crn_build_place *place);
/* Returns whether the line (a list of nested tools) has at least one tool, contains only the number 0 and
 * numbers of tools in the table, and contains no tool twice. */
bool crn_line_numbers_are_valid(uint32_t table_count, const uint32_t *line, uint32_t line_count);
crn_build_status crn_check_line(const crn_instrument *table, uint32_t table_count, const uint32_t *line,
                                uint32_t line_count, crn_build_place *place);
crn_build_status crn_check_entry(const crn_entry *entry);

#endif
