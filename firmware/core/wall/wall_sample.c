/* This file samples the vessel wall, and computes the force of a contact, for callers outside a tick. */
#include "firmware/core/lesion.h"
#include "firmware/core/rod.h"

/* Samples the wall at the moment of the given state; the function sets the vessel's pose to that moment. */
static crn_lumen_sample wall_now(const crn_model *model, const crn_state *state, crn_motion_pose *pose,
                                 const crn_vec3 *position_m_q30)
{
    crn_lumen_sample open;
    if (model->lumen->motion != NULL) {
        crn_motion_pose_begin(model->lumen->motion, pose, &state->words.rhythm, &state->words.rhythm);
    }
    if (state->words.lesions.bits != 0 &&
        crn_lesion_wall(model, &state->words, pose, position_m_q30, &open)) {
        return open;
    }
    if (model->lumen->motion == NULL) {
        return crn_lumen_contact(model->lumen, position_m_q30);
    }
    return crn_motion_contact(model->lumen, model->lumen->motion, pose, position_m_q30);
}

crn_lumen_sample crn_wall_sample(const crn_model *model, const crn_state *state,
                                 const crn_vec3 *position_m_q30)
{
    crn_motion_pose pose;
    return wall_now(model, state, &pose, position_m_q30);
}

/* Samples the wall at a node at the moment of the given state, with the way that the wall has given there.
 * *view receives where the wall at rest is looked at. */
static crn_lumen_sample wall_at_node(const crn_model *model, const crn_state *state, uint32_t node,
                                     crn_motion_pose *pose, crn_wall_view *view)
{
    crn_wall_look(model, state, node, &state->words.nodes[node].position_m_q30, view);
    crn_lumen_sample wall = wall_now(model, state, pose, view->at_m_q30);
    wall.distance_m_q30 = crn_sub_sat(wall.distance_m_q30, view->widen_m_q30);
    return wall;
}

crn_lumen_sample crn_wall_sample_at_node(const crn_model *model, const crn_state *state, uint32_t node)
{
    crn_motion_pose pose;
    crn_wall_view view;
    return wall_at_node(model, state, node, &pose, &view);
}

static void add_push(const crn_lumen_sample *what, int32_t radius_m_q30, crn_vec3 *force_N_q22)
{
    const int32_t depth = crn_add_sat(what->distance_m_q30, radius_m_q30);
    const int32_t push = depth > 0 ? crn_contact_force(depth) : 0;
    for (int k = 0; k < 3; k++) {
        force_N_q22->v[k] = crn_add_sat(force_N_q22->v[k], crn_mul_q30(push, what->normal_q30.v[k]));
    }
}

bool crn_state_contact_force(const crn_model *model, const crn_state *state, uint32_t node,
                             crn_vec3 *force_N_q22)
{
    *force_N_q22 = (crn_vec3){{0, 0, 0}};
    if (model->lumen == NULL || node >= state->words.free_count ||
        state->words.nodes[node].contact == CRN_CONTACT_NONE) {
        return false;
    }
    const crn_node_state *n = &state->words.nodes[node];
    const int32_t radius = state->line.nodes[node].radius_m_q30;
    crn_motion_pose pose;
    crn_wall_view view;
    crn_lumen_sample struts, wall = wall_at_node(model, state, node, &pose, &view);
    add_push(&wall, radius, force_N_q22);
    if (state->words.struts.used != 0 &&
        crn_struts_wall(model, &state->words, &pose, view.at_m_q30, radius, &struts)) {
        add_push(&struts, radius, force_N_q22);
    }
    for (int k = 0; k < 3; k++) {
        int64_t drag = ((int64_t)n->bristle_m_q33.v[k] * CRN_FRICTION_STIFFNESS_N_m) >> 11;
        force_N_q22->v[k] = crn_sat32(force_N_q22->v[k] - drag);
    }
    return true;
}
