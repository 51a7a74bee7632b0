/* Wall contact and friction (docs/rod.md, "contact"). At the predicted configuration x*:
 *   depth = phi + r, n = inward normal; touching when depth > 0 or when the drift will make it so
 *   normal: k_n n n^T in the matrix, k_c depth (+ k_deep beyond 0.2 mm) along n on the right
 *   friction: bristle z with stiffness k_f = min(k_t, mu N / |z + u_t|) (lagged secant: true stick, no
 * chatter) After the solve z takes the tangential motion and is limited to mu N / k_t. May include: rod.h.
 * Called by: core_step.c. */
#include "firmware/core/rod.h"

enum { MARGIN_M_Q30 = SELD_LUMEN_CULL_ERROR_M_Q30 }; /* beyond the drift before the dear sample is skipped */

static int32_t magnitude_sum(const seld_vec3 *a)
{
    int64_t sum = 0;
    for (int k = 0; k < 3; k++) {
        sum += a->v[k] < 0 ? -(int64_t)a->v[k] : a->v[k];
    }
    return seld_sat32(sum);
}

/* Component along n. Format: Q33 . Q30 -> Q33. Overflow: impossible, displacements stay below 2^30 (125 mm). */
static int32_t along(const seld_vec3 *a, const seld_vec3 *n)
{
    return seld_vec3_dot_unit(a, n);
}

static seld_vec3 tangential(const seld_vec3 *a, const seld_vec3 *n)
{
    int32_t part = along(a, n);
    seld_vec3 t;
    for (int k = 0; k < 3; k++) {
        t.v[k] = a->v[k] - seld_scale_q30(part, n->v[k]);
    }
    return t;
}

/* Normal force of a depth: k_c d + k_deep max(0, d - 0.2 mm). Format: Q(a) N/m x Q30 m -> Q22 N; negative
 * depths give the linear part only (it closes the gap in the same solve). */
static int32_t normal_force(const seld_model *model, int32_t depth_m_q30)
{
    int64_t force = (int64_t)model->contact * depth_m_q30;
    if (depth_m_q30 > SELD_CONTACT_DEEP_M_Q30) {
        force += (int64_t)model->contact_deep * (depth_m_q30 - SELD_CONTACT_DEEP_M_Q30);
    }
    return seld_sat32(seld_rshift_round64(force, model->stiffness_exponent + 8));
}

/* 1 / |a| as reciprocal root and shift: 1/|a| = root_q30 2^(half_lead - 62). Returns false for a zero vector.
 */
static bool inverse_length(const seld_vec3 *a, int64_t *root_q30, unsigned *half_lead)
{
    uint64_t square = (uint64_t)seld_vec3_dot64(*a, *a);
    if (square == 0) {
        return false;
    }
    unsigned lead = (unsigned)__builtin_clzll(square) & ~1u;
    *root_q30 = seld_rsqrt_q30((uint32_t)((square << lead) >> 32));
    *half_lead = lead >> 1;
    return true;
}

static int32_t friction_of(const seld_model *model, uint32_t i, uint32_t contact)
{
    const seld_node *node = &model->nodes[i];
    return contact == SELD_CONTACT_SLIPS ? node->friction_kinetic_q30 : node->friction_static_q30;
}

/* k_f in Q(a): mu N / |z + u_t|, at most k_t. Format: N Q22 / m Q33 -> Q(a): N root 2^(half_lead - 62) 2^(11
 * + a). */
static int32_t friction_stiffness(const seld_model *model, int32_t limit_N_q22, const seld_vec3 *reach_m_q33)
{
    int64_t root;
    unsigned half_lead;
    if (!inverse_length(reach_m_q33, &root, &half_lead)) {
        return model->friction;
    }
    unsigned shift = 51 - model->stiffness_exponent - half_lead;
    int64_t stiffness = seld_asr64((int64_t)limit_N_q22 * root, shift);
    return stiffness > model->friction ? model->friction : (int32_t)stiffness;
}

static void wall_matrix(seld_work *work, int32_t normal, int32_t friction)
{
    static const uint8_t row[6] = {0, 0, 0, 1, 1, 2};
    static const uint8_t column[6] = {0, 1, 2, 1, 2, 2};
    seld_vec3 scaled;
    for (int k = 0; k < 3; k++) {
        scaled.v[k] = seld_scale_q30(normal - friction, work->normal_q30.v[k]);
    }
    for (int k = 0; k < 6; k++) {
        work->wall.m[k] = seld_scale_q30(scaled.v[row[k]], work->normal_q30.v[column[k]]);
    }
    work->wall.m[0] += friction;
    work->wall.m[3] += friction;
    work->wall.m[5] += friction;
}

/* Right side of contact and friction in newtons Q22. */
static void wall_force(const seld_model *model, seld_work *work, const seld_vec3 *bristle_and_slide,
                       int32_t friction)
{
    int32_t push = normal_force(model, work->depth_m_q30);
    for (int k = 0; k < 3; k++) {
        int64_t drag =
            seld_rshift_round64((int64_t)friction * bristle_and_slide->v[k], model->stiffness_exponent + 11);
        work->force_N_q22.v[k] =
            seld_sat32(work->force_N_q22.v[k] + seld_mul_q30(push, work->normal_q30.v[k]) - drag);
    }
}

/* Contact of node i with `predicted` depth after the expected motion. */
static void touch(const seld_model *model, seld_state *state, uint32_t i, int32_t predicted_m_q30)
{
    seld_work *work = &state->scratch.nodes[i];
    seld_node_state *node = &state->words.nodes[i];
    const seld_vec3 *n = &work->normal_q30;
    int32_t force = predicted_m_q30 > 0 ? normal_force(model, predicted_m_q30) : 0;
    int32_t limit = seld_mul_q30(force, friction_of(model, i, node->contact));
    seld_vec3 held = seld_vec3_add(node->bristle_m_q33, work->slide_m_q33);
    held = tangential(&held, n);
    seld_vec3 drift = tangential(&work->drift_m_q33, n);
    seld_vec3 reach = seld_vec3_add(held, drift);
    int32_t friction = friction_stiffness(model, limit, &reach);
    int32_t normal = model->contact + (work->depth_m_q30 > SELD_CONTACT_DEEP_M_Q30 ? model->contact_deep : 0);
    wall_matrix(work, normal, friction);
    wall_force(model, work, &held, friction);
    work->touching = 1;
}

/* Depth and normal at x*; false when the field has no gradient there. */
static bool sample(const seld_model *model, seld_work *work, uint32_t i)
{
    seld_lumen_sample wall = seld_lumen_contact(model->lumen, &work->position_m_q30);
    work->depth_m_q30 = seld_add_sat(wall.distance_m_q30, model->nodes[i].radius_m_q30);
    work->normal_q30 = wall.normal_q30;
    return (wall.normal_q30.v[0] | wall.normal_q30.v[1] | wall.normal_q30.v[2]) != 0;
}

static void clear(seld_node_state *node)
{
    node->bristle_m_q33 = (seld_vec3){{0, 0, 0}};
    node->contact = SELD_CONTACT_NONE;
}

static void assemble_node(const seld_model *model, seld_state *state, uint32_t i)
{
    seld_work *work = &state->scratch.nodes[i];
    work->distance_m_q30 = seld_lumen_distance(model->lumen, &work->position_m_q30);
    int32_t reach = (magnitude_sum(&work->drift_m_q33) >> 3) + MARGIN_M_Q30;
    if (work->distance_m_q30 < -model->nodes[i].radius_m_q30 - reach || !sample(model, work, i)) {
        clear(&state->words.nodes[i]);
        return;
    }
    int32_t predicted = seld_sub_sat(work->depth_m_q30, along(&work->drift_m_q33, &work->normal_q30) >> 3);
    if (work->depth_m_q30 <= 0 && predicted <= 0) {
        clear(&state->words.nodes[i]);
        return;
    }
    touch(model, state, i, predicted);
}

void seld_contact_assemble(const seld_model *model, seld_state *state)
{
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        seld_work *work = &state->scratch.nodes[i];
        work->touching = 0;
        work->wall = (seld_sym3){{0, 0, 0, 0, 0, 0}};
        if (model->lumen != NULL) {
            assemble_node(model, state, i);
        } else {
            clear(&state->words.nodes[i]);
        }
    }
}

uint32_t seld_contact_missed(const seld_model *model, seld_state *state, int32_t largest_m_q33)
{
    if (model->lumen == NULL) {
        return 0;
    }
    uint32_t added = 0;
    int32_t reach = 2 * (largest_m_q33 >> 3) + MARGIN_M_Q30 - SELD_MISSED_CONTACT_M_Q30; /* sqrt(3) < 2 */
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        seld_work *work = &state->scratch.nodes[i];
        if (work->touching || work->distance_m_q30 < -model->nodes[i].radius_m_q30 - reach ||
            !sample(model, work, i)) {
            continue;
        }
        int32_t ended = seld_sub_sat(work->depth_m_q30, along(&work->solution_m_q33, &work->normal_q30) >> 3);
        if (ended > SELD_MISSED_CONTACT_M_Q30) {
            touch(model, state, i, ended);
            added++;
        }
    }
    return added;
}

/* z + u_t limited to mu N / k_t; sticks when it was not limited. */
static void move_bristle(const seld_model *model, seld_state *state, uint32_t i, int32_t depth_m_q30)
{
    seld_node_state *node = &state->words.nodes[i];
    seld_work *work = &state->scratch.nodes[i];
    seld_vec3 moved = seld_vec3_add(work->solution_m_q33, work->slide_m_q33);
    moved = seld_vec3_add(moved, node->bristle_m_q33);
    moved = tangential(&moved, &work->normal_q30);
    int32_t force = depth_m_q30 > 0 ? normal_force(model, depth_m_q30) : 0;
    int32_t limit_N_q22 = seld_mul_q30(force, friction_of(model, i, node->contact));
    /* mu N / k_t in m Q33: 2^11 / 2000 = 1 + 25166 / 2^20 */
    int64_t limit_m_q33 = limit_N_q22 + (((int64_t)limit_N_q22 * 25166) >> 20);
    int64_t root;
    unsigned half_lead;
    node->contact = SELD_CONTACT_STICKS;
    if (inverse_length(&moved, &root, &half_lead)) {
        /* ratio = limit / |z| in Q30 */
        int64_t ratio = seld_asr64(limit_m_q33 * root, 32 - half_lead);
        if (ratio < SELD_ONE_Q30) {
            node->contact = SELD_CONTACT_SLIPS;
            for (int k = 0; k < 3; k++) {
                moved.v[k] = seld_mul_q30(moved.v[k], (int32_t)ratio);
            }
        }
    }
    node->bristle_m_q33 = moved;
}

void seld_contact_finish(const seld_model *model, seld_state *state, seld_output *output)
{
    output->contact_count = 0;
    output->penetration_max_m_q30 = 0;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        seld_work *work = &state->scratch.nodes[i];
        if (!work->touching) {
            continue;
        }
        int32_t depth = seld_sub_sat(work->depth_m_q30, along(&work->solution_m_q33, &work->normal_q30) >> 3);
        move_bristle(model, state, i, depth);
        output->contact_count++;
        if (depth > output->penetration_max_m_q30) {
            output->penetration_max_m_q30 = depth;
        }
    }
}
