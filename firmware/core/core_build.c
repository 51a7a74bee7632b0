/* During set-up, this file derives the constants of the model from the tools. The constants are derived once
 * for each set of nested tools, so slow operations such as bit-by-bit division are acceptable. */
#include "firmware/core/balloon.h"
#include "firmware/core/lesion.h"

enum {
    FOLD_MAX_N = 8192,         /* W / l: bounds the products of joint_forces() in rod_force.c */
    BEND_MAX_N_m = 16,         /* W of a joint, for the same bound */
    LOAD_RESERVE_N_m = 250000, /* reserve in the diagonal for contact, friction and tension */
    SOFTEST = 128, /* W c^2 in Q(a): below it a free tip's block has too few bits for its inverse */
};

static int32_t micrometres_to_q30(uint32_t um)
{
    return (int32_t)crn_divide_u64(((uint64_t)um << 30) + 500000u, 1000000u);
}

/* Returns value * numerator / denominator, rounded to nearest. Overflow: the result saturates; the caller
 * keeps |value| * numerator below 2^63. */
static int32_t scaled(int64_t value, uint64_t numerator, uint64_t denominator)
{
    uint64_t size = (uint64_t)(value < 0 ? -value : value) * numerator + denominator / 2;
    uint64_t quotient = crn_divide_u64(size, denominator);
    int32_t result = quotient > INT32_MAX ? INT32_MAX : (int32_t)quotient;
    return value < 0 ? -result : result;
}

/* --- mesh ----------------------------------------------------------------------------------------------- */

typedef struct mesh_plan {
    int32_t total, tip, shaft, fine; /* Q30 m */
} mesh_plan;

/* All tools of the table share one mesh. The mesh has the length of the longest tool, the shortest elements
 * of any tool, and the longest finely meshed part of any tool. */
static mesh_plan plan_mesh(const crn_instrument *tools, uint32_t tool_count)
{
    uint32_t total = 0, tip = UINT32_MAX, shaft = UINT32_MAX, fine = 0;
    for (uint32_t k = 0; k < tool_count; k++) {
        const crn_instrument *tool = &tools[k];
        uint32_t length = tool->knots[tool->knot_count - 1].arc_um;
        total = length > total ? length : total;
        tip = tool->element_tip_um < tip ? tool->element_tip_um : tip;
        shaft = tool->element_shaft_um < shaft ? tool->element_shaft_um : shaft;
        fine = tool->element_fine_um > fine ? tool->element_fine_um : fine;
    }
    return (mesh_plan){micrometres_to_q30(total), micrometres_to_q30(tip), micrometres_to_q30(shaft),
                       micrometres_to_q30(fine)};
}

static int32_t inverse_per_m_q18(int32_t length_m_q30)
{
    return (int32_t)crn_divide_u64(((uint64_t)1 << 48) + ((uint64_t)(uint32_t)length_m_q30 >> 1),
                                   (uint32_t)length_m_q30);
}

/* Builds the cells of the mesh; a cell is the stretch of the tools that belongs to one node. The cell of a
 * node reaches half an edge to either side of the node; the cell of the tip node has only the half that lies
 * behind the tip. */
static void build_cells(crn_model *model)
{
    int32_t begin = 0;
    for (uint32_t i = 0; i <= model->node_count; i++) {
        crn_mesh_node *node = &model->mesh[i];
        node->cell_end_m_q30 = node->arc_m_q30 + node->length_m_q30 / 2;
        node->inverse_cell_per_m_q18 = inverse_per_m_q18(node->cell_end_m_q30 - begin);
        begin = node->cell_end_m_q30;
    }
}

/* Chooses the lengths of the mesh's elements. The elements are short at the tip. Each element is at most 1.5
 * times as long as its neighbour nearer to the tip, up to the element length of the shaft. The lengths of the
 * elements never decrease towards the base. With such a mesh, the matrix W = V - I, with which the solve
 * works (rod_solve.c), has a magnitude of at most 2. The mesh ends at the last whole element. */
static crn_build_status build_mesh(crn_model *model, const mesh_plan *plan)
{
    int32_t length = plan->tip;
    int32_t arc = 0;
    uint32_t node = 0;
    while (arc + length <= plan->total + 64) {
        if (node + 2 > CRN_NODE_MAX) {
            return CRN_BUILD_LENGTH;
        }
        model->mesh[node].arc_m_q30 = arc;
        model->mesh[node].length_m_q30 = length;
        model->mesh[node].inverse_length_per_m_q18 = inverse_per_m_q18(length);
        arc += length;
        node++;
        if (arc >= plan->fine && length < plan->shaft) {
            int32_t grown = length + (length >> 1);
            length = grown < plan->shaft ? grown : plan->shaft;
        }
    }
    model->node_count = node + 1;
    if (model->node_count < 8) {
        return CRN_BUILD_LENGTH;
    }
    /* Adds further edges to the mesh behind the last node, because the solve also reads the entries of the
     * two nodes behind a node. */
    for (uint32_t i = node; i <= node + 1; i++) {
        model->mesh[i] = model->mesh[node - 1];
        model->mesh[i].arc_m_q30 = arc;
        arc += model->mesh[i].length_m_q30;
    }
    build_cells(model);
    return CRN_BUILD_OK;
}

/* --- tools ---------------------------------------------------------------------------------------------- */

/* Returns the mass per length of the blood that the wall of a tool displaces, in Q34 kg/m: half of
 * `added_kg_m3`, which is pi times the density, times the difference of the squared radii. The lumen holds
 * blood, or another tool, which loses weight by itself. The conversion factor from um^2 kg/m^3 is 2^33 / 1e12
 * = 2^21 / 244140625. Overflow is impossible: 2000^2 x 12566 x 2^21 is below 2^57. */
static int32_t displaced_mass(const crn_knot *knot, int32_t added_kg_m3)
{
    const int64_t outer = knot->radius_outer_um, inner = knot->radius_inner_um;
    return scaled((outer * outer - inner * inner) * added_kg_m3, 1u << 21, 244140625u);
}

/* Converts the properties given at a knot (a point along the tool) to the formats of crn_property. The
 * conversion factors are 2^35 / 1e9 from nN m^2 to Q35, 2^20 / 1000 from milli/m to Q20, and 2^34 / 1e6 from
 * mg/m to Q34 kg/m. */
static void knot_values(const crn_knot *knot, int32_t added_kg_m3, int32_t values[CRN_PROPERTY_COUNT])
{
    values[CRN_BEND_N_M2_Q35] = scaled(knot->bend_stiffness_nN_m2, (uint64_t)1 << 35, 1000000000u);
    values[CRN_TWIST_N_M2_Q35] = scaled(knot->twist_stiffness_nN_m2, (uint64_t)1 << 35, 1000000000u);
    values[CRN_CURVE1_PER_M_Q20] = scaled(knot->rest_curvature1_per_m_milli, 1u << 20, 1000u);
    values[CRN_CURVE2_PER_M_Q20] = scaled(knot->rest_curvature2_per_m_milli, 1u << 20, 1000u);
    values[CRN_MASS_KG_PER_M_Q34] =
        scaled(knot->mass_mg_per_m, (uint64_t)1 << 34, 1000000u) - displaced_mass(knot, added_kg_m3);
    values[CRN_RADIUS_M_Q30] = micrometres_to_q30(knot->radius_outer_um);
    values[CRN_KINETIC_Q30] = scaled(knot->friction_kinetic_milli, CRN_ONE_Q30, 1000u);
    values[CRN_STATIC_Q30] = scaled(knot->friction_static_milli, CRN_ONE_Q30, 1000u);
}

static crn_material_law law_of(const crn_material *material)
{
    crn_material_law law = {material->kind, 0, 0, 0, 0, 0};
    /* pi / 2 E in Pa is below 2^39; its root in Q11, and the root of that in Q20 */
    const uint64_t stiffness_Pa = (uint64_t)material->core_modulus_MPa * 1570796u;
    const int32_t root_q11 = crn_root_of(stiffness_Pa << 22);
    const int32_t fourth_root_q20 = crn_root_of((uint64_t)(uint32_t)root_q11 << 29);
    law.yield_q20 = scaled(material->yield_strain_micro, (uint64_t)(uint32_t)fourth_root_q20, 1000000u);
    const uint32_t left_milli = 1000u - material->hardening_milli; /* 100 .. 1000 */
    law.slope_q24 = scaled(material->hardening_milli, 1u << 24, left_milli);
    law.follow_q30 = scaled(left_milli, CRN_ONE_Q30, 1000u);
    law.unload_q30 = scaled(material->unload_milli, CRN_ONE_Q30, 1000u);
    law.limit_q20 = scaled(material->limit_milli, 1u << 20, 1000u);
    return law;
}

static void build_span(crn_span *span, const crn_knot *a, const crn_knot *b, int32_t added_kg_m3)
{
    int32_t to[CRN_PROPERTY_COUNT];
    span->begin_m_q30 = micrometres_to_q30(a->arc_um);
    span->end_m_q30 = micrometres_to_q30(b->arc_um);
    unsigned lead = crn_clz32((uint32_t)(span->end_m_q30 - span->begin_m_q30)) - 1;
    span->inverse_mantissa = crn_reciprocal_q30((uint32_t)(span->end_m_q30 - span->begin_m_q30) << lead);
    span->shift = 31 - lead;
    span->flat = 1;
    knot_values(a, added_kg_m3, span->from);
    knot_values(b, added_kg_m3, to);
    for (int k = 0; k < CRN_PROPERTY_COUNT; k++) {
        /* The widest is that of the mass, 100 g/m to 0.5 g/m that float in the densest blood: 2,141,140,000,
         * below the 2,143,289,344 that crn_scale_q30 takes. */
        span->delta[k] = to[k] - span->from[k];
        span->flat &= span->delta[k] == 0;
    }
}

/* Stores the properties of a tool in the session's table that crn_exchange needs later. */
static void build_table_tool(crn_table_tool *kept, const crn_instrument *instrument)
{
    kept->whole_um = instrument->whole_um;
    kept->rail_um = instrument->rail_um;
    kept->bore_um = instrument->knots[0].radius_inner_um;
    for (uint32_t i = 0; i < instrument->knot_count; i++) {
        const crn_knot *knot = &instrument->knots[i];
        kept->outer_um = knot->radius_outer_um > kept->outer_um ? knot->radius_outer_um : kept->outer_um;
        kept->bore_um = knot->radius_inner_um < kept->bore_um ? knot->radius_inner_um : kept->bore_um;
    }
    crn_balloon_build(&kept->balloon, instrument);
}

static void build_tool(crn_model *model, uint32_t number, const crn_instrument *instrument)
{
    crn_tool *tool = &model->table[number].tool;
    for (uint32_t i = 0; i + 1 < instrument->knot_count; i++) {
        if (instrument->knots[i + 1].arc_um > instrument->knots[i].arc_um) {
            build_span(&tool->spans[tool->span_count++], &instrument->knots[i], &instrument->knots[i + 1],
                       model->added_kg_m3);
        }
    }
    tool->length_m_q30 = tool->spans[tool->span_count - 1].end_m_q30;
    tool->material = law_of(&instrument->material);
    tool->lumen_friction_q30 = scaled(instrument->lumen_friction_milli, CRN_ONE_Q30, 1000u);
    tool->shaft_radius_m_q30 =
        micrometres_to_q30(instrument->knots[instrument->knot_count - 1].radius_outer_um);
    int32_t cap_q17 = (int32_t)instrument->axial_stiffness_max_N << 17;
    model->axial_max_N_q17 = cap_q17 > model->axial_max_N_q17 ? cap_q17 : model->axial_max_N_q17;
    /* Two whole elements of a tool always stay in the introducer sheath. */
    const crn_mesh_node *last = &model->mesh[model->node_count - 1];
    int32_t held = last->arc_m_q30 - model->mesh[model->node_count - 3].arc_m_q30;
    int32_t end = tool->length_m_q30 < last->arc_m_q30 ? tool->length_m_q30 : last->arc_m_q30;
    tool->inserted_max_m_q30 = end - held;
    build_table_tool(&model->table[number], instrument);
    tool->bore_m_q30 = micrometres_to_q30(model->table[number].bore_um);
}

/* --- number format -------------------------------------------------------------------------------------- */

typedef struct stiffness_range {
    int32_t softest_q35,
        stiffest_q35; /* EI that a node can get: the softest single tool, and the stiffest line; N m^2 */
} stiffness_range;

static int32_t bend_at(const crn_tool *tool, uint32_t span, int32_t arc_m_q30)
{
    const crn_span *s = &tool->spans[span];
    return crn_span_value(s, CRN_BEND_N_M2_Q35, crn_span_fraction(s, arc_m_q30));
}

/* Returns the largest bending stiffness EI that tool k can have at arc length `arc_m_q30` behind the leading
 * tip, for any position of the tool. This largest stiffness is the maximum of EI from the tool's own tip to
 * the given arc length. */
static int32_t stiffest_until(const crn_tool *tool, int32_t arc_m_q30)
{
    int32_t most = 0;
    for (uint32_t i = 0; i < tool->span_count && (i == 0 || tool->spans[i].begin_m_q30 < arc_m_q30); i++) {
        int32_t first = tool->spans[i].from[CRN_BEND_N_M2_Q35];
        int32_t last = bend_at(tool, i, arc_m_q30);
        most = first > most ? first : most;
        most = last > most ? last : most;
    }
    return most;
}

static int32_t own_stiffness(const crn_tool *tool, int32_t arc_m_q30)
{
    uint32_t i = 0;
    while (i + 1 < tool->span_count && tool->spans[i].end_m_q30 < arc_m_q30) {
        i++;
    }
    return bend_at(tool, i, arc_m_q30);
}

/* Holds, in descending order, the CRN_TOOL_MAX largest values of one property (bending stiffness or mass per
 * length) among the tools of the table. At most CRN_TOOL_MAX tools can be nested, so the sum of the
 * CRN_TOOL_MAX largest values is an upper limit for any set of nested tools. */
typedef struct largest_values {
    int32_t values[CRN_TOOL_MAX];
} largest_values;

static void keep_largest(largest_values *largest, int32_t value)
{
    for (int i = 0; i < CRN_TOOL_MAX; i++) {
        if (value > largest->values[i]) {
            int32_t smaller = largest->values[i];
            largest->values[i] = value;
            value = smaller;
        }
    }
}

/* Overflow: saturates. */
static int32_t sum_of_largest(const largest_values *largest)
{
    int32_t sum = 0;
    for (int i = 0; i < CRN_TOOL_MAX; i++) {
        sum = crn_add_sat(sum, largest->values[i]);
    }
    return sum;
}

static stiffness_range range_at(const crn_model *model, uint32_t node)
{
    stiffness_range range = {INT32_MAX, 0};
    largest_values stiffest = {{0}};
    for (uint32_t k = 0; k < model->table_count; k++) {
        const crn_tool *tool = &model->table[k].tool;
        int32_t own = own_stiffness(tool, model->mesh[node].arc_m_q30);
        range.softest_q35 = own < range.softest_q35 ? own : range.softest_q35;
        keep_largest(&stiffest, stiffest_until(tool, model->mesh[node].cell_end_m_q30));
    }
    range.stiffest_q35 = sum_of_largest(&stiffest);
    return range;
}

/* Returns the stiffness W of a joint whose cell has the same bending stiffness EI everywhere. Format: Q35 N
 * m^2 x Q18 1/m -> Q26 N m in 64 bits. */
static int64_t cell_stiffness_q26(const crn_model *model, uint32_t node, int32_t bend_N_m2_q35)
{
    return ((int64_t)bend_N_m2_q35 * model->mesh[node].inverse_cell_per_m_q18) >> 27;
}

/* Chooses the exponent of the matrix's number format so that the stiffest diagonal entry stays below 2^29 and
 * the softest block keeps enough bits. */
static crn_build_status choose_exponent(crn_model *model)
{
    int64_t worst_q8 = 0;
    int64_t unclipped_q8 = 0;
    int64_t softest_q8 = INT64_MAX;
    for (uint32_t i = 1; i + 1 < model->node_count; i++) {
        int32_t a = model->mesh[i - 1].inverse_length_per_m_q18;
        int32_t c = model->mesh[i].inverse_length_per_m_q18;
        stiffness_range range = range_at(model, i);
        int64_t bend = cell_stiffness_q26(model, i, range.stiffest_q35);
        if (bend >= (int64_t)BEND_MAX_N_m << 26 || (bend * a) >> 44 >= FOLD_MAX_N) {
            return CRN_BUILD_OVERFLOW;
        }
        int64_t w = crn_bend_spring_q8((int32_t)bend, a, a);
        int64_t axial =
            crn_axial_spring_q8(model, i - 1, (int32_t)bend) + crn_axial_spring_q8(model, i, (int32_t)bend);
        int64_t sum = axial + w * (2 + 4 * CRN_CLIP_SURE);
        worst_q8 = sum > worst_q8 ? sum : worst_q8;
        sum = axial + 2 * w;
        unclipped_q8 = sum > unclipped_q8 ? sum : unclipped_q8;
        int64_t soft = crn_bend_spring_q8((int32_t)cell_stiffness_q26(model, i, range.softest_q35), c, c);
        softest_q8 = soft < softest_q8 ? soft : softest_q8;
    }
    /* If less than 1/CRN_CLIP_SURE of a joint's cell lies outside the introducer sheath, rod_feed.c keeps the
     * joint's part of the diagonal entry below 2^28. The other terms in the diagonal entry of the joint at
     * the sheath's end must also stay below 2^28, so that the sum stays below 2^29. */
    worst_q8 = worst_q8 > 2 * unclipped_q8 ? worst_q8 : 2 * unclipped_q8;
    worst_q8 += (int64_t)(2 * LOAD_RESERVE_N_m) << 8;
    uint32_t exponent = 14;
    while (exponent > 0 && (worst_q8 >> 8) >= ((int64_t)1 << (29 - exponent))) {
        exponent--;
    }
    model->stiffness_exponent = exponent;
    bool fits = exponent >= 2 && (softest_q8 << exponent) >> 8 >= SOFTEST;
    return fits ? CRN_BUILD_OK : CRN_BUILD_OVERFLOW;
}

/* --- what the mesh can bear of each tool ---------------------------------------------------------------- */

/* Checks the cell of node i for the case that this tool leads, that is, has its tip farthest in the vessel.
 * The tool's rest rotation (the angle of its stress-free shape within the cell) and the tool's twist
 * stiffness must fit their number formats. */
static crn_build_status check_cell(const crn_model *model, const crn_span *span, uint32_t i,
                                   int32_t arc_m_q30)
{
    int32_t cell = model->mesh[i].cell_end_m_q30 - crn_cell_begin(model, i);
    int32_t fraction = crn_span_fraction(span, arc_m_q30);
    int64_t turn1 = crn_mul(crn_span_value(span, CRN_CURVE1_PER_M_Q20, fraction), cell, 20);
    int64_t turn2 = crn_mul(crn_span_value(span, CRN_CURVE2_PER_M_Q20, fraction), cell, 20);
    const int64_t most = CRN_TURN_OF_CELL_MAX_Q30;
    if ((turn1 * turn1 >> 2) + (turn2 * turn2 >> 2) > most * most >> 2) {
        return CRN_BUILD_ELEMENTS;
    }
    int64_t twist = crn_span_value(span, CRN_TWIST_N_M2_Q35, fraction);
    /* there is no joint at the tip, whose cell is half as long */
    bool fits = i == 0 || (twist * model->mesh[i].inverse_cell_per_m_q18) >> 27 < (int64_t)CRN_TWIST_MAX_N_m
                                                                                      << 26;
    return fits ? CRN_BUILD_OK : CRN_BUILD_OVERFLOW;
}

static uint32_t knot_before(const crn_instrument *tool, int32_t arc_m_q30)
{
    uint32_t knot = 0;
    while (knot + 1 < tool->knot_count && micrometres_to_q30(tool->knots[knot + 1].arc_um) <= arc_m_q30) {
        knot++;
    }
    return knot;
}

/* Checks that a tool is long enough for the shortest insertion that the simulation allows, and that its
 * stress-free shape and twist stiffness fit its own cells. */
static crn_build_status check_reach(const crn_model *model, uint32_t k, const crn_instrument *instrument,
                                    crn_build_place *place)
{
    const crn_tool *tool = &model->table[k].tool;
    *place = (crn_build_place){k, 0};
    if (tool->inserted_max_m_q30 < crn_least_inserted(model)) {
        return CRN_BUILD_LENGTH;
    }
    uint32_t span = 0;
    for (uint32_t i = 0; i < model->node_count && model->mesh[i].arc_m_q30 <= tool->length_m_q30; i++) {
        int32_t arc = model->mesh[i].arc_m_q30;
        crn_span_seek(tool, &span, arc);
        crn_build_status status = check_cell(model, &tool->spans[span], i, arc);
        if (status != CRN_BUILD_OK) {
            place->knot = knot_before(instrument, arc);
            return status;
        }
    }
    *place = (crn_build_place){0, 0};
    return CRN_BUILD_OK;
}

/* Checks that the heaviest set of nested tools, with the blood that the widest tool moves along, has less
 * than 1.95 g in the longest element, because the fixed-point format cannot hold more. */
static crn_build_status check_mass(const crn_model *model)
{
    const crn_mesh_node *last = &model->mesh[model->node_count - 1];
    largest_values heaviest = {{0}};
    int32_t widest_m_q30 = 0;
    for (uint32_t k = 0; k < model->table_count; k++) {
        const crn_tool *tool = &model->table[k].tool;
        int32_t most = 0;
        for (uint32_t i = 0; i < tool->span_count; i++) {
            int32_t from = tool->spans[i].from[CRN_MASS_KG_PER_M_Q34];
            int32_t to = from + tool->spans[i].delta[CRN_MASS_KG_PER_M_Q34];
            most = from > most ? from : most;
            most = to > most ? to : most;
        }
        const int32_t radius_m_q30 = micrometres_to_q30(model->table[k].outer_um);
        widest_m_q30 = radius_m_q30 > widest_m_q30 ? radius_m_q30 : widest_m_q30;
        keep_largest(&heaviest, most);
    }
    int64_t sum_q34 = crn_added_mass_q34(model, widest_m_q30);
    for (int i = 0; i < CRN_TOOL_MAX; i++) {
        sum_q34 += heaviest.values[i];
    }
    return (sum_q34 * last->length_m_q30) >> 24 < INT32_MAX ? CRN_BUILD_OK : CRN_BUILD_OVERFLOW;
}

/* --- the rest ------------------------------------------------------------------------------------------- */

/* Builds two axes perpendicular to the direction of insertion, starting from the coordinate axis least
 * aligned with it. */
static void build_base_axes(crn_model *model)
{
    crn_vec3 direction = model->entry.direction_q30;
    int least = 0;
    for (int k = 1; k < 3; k++) {
        int64_t size_k = direction.v[k] < 0 ? -(int64_t)direction.v[k] : direction.v[k];
        int64_t size_least = direction.v[least] < 0 ? -(int64_t)direction.v[least] : direction.v[least];
        least = size_k < size_least ? k : least;
    }
    crn_vec3 helper = {{0, 0, 0}};
    helper.v[least] = CRN_ONE_Q30;
    crn_vec3 across = crn_vec3_cross(helper, direction, 30);
    model->base_axis1_q30 = crn_vec3_normalise(across, helper, NULL);
    /* d2 = t x d1 with t = -direction */
    crn_vec3 tangent = crn_vec3_make(-direction.v[0], -direction.v[1], -direction.v[2]);
    model->base_axis2_q30 = crn_vec3_cross(tangent, model->base_axis1_q30, 30);
}

/* Derives the constants of every tool of the table. If the table has more tools than can be nested at once,
 * and the mesh would have too many elements, the function makes the elements of the shaft longer. The
 * function also chooses the number format of the matrix so that any tools of the table can be nested. */
static crn_build_status build_table(crn_model *model, const crn_instrument *table, crn_build_place *place)
{
    enum { STEPS = 16 }; /* from 4 mm to more than 8 mm */
    const int32_t shaft_max = micrometres_to_q30(CRN_ELEMENT_MAX_um);
    mesh_plan plan = plan_mesh(table, model->table_count);
    crn_build_status status = build_mesh(model, &plan);
    for (int i = 0; i < STEPS && status == CRN_BUILD_LENGTH && model->table_count > model->tool_count; i++) {
        const int32_t longer = plan.shaft + plan.shaft / 16;
        plan.shaft = longer < shaft_max ? longer : shaft_max;
        status = build_mesh(model, &plan);
    }
    if (status != CRN_BUILD_OK) {
        return status;
    }
    for (uint32_t k = 0; k < model->table_count; k++) {
        build_tool(model, k, &table[k]);
    }
    for (uint32_t k = 0; k < model->table_count && status == CRN_BUILD_OK; k++) {
        status = check_reach(model, k, &table[k], place);
    }
    status = status == CRN_BUILD_OK ? check_mass(model) : status;
    return status == CRN_BUILD_OK ? choose_exponent(model) : status;
}

static void clear_model(crn_model *model)
{
    unsigned char *bytes = (unsigned char *)model;
    for (size_t i = 0; i < sizeof *model; i++) {
        bytes[i] = 0;
    }
}

crn_build_status crn_model_build_table(crn_model *model, const crn_instrument *table, uint32_t table_count,
                                       const uint32_t *line, uint32_t line_count, const crn_lumen *lumen,
                                       const crn_entry *entry, crn_build_place *place)
{
    crn_build_status status = crn_check_table(table, table_count, place);
    if (status == CRN_BUILD_OK) {
        status = crn_check_line(table, table_count, line, line_count, place);
    }
    if (status == CRN_BUILD_OK) {
        status = crn_check_entry(entry);
    }
    if (status != CRN_BUILD_OK) {
        return status;
    }
    clear_model(model);
#if CRN_HAS_LANES
    model->has_lanes = crn_lanes_present();
#endif
    model->lumen = lumen;
    model->entry = *entry;
    model->table_count = table_count;
    model->tool_count = line_count;
    model->stall_N_q22 = 6 << 22;
    model->added_kg_m3 = scaled(entry->blood_kg_m3, 6283185, 1000000);
    status = build_table(model, table, place);
    if (status != CRN_BUILD_OK) {
        return status;
    }
    model->contact = CRN_CONTACT_STIFFNESS_N_m << model->stiffness_exponent;
    model->contact_deep = CRN_CONTACT_STIFFNESS_DEEP_N_m << model->stiffness_exponent;
    model->friction = CRN_FRICTION_STIFFNESS_N_m << model->stiffness_exponent;
    if (lumen != NULL && lumen->motion != NULL) {
        crn_motion_steepness_make(lumen->motion, &model->steepness);
    }
    if (lumen != NULL && lumen->walls != NULL) {
        crn_wall_build(lumen->walls, model->walls);
    }
    build_base_axes(model);
    for (uint32_t k = 0; k < line_count; k++) {
        model->line[k] = line[k];
        crn_exchange_put(model, k, line[k]);
    }
    crn_model_set_gravity(model, 0, 0, -9810);
    return CRN_BUILD_OK;
}

crn_build_status crn_model_build(crn_model *model, const crn_instrument *tools, uint32_t tool_count,
                                 const crn_lumen *lumen, const crn_entry *entry, crn_build_place *place)
{
    static const uint32_t all[CRN_TOOL_MAX] = {1, 2, 3};
    return crn_model_build_table(model, tools, tool_count, all, tool_count, lumen, entry, place);
}

void crn_model_set_gravity(crn_model *model, int32_t x_mm_s2, int32_t y_mm_s2, int32_t z_mm_s2)
{
    const int32_t gravity[3] = {x_mm_s2, y_mm_s2, z_mm_s2};
    for (int k = 0; k < 3; k++) {
        model->gravity_m_s2_q20[k] = scaled(gravity[k], 1u << 20, 1000u);
    }
}

void crn_model_set_tip_load(crn_model *model, crn_vec3 load_N_q22)
{
    const int32_t most_N_q22 = 100 << 22;
    for (int k = 0; k < 3; k++) {
        model->tip_load_N_q22.v[k] = crn_clamp(load_N_q22.v[k], -most_N_q22, most_N_q22);
    }
}

void crn_model_set_tip_hold(crn_model *model, const crn_tip_hold *hold)
{
    model->hold = *hold;
}
