/* This file computes the part of a tool's bend that does not spring back: the permanent set of a metal that
 * yields, and the transformed part of superelastic nitinol (docs/rod.md, "materials").
 *
 * A tool has one set for each of the cells that the mesh has when this tool leads, so the set stays with the
 * material while the tool slides inside others. The set is a rest rotation towards the material axes d1 and
 * d2. It adds to the rotation of the tool's rest shape. With the elastic rotation e = b - rest - set (b: bend
 * of the cell), the curvature at yield k_y, the cell's length l and the slope g of the hardening:
 *
 *     metal      x = e - g set; if |x| > k_y l, the set grows by (|x| - k_y l) / (1 + g) along x
 *     nitinol    forward: if |e| > k_y l + g |set|, the set grows by the excess / (1 + g) along e, up to its
 *                limit; back: if e along the set is below r k_y l + g |set|, the set shrinks by the lack /
 *                (1 + g), at most to 0
 *
 * The elastic moment EI e / l is thus k_y EI at the beginning of the plateau, and r k_y EI at the end of the
 * way back. The set follows the predicted configuration of a tick and acts from the next tick on. A closed
 * loop of bends never gives energy back, so the law is stable for any stiffness. */
#include "firmware/core/rod.h"

enum { SET_MAX_Q29 = 720000000 }; /* 1.34, a turn of 68 degrees in one cell: the limit of a rest rotation */

/* Returns the number of cells of a tool that can have a set. */
static uint32_t cell_count(const crn_model *model)
{
    return model->node_count < CRN_SET_CELL_MAX ? model->node_count : CRN_SET_CELL_MAX;
}

/* Returns whether a tool that can have sets is at a position of the line. */
static bool can_yield(const crn_model *model, const crn_state_words *words, uint32_t k)
{
    return crn_has_tool(words, k) && crn_tool_on(model, k)->material.kind != CRN_ELASTIC;
}

/* --- the set in the joints ------------------------------------------------------------------------------ */

/* Returns the set of a tool between two of its own arc lengths. *cell is the first cell that reaches beyond
 * `from`. */
static crn_set set_between(const crn_model *model, const crn_set *cells, int32_t from, int32_t to,
                           uint32_t *cell)
{
    const uint32_t count = cell_count(model);
    crn_set sum = {{0, 0}};
    while (*cell < count && model->mesh[*cell].cell_end_m_q30 <= from) {
        (*cell)++;
    }
    for (uint32_t i = *cell; i < count && crn_cell_begin(model, i) < to; i++) {
        const int32_t begin = crn_cell_begin(model, i), end = model->mesh[i].cell_end_m_q30;
        const crn_set set = cells[i];
        if ((set.turn_q29[0] | set.turn_q29[1]) == 0) {
            continue;
        }
        const int32_t overlap = (to < end ? to : end) - (from > begin ? from : begin);
        const bool is_whole = overlap == end - begin;
        const int32_t part_q30 = is_whole ? CRN_ONE_Q30 : crn_quotient(overlap, end - begin, 30);
        for (int c = 0; c < 2; c++) {
            sum.turn_q29[c] = crn_add_sat(sum.turn_q29[c], crn_scale_q30(set.turn_q29[c], part_q30));
        }
    }
    return sum;
}

/* Returns the part that a tool has in the bending stiffness of a joint, Q15. */
static int32_t share_q15(const crn_model *model, const crn_joint *joint, uint32_t k)
{
    const int32_t upto = k + 1 < model->tool_count ? joint->inner_share_q15[k] : 1 << 15;
    return upto - (k > 0 ? joint->inner_share_q15[k - 1] : 0);
}

static void put_set(crn_joint *joint, uint32_t k, crn_set set, int32_t share)
{
    for (int c = 0; c < 2; c++) {
        const int32_t part = crn_sat32(crn_rshift_round64(crn_product(set.turn_q29[c], share), 30));
        joint->set_q14[k][c] = (int16_t)crn_clamp(part, -(SET_MAX_Q29 >> 15), SET_MAX_Q29 >> 15);
    }
    const bool is_curved =
        (joint->turn1_q30[k] | joint->turn2_q30[k] | joint->set_q14[k][0] | joint->set_q14[k][1]) != 0;
    joint->curved = (joint->curved & ~(1u << k)) | (uint32_t)is_curved << k;
}

/* The joints of a tool with a material get their sets anew in every tick, also those behind the sheath's end
 * that an edge's frame looks at: nothing of an earlier tick may stay in them, because a restored state has
 * only the saved words. */
void crn_set_apply(const crn_model *model, crn_state *state)
{
    for (uint32_t k = 0; k < model->tool_count; k++) {
        if (!can_yield(model, &state->words, k)) {
            continue;
        }
        const int32_t offset = state->line.offset_m_q30[k];
        uint32_t cell = 0;
        for (uint32_t i = 1; i <= state->words.free_count + 1; i++) {
            crn_joint *joint = &state->line.nodes[i].joint;
            const int32_t from = crn_sub_sat(crn_cell_begin(model, i), offset);
            const int32_t to = crn_sub_sat(model->mesh[i].cell_end_m_q30, offset);
            crn_set set = {{0, 0}};
            if (to > 0) {
                set = set_between(model, state->words.set.cells[k], from > 0 ? from : 0, to, &cell);
            }
            put_set(joint, k, set, share_q15(model, joint, k));
        }
    }
}

void crn_set_curvature(const crn_model *model, const crn_state_words *words, uint32_t k, int32_t arc_m_q30,
                       int32_t per_m_q20[2])
{
    const uint32_t count = cell_count(model);
    uint32_t i = 0;
    per_m_q20[0] = 0;
    per_m_q20[1] = 0;
    while (i < count && model->mesh[i].cell_end_m_q30 <= arc_m_q30) {
        i++;
    }
    if (i == count) {
        return;
    }
    const crn_set set = words->set.cells[k][i];
    for (int c = 0; c < 2; c++) {
        /* Q29 x Q18 1/m -> Q20 */
        per_m_q20[c] = crn_mul(set.turn_q29[c], model->mesh[i].inverse_cell_per_m_q18, 27);
    }
}

/* --- the change of the set ------------------------------------------------------------------------------ */

/* Returns 2^(-1/4) EI^(-1/4), Q20. The first root of EI is an inverse one: with EI = x 2^-35 and an even n of
 * leading zeros, EI^(-1/2) = root 2^(n/2 - 28.5). Overflow is impossible: EI is at least 1e-7 N m^2, so n is
 * at most 20, and the root of the result below 2^52. */
static int32_t inverse_fourth_root_q20(int32_t bend_N_m2_q35)
{
    const unsigned lead = (unsigned)__builtin_clz((uint32_t)bend_N_m2_q35) & ~1u;
    const uint64_t root = (uint64_t)(uint32_t)crn_rsqrt_q30((uint32_t)bend_N_m2_q35 << lead);
    return crn_root_of(root << (lead / 2 + 11));
}

/* Returns the rotation at which a cell of the given length yields, in Q29, at a tool's own arc length.
 * Format: Q20 1/m x Q30 m -> Q29. Overflow: saturates. */
static int32_t yield_of(const crn_tool *tool, const crn_span *span, int32_t arc_m_q30, int32_t length_m_q30)
{
    const int32_t bend = crn_span_value(span, CRN_BEND_N_M2_Q35, crn_span_fraction(span, arc_m_q30));
    const int32_t per_m_q20 = crn_mul(tool->material.yield_q20, inverse_fourth_root_q20(bend), 20);
    return crn_mul(per_m_q20, length_m_q30, 21);
}

void crn_set_mark(const crn_model *model, crn_state *state)
{
    for (uint32_t k = 0; k < model->tool_count; k++) {
        const crn_tool *tool = crn_tool_on(model, k);
        uint32_t span = 0;
        if (!can_yield(model, &state->words, k)) {
            continue;
        }
        for (uint32_t i = 1; i + 1 < state->words.free_count; i++) {
            crn_joint *joint = &state->line.nodes[i].joint;
            const int32_t arc = model->mesh[i].arc_m_q30 - state->line.offset_m_q30[k];
            if (arc <= 0 || arc >= model->mesh[cell_count(model) - 1].cell_end_m_q30 ||
                (joint->curved >> k & 1u) != 0) {
                continue;
            }
            crn_span_seek(tool, &span, arc);
            const int32_t yield = yield_of(tool, &tool->spans[span], arc,
                                           model->mesh[i].cell_end_m_q30 - crn_cell_begin(model, i));
            const crn_vec3 bend = crn_joint_bend(state, i);
            if (crn_vec3_dot64(bend, bend) > crn_product(yield, yield)) {
                joint->curved |= 1u << k;
            }
        }
    }
}

/* Returns the bend of joint i towards the axes d1 and d2 of tool k, the mean of those of the joint's edges.
 */
static crn_set bend_of(const crn_state *state, uint32_t k, uint32_t i)
{
    const crn_vec3 bend = crn_joint_bend(state, i);
    crn_set sum = {{0, 0}};
    for (uint32_t edge = i - 1; edge <= i; edge++) {
        const crn_vec3 *axis1 = &state->scratch.nodes[edge].u.a.axis1_q30[k];
        const crn_vec3 axis2 = crn_vec3_cross_unit(&state->words.nodes[edge].tangent_q30, axis1);
        sum.turn_q29[0] += (int32_t)(crn_vec3_dot64(bend, *axis1) >> 31);
        sum.turn_q29[1] += (int32_t)(crn_vec3_dot64(bend, axis2) >> 31);
    }
    return sum;
}

static int32_t size_of(crn_set a)
{
    /* within 2 rad, so that the sum fits crn_root_of() */
    const int32_t x = crn_clamp(a.turn_q29[0], -(1 << 30), 1 << 30),
                  y = crn_clamp(a.turn_q29[1], -(1 << 30), 1 << 30);
    return crn_root_of((uint64_t)(crn_product(x, x) + crn_product(y, y)));
}

/* Adds `amount` along the direction of a vector of the given length, which is not 0. */
static void add_along(crn_set *sum, crn_set direction, int32_t size, int32_t amount)
{
    for (int c = 0; c < 2; c++) {
        const int32_t part_q30 = crn_quotient(direction.turn_q29[c], size, 30);
        sum->turn_q29[c] = crn_add_sat(sum->turn_q29[c], crn_mul_q30(part_q30, amount));
    }
}

/* Makes a vector as long as `most`, if it is longer. */
static void shorten(crn_set *a, int32_t most)
{
    const int32_t size = size_of(*a);
    if (size > most) {
        const int32_t part_q30 = crn_quotient(most, size, 30);
        a->turn_q29[0] = crn_mul_q30(a->turn_q29[0], part_q30);
        a->turn_q29[1] = crn_mul_q30(a->turn_q29[1], part_q30);
    }
}

/* The set of a metal after the cell bends elastically by `elastic`, with kinematic hardening. */
static void yield_metal(const crn_material_law *law, crn_set elastic, int32_t yield, crn_set *set)
{
    crn_set beyond = elastic;
    for (int c = 0; c < 2; c++) {
        beyond.turn_q29[c] = crn_sub_sat(elastic.turn_q29[c], crn_mul(law->slope_q24, set->turn_q29[c], 24));
    }
    const int32_t size = size_of(beyond);
    if (size > yield) {
        add_along(set, beyond, size, crn_mul_q30(size - yield, law->follow_q30));
    }
}

/* The transformed part of a superelastic tool. */
static void transform(const crn_material_law *law, crn_set elastic, int32_t yield, crn_set *set)
{
    const int32_t before = size_of(*set);
    const int32_t hardened = crn_mul(law->slope_q24, before, 24);
    const int32_t size = size_of(elastic);
    const int32_t most = crn_mul(law->limit_q20, yield, 20);
    const int32_t begin = crn_add_sat(yield, hardened);
    if (size > begin) {
        add_along(set, elastic, size, crn_mul_q30(size - begin, law->follow_q30));
        shorten(set, before > most ? before : most);
        return;
    }
    if (before == 0) {
        return;
    }
    const int64_t along_q58 = crn_product(elastic.turn_q29[0], set->turn_q29[0]) +
                              crn_product(elastic.turn_q29[1], set->turn_q29[1]);
    const int32_t along = crn_quotient(crn_sat32(crn_asr64(along_q58, 29)), before, 29);
    const int32_t lack = crn_sub_sat(crn_add_sat(crn_mul_q30(law->unload_q30, yield), hardened), along);
    if (lack > 0) {
        const int32_t less = crn_mul_q30(lack, law->follow_q30);
        shorten(set, before > less ? before - less : 0);
    }
}

/* The rest rotation of a tool between two of its own arc lengths, without its set, as far as it is released.
 * It is the integral over the spans, as in the joint: where the curvature has a step within a cell, a single
 * point of the cell would make it yield for ever. */
static crn_set rest_of(const crn_state *state, const crn_tool *tool, int32_t from, int32_t to)
{
    const crn_stretch part = crn_tool_integrate(tool, 0, from, to);
    const int64_t turn_q30[2] = {part.turn1_q30, part.turn2_q30};
    crn_set rest;
    for (int c = 0; c < 2; c++) {
        rest.turn_q29[c] = crn_scale_q30(crn_rest_turn_of(crn_limit_turn(crn_sat32(turn_q30[c]))),
                                         state->words.release_q30) /
                           2;
    }
    return rest;
}

/* Follows the set of one cell of tool k. Joint i bends as this cell, or is the one where it lies. */
static void follow_cell(const crn_model *model, crn_state *state, uint32_t k, uint32_t cell, uint32_t i,
                        const crn_span *span)
{
    crn_set *kept = &state->words.set.cells[k][cell];
    const int32_t length = model->mesh[cell].cell_end_m_q30 - crn_cell_begin(model, cell);
    const int32_t arc = model->mesh[cell].arc_m_q30;
    const int32_t yield = yield_of(crn_tool_on(model, k), span, arc, length);
    const crn_set rest =
        rest_of(state, crn_tool_on(model, k), crn_cell_begin(model, cell), model->mesh[cell].cell_end_m_q30);
    crn_set set = *kept;
    crn_set elastic = bend_of(state, k, i);
    const int32_t there = model->mesh[i].cell_end_m_q30 - crn_cell_begin(model, i);
    for (int c = 0; c < 2; c++) {
        int32_t bend = elastic.turn_q29[c];
        bend = there == length ? bend : crn_mul(bend, crn_quotient(length, there, 24), 24);
        elastic.turn_q29[c] = crn_sub_sat(crn_sub_sat(bend, rest.turn_q29[c]), set.turn_q29[c]);
    }
    const crn_material_law *law = &crn_tool_on(model, k)->material;
    if (law->kind == CRN_PLASTIC) {
        yield_metal(law, elastic, yield, &set);
    } else {
        transform(law, elastic, yield, &set);
    }
    shorten(&set, SET_MAX_Q29);
    *kept = set;
    state->words.set.used_bits |= (uint32_t)((set.turn_q29[0] | set.turn_q29[1]) != 0) << k;
}

void crn_set_follow(const crn_model *model, crn_state *state)
{
    for (uint32_t k = 0; k < model->tool_count; k++) {
        const crn_tool *tool = crn_tool_on(model, k);
        if (!can_yield(model, &state->words, k)) {
            continue;
        }
        uint32_t span = 0;
        uint32_t i = 1;
        for (uint32_t cell = 1; cell < cell_count(model); cell++) {
            const int32_t arc = model->mesh[cell].arc_m_q30;
            const int32_t there = crn_add_sat(arc, state->line.offset_m_q30[k]);
            while (i < state->words.free_count && model->mesh[i].cell_end_m_q30 <= there) {
                i++;
            }
            if (i + 1 >= state->words.free_count || arc > tool->length_m_q30) {
                break;
            }
            crn_span_seek(tool, &span, arc);
            if ((state->line.nodes[i].joint.curved >> k & 1u) != 0) {
                follow_cell(model, state, k, cell, i, &tool->spans[span]);
            }
        }
    }
}

void crn_set_forget(crn_state_words *words, uint32_t position)
{
    for (uint32_t i = 0; i < CRN_SET_CELL_MAX; i++) {
        words->set.cells[position][i] = (crn_set){{0, 0}};
    }
    words->set.used_bits &= ~(1u << position);
}

bool crn_set_is_valid(const crn_model *model, const crn_state_words *words)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const uint32_t number = k < model->tool_count ? words->exchange.line[k] : 0;
        const bool yields = number != 0 && model->table[number - 1].tool.material.kind != CRN_ELASTIC;
        if (!yields && (words->set.used_bits >> k & 1u) != 0) {
            return false;
        }
        int32_t any = 0;
        for (uint32_t i = 0; i < CRN_SET_CELL_MAX; i++) {
            for (int c = 0; c < 2; c++) {
                const int32_t part = words->set.cells[k][i].turn_q29[c];
                any |= part;
                if (part > SET_MAX_Q29 || part < -SET_MAX_Q29) {
                    return false;
                }
            }
        }
        if (any != 0 && (words->set.used_bits >> k & 1u) == 0) {
            return false;
        }
    }
    return words->set.used_bits >> CRN_TOOL_MAX == 0;
}
