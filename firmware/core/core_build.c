/* Set-up: instrument -> constants. Runs once per instrument, so it may divide (bit by bit) and take its time.
 * Averages over a joint's cell follow docs/rod.md: compliance is averaged, not stiffness ("series"), because
 * arithmetic averages across a stiffness step give force spikes at the handle.
 * May include: core_model.h. Called by: firmware/app, tools, tests through core.h. */
#include "firmware/core/core_model.h"

enum {
    ARC_MIN_um = 20000,
    ARC_MAX_um = 1600000,
    RATIO_AXIAL_TO_BEND = 256, /* k_s / w: above about 450 the fixed-point solve loses accuracy */
    CLIP_FACTOR_MAX = 10,      /* a cell clipped at the mouth keeps at least a tenth of its length */
    BEND_MAX_N_m = 16, /* W of a joint, and W / l: bound the products of joint_forces() in rod_force.c */
    FOLD_MAX_N = 8192,
    LOAD_RESERVE_N_m = 250000, /* room in the diagonal for contact, friction and tension */
};

typedef enum property { BEND, TWIST, MASS, RADIUS, KINETIC, STATIC, TURN1, TURN2 } property;

static int64_t knot_value(const seld_knot *knot, property which)
{
    switch (which) {
    case BEND:
        return knot->bend_stiffness_nN_m2;
    case TWIST:
        return knot->twist_stiffness_nN_m2;
    case MASS:
        return knot->mass_mg_per_m;
    case RADIUS:
        return knot->radius_outer_um;
    case KINETIC:
        return knot->friction_kinetic_milli;
    case STATIC:
        return knot->friction_static_milli;
    case TURN1:
        return knot->rest_curvature1_per_m_milli;
    case TURN2:
        return knot->rest_curvature2_per_m_milli;
    }
    return 0;
}

/* floor(a b / c) for signed a and positive b, c; |a b| < 2^63. */
static int64_t scale(int64_t a, int64_t b, int64_t c)
{
    int64_t product = a * b;
    uint64_t quotient = seld_divide_u64((uint64_t)(product < 0 ? -product : product), (uint64_t)c);
    return product < 0 ? -(int64_t)quotient : (int64_t)quotient;
}

static int32_t micrometres_to_q30(uint32_t um)
{
    return (int32_t)seld_divide_u64(((uint64_t)um << 30) + 500000u, 1000000u);
}

static uint32_t q30_to_nanometres(int32_t m_q30)
{
    return (uint32_t)(((uint64_t)(uint32_t)m_q30 * 1000000000u) >> 30);
}

/* --- checks
 * -------------------------------------------------------------------------------------------------- */

static bool in_range(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

static bool knot_in_range(const seld_knot *k)
{
    return in_range(k->bend_stiffness_nN_m2, 100, 30000000) &&
           in_range(k->twist_stiffness_nN_m2, 100, 30000000) && in_range(k->mass_mg_per_m, 500, 100000) &&
           in_range(k->radius_outer_um, 100, 2000) && k->friction_static_milli <= 1000 &&
           k->friction_kinetic_milli <= k->friction_static_milli &&
           k->rest_curvature1_per_m_milli >= -1000000 && k->rest_curvature1_per_m_milli <= 1000000 &&
           k->rest_curvature2_per_m_milli >= -1000000 && k->rest_curvature2_per_m_milli <= 1000000;
}

static seld_build_status check_instrument(const seld_instrument *instrument, uint32_t *field)
{
    *field = 0;
    if (!in_range(instrument->knot_count, 2, SELD_KNOT_MAX) || instrument->knots[0].arc_um != 0) {
        return SELD_BUILD_KNOTS;
    }
    for (uint32_t i = 0; i < instrument->knot_count; i++) {
        *field = i;
        if (!knot_in_range(&instrument->knots[i])) {
            return SELD_BUILD_RANGE;
        }
        if (i > 0 && instrument->knots[i].arc_um < instrument->knots[i - 1].arc_um) {
            return SELD_BUILD_KNOTS;
        }
    }
    *field = instrument->knot_count - 1;
    if (!in_range(instrument->knots[instrument->knot_count - 1].arc_um, ARC_MIN_um, ARC_MAX_um)) {
        return SELD_BUILD_LENGTH;
    }
    *field = 0;
    if (!in_range(instrument->axial_stiffness_max_N, 100, 10000)) {
        return SELD_BUILD_RANGE;
    }
    if (!in_range(instrument->element_tip_um, 200, 8000) ||
        !in_range(instrument->element_shaft_um, instrument->element_tip_um, 8000) ||
        instrument->element_fine_um > ARC_MAX_um) {
        return SELD_BUILD_ELEMENTS;
    }
    return SELD_BUILD_OK;
}

static seld_build_status check_entry(const seld_entry *entry)
{
    const int32_t limit_m_q30 = 2040109465; /* 1.9 m */
    int64_t square = 0;
    for (int k = 0; k < 3; k++) {
        int32_t position = entry->position_m_q30.v[k];
        if (position > limit_m_q30 || position < -limit_m_q30) {
            return SELD_BUILD_ENTRY;
        }
        int64_t component = entry->direction_q30.v[k] >> 2;
        if (component > (1 << 28) + 4 || component < -(1 << 28) - 4) {
            return SELD_BUILD_ENTRY;
        }
        square += component * component;
    }
    int64_t error = square - ((int64_t)1 << 56);
    return (error > ((int64_t)1 << 37) || error < -((int64_t)1 << 37)) ? SELD_BUILD_ENTRY : SELD_BUILD_OK;
}

/* --- mesh
 * ---------------------------------------------------------------------------------------------------- */

/* Element lengths: fine at the tip, growing by at most 3:2 to the shaft's; never shrinking towards the base,
 * which keeps |W| <= 2 in the solve. The instrument ends at the last whole element. */
static seld_build_status build_mesh(seld_model *model, const seld_instrument *instrument)
{
    int32_t total = micrometres_to_q30(instrument->knots[instrument->knot_count - 1].arc_um);
    int32_t shaft = micrometres_to_q30(instrument->element_shaft_um);
    int32_t fine = micrometres_to_q30(instrument->element_fine_um);
    int32_t length = micrometres_to_q30(instrument->element_tip_um);
    int32_t arc = 0;
    uint32_t node = 0;
    while (arc + length <= total + 64) {
        if (node + 2 > SELD_NODE_MAX) {
            return SELD_BUILD_LENGTH;
        }
        model->nodes[node].arc_m_q30 = arc;
        model->edges[node].length_m_q30 = length;
        model->edges[node].inverse_length_per_m_q18 = (int32_t)seld_divide_u64(
            ((uint64_t)1 << 48) + ((uint64_t)(uint32_t)length >> 1), (uint32_t)length);
        arc += length;
        node++;
        if (arc >= fine && length < shaft) {
            int32_t grown = length + (length >> 1);
            length = grown < shaft ? grown : shaft;
        }
    }
    model->nodes[node].arc_m_q30 = arc;
    model->node_count = node + 1;
    /* One more edge than nodes need, so that the solve may read the row behind the last node. */
    model->edges[node] = model->edges[node - 1];
    return model->node_count < 8 ? SELD_BUILD_LENGTH : SELD_BUILD_OK;
}

/* --- profile
 * ------------------------------------------------------------------------------------------------- */

/* Value of a property at an arc length between two knots. */
static int64_t between(const seld_knot *a, const seld_knot *b, property which, uint32_t arc_nm)
{
    int64_t va = knot_value(a, which);
    if (b->arc_um == a->arc_um) {
        return va;
    }
    int64_t from_nm = (int64_t)a->arc_um * 1000;
    int64_t to_nm = (int64_t)b->arc_um * 1000;
    return va + scale(knot_value(b, which) - va, (int64_t)arc_nm - from_nm, to_nm - from_nm);
}

static int64_t value_at(const seld_instrument *instrument, property which, uint32_t arc_nm)
{
    for (uint32_t i = 0; i + 1 < instrument->knot_count; i++) {
        if (arc_nm < instrument->knots[i + 1].arc_um * 1000u) {
            return between(&instrument->knots[i], &instrument->knots[i + 1], which, arc_nm);
        }
    }
    return knot_value(&instrument->knots[instrument->knot_count - 1], which);
}

static int64_t inverse_q43(int64_t value)
{
    return (int64_t)seld_divide_u64((uint64_t)1 << 43, (uint64_t)value);
}

/* Integral of a property, or of its inverse in Q43, over [from, to] by Simpson's rule on each linear piece
 * (exact for the property; for the inverse of a linear taper good to 0.1 % when it at most doubles within one
 * cell). Format: property units x nm; the inverse x nm in Q43. Overflow: impossible, EI >= 100 nN m^2 and
 * cell <= 8 mm keep the inner product below 6 * 2^43 / 100 * 8e6 = 4.3e18. */
static int64_t integrate(const seld_instrument *instrument, property which, bool inverse, uint32_t from_nm,
                         uint32_t to_nm)
{
    int64_t sum = 0;
    for (uint32_t i = 0; i + 1 < instrument->knot_count; i++) {
        const seld_knot *a = &instrument->knots[i];
        const seld_knot *b = &instrument->knots[i + 1];
        uint32_t low = from_nm > a->arc_um * 1000u ? from_nm : a->arc_um * 1000u;
        uint32_t high = to_nm < b->arc_um * 1000u ? to_nm : b->arc_um * 1000u;
        if (high <= low) {
            continue;
        }
        int64_t f0 = between(a, b, which, low);
        int64_t f1 = between(a, b, which, low + (high - low) / 2);
        int64_t f2 = between(a, b, which, high);
        if (inverse) {
            f0 = inverse_q43(f0);
            f1 = inverse_q43(f1);
            f2 = inverse_q43(f2);
        }
        sum += scale(f0 + 4 * f1 + f2, (int64_t)(high - low), 6);
    }
    return sum;
}

typedef struct cell {
    uint32_t from_nm, to_nm;
} cell;

/* The cell of a node in nanometres, half an edge to either side, inside the instrument. */
static cell node_cell(const seld_model *model, uint32_t node, uint32_t end_nm)
{
    int32_t arc = model->nodes[node].arc_m_q30;
    int32_t before = node > 0 ? model->edges[node - 1].length_m_q30 / 2 : 0;
    int32_t after = node + 1 < model->node_count ? model->edges[node].length_m_q30 / 2 : 0;
    cell c = {q30_to_nanometres(arc - before), q30_to_nanometres(arc + after)};
    c.to_nm = c.to_nm > end_nm ? end_nm : c.to_nm;
    return c;
}

/* Stiffness of a cell, 1 / integral ds/EI. Format: N m in Q26. integral = S nm / nN m^2 in Q43 = S / 2^43 per
 * N m, so the value in Q26 is 2^69 / S. */
static int64_t cell_stiffness_q26(const seld_instrument *instrument, property which, cell c)
{
    int64_t sum = integrate(instrument, which, true, c.from_nm, c.to_nm);
    return (int64_t)seld_divide_u64((uint64_t)1 << 59, ((uint64_t)sum >> 10) + 1u);
}

/* Rest turning over a cell as the chord 2 sin(turn / 2) that two unit edges make: g (1 - g^2 / 24).
 * Format: milli/m x nm = 1e-12 rad -> Q30. Overflow: 1000/m over 8 mm = 8 rad saturates at 2 rad. */
static int32_t cell_turn_q30(const seld_instrument *instrument, property which, cell c)
{
    int64_t sum = scale(integrate(instrument, which, false, c.from_nm, c.to_nm), 1, 1000);
    int32_t turn = seld_sat32(scale(sum, SELD_ONE_Q30, 1000000000));
    int32_t square = seld_mul_q30(turn, turn);
    return turn - seld_mul(seld_mul_q30(turn, square), 44739243, 30); /* 1/24 in Q30 */
}

static void build_joint(seld_model *model, const seld_instrument *instrument, uint32_t node, cell c)
{
    seld_joint *joint = &model->joints[node];
    joint->bend_N_m_q26 = seld_sat32(cell_stiffness_q26(instrument, BEND, c));
    joint->twist_N_m_q26 = seld_sat32(cell_stiffness_q26(instrument, TWIST, c));
    joint->turn1_q30 = cell_turn_q30(instrument, TURN1, c);
    joint->turn2_q30 = cell_turn_q30(instrument, TURN2, c);
}

static void build_node(seld_model *model, const seld_instrument *instrument, uint32_t node, cell c)
{
    seld_node *n = &model->nodes[node];
    uint32_t arc_nm = q30_to_nanometres(n->arc_m_q30);
    n->radius_m_q30 = micrometres_to_q30((uint32_t)value_at(instrument, RADIUS, arc_nm));
    n->friction_kinetic_q30 = (int32_t)scale(value_at(instrument, KINETIC, arc_nm), SELD_ONE_Q30, 1000);
    n->friction_static_q30 = (int32_t)scale(value_at(instrument, STATIC, arc_nm), SELD_ONE_Q30, 1000);
    /* mg/m x nm = 1e-15 kg: Q40 = sum * 2^40 / 1e15. */
    int64_t mass = integrate(instrument, MASS, false, c.from_nm, c.to_nm);
    n->mass_kg_q40 = seld_sat32(scale(mass, 1099512, 1000000000));
}

/* --- stiffness in Q(a)
 * --------------------------------------------------------------------------------------- */

/* W a c in N/m with 8 fractional bits. Overflow: W < 2^31 and a c <= 2.5e7 (Q4: 2^28.6): below 2^60. */
static int64_t bend_spring_q8(int32_t bend_q26, int32_t a_q18, int32_t c_q18)
{
    int64_t ac_q18 = ((int64_t)a_q18 * c_q18) >> 18;
    return ((ac_q18 >> 14) * (int64_t)bend_q26) >> 22;
}

static int64_t axial_spring_q8(const seld_model *model, const seld_instrument *instrument, uint32_t edge)
{
    int32_t inverse = model->edges[edge].inverse_length_per_m_q18;
    int64_t cap = ((int64_t)instrument->axial_stiffness_max_N * inverse) >> 10;
    int64_t softest = cap;
    for (uint32_t joint = edge; joint <= edge + 1; joint++) {
        if (joint == 0 || joint + 1 >= model->node_count) {
            continue;
        }
        int64_t w = bend_spring_q8(model->joints[joint].bend_N_m_q26, inverse, inverse) * RATIO_AXIAL_TO_BEND;
        softest = w < softest ? w : softest;
    }
    return softest;
}

/* Shift from 8 fractional bits to Q(a), rounded. */
static int32_t to_exponent(int64_t value_q8, uint32_t exponent)
{
    return seld_sat32(exponent >= 8 ? value_q8 << (exponent - 8)
                                    : seld_rshift_round64(value_q8, 8 - exponent));
}

static seld_build_status choose_exponent(seld_model *model, const int64_t *axial_q8)
{
    int64_t worst_q8 = 0;
    for (uint32_t i = 1; i + 1 < model->node_count; i++) {
        int32_t a = model->edges[i - 1].inverse_length_per_m_q18;
        int32_t bend = model->joints[i].bend_N_m_q26;
        if (bend >= BEND_MAX_N_m << 26 || ((int64_t)bend * a) >> 44 >= FOLD_MAX_N) {
            return SELD_BUILD_OVERFLOW;
        }
        int64_t w = bend_spring_q8(bend, a, a);
        int64_t sum = axial_q8[i - 1] + axial_q8[i] + w * (2 + 4 * CLIP_FACTOR_MAX);
        worst_q8 = sum > worst_q8 ? sum : worst_q8;
    }
    worst_q8 += (int64_t)LOAD_RESERVE_N_m << 8;
    uint32_t exponent = 14;
    while (exponent > 0 && (worst_q8 >> 8) >= ((int64_t)1 << (29 - exponent))) {
        exponent--;
    }
    model->stiffness_exponent = exponent;
    return exponent < 2 ? SELD_BUILD_OVERFLOW : SELD_BUILD_OK;
}

static void build_springs(seld_model *model, const int64_t *axial_q8)
{
    uint32_t exponent = model->stiffness_exponent;
    uint64_t compliance = 0;
    for (uint32_t i = 0; i < model->node_count; i++) {
        seld_edge *edge = &model->edges[i];
        edge->spring = to_exponent(axial_q8[i], exponent);
        int64_t stiffness_q17 = (axial_q8[i] * edge->length_m_q30) >> 21;
        edge->axial_stiffness_N_q17 = seld_sat32(stiffness_q17);
        model->compliance_m_N_q40[i] = compliance > INT32_MAX ? INT32_MAX : (uint32_t)compliance;
        compliance += seld_divide_u64((uint64_t)1 << 48, (uint64_t)axial_q8[i]);
        seld_node *node = &model->nodes[i];
        /* kg in Q40 / (1 ms)^2 -> Q(a) N/m */
        node->inertia = seld_sat32(((int64_t)node->mass_kg_q40 * 1000000) >> (40 - exponent));
        if (i == 0 || i + 1 == model->node_count) {
            continue;
        }
        seld_joint *joint = &model->joints[i];
        int32_t a = model->edges[i - 1].inverse_length_per_m_q18;
        int32_t c = edge->inverse_length_per_m_q18;
        joint->p = to_exponent(bend_spring_q8(joint->bend_N_m_q26, a, a), exponent);
        joint->q = to_exponent(bend_spring_q8(joint->bend_N_m_q26, a, c), exponent);
        joint->r = to_exponent(bend_spring_q8(joint->bend_N_m_q26, c, c), exponent);
    }
    model->contact = SELD_CONTACT_STIFFNESS_N_m << exponent;
    model->contact_deep = SELD_CONTACT_STIFFNESS_DEEP_N_m << exponent;
    model->friction = SELD_FRICTION_STIFFNESS_N_m << exponent;
}

/* Rows of the bending matrix and inertia, all joints present (docs/rod.md, "rows"). */
static void build_rows(seld_model *model)
{
    for (uint32_t i = 0; i < model->node_count; i++) {
        const seld_joint none = {0};
        const seld_joint *before = i > 0 ? &model->joints[i - 1] : &none;
        const seld_joint *here = &model->joints[i];
        const seld_joint *after = &model->joints[i + 1];
        seld_node *node = &model->nodes[i];
        node->diagonal = node->inertia + before->r + here->p + 2 * here->q + here->r + after->p;
        node->off_diagonal = -(here->q + here->r + after->p + after->q);
        node->off_second = after->q;
    }
}

/* Two axes across the direction of insertion, from the coordinate axis least aligned with it. */
static void build_base_axes(seld_model *model)
{
    seld_vec3 direction = model->entry.direction_q30;
    int least = 0;
    for (int k = 1; k < 3; k++) {
        int64_t size_k = direction.v[k] < 0 ? -(int64_t)direction.v[k] : direction.v[k];
        int64_t size_least = direction.v[least] < 0 ? -(int64_t)direction.v[least] : direction.v[least];
        least = size_k < size_least ? k : least;
    }
    seld_vec3 helper = {{0, 0, 0}};
    helper.v[least] = SELD_ONE_Q30;
    seld_vec3 across = seld_vec3_cross(helper, direction, 30);
    model->base_axis1_q30 = seld_vec3_normalise(across, helper, NULL);
    /* d2 = t x d1 with t = -direction */
    seld_vec3 tangent = seld_vec3_make(-direction.v[0], -direction.v[1], -direction.v[2]);
    model->base_axis2_q30 = seld_vec3_cross(tangent, model->base_axis1_q30, 30);
}

seld_build_status seld_model_build(seld_model *model, const seld_instrument *instrument,
                                   const seld_lumen *lumen, const seld_entry *entry, uint32_t *field)
{
    seld_build_status status = check_instrument(instrument, field);
    if (status == SELD_BUILD_OK) {
        status = check_entry(entry);
    }
    if (status != SELD_BUILD_OK) {
        return status;
    }
    unsigned char *bytes = (unsigned char *)model;
    for (size_t i = 0; i < sizeof *model; i++) {
        bytes[i] = 0;
    }
    model->lumen = lumen;
    model->entry = *entry;
    model->stall_N_q22 = 6 << 22;
    status = build_mesh(model, instrument);
    if (status != SELD_BUILD_OK) {
        return status;
    }
    uint32_t end_nm = instrument->knots[instrument->knot_count - 1].arc_um * 1000u;
    for (uint32_t i = 0; i < model->node_count; i++) {
        cell c = node_cell(model, i, end_nm);
        build_node(model, instrument, i, c);
        if (i > 0 && i + 1 < model->node_count) {
            build_joint(model, instrument, i, c);
        }
    }
    int64_t axial_q8[SELD_ARRAY_NODES];
    for (uint32_t i = 0; i < model->node_count; i++) {
        axial_q8[i] = axial_spring_q8(model, instrument, i);
    }
    status = choose_exponent(model, axial_q8);
    if (status != SELD_BUILD_OK) {
        return status;
    }
    build_springs(model, axial_q8);
    build_rows(model);
    build_base_axes(model);
    seld_model_set_gravity(model, 0, 0, -9810);
    return SELD_BUILD_OK;
}

/* Weight per node with the rounding error carried to the next node, so that the total is exact. */
void seld_model_set_gravity(seld_model *model, int32_t x_mm_s2, int32_t y_mm_s2, int32_t z_mm_s2)
{
    const int32_t gravity[3] = {x_mm_s2, y_mm_s2, z_mm_s2};
    for (int k = 0; k < 3; k++) {
        int64_t carry = 0;
        for (uint32_t i = 0; i < model->node_count; i++) {
            /* kg Q40 x mm/s^2 -> N Q22: >> 18, / 1000 */
            int64_t exact = scale((int64_t)model->nodes[i].mass_kg_q40 * gravity[k], 1024, 1000) + carry;
            int64_t rounded = seld_rshift_round64(exact, 28);
            carry = exact - rounded * ((int64_t)1 << 28);
            model->nodes[i].weight_N_q22.v[k] = seld_sat32(rounded);
        }
    }
}

void seld_model_set_tip_load(seld_model *model, seld_vec3 load_N_q22)
{
    model->tip_load_N_q22 = load_N_q22;
}
