/* The state of one line. `crn_state_words` holds all data that pass from one tick to the next. The 32-bit
 * words of `crn_state_words`, which contain no pointers or padding, are hashed, saved and compared directly.
 * Besides the saved words, the state contains two work areas, so that the core needs neither a heap nor a
 * large stack. `voxels` remembers samples of the distance field. `crn_line` holds the combined properties of
 * all tools at their present positions. The combined properties are derived from the state's words and the
 * model. They stay unchanged while no tool slides against another, except the sets of tools that yield, which
 * every tick puts in anew (rod_set.c). `crn_scratch` is dead between ticks. */
#ifndef CRN_CORE_STATE_H
#define CRN_CORE_STATE_H

#include "firmware/core/core_model.h"
#include "firmware/core/motion.h"

enum { CRN_PAIR_MAX = CRN_TOOL_MAX - 1 }; /* tool k inside tool k + 1 */

typedef struct crn_node_state {
    crn_vec3 position_m_q30;
    crn_vec3 step_m_q33;    /* displacement of the last tick (velocity x h) */
    crn_vec3 tangent_q30;   /* edge i: unit vector towards node i + 1, at the last predicted configuration */
    crn_vec3 bristle_m_q33; /* friction: elastic tangential displacement of the surface at the wall */
    /* edge i: material axis d1 against the axis carried from the inserter */
    uint32_t angle_turn32[CRN_TOOL_MAX];
    int32_t spin_q30[CRN_TOOL_MAX]; /* edge i: rotation in the last tick, radians */
    /* edge i: elastic rotation of tool k inside the tool directly around it, radians */
    int32_t grip_q30[CRN_PAIR_MAX];
    uint32_t contact; /* CRN_CONTACT_* */
} crn_node_state;

enum { CRN_CONTACT_NONE = 0, CRN_CONTACT_SLIPS = 1, CRN_CONTACT_STICKS = 2, CRN_CONTACT_CREEPS = 3 };

typedef struct crn_tool_state {
    int32_t inserted_m_q30;    /* s: length from the inserter's distal end to the tip */
    int32_t hand_offset_m_q30; /* hand position + offset = wanted s; the offset changes only when the hand
                                  slips */
    uint32_t base_turn32;      /* angle of the tool's material frame in the inserter */
    int32_t handle_axial_N_q22;
    /* Of a contact between tools: 0: tool 0 in tool 1; 1: tools 0 and 1 in tool 2; 2: tool 0 in tool 2 where
     * tool 1 does not lie between them. */
    int32_t slide_grip_m_q33; /* friction: elastic slide of the inner tool in the outer one */
    int32_t slide_share_q30;  /* part of the largest friction that this slide has, -1 .. 1 */
    int32_t tip_axial_N_q22;  /* pull of the inner tools where the contact begins, + in tension, smoothed */
} crn_tool_state;

typedef struct crn_balloon_ball {
    crn_vec3 centre_m_q30;
    int32_t radius_m_q30;
    int32_t wall_N_q22; /* 0: no wall confines the ball */
} crn_balloon_ball;

typedef struct crn_balloon_state {
    uint32_t bits;             /* CRN_BALLOON_* */
    int32_t pressure_Pa;       /* in it */
    uint32_t confined_bits[2]; /* balls without clearance between the walls in the directions that even and
                                  odd ticks look in */
    crn_balloon_ball balls[CRN_BALLOON_BALL_MAX]; /* from the distal end */
} crn_balloon_state;

typedef struct crn_lesion_state {
    uint32_t bits; /* bit i: a station of lesion i is open, or is to be opened */
    int32_t open_q30[CRN_LESION_MAX][CRN_LESION_STATION_MAX]; /* how far each station is open: 0 as baked, 1
                                                                 as the healthy vessel */
    /* the part of the opening that does not recoil */
    int32_t kept_q30[CRN_LESION_MAX][CRN_LESION_STATION_MAX];
} crn_lesion_state;

/* The structure crn_strut_ring holds a ring's present position and the position that a command has requested.
 * If a strut ring does not exist, all its fields are 0. */
typedef struct crn_strut_ring {
    crn_vec3 centre_m_q30, wanted_m_q30;
    int32_t inside_m_q30, wanted_inside_m_q30;
    int32_t thickness_m_q30;
} crn_strut_ring;

typedef struct crn_strut_state {
    uint32_t used; /* number of rings up to the last one present */
    uint32_t joined_bits[CRN_STRUT_RING_MAX / 32], moving_bits[CRN_STRUT_RING_MAX / 32];
    crn_strut_ring rings[CRN_STRUT_RING_MAX]; /* rings from `used` on do not enter a hash */
} crn_strut_state;

/* Says which tools of the table are nested at present. The words of crn_exchange_state are part of the hashes
 * only after the first exchange of tools. */
typedef struct crn_exchange_state {
    uint32_t count;              /* exchanges so far */
    uint32_t line[CRN_TOOL_MAX]; /* number of the tool in the table, from 1; 0: free */
    uint32_t burst_bits; /* bit i: the balloon of tool i + 1, which was taken off the line, has burst */
} crn_exchange_state;

/* The part of a cell's bend that does not spring back, as a rest rotation towards d1 and d2 (rod_set.c). With
 * half of the bits, the small steps of a tick would be lost in the direction that takes the smaller ones. */
typedef struct crn_set {
    int32_t turn_q29[2];
} crn_set;

typedef struct crn_set_state {
    uint32_t used_bits; /* bit k: a cell of tool k has a set; without any, the sets do not enter a hash */
    crn_set cells[CRN_TOOL_MAX][CRN_SET_CELL_MAX];
} crn_set_state;

enum {
    CRN_WALL_STATION_MAX = 192,         /* 1.5 m */
    CRN_WALL_SPACING_LOG2_Q30 = 23,     /* 7.8 mm */
    CRN_WALL_WAY_MAX_M_Q30 = 21474836,  /* 20 mm */
    CRN_WALL_WIDEN_MAX_M_Q30 = 4294967, /* 4 mm */
};

/* How far the vessel is displaced at a station. */
typedef struct crn_wall_give {
    crn_vec3 way_m_q30;
    int32_t widen_m_q30;
} crn_wall_give;

typedef struct crn_wall_state {
    uint32_t used; /* number of stations up to the last one that is displaced; 0: the vessel is at rest */
    crn_wall_give stations[CRN_WALL_STATION_MAX]; /* those from `used` on do not enter a hash */
} crn_wall_state;

typedef struct crn_state_words {
    uint32_t tick;
    uint32_t fault_bits;
    uint32_t free_count;       /* na: nodes beyond the inserter */
    int32_t line_axial_N_q22;  /* axial force of the line on the inserter: the total that all hands bear
                                  together */
    int32_t line_change_N_q22; /* its change in the last tick, and the displacement of the leading tip that
                                  caused it */
    int32_t line_feed_m_q30;
    uint32_t line_compliance_m_N_q40; /* compliance of the line seen from the hands, the smallest of the last
                                         ticks */
    uint32_t has_missed; /* 1: the last tick ended inside a wall at rest where no contact was seen */
    /* share of the rest shapes that is applied: 0 in the introducer, 1 after 256 ticks */
    int32_t release_q30;
    crn_rhythm rhythm;
    crn_balloon_state balloon;
    crn_lesion_state lesions;
    crn_tool_state tools[CRN_TOOL_MAX];
    crn_strut_state struts;
    crn_exchange_state exchange;
    crn_set_state set;
    crn_wall_state wall;
    crn_node_state nodes[CRN_ARRAY_NODES];
} crn_state_words;

/* Describes the combined tools at one node: the joint, the edge behind the node, the mass and the surface. */
typedef struct crn_joint {
    int32_t bend_N_m_q26; /* W = 1 / integral ds/EI over the cell, EI of all tools there */
    int32_t p, q, r;      /* W a^2, W a c, W c^2 in Q(a) N/m; a, c = 1 / edge before and after */
    int32_t twist_N_m_q26[CRN_TOOL_MAX]; /* the same with a tool's GJ; 0 where the tool is absent */
    int32_t turn1_q30[CRN_TOOL_MAX]; /* a tool's part of the cell's rest turning, towards its d1, radians */
    int32_t turn2_q30[CRN_TOOL_MAX];
    int16_t set_q14[CRN_TOOL_MAX][2];       /* a tool's part of its set, as turn1 and turn2 */
    uint16_t inner_share_q15[CRN_PAIR_MAX]; /* share of the tools 0 .. k in the bending stiffness */
    uint32_t curved; /* bit k: turn1, turn2 or the set of tool k is not 0, or a set may begin in this tick */
} crn_joint;

typedef struct crn_line_node {
    crn_joint joint;
    int32_t spring;                /* edge: EA / length in Q(a) N/m */
    int32_t axial_stiffness_N_q17; /* edge: EA */
    /* sum of length / EA of edges 0 .. i-1, saturated; up to the first steady node */
    int32_t compliance_m_N_q40;
    int32_t mass_kg_q40;   /* inertia, with the blood that moves along */
    int32_t weight_kg_q40; /* mass less that of the blood displaced; negative where the tools float */
    int32_t radius_m_q30;
    int32_t kinetic_q30, static_q30;
    uint8_t outer, under; /* the tool that touches the wall, and the one beneath it in the cell of a tip */
    uint16_t outer_share_q15; /* 2^15 except in the cell of the outer tool's tip */
} crn_line_node;

enum { CRN_OFFSET_FREE = INT32_MAX }; /* offset of a free position: behind every node */

typedef struct crn_line {
    uint32_t count;   /* nodes that are up to date; 0: none */
    uint32_t steady;  /* first node that equals all nodes behind it; `count` where there is none */
    uint32_t uniform; /* first node whose two edges in front are as long as all edges behind it */
    int32_t edge_compliance_m_N_q40;    /* compliance of one edge from there on */
    int32_t offset_m_q30[CRN_TOOL_MAX]; /* how far each tip is behind the leading one */
    crn_line_node nodes[CRN_ARRAY_NODES];
} crn_line;

/* Stores a symmetric 3x3 matrix as xx, xy, xz, yy, yz, zz. */
typedef struct crn_sym3 {
    int32_t m[6];
} crn_sym3;

/* The assembled terms of the matrix are no longer needed once the matrix is complete, so the results of the
 * elimination overwrite them. */
typedef struct crn_assembly {
    crn_vec3 stretch_q30;             /* edge: (x*[i+1] - x*[i]) / length */
    crn_vec3 axis1_q30[CRN_TOOL_MAX]; /* edge: axis d1 of a tool, where its rest shape needs it */
    int32_t twist_ratio_q30, twist_angle_q30;
    int32_t press_N_m_q30[CRN_PAIR_MAX]; /* edge: mu N r between tool k and the one around it */
    uint16_t grip_N_m_q26[CRN_PAIR_MAX]; /* edge: stiffness of that friction in this tick, at most
                                            CRN_GRIP_STIFFNESS */
} crn_assembly;

typedef struct crn_factor {
    int32_t w_q29[9]; /* block LDL^T: W = D^-1 U */
    crn_sym3 p_q29;   /* P = D^-1 kb */
} crn_factor;

typedef struct crn_work {
    /* predicted configuration x* = x - T ds: the line slid along itself by this tick's feed; a tightly curved
     * tip continues its rotation */
    crn_vec3 position_m_q30;
    crn_vec3 slide_m_q33; /* x* - x */
    union {
        crn_vec3 drift_m_q33; /* last step minus slide: the motion by inertia beyond sliding */
        crn_vec3 around_q30;  /* once a touching node is found: normal x tangent, the direction in which a
                                 turning surface moves */
    };
    int32_t strain_q30; /* edge, at x* */
    int32_t geometric;  /* edge: tension / length in Q(a), 0 in compression, plus a contribution of twist at a
                           rest shape */
    int32_t torque_N_m_q30; /* joint: twisting moment of all tools */
    crn_vec3 force_N_q22;   /* right side */
    crn_vec3 normal_q30;
    int32_t distance_m_q30; /* distance to the wall at x*; for a node far from the wall, a bound: the node is
                               at least so far inside */
    int32_t depth_m_q30;    /* at x*; meaningful while touching */
    int32_t wall_round;     /* N / r with the curvature of CRN_WALL_ROUND, Q(a) */
    int32_t wall_normal, wall_friction; /* contact stiffnesses, Q(a); 0 where nothing touches */
    int32_t tied;        /* isotropic stiffness of the tie between the node and a balloon, Q(a) */
    crn_vec3 held_m_q33; /* touching: bristle and displacement without the deviation, across the normal */
    int32_t reach_m_q33; /* touching: expected bristle along normal x tangent, without the rotation of the
                            surface */
    /* 1: one contact; 2 + i: the node also has the second contact second[i] of the scratch */
    uint32_t touching;
    union {
        crn_assembly a;
        crn_factor f;
    } u;
    union {
        crn_vec3 moment_N_m_q30; /* joint, before the solve: W b, where there are several tools */
        crn_vec3 solution_m_q33;
    };
} crn_work;

/* Describes the second contact of a node that lies between stent struts and vessel wall and touches both. */
typedef struct crn_second_contact {
    uint32_t node;
    int32_t depth_m_q30; /* at x* */
    int32_t stiffness;   /* Q(a) */
    crn_vec3 normal_q30;
} crn_second_contact;

enum {
    CRN_SECOND_MAX = 48 /* nodes between two surfaces; any beyond this number meet only the deeper one */
};

enum { CRN_SCRATCH_SPARE = 1024 }; /* beside the saved state */

typedef struct crn_scratch {
    union {
        crn_work nodes[CRN_ARRAY_NODES];
        crn_state_words incoming; /* a state being restored, until it has passed its checks */
        /* Memory for the owner of the state, who may use it between ticks: room for a saved state. A state
         * can be restored from bytes that lie here, which are lost then: crn_state_restore() reads them in
         * their order, and writes each word of `incoming` at or before the place where it has read it. */
        uint8_t spare[sizeof(crn_state_words) + CRN_SCRATCH_SPARE];
    };
    crn_motion_pose pose;      /* pose of a vessel that moves */
    crn_joint mouth[2];        /* joints na-1 and na with their cells clipped at the inserter's distal end */
    int32_t mouth_axial_N_q22; /* force of the inserter's distal end on a bent line */
    int32_t feed_m_q33;        /* displacement of the leading tip: how far the line slides along itself */
    /* length that edges would have gained by turning in the solve, which was taken back */
    int32_t kept_m_q33;
    int32_t slide_m_q33[CRN_TOOL_MAX]; /* slide of each tool along the line: its feed less that of the line */
    int32_t turn_q30[CRN_TOOL_MAX];    /* rotation of each tool in the inserter, radians */
    int32_t torque_N_m_q30[CRN_TOOL_MAX];   /* on each handle */
    int32_t axial_N_q22[CRN_TOOL_MAX];      /* force on each handle of a tool that does not lead */
    int32_t grip_limit_N_q22[CRN_TOOL_MAX]; /* sum of mu N of a contact between tools, as in crn_tool_state */
    int32_t press_Pa[CRN_BALLOON_BALL_MAX]; /* pressure of a ball on the wall that confines it */
    int32_t wall_shrink_q30;                /* for a lumen that moves: crn_motion_shrink_q30 in this tick */
    crn_vec3 struts_low_m_q30, struts_high_m_q30; /* a box around all struts, with a margin for a node */
    uint32_t second_count;
    crn_second_contact second[CRN_SECOND_MAX];
    int32_t outside_m_q30; /* depth of a node beyond the field's band; 0: none */
} crn_scratch;

struct crn_state {
    crn_state_words words;
    crn_line line;
    /* where each node was last in the distance field; it saves time and changes no result */
    crn_lumen_voxel voxels[CRN_ARRAY_NODES];
    crn_scratch scratch;
};

#endif
