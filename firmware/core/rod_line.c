/* This file combines the tools at their present positions into one set of joints, edges, masses and surfaces
 * (docs/rod.md, "tools").
 *
 * Node i lies at arc length S behind the leading tip, where tool k is at its own arc length S - offset(k).
 * Within a node's cell (half an edge to either side of the node), the code averages the compliance, not the
 * stiffness ("series"). Averaging the stiffness itself, across a tool's tip or an abrupt change of stiffness,
 * would give force spikes at the handle.
 *   1/W = integral ds / EI,  EI = sum EI_k;   turn_k = integral (EI_k / EI) kappa_k ds
 * A node's cell that contains a tool's tip is summed piece by piece, so all values change smoothly as the
 * tools slide. */
#include "firmware/core/rod.h"

enum {
    TWIST_MAX_N_m_Q26 = CRN_TWIST_MAX_N_m << 26
}; /* limit for one joint; two of them fit a pivot (rod_twist.c) */

/* The state of one pass along the mesh: the span (part between two knots) of each tool at the present cell.
 */
typedef struct walk {
    const crn_model *model;
    crn_line *line;
    uint32_t span[CRN_TOOL_MAX];
} walk;

typedef struct cell {
    int32_t begin, end; /* Q30 m behind the leading tip */
} cell;

static int32_t turn_of(int32_t per_m_q20, int32_t length_m_q30)
{
    return crn_mul(per_m_q20, length_m_q30, 20);
}

/* Returns the integrals of a tool's properties between two of its own arc lengths. For the part of the tool
 * that lies in one span, the code uses the property's value in the middle of this part. */
crn_stretch crn_tool_integrate(const crn_tool *tool, uint32_t span, int32_t from, int32_t to)
{
    crn_stretch sum = {0, 0, 0, 0};
    crn_span_seek(tool, &span, from);
    while (from < to) {
        const crn_span *s = &tool->spans[span];
        bool last = span + 1 == tool->span_count || to <= s->end_m_q30;
        int32_t until = last ? to : s->end_m_q30;
        int32_t fraction = crn_span_fraction(s, from + (until - from) / 2);
        sum.bend_q32 += crn_compliance_q32(until - from, crn_span_value(s, CRN_BEND_N_M2_Q35, fraction));
        sum.twist_q32 += crn_compliance_q32(until - from, crn_span_value(s, CRN_TWIST_N_M2_Q35, fraction));
        sum.turn1_q30 += turn_of(crn_span_value(s, CRN_CURVE1_PER_M_Q20, fraction), until - from);
        sum.turn2_q30 += turn_of(crn_span_value(s, CRN_CURVE2_PER_M_Q20, fraction), until - from);
        from = until;
        span++;
    }
    return sum;
}

/* Computes, for each pair of neighbouring tools, the fraction (in Q15) of the joint's bending stiffness that
 * belongs to the inner tools. Q15. */
static void share_stiffness(const walk *w, const int32_t own_q26[CRN_TOOL_MAX], crn_joint *joint)
{
    if (w->model->tool_count < 2) {
        return;
    }
    unsigned lead = crn_clz32((uint32_t)joint->bend_N_m_q26) - 1;
    int64_t inverse = crn_reciprocal_q30((uint32_t)joint->bend_N_m_q26 << lead);
    int32_t inner_q26 = 0;
    for (uint32_t pair = 0; pair + 1 < w->model->tool_count; pair++) {
        inner_q26 = crn_add_sat(inner_q26, own_q26[pair]);
        bool all = inner_q26 >= joint->bend_N_m_q26;
        joint->inner_share_q15[pair] =
            (uint16_t)(all ? 1 << 15 : crn_rshift_round64(inner_q26 * inverse, 46 - lead));
    }
}

/* --- cells that no tip divides -------------------------------------------------------------------------- */

/* Evaluates tool k over the whole cell of a node: its own bending stiffness W, its twist stiffness and its
 * rest rotations. */
static int32_t whole_cell(walk *w, uint32_t k, const crn_mesh_node *mesh, cell c, crn_joint *joint)
{
    const crn_tool *tool = crn_tool_on(w->model, k);
    int32_t from = c.begin - w->line->offset_m_q30[k];
    int32_t to = c.end - w->line->offset_m_q30[k];
    crn_span_seek(tool, &w->span[k], from);
    const crn_span *s = &tool->spans[w->span[k]];
    if (to <= s->end_m_q30 || w->span[k] + 1 == tool->span_count) {
        int32_t fraction = s->flat ? 0 : crn_span_fraction(s, from + (to - from) / 2);
        int32_t inverse = mesh->inverse_cell_per_m_q18;
        joint->twist_N_m_q26[k] = crn_mul(crn_span_value(s, CRN_TWIST_N_M2_Q35, fraction), inverse, 27);
        joint->turn1_q30[k] = turn_of(crn_span_value(s, CRN_CURVE1_PER_M_Q20, fraction), to - from);
        joint->turn2_q30[k] = turn_of(crn_span_value(s, CRN_CURVE2_PER_M_Q20, fraction), to - from);
        return crn_mul(crn_span_value(s, CRN_BEND_N_M2_Q35, fraction), inverse, 27);
    }
    crn_stretch sum = crn_tool_integrate(tool, w->span[k], from, to);
    joint->twist_N_m_q26[k] = crn_inverse_of(sum.twist_q32, 58);
    joint->turn1_q30[k] = crn_sat32(sum.turn1_q30);
    joint->turn2_q30[k] = crn_sat32(sum.turn2_q30);
    return crn_inverse_of(sum.bend_q32, 58);
}

/* --- cells that one or more tips divide ----------------------------------------------------------------- */

/* Adds the integrals over the piece [from, to] of a node's cell; no tool begins or ends within the piece. */
static void add_piece(walk *w, int32_t from, int32_t to, crn_stretch sums[CRN_TOOL_MAX], int64_t *compliance)
{
    crn_stretch part[CRN_TOOL_MAX] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
    int32_t stiffness_q35[CRN_TOOL_MAX];
    int32_t total_q35 = 0;
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        int32_t offset = w->line->offset_m_q30[k];
        stiffness_q35[k] = 0;
        if (offset > from) {
            continue;
        }
        part[k] = crn_tool_integrate(crn_tool_on(w->model, k), w->span[k], from - offset, to - offset);
        stiffness_q35[k] = crn_series_stiffness_q35(to - from, part[k].bend_q32);
        total_q35 = crn_add_sat(total_q35, stiffness_q35[k]);
    }
    *compliance += crn_compliance_q32(to - from, total_q35 < 1 << 11 ? 1 << 11 : total_q35);
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        if (stiffness_q35[k] == 0) {
            continue;
        }
        int32_t share = crn_quotient(stiffness_q35[k], total_q35, 30);
        sums[k].twist_q32 += part[k].twist_q32;
        sums[k].bend_q32 += crn_mul_q30(to - from, share);
        sums[k].turn1_q30 += crn_mul_q30(crn_sat32(part[k].turn1_q30), share);
        sums[k].turn2_q30 += crn_mul_q30(crn_sat32(part[k].turn2_q30), share);
    }
}

/* Integrates the tools' properties over a node's cell, piece by piece from one tool's tip to the next. At
 * most CRN_TOOL_MAX tips lie in the cell of a node. */
static void divided_cell(walk *w, cell c, crn_joint *joint)
{
    crn_stretch sums[CRN_TOOL_MAX] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
    int64_t compliance = 0;
    int32_t from = c.begin;
    for (int piece = 0; piece <= CRN_TOOL_MAX && from < c.end; piece++) {
        int32_t to = c.end;
        for (uint32_t k = 0; k < w->model->tool_count; k++) {
            int32_t tip = w->line->offset_m_q30[k];
            to = tip > from && tip < to ? tip : to;
        }
        add_piece(w, from, to, sums, &compliance);
        from = to;
    }
    joint->bend_N_m_q26 = crn_inverse_of(compliance, 58);
    int32_t parts_q26[CRN_TOOL_MAX];
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        int32_t part = crn_quotient((int32_t)sums[k].bend_q32, c.end - c.begin, 30);
        parts_q26[k] = crn_mul_q30(joint->bend_N_m_q26, part);
    }
    share_stiffness(w, parts_q26, joint);
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        if (w->line->offset_m_q30[k] >= c.end) {
            continue;
        }
        int64_t least = 1;
        if (w->line->offset_m_q30[k] > c.begin) {
            /* The code uses the compliance of at least a tenth of the cell, so that a tip that has just
             * entered the cell does not make a rigid joint. */
            int32_t tip_q35 = crn_tool_on(w->model, k)->spans[0].from[CRN_TWIST_N_M2_Q35];
            least = crn_compliance_q32((c.end - c.begin) / 10, tip_q35);
        }
        joint->twist_N_m_q26[k] = crn_inverse_of(sums[k].twist_q32 > least ? sums[k].twist_q32 : least, 58);
        joint->turn1_q30[k] = crn_sat32(sums[k].turn1_q30);
        joint->turn2_q30[k] = crn_sat32(sums[k].turn2_q30);
    }
}

/* --- one node ------------------------------------------------------------------------------------------- */

static bool is_divided(const walk *w, cell c)
{
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        if (w->line->offset_m_q30[k] > c.begin && w->line->offset_m_q30[k] < c.end) {
            return true;
        }
    }
    return false;
}

/* Where there are several tools, the rest rotation of each tool is weighted with the tool's fraction of the
 * stiffness. */
static void share_turns(const walk *w, const int32_t own_q26[CRN_TOOL_MAX], crn_joint *joint)
{
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        if (own_q26[k] != joint->bend_N_m_q26 && (joint->turn1_q30[k] | joint->turn2_q30[k]) != 0) {
            int32_t share = crn_quotient(own_q26[k], joint->bend_N_m_q26, 30);
            joint->turn1_q30[k] = crn_mul_q30(joint->turn1_q30[k], share);
            joint->turn2_q30[k] = crn_mul_q30(joint->turn2_q30[k], share);
        }
    }
}

/* Computes the bending entries p, q and r of joint i from the joint's stiffness. */
static void build_entries(const walk *w, uint32_t i, crn_joint *joint)
{
    const crn_mesh_node *mesh = &w->model->mesh[i];
    if (i > 0) {
        unsigned exponent = w->model->stiffness_exponent;
        int32_t bend = joint->bend_N_m_q26;
        int32_t a = mesh[-1].inverse_length_per_m_q18;
        int32_t b = mesh->inverse_length_per_m_q18;
        joint->p = crn_to_exponent(crn_bend_spring_q8(bend, a, a), exponent);
        joint->q = a == b ? joint->p : crn_to_exponent(crn_bend_spring_q8(bend, a, b), exponent);
        joint->r = a == b ? joint->p : crn_to_exponent(crn_bend_spring_q8(bend, b, b), exponent);
    }
}

static void build_joint(walk *w, uint32_t i, cell c)
{
    crn_joint *joint = &w->line->nodes[i].joint;
    const crn_mesh_node *mesh = &w->model->mesh[i];
    *joint = (crn_joint){0};
    if (is_divided(w, c)) {
        divided_cell(w, c, joint);
    } else {
        int32_t own_q26[CRN_TOOL_MAX] = {0, 0, 0};
        for (uint32_t k = 0; k < w->model->tool_count; k++) {
            if (w->line->offset_m_q30[k] <= c.begin) {
                own_q26[k] = whole_cell(w, k, mesh, c, joint);
                joint->bend_N_m_q26 = crn_add_sat(joint->bend_N_m_q26, own_q26[k]);
            }
        }
        share_turns(w, own_q26, joint);
        share_stiffness(w, own_q26, joint);
    }
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        joint->twist_N_m_q26[k] =
            joint->twist_N_m_q26[k] < TWIST_MAX_N_m_Q26 ? joint->twist_N_m_q26[k] : TWIST_MAX_N_m_Q26;
        joint->turn1_q30[k] = crn_rest_turn_of(crn_limit_turn(joint->turn1_q30[k]));
        joint->turn2_q30[k] = crn_rest_turn_of(crn_limit_turn(joint->turn2_q30[k]));
        joint->curved |= (uint32_t)((joint->turn1_q30[k] | joint->turn2_q30[k]) != 0) << k;
    }
}

/* Returns the fraction of the length of a node's cell that tool k covers, in Q30. */
static int32_t cover_of(const walk *w, uint32_t k, cell c)
{
    int32_t offset = w->line->offset_m_q30[k];
    if (offset <= c.begin) {
        return CRN_ONE_Q30;
    }
    return offset >= c.end ? 0 : crn_quotient(c.end - offset, c.end - c.begin, 30);
}

static int32_t blend(int32_t under, int32_t over, int32_t share_q30)
{
    return under + crn_scale_q30(over - under, share_q30);
}

/* Computes the mass and the surface of a node. The masses of all tools add up, and the outermost tool touches
 * the wall. In the cell with the outermost tool's tip, the radii and friction of two tools are blended,
 * because a sudden change would cause a jump (docs/rod.md). */
static void build_surface(walk *w, uint32_t i, cell c)
{
    crn_line_node *node = &w->line->nodes[i];
    int64_t mass_kg_per_m_q34 = 0;
    bool first = true;
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        int32_t cover = cover_of(w, k, c);
        if (cover == 0) {
            continue;
        }
        const crn_tool *tool = crn_tool_on(w->model, k);
        int32_t arc = c.begin + (c.end - c.begin) / 2 - w->line->offset_m_q30[k];
        uint32_t span = w->span[k];
        arc = arc < 0 ? 0 : arc;
        crn_span_seek(tool, &span, arc);
        const crn_span *s = &tool->spans[span];
        int32_t fraction = s->flat ? 0 : crn_span_fraction(s, arc);
        mass_kg_per_m_q34 += crn_scale_q30(crn_span_value(s, CRN_MASS_KG_PER_M_Q34, fraction), cover);
        int32_t share = first ? CRN_ONE_Q30 : cover;
        node->radius_m_q30 =
            blend(first ? 0 : node->radius_m_q30, crn_span_value(s, CRN_RADIUS_M_Q30, fraction), share);
        node->kinetic_q30 =
            blend(first ? 0 : node->kinetic_q30, crn_span_value(s, CRN_KINETIC_Q30, fraction), share);
        node->static_q30 =
            blend(first ? 0 : node->static_q30, crn_span_value(s, CRN_STATIC_Q30, fraction), share);
        node->under = first ? (uint8_t)k : node->outer;
        node->outer = (uint8_t)k;
        node->outer_share_q15 = (uint16_t)(share >> 15);
        first = false;
    }
    crn_set_mass(w->model, node, mass_kg_per_m_q34, c.end - c.begin);
}

/* Sets the axial stiffness EA of edge i to the largest value that the number format permits beside the softer
 * of the edge's two joints, but at most to the model's largest axial stiffness. */
static void build_edge(walk *w, uint32_t i)
{
    crn_line_node *node = &w->line->nodes[i];
    int32_t softer = node[1].joint.bend_N_m_q26;
    if (i > 0 && node->joint.bend_N_m_q26 < softer) {
        softer = node->joint.bend_N_m_q26;
    }
    int64_t spring_q8 = crn_axial_spring_q8(w->model, i, softer);
    node->spring = crn_to_exponent(spring_q8, w->model->stiffness_exponent);
    node->axial_stiffness_N_q17 = crn_sat32((spring_q8 * w->model->mesh[i].length_m_q30) >> 21);
    w->line->edge_compliance_m_N_q40 = crn_inverse_of(spring_q8, 48);
    node[1].compliance_m_N_q40 = crn_add_sat(node->compliance_m_N_q40, w->line->edge_compliance_m_N_q40);
}

/* --- cells like most of them: each tool either absent or in one span, straight -------------------------- */

static bool is_straight(const crn_span *s)
{
    return (s->from[CRN_CURVE1_PER_M_Q20] | s->delta[CRN_CURVE1_PER_M_Q20] | s->from[CRN_CURVE2_PER_M_Q20] |
            s->delta[CRN_CURVE2_PER_M_Q20]) == 0;
}

/* Returns whether the cell is plain. In a plain cell, each tool is either absent, or straight, present
 * throughout, and within one span between two knots. As a side effect, the pass along the mesh advances to
 * the span in which each tool is at this cell. */
static bool is_plain(walk *w, cell c)
{
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        const crn_tool *tool = crn_tool_on(w->model, k);
        int32_t offset = w->line->offset_m_q30[k];
        if (offset >= c.end) {
            continue;
        }
        crn_span_seek(tool, &w->span[k], c.begin - offset);
        const crn_span *s = &tool->spans[w->span[k]];
        bool one = c.end - offset <= s->end_m_q30 || w->span[k] + 1 == tool->span_count;
        if (offset > c.begin || !one || !is_straight(s)) {
            return false;
        }
    }
    return true;
}

/* Computes joint, mass and surface of a plain cell (one without a curve, tip or knot) from the properties of
 * each tool at one point. */
static void build_plain(walk *w, uint32_t i, cell c)
{
    crn_line_node *node = &w->line->nodes[i];
    int32_t inverse = w->model->mesh[i].inverse_cell_per_m_q18;
    int32_t middle = c.begin + (c.end - c.begin) / 2;
    int32_t own_q26[CRN_TOOL_MAX] = {0, 0, 0};
    int64_t mass_kg_per_m_q34 = 0;
    int32_t bend = 0, outer_fraction = 0;
    uint32_t outer = CRN_TOOL_MAX;
    node->joint.p = node->joint.q = node->joint.r = 0; /* for the tip, which has no joint */
    node->joint.curved = 0;
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        int32_t offset = w->line->offset_m_q30[k];
        node->joint.twist_N_m_q26[k] = node->joint.turn1_q30[k] = node->joint.turn2_q30[k] = 0;
        node->joint.set_q14[k][0] = 0;
        node->joint.set_q14[k][1] = 0;
        if (offset >= c.end) {
            continue;
        }
        const crn_span *s = &crn_tool_on(w->model, k)->spans[w->span[k]];
        int32_t fraction = s->flat ? 0 : crn_span_fraction(s, middle - offset);
        int32_t twist = crn_mul(crn_span_value(s, CRN_TWIST_N_M2_Q35, fraction), inverse, 27);
        own_q26[k] = crn_mul(crn_span_value(s, CRN_BEND_N_M2_Q35, fraction), inverse, 27);
        node->joint.twist_N_m_q26[k] = twist < TWIST_MAX_N_m_Q26 ? twist : TWIST_MAX_N_m_Q26;
        bend = crn_add_sat(bend, own_q26[k]);
        mass_kg_per_m_q34 += crn_span_value(s, CRN_MASS_KG_PER_M_Q34, fraction);
        node->under = (uint8_t)(outer == CRN_TOOL_MAX ? k : outer);
        outer = k;
        outer_fraction = fraction;
    }
    /* The leading tool is present in every cell, so there is always an outermost tool. */
    const crn_span *s = &crn_tool_on(w->model, outer)->spans[w->span[outer]];
    node->joint.bend_N_m_q26 = bend;
    share_stiffness(w, own_q26, &node->joint);
    node->outer = (uint8_t)outer;
    node->outer_share_q15 = 1 << 15;
    node->radius_m_q30 = crn_span_value(s, CRN_RADIUS_M_Q30, outer_fraction);
    node->kinetic_q30 = crn_span_value(s, CRN_KINETIC_Q30, outer_fraction);
    node->static_q30 = crn_span_value(s, CRN_STATIC_Q30, outer_fraction);
    crn_set_mass(w->model, node, mass_kg_per_m_q34, c.end - c.begin);
}

/* --- the whole line ------------------------------------------------------------------------------------- */

/* Returns whether node i has the same properties as node i-1: the elements are equally long, and each tool is
 * absent or has constant properties over the two cells. */
static bool repeats(const walk *w, uint32_t i)
{
    const crn_mesh_node *mesh = &w->model->mesh[i];
    if (i < 3 || mesh->length_m_q30 != mesh[-2].length_m_q30) {
        return false;
    }
    for (uint32_t k = 0; k < w->model->tool_count; k++) {
        int32_t offset = w->line->offset_m_q30[k];
        const crn_tool *tool = crn_tool_on(w->model, k);
        const crn_span *s = &tool->spans[w->span[k]];
        bool inside = s->flat && mesh[-2].cell_end_m_q30 - offset >= s->begin_m_q30 &&
                      (mesh->cell_end_m_q30 - offset <= s->end_m_q30 || w->span[k] + 1 == tool->span_count);
        if (offset < mesh->cell_end_m_q30 && !inside) {
            return false;
        }
    }
    return true;
}

/* Returns the arc length behind the leading tip beyond which every tool is in its last span and that span has
 * constant properties, as most of a shaft has. */
static int32_t steady_arc(const crn_model *model, const crn_line *line)
{
    int32_t arc = 0;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        if (line->offset_m_q30[k] == CRN_OFFSET_FREE) {
            continue;
        }
        const crn_span *last = &crn_tool_on(model, k)->spans[crn_tool_on(model, k)->span_count - 1];
        int32_t begin = last->flat ? crn_add_sat(last->begin_m_q30, line->offset_m_q30[k]) : INT32_MAX;
        arc = begin > arc ? begin : arc;
    }
    return arc;
}

/* Returns the first node that has the same properties as all nodes behind it, or `count` when there is no
 * such node. */
static uint32_t steady_node(const crn_model *model, const crn_line *line, uint32_t count)
{
    int32_t arc = steady_arc(model, line);
    const crn_mesh_node *mesh = model->mesh;
    uint32_t i = line->uniform;
    i = line->count > 0 && line->steady > i ? line->steady : i;
    while (i > line->uniform && mesh[i - 3].cell_end_m_q30 >= arc) {
        i--;
    }
    while (i < count && mesh[i - 2].cell_end_m_q30 < arc) {
        i++;
    }
    return i < count ? i : count;
}

/* Returns the first node for which the two edges in front of it and all edges behind it are equally long. */
static uint32_t uniform_node(const crn_model *model)
{
    uint32_t i = model->node_count + 2;
    while (i > 3 && model->mesh[i - 3].length_m_q30 == model->mesh[model->node_count].length_m_q30) {
        i--;
    }
    return i;
}

static cell cell_of(const crn_model *model, uint32_t i)
{
    return (cell){crn_cell_begin(model, i), model->mesh[i].cell_end_m_q30};
}

static void build_node(walk *w, uint32_t i)
{
    crn_line_node *node = &w->line->nodes[i];
    if (repeats(w, i)) {
        int32_t compliance = node->compliance_m_N_q40;
        *node = node[-1];
        node->compliance_m_N_q40 = compliance;
        return;
    }
    const cell c = cell_of(w->model, i);
    if (is_plain(w, c)) {
        build_plain(w, i, c);
    } else {
        build_joint(w, i, c);
        build_surface(w, i, c);
    }
    build_entries(w, i, &node->joint);
}

/* Makes the edge behind node i a copy of the edge in front of the node. */
static void repeat_edge(crn_line *line, uint32_t i)
{
    line->nodes[i].spring = line->nodes[i - 1].spring;
    line->nodes[i].axial_stiffness_N_q17 = line->nodes[i - 1].axial_stiffness_N_q17;
}

/* --- nodes that keep their values ----------------------------------------------------------------------- */

/* Where the tip of a tool was in the last pass and is now, behind the leading tip, and the tool's span at the
 * cell that was looked at last. */
typedef struct move {
    int32_t front_m_q30, back_m_q30;
    uint32_t span;
} move;

/* Returns whether a tool has, all over the cell, the properties that it had in the last pass. */
static bool is_same(const crn_tool *tool, move *m, cell c)
{
    if (m->front_m_q30 == m->back_m_q30 || c.end <= m->front_m_q30) {
        return true;
    }
    while (m->span + 1 < tool->span_count &&
           crn_add_sat(tool->spans[m->span].end_m_q30, m->front_m_q30) < c.end) {
        m->span++;
    }
    const crn_span *s = &tool->spans[m->span];
    return s->flat && c.begin >= crn_add_sat(s->begin_m_q30, m->back_m_q30);
}

static bool cell_is_same(const crn_model *model, move moves[CRN_TOOL_MAX], uint32_t i)
{
    const cell c = cell_of(model, i);
    for (uint32_t k = 0; k < model->tool_count; k++) {
        if (!is_same(crn_tool_on(model, k), &moves[k], c)) {
            return false;
        }
    }
    return true;
}

/* What a pass knows of the node in front. */
typedef struct front {
    bool is_built;
    int32_t compliance_m_N_q40; /* in the last pass */
} front;

/* Builds node i, and the edge in front of it, unless both keep their values. The compliance of a kept edge is
 * the difference of its nodes' compliances in the last pass, unless the latter is saturated. The last edge is
 * built for the compliance of all edges behind it. */
static void visit(walk *w, uint32_t i, bool is_built, bool is_last, front *ahead)
{
    crn_line_node *node = &w->line->nodes[i];
    const int32_t was = node->compliance_m_N_q40;
    if (is_built) {
        build_node(w, i);
    }
    if (i > 0) {
        const int32_t base = node[-1].compliance_m_N_q40;
        if (is_built || ahead->is_built || is_last ||
            (base != ahead->compliance_m_N_q40 && was == INT32_MAX)) {
            build_edge(w, i - 1);
        } else {
            node->compliance_m_N_q40 = crn_add_sat(base, was - ahead->compliance_m_N_q40);
        }
    }
    *ahead = (front){is_built, was};
}

static void build_line(const crn_model *model, crn_line *line, uint32_t count, move moves[CRN_TOOL_MAX])
{
    walk w = {model, line, {0, 0, 0}};
    if (line->count == 0) {
        line->uniform = uniform_node(model);
    }
    const uint32_t steady = steady_node(model, line, count);
    const uint32_t last = steady < count ? steady : count - 1;
    /* Up to `kept`, nodes were built in the last pass. Those behind are copies of it, up to line->count. */
    const uint32_t kept = line->count > 0 ? line->steady : count;
    front ahead = {false, 0};
    line->nodes[0].compliance_m_N_q40 = 0;
    for (uint32_t i = 0; i <= last; i++) {
        const bool is_kept = i < line->count && i <= kept && cell_is_same(model, moves, i);
        visit(&w, i, !is_kept, i == last, &ahead);
    }
    if (steady < count) {
        repeat_edge(line, steady);
    }
    for (uint32_t i = steady + 1; i < count; i++) {
        if (i < kept || i >= line->count) {
            line->nodes[i] = line->nodes[i - 1];
        }
    }
    repeat_edge(line, count - 1); /* there is no joint behind it */
    line->count = count;
    line->steady = steady;
}

void crn_line_update(const crn_model *model, crn_state *state)
{
    enum { BEHIND_MOUTH = 3, RESERVE = 16 };
    crn_line *line = &state->line;
    int32_t lead = crn_lead_inserted(model, &state->words);
    bool same = line->count >= state->words.free_count + BEHIND_MOUTH;
    move moves[CRN_TOOL_MAX] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (uint32_t k = 0; k < model->tool_count; k++) {
        int32_t offset =
            crn_has_tool(&state->words, k) ? lead - state->words.tools[k].inserted_m_q30 : CRN_OFFSET_FREE;
        const int32_t before = line->offset_m_q30[k];
        same = same && offset == before;
        moves[k] = (move){offset < before ? offset : before, offset < before ? before : offset, 0};
        line->offset_m_q30[k] = offset;
    }
    if (same) {
        return;
    }
    uint32_t count = state->words.free_count + RESERVE;
    build_line(model, line,
               model->tool_count == 1 || count > model->node_count ? model->node_count + 1 : count, moves);
}
