/* This file computes contact and friction of the tools on the vessel wall (docs/rod.md, "contact").
 *
 * At the predicted configuration x*, a node of radius r has the contact depth phi + r. Here phi is the signed
 * distance from the wall, and n is the wall's inward normal at the node. The node touches the wall when its
 * depth is positive or when its drift will make the depth positive.
 * - Normal direction: k_n n n^T goes into the matrix, and k_c depth (+ k_deep beyond 0.2 mm) along n into the
 *   right side.
 * - Friction: the bristle z has the stiffness k_f = min(k_t, mu N / |z + displacement|) (lagged secant: true
 *   stick, no chatter). Unless it sticks, mu N is limited to some times its value after the last solve.
 *
 * The displacement of a tool's surface has three terms: the displacement of the node, the slide of the outer
 * tool along the common centreline, and radius times rotation, r theta, across the normal n and the tangent
 * t. One friction limit mu N bounds sliding and turning together, so a wire that slides turns freely. After
 * the solve, the surface's displacement is added to the friction displacement z, up to its limit mu N / k_t.
 *
 * Stent struts (lesion.h) are treated like the vessel wall. A node that touches both stent struts and vessel
 * wall has two contacts. The matrix contains the normals of a node's two contacts. The friction displacement
 * (bristle) of the node is that of its deeper contact, and friction uses the sum of the two normal forces. */
#include "firmware/core/lesion.h"
#include "firmware/core/rod.h"

enum {
    ROUNDING_M_Q30 = 4, /* rounding of displacements along the normal; these and the distance decide whether a
                           node can touch */
    NORMAL_MAX_N_Q22 = 1 << 29, /* 128 N: bounds a bristle to 66 mm, below 2^30 in Q33 */
};

/* As normal_force(), for every depth. */
CRN_RARE static int32_t deep_force(int32_t depth_m_q30)
{
    int64_t force = (int64_t)depth_m_q30 * CRN_CONTACT_STIFFNESS_N_m;
    if (depth_m_q30 > CRN_CONTACT_DEEP_M_Q30) {
        force += (int64_t)(depth_m_q30 - CRN_CONTACT_DEEP_M_Q30) * CRN_CONTACT_STIFFNESS_DEEP_N_m;
    }
    force = crn_rshift_round64(force, 8);
    if ((uint64_t)(force + NORMAL_MAX_N_Q22) <= (uint64_t)NORMAL_MAX_N_Q22 * 2) {
        return (int32_t)force;
    }
    return force > 0 ? NORMAL_MAX_N_Q22 : -NORMAL_MAX_N_Q22;
}

/* Returns the normal force at a depth d: k_c d + k_deep max(0, d - 0.2 mm). Format: Q30 m -> Q22 N; negative
 * depths give the linear part only (it closes the gap in the same solve). Overflow: the force is limited. A
 * depth of -1 m would give -5000 N, but a surface so far from the wall has no contact. */
static inline int32_t normal_force(int32_t depth_m_q30)
{
    const uint32_t most = CRN_CONTACT_DEEP_M_Q30;
    _Static_assert((int64_t)CRN_CONTACT_DEEP_M_Q30 * CRN_CONTACT_STIFFNESS_N_m < INT32_MAX - 128, "32 bits");
    if ((uint32_t)depth_m_q30 + most <= 2 * most) { /* the usual case */
        return crn_asr32(depth_m_q30 * CRN_CONTACT_STIFFNESS_N_m + 128, 8);
    }
    return deep_force(depth_m_q30);
}

/* Returns the outermost tool's slide along the centreline at node i, in Q33 m, positive towards the tip. */
static inline int32_t surface_slide(const crn_state *state, const crn_line_node *line)
{
    int32_t under = state->scratch.slide_m_q33[line->under];
    int64_t more = (int64_t)(state->scratch.slide_m_q33[line->outer] - under) * line->outer_share_q15;
    return under + (int32_t)(more >> 15);
}

/* Returns the sum of the friction displacement and the surface's displacement, without the node's deviation
 * and the tool's rotation. Overflow is impossible: friction displacements are below 2^29.1 (NORMAL_MAX),
 * slides below 2^24. */
static inline crn_vec3 surface_way(const crn_model *model, const crn_state *state, const crn_node_state *node,
                                   const crn_work *work, const crn_line_node *line)
{
    crn_vec3 way = {{node->bristle_m_q33.v[0] + work->slide_m_q33.v[0],
                     node->bristle_m_q33.v[1] + work->slide_m_q33.v[1],
                     node->bristle_m_q33.v[2] + work->slide_m_q33.v[2]}};
    int32_t slide = model->tool_count > 1 ? surface_slide(state, line) : 0;
    return slide != 0 ? without(&way, &node->tangent_q30, slide) : way;
}

/* Returns how far the tool's rotation in the last tick moves its surface at node i along normal x tangent. */
static inline int32_t surface_roll(const crn_node_state *node, const crn_line_node *line)
{
    return crn_surface_way(line->radius_m_q30, node->spin_q30[line->outer]);
}

static inline void add_roll(crn_vec3 *way, const crn_vec3 *around_q30, int32_t roll_m_q33)
{
    for (int k = 0; k < 3; k++) {
        way->v[k] += crn_scale_q30(roll_m_q33, around_q30->v[k]);
    }
}

/* The friction displacement (bristle) is measured relative to the wall. The wall's own motion at the node
 * that was sampled last is subtracted from the displacement of the surface. Overflow: 2^24. */
static void take_wall_step(const crn_model *model, crn_state *state, crn_vec3 *way)
{
    crn_vec3 wall = crn_motion_wall_step(model->lumen->motion, &state->scratch.pose);
    for (int k = 0; k < 3; k++) {
        way->v[k] -= wall.v[k];
    }
}

static inline int32_t stiffness_at(const crn_model *model, int32_t depth_m_q30)
{
    return model->contact + (depth_m_q30 > CRN_CONTACT_DEEP_M_Q30 ? model->contact_deep : 0);
}

static inline const crn_second_contact *second_of(const crn_state *state, const crn_work *work)
{
    return &state->scratch.second[work->touching - 2];
}

/* Returns the sum of the normal forces of a node's two contacts after the node has moved by a deviation.
 * Overflow: the sum is limited like the force of a single contact. Format: Q22 N, Q33 m -> Q22 N. */
CRN_RARE static int32_t both_forces(const crn_state *state, const crn_work *work, int32_t force_N_q22,
                                    const crn_vec3 *deviation_m_q33)
{
    const crn_second_contact *second = second_of(state, work);
    const int32_t depth = crn_sub_sat(second->depth_m_q30, along(deviation_m_q33, &second->normal_q30) >> 3);
    return crn_clamp(force_N_q22 + (depth > 0 ? normal_force(depth) : 0), 0, NORMAL_MAX_N_Q22);
}

/* Sets the stiffnesses of node i's contact for the motion expected in this tick. The vector `expected` is the
 * node's expected deviation from its slide, and `inwards` is its component along the normal. The vectors
 * `expected` and `around` may share memory. `predicted_m_q30` is the contact depth of the node after the
 * deviation. Overflow is impossible: the friction displacement is below 2^29.2, deviations are below 2^29 and
 * the displacement by rolling is below 2^23, so every component of their sum is below 2^30.5. */
static inline void touch(const crn_model *model, crn_state *state, const crn_node_state *node, crn_work *work,
                         const crn_line_node *line, int32_t predicted_m_q30, const crn_vec3 *expected,
                         int32_t inwards)
{
    const crn_vec3 *n = &work->normal_q30;
    int32_t force = predicted_m_q30 > 0 ? normal_force(predicted_m_q30) : 0;
    if (work->touching > 1) {
        force = both_forces(state, work, force, expected);
    }
    int32_t limit = crn_scale_q30(force, friction_of(node, line));
    if (node->contact != CRN_CONTACT_STICKS) {
        limit = growing_limit(node, limit);
    }
    crn_vec3 way = surface_way(model, state, node, work, line);
    if (model->lumen->motion != NULL) {
        take_wall_step(model, state, &way);
    }
    crn_vec3 held = tangential(&way, n);
    crn_vec3 reach = without(expected, n, inwards);
    for (int k = 0; k < 3; k++) {
        reach.v[k] += held.v[k];
    }
    crn_vec3 around = crn_vec3_cross_unit(n, &node->tangent_q30);
    work->held_m_q33 = held;
    work->around_q30 = around;
    work->reach_m_q33 = crn_vec3_dot_unit(&reach, &around);
    int32_t roll = surface_roll(node, line);
    if (roll != 0) {
        add_roll(&reach, &around, roll);
    }
    work->wall_friction = friction_stiffness(model, limit, &reach);
    work->wall_normal = stiffness_at(model, work->depth_m_q30);
    /* N / 1 mm: N Q22 -> Q(a) N/m; 20 N x 1000 / m in Q14 fit 29 bits, and 1000 = 125 x 8 */
    int32_t round_N_q22 = force < CRN_WALL_ROUND_MAX_N << 22 ? force : CRN_WALL_ROUND_MAX_N << 22;
    work->wall_round =
        (crn_asr32(round_N_q22, 3) * (CRN_WALL_ROUND_PER_m / 8)) >> (16 - model->stiffness_exponent);
    work->touching = work->touching > 1 ? work->touching : 1;
}

/* Adds the forces of contact and friction to the right side, in newtons (Q22), once the rotation of the
 * tool's surface is known. Overflow: a friction force is below 2000 N/m x 180 mm; the sum saturates. */
static inline void push_node(const crn_model *model, const crn_node_state *node, crn_work *work,
                             const crn_line_node *line)
{
    int32_t roll = surface_roll(node, line);
    if (roll != 0) {
        add_roll(&work->held_m_q33, &work->around_q30, roll);
    }
    int32_t push = normal_force(work->depth_m_q30);
    int32_t minus_q19 = -(work->wall_friction << (19 - model->stiffness_exponent)); /* below 2^30 */
    for (int k = 0; k < 3; k++) {
        /* Q19 N/m x Q33 m -> Q20 N, in steps of 1 uN */
        int32_t drag = crn_mulh(minus_q19, work->held_m_q33.v[k]) * 4;
        int32_t force = crn_scale_q30(push, work->normal_q30.v[k]) + drag;
        work->force_N_q22.v[k] = crn_add_sat(work->force_N_q22.v[k], force);
    }
}

CRN_RARE static void push_second(crn_state *state, const crn_second_contact *second)
{
    crn_work *work = &state->scratch.nodes[second->node];
    if (work->touching < 2) {
        return; /* held */
    }
    const int32_t push = normal_force(second->depth_m_q30);
    for (int k = 0; k < 3; k++) {
        work->force_N_q22.v[k] =
            crn_add_sat(work->force_N_q22.v[k], crn_scale_q30(push, second->normal_q30.v[k]));
    }
}

/* Samples the wall at a node; `placed` is true if wall_distance() looked up this point last. */
static inline crn_lumen_sample wall_at(const crn_model *model, crn_state *state, const crn_wall_view *view,
                                       bool placed)
{
    const crn_lumen *lumen = model->lumen;
    crn_lumen_sample open;
    if (state->words.lesions.bits != 0 &&
        crn_lesion_wall(model, &state->words, &state->scratch.pose, view->at_m_q30, &open)) {
        return open;
    }
    if (lumen->motion == NULL) {
        return crn_lumen_contact(lumen, view->at_m_q30);
    }
    return placed ? crn_motion_contact_here(lumen, lumen->motion, &state->scratch.pose)
                  : crn_motion_contact(lumen, lumen->motion, &state->scratch.pose, view->at_m_q30);
}

/* Computes a node's contact depth and the wall's normal at x*; returns false where the distance field has no
 * gradient. */
static inline bool sample(const crn_model *model, crn_state *state, crn_work *work, const crn_line_node *line,
                          const crn_wall_view *view, bool placed)
{
    const crn_lumen_sample wall = wall_at(model, state, view, placed);
    work->distance_m_q30 = crn_sub_sat(wall.distance_m_q30, view->widen_m_q30);
    work->normal_q30 = wall.normal_q30;
    work->depth_m_q30 = crn_add_sat(work->distance_m_q30, line->radius_m_q30);
    bool known = (work->normal_q30.v[0] | work->normal_q30.v[1] | work->normal_q30.v[2]) != 0;
    if (!known && work->distance_m_q30 > 0) {
        state->words.fault_bits |= CRN_FAULT_OUTSIDE;
        if (work->depth_m_q30 > state->scratch.outside_m_q30) {
            state->scratch.outside_m_q30 = work->depth_m_q30;
        }
    }
    return known;
}

static void clear(crn_node_state *node)
{
    node->bristle_m_q33 = (crn_vec3){{0, 0, 0}};
    node->contact = CRN_CONTACT_NONE;
}

/* Returns the node's distance to the wall at the predicted configuration as if all lesions were closed. If
 * lesions are open, the true distance is at least as large. For a node farther inside than `far`, and for a
 * moving wall, the result is a lower bound; at the wall or beyond it, the bound is at least 0. */
static inline int32_t wall_distance(const crn_model *model, crn_state *state, const crn_wall_view *view,
                                    int32_t far_m_q30, crn_lumen_voxel *voxel)
{
    const crn_lumen *lumen = model->lumen;
    const int32_t far = far_m_q30 + view->widen_m_q30; /* of the wall at rest */
    const int32_t rest = lumen->motion == NULL
                             ? crn_lumen_distance_unless_far(lumen, view->at_m_q30, far, voxel)
                             : crn_motion_distance(lumen, lumen->motion, &state->scratch.pose, view->at_m_q30,
                                                   state->scratch.wall_shrink_q30, far);
    /* Beyond a moving wall at rest, the distance may be too small; there, the node is sampled. */
    return lumen->motion != NULL && view->widen_m_q30 != 0 && rest >= 0
               ? far_m_q30
               : crn_sub_sat(rest, view->widen_m_q30);
}

/* A node is sampled only if it touched the wall in the last tick or is near the wall now. */
static inline bool may_touch(const crn_model *model, crn_state *state, const crn_node_state *node,
                             crn_work *work, const crn_line_node *line, const crn_wall_view *view,
                             crn_lumen_voxel *voxel)
{
    const bool placed = node->contact == CRN_CONTACT_NONE;
    if (placed) {
        int32_t far = -line->radius_m_q30 - (length_at_most(&work->drift_m_q33) >> 3) - ROUNDING_M_Q30;
        work->distance_m_q30 = wall_distance(model, state, view, far, voxel);
        if (work->distance_m_q30 < far) {
            return false;
        }
    }
    return sample(model, state, work, line, view, placed);
}

/* Returns the greater of a node's contact depths at the position x* and after the motion `drift_m_q33`. */
static int32_t worst_depth(const crn_vec3 *normal_q30, int32_t depth_m_q30, const crn_vec3 *drift_m_q33)
{
    const int32_t predicted = crn_sub_sat(depth_m_q30, along(drift_m_q33, normal_q30) >> 3);
    return predicted > depth_m_q30 ? predicted : depth_m_q30;
}

/* Of stent struts and wall, the surface in which a node is deeper becomes the node's first contact. The
 * shallower surface becomes the second contact if the node touches it, too. */
CRN_RARE static bool meet_struts(const crn_model *model, crn_state *state, crn_work *work,
                                 const crn_line_node *line, const crn_wall_view *view, bool is_at_wall)
{
    crn_lumen_sample struts;
    if (!crn_struts_here(model, state, view->at_m_q30, line->radius_m_q30, &struts)) {
        return is_at_wall;
    }
    const int32_t depth = crn_add_sat(struts.distance_m_q30, line->radius_m_q30);
    const crn_vec3 drift = work->drift_m_q33;
    const int32_t by_struts = worst_depth(&struts.normal_q30, depth, &drift);
    const int32_t by_wall =
        is_at_wall ? worst_depth(&work->normal_q30, work->depth_m_q30, &drift) : INT32_MIN;
    const uint32_t node = (uint32_t)(work - state->scratch.nodes);
    crn_second_contact second = {node, depth, stiffness_at(model, depth), struts.normal_q30};
    if (struts.distance_m_q30 > work->distance_m_q30) {
        work->distance_m_q30 = struts.distance_m_q30;
    }
    if (by_struts > by_wall) {
        second = (crn_second_contact){node, work->depth_m_q30, stiffness_at(model, work->depth_m_q30),
                                      work->normal_q30};
        work->normal_q30 = struts.normal_q30;
        work->depth_m_q30 = depth;
    }
    const int32_t less = by_struts > by_wall ? by_wall : by_struts;
    if (less > 0 && state->scratch.second_count < CRN_SECOND_MAX) {
        state->scratch.second[state->scratch.second_count] = second;
        work->touching = 2 + state->scratch.second_count++;
    }
    return true;
}

static inline void find_node(const crn_model *model, crn_state *state, crn_node_state *node, crn_work *work,
                             const crn_line_node *line, crn_lumen_voxel *voxel)
{
    crn_wall_view view;
    crn_wall_look(model, state, (uint32_t)(work - state->scratch.nodes), &work->position_m_q30, &view);
    bool is_near = may_touch(model, state, node, work, line, &view, voxel);
    if (state->words.struts.used != 0) {
        is_near = meet_struts(model, state, work, line, &view, is_near);
    }
    if (!is_near) {
        clear(node);
        return;
    }
    int32_t inwards = along(&work->drift_m_q33, &work->normal_q30);
    int32_t predicted = crn_sub_sat(work->depth_m_q30, inwards >> 3);
    if (work->depth_m_q30 <= 0 && predicted <= 0) {
        clear(node);
        return;
    }
    touch(model, state, node, work, line, predicted, &work->drift_m_q33, inwards);
}

/* If springs hold the tip (in a validation case), these springs take the place of a contact. */
static void hold_node(const crn_model *model, crn_state *state, uint32_t i, const crn_vec3 *anchor_m_q30)
{
    crn_work *work = &state->scratch.nodes[i];
    clear(&state->words.nodes[i]);
    work->touching = 0;
    work->normal_q30 = model->hold.axis_q30;
    work->wall_friction = CRN_HOLD_STIFFNESS_N_m << model->stiffness_exponent;
    work->wall_normal = model->hold.axial_free ? 0 : work->wall_friction;
    crn_vec3 miss = crn_vec3_sub(*anchor_m_q30, work->position_m_q30);
    if (model->hold.axial_free) {
        miss = tangential(&miss, &model->hold.axis_q30);
    }
    for (int k = 0; k < 3; k++) {
        /* Q30 m -> Q22 N */
        int64_t pull = ((int64_t)CRN_HOLD_STIFFNESS_N_m * miss.v[k]) >> 8;
        pull = pull > NORMAL_MAX_N_Q22 ? NORMAL_MAX_N_Q22
                                       : (pull < -NORMAL_MAX_N_Q22 ? -NORMAL_MAX_N_Q22 : pull);
        work->force_N_q22.v[k] = crn_sat32(work->force_N_q22.v[k] + pull);
    }
}

void crn_contact_find(const crn_model *model, crn_state *state)
{
    uint32_t na = state->words.free_count;
    crn_work *work = state->scratch.nodes;
    crn_node_state *node = state->words.nodes;
    const crn_line_node *line = state->line.nodes;
    state->scratch.outside_m_q30 = 0;
    state->scratch.second_count = 0;
    /* this includes the two held nodes: the solve reads past the last free one */
    for (uint32_t i = 0; i < na + 2; i++, work++, node++, line++) {
        work->touching = 0;
        work->wall_normal = 0;
        work->wall_friction = 0;
        work->tied = 0;
        if (model->lumen != NULL && i < na) {
            find_node(model, state, node, work, line, &state->voxels[i]);
        } else {
            clear(node);
        }
    }
    if (model->hold.pinned) {
        hold_node(model, state, 0, &model->hold.position_m_q30[0]);
    }
    if (model->hold.second > 0 && model->hold.second < na) {
        hold_node(model, state, model->hold.second, &model->hold.position_m_q30[1]);
    }
}

void crn_contact_forces(const crn_model *model, crn_state *state)
{
    crn_work *work = state->scratch.nodes;
    const crn_node_state *node = state->words.nodes;
    const crn_line_node *line = state->line.nodes;
    for (uint32_t i = 0; i < state->words.free_count; i++, work++, node++, line++) {
        if (work->touching) {
            push_node(model, node, work, line);
        }
    }
    for (uint32_t k = 0; k < state->scratch.second_count; k++) {
        push_second(state, &state->scratch.second[k]);
    }
}

/* Replaces the wall, or no contact, by struts where they are deeper at x*. */
CRN_RARE static bool or_struts(const crn_model *model, crn_state *state, crn_work *work,
                               const crn_line_node *line, const crn_wall_view *view, bool is_known)
{
    crn_lumen_sample struts;
    if (!crn_struts_here(model, state, view->at_m_q30, line->radius_m_q30, &struts) ||
        (is_known && struts.distance_m_q30 <= work->distance_m_q30)) {
        return is_known;
    }
    work->normal_q30 = struts.normal_q30;
    work->distance_m_q30 = struts.distance_m_q30;
    work->depth_m_q30 = crn_add_sat(struts.distance_m_q30, line->radius_m_q30);
    return true;
}

/* Returns whether node i ends deeper than 0.1 mm in the wall although no contact was found at the predicted
 * configuration. If a contact was missed, also returns the node's inward displacement. `reach` is twice the
 * largest component of the deviation, less the allowed depth of 0.1 mm. */
static inline bool was_missed(const crn_model *model, crn_state *state, uint32_t i, int32_t reach_m_q30,
                              int32_t *inwards_m_q33)
{
    crn_work *work = &state->scratch.nodes[i];
    const crn_line_node *line = &state->line.nodes[i];
    const bool held = work->touching || work->wall_friction != 0;
    if (held || work->distance_m_q30 < -line->radius_m_q30 - reach_m_q30) {
        return false;
    }
    crn_wall_view view;
    crn_wall_look(model, state, i, &work->position_m_q30, &view);
    bool is_known = sample(model, state, work, line, &view, false);
    if (state->words.struts.used != 0) {
        is_known = or_struts(model, state, work, line, &view, is_known);
    }
    if (!is_known) {
        return false;
    }
    *inwards_m_q33 = along(&work->solution_m_q33, &work->normal_q30);
    return crn_sub_sat(work->depth_m_q30, *inwards_m_q33 >> 3) > CRN_MISSED_CONTACT_M_Q30;
}

static inline int32_t reach_of(int32_t largest_m_q33)
{
    return 2 * (largest_m_q33 >> 3) + ROUNDING_M_Q30 - CRN_MISSED_CONTACT_M_Q30; /* sqrt(3) < 2 */
}

uint32_t crn_contact_missed(const crn_model *model, crn_state *state, int32_t largest_m_q33)
{
    uint32_t added = 0;
    const int32_t reach = reach_of(largest_m_q33);
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        crn_work *work = &state->scratch.nodes[i];
        const crn_node_state *node = &state->words.nodes[i];
        const crn_line_node *line = &state->line.nodes[i];
        int32_t inwards;
        if (was_missed(model, state, i, reach, &inwards)) {
            int32_t ended = crn_sub_sat(work->depth_m_q30, inwards >> 3);
            touch(model, state, node, work, line, ended, &work->solution_m_q33, inwards);
            push_node(model, node, work, line);
            added++;
        }
    }
    return added;
}

int32_t crn_contact_share(const crn_model *model, crn_state *state, int32_t largest_m_q33)
{
    int32_t share_q30 = CRN_ONE_Q30;
    const int32_t reach = reach_of(largest_m_q33);
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        int32_t inwards;
        if (!was_missed(model, state, i, reach, &inwards)) {
            continue;
        }
        /* a node that is deeper already was pushed in by a lesion or a strut and gets no deeper */
        const int32_t room = CRN_MISSED_CONTACT_M_Q30 - state->scratch.nodes[i].depth_m_q30;
        const int32_t share = room > 0 ? crn_quotient(room, -(inwards >> 3), 30) : 0;
        share_q30 = share < share_q30 ? share : share_q30;
    }
    return share_q30;
}

/* Adds the surface's displacement to the friction displacement (bristle) z and limits the sum to mu N / k_t,
 * the friction limit over the stiffness; within this limit the contact sticks. `inwards_m_q33` is the
 * deviation along the normal. */
static inline void move_bristle(const crn_state *state, crn_node_state *node, const crn_work *work,
                                const crn_line_node *line, int32_t depth_m_q30, int32_t inwards_m_q33)
{
    crn_vec3 way = without(&work->solution_m_q33, &work->normal_q30, inwards_m_q33);
    for (int k = 0; k < 3; k++) {
        way.v[k] += work->held_m_q33.v[k];
    }
    int32_t force = depth_m_q30 > 0 ? normal_force(depth_m_q30) : 0;
    if (work->touching > 1) {
        force = both_forces(state, work, force, &work->solution_m_q33);
    }
    int32_t most = bristle_limit(crn_scale_q30(force, friction_of(node, line)));
    int64_t square = crn_vec3_dot64(way, way);
    node->contact = CRN_CONTACT_STICKS;
    if (square > crn_product(most, most)) {
        unsigned half_lead;
        int32_t root = inverse_root(square, &half_lead);
        int32_t ratio_q30 =
            (int32_t)crn_asr64(crn_product(most, root), 32 - half_lead); /* limit / |z|, below 1 */
        const int64_t creeping = (int64_t)most + CRN_CREEP_M_Q33;
        node->contact = square > creeping * creeping ? CRN_CONTACT_SLIPS : CRN_CONTACT_CREEPS;
        for (int k = 0; k < 3; k++) {
            way.v[k] = crn_scale_q30(way.v[k], ratio_q30);
        }
    }
    node->bristle_m_q33 = way;
}

/* Adds the friction along the centreline, -k_t z, to the axial load of the tool that touches the wall.
 * Format: N/m x Q33 m -> Q22 N. */
static void charge_outer_tool(crn_state *state, const crn_node_state *node, const crn_line_node *line)
{
    int32_t way_m_q33 = along(&node->bristle_m_q33, &node->tangent_q30);
    int32_t drag_N_q22 = (int32_t)(((int64_t)way_m_q33 * -CRN_FRICTION_STIFFNESS_N_m) >> 11);
    int32_t outer = (int32_t)(((int64_t)drag_N_q22 * line->outer_share_q15) >> 15);
    int32_t *axial = state->scratch.axial_N_q22;
    axial[line->outer] = crn_add_sat(axial[line->outer], outer);
    axial[line->under] = crn_add_sat(axial[line->under], drag_N_q22 - outer);
}

void crn_contact_finish(const crn_model *model, crn_state *state, crn_output *output)
{
    output->contact_count = 0;
    output->penetration_max_m_q30 =
        state->scratch.outside_m_q30; /* no contact acts outside the field, so this is the deepest node */
    const crn_work *work = state->scratch.nodes;
    crn_node_state *node = state->words.nodes;
    const crn_line_node *line = state->line.nodes;
    for (uint32_t i = 0; i < state->words.free_count; i++, work++, node++, line++) {
        if (!work->touching) {
            continue;
        }
        int32_t deviation = along(&work->solution_m_q33, &work->normal_q30);
        int32_t depth = crn_sub_sat(work->depth_m_q30, deviation >> 3);
        move_bristle(state, node, work, line, depth, deviation);
        if (model->tool_count > 1) {
            charge_outer_tool(state, node, line);
        }
        output->contact_count++;
        if (depth > output->penetration_max_m_q30) {
            output->penetration_max_m_q30 = depth;
        }
    }
}

int32_t crn_contact_force(int32_t depth_m_q30)
{
    return normal_force(depth_m_q30);
}
