/* This file implements the virtual coupling between hands and tools: a spring and a damper along the
 * insertion axis, and a spring and a damper about this axis. The friction of sheath and valve acts on the
 * tool's side of the coupling. */
#include "firmware/app/haptics/haptics.h"
#include "firmware/app/safety/arithmetic.h"
#include "firmware/core/fixed.h"

enum {
    FOLLOW = 4,              /* the core's feed covers a quarter of what it is given (docs/rod.md, "Feed") */
    ALONG_SHIFT = 20,        /* N/m x 2^12 = Q22 N per Q30 m, times 2^20 */
    ALONG_STEP_MAX = 515396, /* 0.48 mm a tick: below the core's 0.5 */
    ALONG_SENSE = 2147,      /* 2 um */
    ALONG_ESTIMATE_MAX = 50000, /* N/m: a short stiff wire at a wall of 25 kN/m */
    ALONG_RELAX_SHIFT = 18,     /* the stiffness shown is forgotten within 0.24 mm */
    ABOUT_SHIFT = 40,
    ABOUT_SCALE =
        26986, /* 2 pi x 2^(24 + 40 - 32) / 10^6: Q24 N m per 2^-32 turn, times 2^40, of 1 uN m/rad */
    ABOUT_STEP_MAX = 13600000,    /* 0.0199 rad a tick: below the core's 20 rad/s */
    ABOUT_SENSE = 68000,          /* 0.1 mrad */
    ABOUT_ESTIMATE_MAX = 1000000, /* uN m/rad */
    ABOUT_RELAX_SHIFT = 26,       /* 0.1 rad */
};

/* --- constants of a track --- */

/* Overflow is impossible: the stiffness is at most 5 000 N/m x 2^12 along the insertion axis and 10^5 uN
 * m/rad x 26 986 about this axis, and a shifted force limit stays below 2^61. */
void crn_haptics_axis_set(crn_haptics_axis *axis, int which, const crn_haptics_coupling *coupling)
{
    const bool is_along = which == CRN_APP_ALONG;
    const int64_t unit = is_along ? 1 << 12 : ABOUT_SCALE;
    const int64_t stiffness = coupling->stiffness;
    /* Over a tick of 1 ms, a damping of 1 mN s/m acts like a stiffness of 1 N/m, and 1 nN m s/rad acts like 1
     * uN m/rad. */
    const int64_t damping = coupling->damping;
    *axis = (crn_haptics_axis){
        .stiffness = stiffness * unit,
        .damping = damping * unit,
        .estimate_max = (is_along ? ALONG_ESTIMATE_MAX : ABOUT_ESTIMATE_MAX) * unit,
        .seal = is_along ? (int32_t)crn_quotient((int64_t)coupling->seal << 22, 1000)
                         : (int32_t)crn_quotient(crn_quotient((int64_t)coupling->seal << 24, 1000), 1000),
        .force_max = is_along ? CRN_APP_FORCE_LIMIT_mN / 1000 * (1 << 22)
                              : (int32_t)(((int64_t)CRN_APP_TORQUE_LIMIT_uN_m << 24) / 1000000),
        .step_max = is_along ? ALONG_STEP_MAX : ABOUT_STEP_MAX,
        .sense_step = is_along ? ALONG_SENSE : ABOUT_SENSE,
        .shift = is_along ? ALONG_SHIFT : ABOUT_SHIFT,
        .relax_shift = is_along ? ALONG_RELAX_SHIFT : ABOUT_RELAX_SHIFT,
    };
    if (stiffness > 0) {
        axis->lead_max =
            (int64_t)crn_divide_u64((uint64_t)axis->force_max << axis->shift, (uint64_t)axis->stiffness);
        if (axis->lead_max > INT32_MAX / 2) axis->lead_max = INT32_MAX / 2;
    }
}

/* --- one tick --- */

static int64_t limited(int64_t value, int64_t limit)
{
    if (value > limit) return limit;
    return value < -limit ? -limit : value;
}

/* Format: force / travel x 2^shift times travel. Overflow is impossible: the distance `lead` by which the
 * hand is ahead of its tool is limited to lead_max, so stiffness x lead is at most the shifted force limit.
 * The damper's force is at most the shifted force limit times the ratio damping / stiffness, and the sum of
 * spring and damper is limited to twice the force limit. */
static int32_t spring_force(const crn_haptics_axis *axis, int64_t lead, int64_t lead_before)
{
    int64_t elastic = crn_rshift_round64(axis->stiffness * lead, axis->shift);
    int64_t viscous =
        crn_rshift_round64(axis->damping * limited(lead - lead_before, axis->lead_max), axis->shift);
    return (int32_t)limited(elastic + viscous, 2 * (int64_t)axis->force_max);
}

/* Returns the travel of the tool in this tick, as the coupling predicts it. The tool moves to the position at
 * which spring, rod and friction balance again, if the rod is as stiff as in the last ticks. The predicted
 * travel is an implicit Euler step of a tool without mass. While the forces of spring and rod differ by less
 * than the friction, the tool does not move at all. */
static int32_t step_of(const crn_haptics_axis *axis, const crn_haptics_spring *spring, int32_t force)
{
    int64_t rest = (int64_t)force - spring->force;
    int64_t moving = (rest < 0 ? -rest : rest) - axis->seal;
    if (moving <= 0) return 0;
    moving = limited(moving, 4 * (int64_t)axis->force_max);
    uint64_t stiffness = (uint64_t)(axis->stiffness + axis->damping + spring->estimate);
    int64_t step =
        limited((int64_t)crn_divide_u64((uint64_t)moving << axis->shift, stiffness), axis->step_max);
    return (int32_t)(rest < 0 ? -step : step);
}

/* Advances the coupling's spring by one tick; the positions `hand` and `tool` may wrap. */
static int32_t step_spring(const crn_haptics_axis *axis, crn_haptics_spring *spring, int32_t hand,
                           int32_t tool)
{
    if (!spring->is_set) {
        *spring = (crn_haptics_spring){.is_set = true, .reference = crn_wrapped_difference(hand, tool)};
    }
    int64_t lead = crn_wrapped_difference(crn_wrapped_difference(hand, tool), spring->reference);
    int64_t kept = limited(lead, axis->lead_max); /* beyond the force limit the hand slips */
    spring->reference = crn_i32_from_u32((uint32_t)spring->reference + (uint32_t)(lead - kept));
    spring->lead_before = spring->lead;
    spring->lead = (int32_t)kept;
    spring->position = tool;
    return step_of(axis, spring, spring_force(axis, kept, spring->lead_before));
}

/* Lets a tool rest where it is, without a force on the hand. */
static void rest(crn_haptics *haptics, uint32_t k, const crn_haptics_tool *tool, crn_hand_position *followed)
{
    const crn_haptics_axis *axes = haptics->tracks[k].axes;
    for (int i = 0; i < 2; i++) haptics->springs[k][i] = (crn_haptics_spring){.is_set = false};
    if (axes[CRN_APP_ALONG].stiffness > 0)
        followed->feed_m_q30 =
            (int32_t)limited((int64_t)tool->inserted_m_q30 - tool->hand_offset_m_q30, INT32_MAX);
    if (axes[CRN_APP_ABOUT].stiffness > 0) followed->turn32 = tool->base_turn32;
}

/* In each tick the core moves the tool by a quarter of the distance by which the tool lags behind its
 * commanded position. To move the tool by one step in this tick, the code gives the core a position four
 * steps ahead of the tool. */
void crn_haptics_before(crn_haptics *haptics, const crn_haptics_input *input,
                        crn_hand_position followed[CRN_PORT_TOOL_MAX])
{
    for (uint32_t k = 0; k < input->tool_count; k++) {
        const crn_haptics_axis *axes = haptics->tracks[k].axes;
        const crn_haptics_tool *tool = &input->tools[k];
        const crn_hand_position *hand = &input->hands[k];
        followed[k] = *hand;
        if (tool->is_free || haptics->releases[k].left_ticks > 0) {
            rest(haptics, k, tool, &followed[k]);
            continue;
        }
        if (axes[CRN_APP_ALONG].stiffness > 0) {
            const int32_t step = step_spring(&axes[CRN_APP_ALONG], &haptics->springs[k][CRN_APP_ALONG],
                                             hand->feed_m_q30, tool->inserted_m_q30);
            const int64_t feed = (int64_t)tool->inserted_m_q30 - tool->hand_offset_m_q30 + FOLLOW * step;
            followed[k].feed_m_q30 = (int32_t)limited(feed, INT32_MAX);
        }
        if (axes[CRN_APP_ABOUT].stiffness > 0) {
            const int32_t step =
                step_spring(&axes[CRN_APP_ABOUT], &haptics->springs[k][CRN_APP_ABOUT],
                            crn_i32_from_u32(hand->turn32), crn_i32_from_u32(tool->base_turn32));
            followed[k].turn32 = tool->base_turn32 + (uint32_t)(FOLLOW * step);
        }
    }
}

/* Updates the estimate of the stiffness with which the tool resists. The estimate of the tool's stiffness
 * rises at once to a larger observed stiffness, and falls again as the tool travels. */
static void settle_spring(const crn_haptics_axis *axis, crn_haptics_spring *spring, int32_t position,
                          int32_t force)
{
    int32_t moved = crn_wrapped_difference(position, spring->position);
    int64_t size = moved < 0 ? -(int64_t)moved : moved;
    int64_t change = moved < 0 ? (int64_t)spring->force - force : (int64_t)force - spring->force;
    if (size > axis->sense_step) {
        int64_t faded = limited(size, (int64_t)1 << axis->relax_shift);
        spring->estimate -= (spring->estimate * faded) >> axis->relax_shift;
        uint64_t shown = 0;
        change = limited(change, 4 * (int64_t)axis->force_max);
        if (change > 0) shown = crn_divide_u64((uint64_t)change << axis->shift, (uint64_t)size);
        if (shown > (uint64_t)axis->estimate_max) shown = (uint64_t)axis->estimate_max;
        if (spring->estimate < (int64_t)shown) spring->estimate = (int64_t)shown;
    }
    spring->lead = (int32_t)limited((int64_t)spring->lead - moved, 2 * axis->lead_max);
    spring->force = force;
    spring->output = spring_force(axis, limited(spring->lead, axis->lead_max), spring->lead_before);
}

void crn_haptics_settle(crn_haptics *haptics, const crn_haptics_input *input)
{
    for (uint32_t k = 0; k < input->tool_count; k++) {
        const crn_haptics_axis *axes = haptics->tracks[k].axes;
        const crn_haptics_tool *tool = &input->tools[k];
        if (haptics->springs[k][CRN_APP_ALONG].is_set) {
            settle_spring(&axes[CRN_APP_ALONG], &haptics->springs[k][CRN_APP_ALONG], tool->inserted_m_q30,
                          tool->axial_N_q22);
        }
        if (haptics->springs[k][CRN_APP_ABOUT].is_set) {
            settle_spring(&axes[CRN_APP_ABOUT], &haptics->springs[k][CRN_APP_ABOUT],
                          crn_i32_from_u32(tool->base_turn32), tool->torque_N_m_q24);
        }
    }
}

void crn_haptics_reset(crn_haptics *haptics)
{
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        for (int i = 0; i < 2; i++) haptics->springs[k][i] = (crn_haptics_spring){.is_set = false};
        haptics->energies[k] = (crn_haptics_energy){.scale_q16 = 1 << 16};
        haptics->releases[k] = (crn_haptics_release){.left_ticks = 0};
    }
}
