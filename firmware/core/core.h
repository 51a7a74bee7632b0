/* This is the core's public header. The core simulates one set of up to three nested (coaxial) tools in one
 * lumen, and advances the simulation in ticks of 1 ms. The nested tools (the line) come from a table of up to
 * eight tools. Between two ticks, crn_exchange() takes a tool off the line, or puts another tool on it.
 *
 *   crn_model_build()  tools + lumen + entry -> constants                 (set-up, once)
 *   crn_state_init()   rest state with the tools in the inserter
 *   crn_step()         (model, state, input) -> state', output            (exactly one tick)
 *   crn_state_save/restore/hash                                           (32-bit words, crn_state_bytes)
 *
 * Tools are numbered from the innermost (0, the wire) to the outermost and share one centreline where they
 * overlap. The tool whose tip is farthest in the vessel is the leading tool; any tool may lead. Node 0 is the
 * tip of the leading tool; the node numbers increase towards the user's hand. In the patient frame, +x points
 * to the patient's left, +y to the head, and +z to the front (anterior). */
#ifndef CRN_CORE_H
#define CRN_CORE_H

#include "firmware/core/lumen.h"
#include "firmware/core/rhythm.h"
#include "firmware/core/vector.h"

#ifndef CRN_NODE_MAX
#define CRN_NODE_MAX                                                                                         \
    384 /* nodes of one line; a board with less memory is built with fewer, which does not change hashes */
#endif

enum {
    CRN_CORE_VERSION = 17,      /* changes whenever the same inputs may give another hash */
    CRN_TOOL_MAX = 3,           /* positions of one line, each with one coaxial tool or none */
    CRN_TABLE_MAX = 8,          /* tools that one session can use, on the line and beside it */
    CRN_KNOT_MAX = 32,          /* knots of one instrument */
    CRN_BALLOON_POINT_MAX = 12, /* points of a balloon's table */
    CRN_BALLOON_BALL_MAX = 24,
    CRN_PRESSURE_MAX_Pa = 4000000,
    CRN_STRUT_RING_MAX = 64, /* of all stents */
    CRN_TICK_us = 1000,
    CRN_BLOOD_kg_m3 = 1060,
    CRN_SET_CELL_MAX = 160, /* cells of a tool, from its tip, that may yield */
};

/* A knot gives the properties of an instrument at one arc length. Between knots, properties are interpolated
 * linearly by arc length, which is measured from the distal tip. Two knots at the same arc length describe an
 * abrupt change of the properties. The function crn_model_build checks all values of an instrument's knots.
 */
typedef struct crn_knot {
    uint32_t arc_um;                /* 0 .. 2 000 000 from the tip, non-decreasing, first is 0 */
    uint32_t bend_stiffness_nN_m2;  /* EI: 100 (1e-7 N m^2) .. 30 000 000 (3e-2 N m^2) */
    uint32_t twist_stiffness_nN_m2; /* GJ: same range */
    uint32_t mass_mg_per_m;         /* 500 .. 100 000 */
    uint32_t radius_outer_um;       /* 100 .. 2 000 */
    /* 0 for a solid wire, else the radius of the lumen: less than the outer radius */
    uint32_t radius_inner_um;
    uint32_t friction_kinetic_milli; /* 0 .. 1 000 */
    uint32_t friction_static_milli;  /* >= kinetic, 0 .. 1 000 */
    /* about material axis d2, turning towards d1; +-1 000 000 (R = 1 mm) */
    int32_t rest_curvature1_per_m_milli;
    int32_t rest_curvature2_per_m_milli; /* turning towards d2 */
} crn_knot;

/* What happens beyond the yield curvature (rod_set.c). */
typedef enum crn_material_kind {
    CRN_ELASTIC = 0,      /* nothing: the moment grows as before */
    CRN_PLASTIC = 1,      /* a metal: a part of the bend stays */
    CRN_SUPERELASTIC = 2, /* nitinol: the moment hardly grows, and on the way back it is lower */
} crn_material_kind;

/* For an elastic tool, all numbers are 0. */
typedef struct crn_material {
    uint32_t kind;
    /* Strain of the core's surface at which the material yields or begins to transform, 1e-6: 500 .. 50 000.
     * The core's radius follows from EI and Young's modulus, as that of a solid round wire: r = (4 EI / (pi
     * E))^(1/4). The curvature at yield is the strain divided by this radius. */
    uint32_t yield_strain_micro;
    uint32_t core_modulus_MPa; /* E: 1 000 .. 300 000 */
    uint32_t hardening_milli;  /* slope of the moment beyond the yield, as a part of EI: 0 .. 900 */
    uint32_t unload_milli; /* superelastic: height of the plateau on the way back, as a part of that of the
                              way out: 0 .. 950; else 0 */
    uint32_t limit_milli;  /* superelastic: largest transformed curvature over the yield curvature, 100 ..
                              20 000; else 0 */
} crn_material;

/* A balloon on a tool. Only one of the nested tools may have a balloon. The balloon's table gives the
 * diameter of the unconfined balloon at each pressure. */
typedef struct crn_balloon {
    uint32_t point_count; /* points of the table, 2 .. CRN_BALLOON_POINT_MAX; 0: the tool has no balloon */
    uint32_t distal_um, proximal_um;              /* working length from the tool's tip: 2 to 60 mm */
    uint32_t burst_kPa;                           /* above the table's last pressure, at most 4000 */
    uint32_t pressure_kPa[CRN_BALLOON_POINT_MAX]; /* increasing; the first is at least 100 */
    uint32_t diameter_um[CRN_BALLOON_POINT_MAX];  /* increasing, at most 20 000; the first is wider than the
                                                     folded tool */
} crn_balloon;

typedef struct crn_instrument {
    uint32_t knot_count; /* 2 .. CRN_KNOT_MAX */
    crn_knot knots[CRN_KNOT_MAX];
    uint32_t lumen_friction_milli;  /* friction of a catheter's lumen on the tool inside it, 0 .. 1 000 */
    uint32_t axial_stiffness_max_N; /* cap of EA, 100 .. 10 000; a line takes the largest cap of its tools */
    uint32_t element_tip_um;        /* shortest element, 200 .. 8 000 (1 000 usual) */
    uint32_t element_shaft_um;      /* longest element, >= element_tip_um, <= 8 000 (4 000 usual) */
    uint32_t element_fine_um;       /* arc length from the tip meshed with element_tip_um */
    /* Only crn_exchange() reads the lengths whole_um and rail_um; a whole_um of 0 means that the length is
     * not known and not checked. */
    uint32_t whole_um; /* length of the real tool from tip to end, at most 4 m; the knots may describe less */
    uint32_t rail_um;  /* part, from the tip, that runs over a wire; 0: all of it (over the wire) */
    crn_balloon balloon;
    crn_material material;
} crn_instrument; /* a line takes the finest tip and shaft and the longest fine part of its tools */

/* The tools enter through an introducer sheath (`inserter` in names) that ends inside the lumen. */
typedef struct crn_entry {
    crn_vec3 position_m_q30; /* centre of the sheath's distal end */
    crn_vec3 direction_q30;  /* unit vector into the vessel */
    /* Density of the blood around the tools and in their lumens, 0 .. 2 000; 0: none. The tools lose the
     * weight of the blood that they displace, and move blood along. */
    uint32_t blood_kg_m3;
} crn_entry;

typedef struct crn_model crn_model; /* the complete type is in core_model.h, for those who own the memory */
typedef struct crn_state crn_state; /* the complete type is in core_state.h */

typedef enum crn_build_status {
    CRN_BUILD_OK = 0,
    CRN_BUILD_KNOTS,    /* invalid number or order of knots */
    CRN_BUILD_RANGE,    /* a property out of its range */
    CRN_BUILD_LENGTH,   /* shorter than 20 mm or than five of the line's elements, or more than CRN_NODE_MAX
                           nodes */
    CRN_BUILD_ELEMENTS, /* element lengths out of range, or so long that the rest shape turns by more than 1.2
                           rad in one element */
    CRN_BUILD_ENTRY, /* direction is not a unit vector, position is outside +-1.9 m, or blood is too dense */
    CRN_BUILD_OVERFLOW, /* stiffness or mass and element length together exceed the number format */
    CRN_BUILD_TOOLS,   /* the number of tools or positions is out of range, or the line names a tool that does
                          not exist, one tool twice, or no tool at all */
    CRN_BUILD_NESTING, /* a tool does not fit into the lumen of the next one */
    CRN_BUILD_BALLOON, /* invalid position or table of a balloon, or a second balloon */
} crn_build_status;

/* Names the cause when crn_model_build refuses a model: the tool, and the number of the faulty knot in the
 * tool (0 when no knot is at fault). */
typedef struct crn_build_place {
    uint32_t tool, knot;
} crn_build_place;

/* The input of one tick contains the position (not the velocity) of each of the user's hands, and the
 * commands for heart, breath, lesions and stent struts. */
typedef struct crn_hand_pose {
    int32_t feed_m_q30; /* position along the inserter axis since the start, + into the patient */
    uint32_t turn32;    /* angle, one turn = 2^32, + right-handed about the direction of insertion */
} crn_hand_pose;

/* Commands a stent to hold the points `first` to `last` of a lesion open to the extent `open_q30`. */
typedef struct crn_scaffold {
    uint32_t lesion, first, last;
    int32_t open_q30; /* An extent of 0 has no effect, and an extent of 1 (in Q30) opens the points
                         completely. A command for a point that does not exist has no effect */
} crn_scaffold;

/* Commands the position of one strut ring of a deployed stent. A ring is a circle in the lumen's reference
 * pose. Rings with consecutive numbers that are marked as joined form one stent. An existing strut ring moves
 * towards its commanded position by at most 5 um a tick. */
typedef struct crn_strut_order {
    uint32_t number;      /* 1 .. CRN_STRUT_RING_MAX; 0: no order, and all other fields are 0 */
    int32_t centre_um[3]; /* at most 1 900 000 */
    uint32_t inside_um; /* radius inside of the struts, 200 .. 20 000; 0: there is no such ring any more, and
                           what follows is 0 */
    uint32_t thickness_um; /* thickness of the struts, 10 .. 1 000 */
    uint32_t is_joined;    /* 1: joined to the ring of the next number */
} crn_strut_order;

typedef struct crn_input {
    crn_hand_pose hands[CRN_TOOL_MAX];
    crn_rhythm_order rhythm; /* zero: nothing */
    crn_scaffold scaffold;
    crn_strut_order strut;
    int32_t inflator_Pa; /* pressure in the balloon above that of the blood; limited to 0 ..
                            CRN_PRESSURE_MAX_Pa */
} crn_input;

/* Holds the force and the torque that one tool exerts on the user's hand, and the inserted length of this
 * tool. */
typedef struct crn_handle {
    int32_t axial_N_q22;    /* force on the hand, + pushes it back out */
    int32_t torque_N_m_q24; /* torque on the hand, + opposes positive rotation */
    /* length beyond the inserter's distal end; negative while the tip is still inside */
    int32_t inserted_m_q30;
} crn_handle;

/* Output of one tick. */
typedef struct crn_output {
    uint32_t tick;         /* ticks done, including this one */
    uint32_t hash_lane[2]; /* cheap hash of the state after this tick */
    crn_handle tools[CRN_TOOL_MAX];
    int32_t penetration_max_m_q30; /* deepest contact depth after the step */
    int32_t strain_max_q30;        /* length error of the free part, relative, whole length */
    uint16_t contact_count;
    uint16_t solve_count;   /* 1, or 2 where a contact was missed, whether or not it took a second solve */
    uint16_t lead_tool;     /* the tool whose tip is node 0 */
    uint32_t fault_bits;    /* CRN_FAULT_* of the state; a set bit stays set */
    uint32_t heart_phase32; /* after the tick: the phase of the wall that the contacts met */
    uint32_t breath_phase32;
    uint32_t beat_ms;      /* time since the beat began */
    uint32_t interval_ms;  /* time from the beginning of the beat to the next one */
    uint32_t rhythm_bits;  /* CRN_RHYTHM_* */
    uint32_t balloon_bits; /* CRN_BALLOON_* */
    int32_t balloon_Pa;    /* pressure in it */
    int32_t balloon_radius_max_m_q30, balloon_radius_min_m_q30;
    int32_t balloon_wall_N_q22; /* total force of all its balls on the wall */
} crn_output;

enum {
    CRN_FAULT_SATURATED = 1u << 0,   /* a physical quantity reached its format's limit */
    CRN_FAULT_FEED_LIMIT = 1u << 1,  /* the hand moved faster than the feed limit; the rest was dropped */
    CRN_FAULT_STEP_CAPPED = 1u << 2, /* the motion of one tick was scaled down */
    CRN_FAULT_INSERT_END = 1u << 3,  /* fully inserted or fully withdrawn; the hand slips */
    CRN_FAULT_OUTSIDE = 1u << 4,     /* a node left the region that the lumen's field describes */
};

enum { CRN_BALLOON_BURST = 1u << 0 };

/* These functions return the sizes of the model and of the state in bytes, for callers that allocate the
 * memory. */
size_t crn_model_size(void);
size_t crn_state_size(void);

/* Derives all constants of `tool_count` tools, which are listed from the innermost to the outermost. The
 * pointer `lumen` may be NULL (free space), and its target must exist as long as the model; the tools are
 * copied. If the status is not CRN_BUILD_OK, the model must not be used, and *place names the tool, and the
 * knot of its table of properties, that caused the refusal. */
crn_build_status crn_model_build(crn_model *model, const crn_instrument *tools, uint32_t tool_count,
                                 const crn_lumen *lumen, const crn_entry *entry, crn_build_place *place);

/* Sets the gravity of the model, mm/s^2 along each axis (patient frame). The default gravity is (0, 0, -9810)
 * mm/s^2, for a patient who lies on the back. */
void crn_model_set_gravity(crn_model *model, int32_t x_mm_s2, int32_t y_mm_s2, int32_t z_mm_s2);

/* Builds a model, as crn_model_build does, for a session in which tools are exchanged. The table has
 * `table_count` tools in any order. The line (the set of nested tools) has `line_count` positions from the
 * innermost to the outermost. line[k] is the number of the tool at position k, counted from 1; 0 means that
 * no tool is at this position. All tools of the table share one mesh, so an exchange moves no node. The index
 * `tool` of crn_build_place counts the tools of the table from 0. */
crn_build_status crn_model_build_table(crn_model *model, const crn_instrument *table, uint32_t table_count,
                                       const uint32_t *line, uint32_t line_count, const crn_lumen *lumen,
                                       const crn_entry *entry, crn_build_place *place);

/* Makes a state in which nothing moves. The length inserted_um[k] of each tool k lies beyond the introducer
 * sheath, straight along the sheath's axis. The inserted length of the tool that reaches farthest is limited
 * to the allowed range, which begins at the length of a few elements. */
void crn_state_init(const crn_model *model, crn_state *state, const uint32_t *inserted_um);

/* Advances the state by one tick. The function crn_step never fails: a value that its number format cannot
 * hold saturates, and a fault bit is set. */
void crn_step(const crn_model *model, crn_state *state, const crn_input *input, crn_output *output);

/* An exchange takes a tool out of the set of nested tools (the line), puts a tool of the table on a position
 * that has none, or does both at once. A tool that joins the nested tools begins with its tip in the
 * introducer sheath, CRN_WITHDRAWN behind the sheath's end. A tool can be removed from the nested tools only
 * after its tip was withdrawn into the sheath. The leading tool cannot be removed without a replacement, and
 * is replaced only when the nested tools have their shortest allowed inserted length. */
typedef struct crn_exchange_order {
    uint32_t position; /* 0: innermost */
    uint32_t tool;     /* number in the table, from 1; 0: the tool at this position leaves the line */
} crn_exchange_order;

/* Lists the reasons for which an exchange of tools is refused, in the order in which the code checks them.
 * The wire protocol has a text for each reason of a refusal (shared/wire/wire_exchanges.def). */
typedef enum crn_exchange_status {
    CRN_EXCHANGE_DONE = 0,
    CRN_EXCHANGE_NO_POSITION, /* the line does not have this position */
    CRN_EXCHANGE_NO_TOOL,     /* the table does not have this tool */
    CRN_EXCHANGE_FREE,        /* no tool is at the position that is to become free */
    CRN_EXCHANGE_ON_LINE,     /* the tool is on the line already */
    CRN_EXCHANGE_INSIDE,      /* the tool at the position is still in the patient */
    CRN_EXCHANGE_LEADS,       /* no other tool is in the patient, so the line would be empty */
    CRN_EXCHANGE_INFLATED,    /* the balloon of the tool at the position is under pressure */
    CRN_EXCHANGE_TOO_WIDE,    /* the new tool does not fit into the tool around it */
    CRN_EXCHANGE_TOO_NARROW,  /* the tool inside does not fit into the new tool */
    CRN_EXCHANGE_HUB,         /* a tool inside has a lumen, thus a hub, over which nothing passes */
    CRN_EXCHANGE_SHORT,       /* the wire inside is too short outside of the patient to hold it meanwhile */
    CRN_EXCHANGE_BALLOON,     /* another tool of the line has a balloon already */
    CRN_EXCHANGE_BURST,       /* the balloon of the new tool has burst */
} crn_exchange_status;

/* The function crn_exchange_check changes nothing. The function crn_exchange carries out an order to exchange
 * tools between two ticks, and changes nothing when it does not return CRN_EXCHANGE_DONE. An exchange does
 * not change the other tools. The duration of an exchange has a bound: crn_exchange copies one tool, and the
 * next tick combines the nested tools anew. */
crn_exchange_status crn_exchange_check(const crn_model *model, const crn_state *state,
                                       const crn_exchange_order *order);
crn_exchange_status crn_exchange(crn_model *model, crn_state *state, const crn_exchange_order *order);
/* Returns the number, counted from 1, that the tool at a position has in the table of tools; returns 0 if no
 * tool is at this position. */
uint32_t crn_state_tool_at(const crn_state *state, uint32_t position);

/* These functions save the state as 32-bit words, stored as little-endian bytes, and restore the state from
 * such bytes. The function crn_state_restore checks the ranges and the structure of the bytes, which may come
 * from an attacker, and leaves the state unchanged when it returns false. After crn_state_restore has
 * returned true, the model has the same nested tools as the restored state. */
size_t crn_state_bytes(void);
void crn_state_save(const crn_state *state, uint8_t *bytes);
bool crn_state_restore(crn_model *model, crn_state *state, const uint8_t *bytes);

/* Returns the full 64-bit hash, which is FNV-1a over the state's words. */
uint64_t crn_state_hash64(const crn_state *state);

/* These functions read the state for drawing pictures and for tests. */
uint32_t crn_model_tool_count(const crn_model *model);
uint32_t crn_state_node_count(const crn_model *model); /* nodes of the line at its longest */
uint32_t crn_state_free_count(const crn_state *state); /* nodes beyond the inserter: 0 .. free_count-1 */
crn_vec3 crn_state_position(const crn_state *state, uint32_t node);
int32_t crn_model_edge_length(const crn_model *model, uint32_t edge); /* rest length, Q30 m */
/* rest arc length from the leading tip, Q30 m */
int32_t crn_model_arc(const crn_model *model, uint32_t node);
/* radius that touches the wall there, Q30 m */
int32_t crn_state_radius(const crn_state *state, uint32_t node);
int32_t crn_state_inserted(const crn_state *state, uint32_t tool); /* Q30 m; the largest one leads */

/* Computes the force of the wall on a free node in the present state, in Q22 N: the normal force along the
 * wall's inward normal, plus friction. If the node does not touch the wall, the function returns false and
 * sets the force to zero. */
bool crn_state_contact_force(const crn_model *model, const crn_state *state, uint32_t node,
                             crn_vec3 *force_N_q22);

/* Returns the contact depth (in Q30 m) of the free node that is deepest in the wall. The depth is negative
 * while all free nodes are inside the lumen; it is INT32_MIN when the model has no lumen. During set-up,
 * crn_state_depth shows whether a tool would be inside the wall when the session starts; tests use the
 * function, too. The function crn_step reports its own contact depth in the output. */
int32_t crn_state_depth(const crn_model *model, const crn_state *state);
/* Reports the balloon's shape for pictures: the radii of its balls (spheres), beginning at the distal end. In
 * `arc_m_q30` the function reports the arc length from the leading tip to the balloon's distal end. Returns
 * the number of balls (spheres) that represent the balloon; the number is 0 when no tool has a balloon. */
uint32_t crn_state_balloon(const crn_model *model, const crn_state *state,
                           int32_t radii_m_q30[CRN_BALLOON_BALL_MAX], int32_t *arc_m_q30,
                           int32_t *spacing_m_q30);

/* The function crn_state_open returns how far a lesion of the lumen is open at one point of the lesion, in
 * Q30. The value 0 stands for the narrowed wall as the program that bakes the scene has stored it, and 1
 * stands for the healthy vessel. The function crn_state_open also returns 0 if the lesion does not have the
 * given point. The function crn_model_stations returns the number of points along a lesion that a balloon can
 * open, or 0 if no lesion has the given number. The function crn_state_scaffold opens points of a lesion at
 * once and holds them open permanently. The function crn_state_scaffold returns false if the lesion does not
 * have the given points. */
int32_t crn_state_open(const crn_state *state, uint32_t lesion, uint32_t station);
uint32_t crn_model_stations(const crn_model *model, uint32_t lesion);
bool crn_state_scaffold(const crn_model *model, crn_state *state, const crn_scaffold *order);

/* The function crn_strut_order_is_valid returns whether a command for a strut ring is well-formed. A command
 * whose fields are all 0 has no effect and is also valid. The function crn_state_strut applies a command for
 * a strut ring; when the command is invalid, the function returns false and changes nothing. */
bool crn_strut_order_is_valid(const crn_strut_order *order);
bool crn_state_strut(crn_state *state, const crn_strut_order *order);

uint32_t crn_state_tick(const crn_state *state);
const crn_rhythm *crn_state_rhythm(const crn_state *state);

#endif
