/* These tests check the combined properties of nested tools. The compliance of a node's cell is the sum of
 * the compliances of its parts with and without the outer tool, wherever the outer tool's tip lies in the
 * cell. A tool's twist stiffness at a point does not depend on which other tool's tip is near. The core
 * refuses tools whose shape, twist stiffness or mass does not fit the mesh, and names the tool.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/core_state.h"
#include "firmware/core/rod.h"
#include "firmware/tests/reference/tube_lumen.h"

static const double Q30 = 1073741824.0;
static const double Q26 = 67108864.0;

typedef struct rig {
    crn_model model;
    crn_state state;
} rig;

static crn_instrument make_tool(double bend_N_m2, uint32_t length_um, uint32_t element_um, uint32_t radius_um,
                                uint32_t bore_um)
{
    crn_instrument tool = reference_wire(bend_N_m2, length_um, element_um, 0.1);
    for (uint32_t i = 0; i < tool.knot_count; i++) {
        tool.knots[i].radius_outer_um = radius_um;
        tool.knots[i].radius_inner_um = bore_um;
    }
    return tool;
}

static crn_build_status build(rig *r, const crn_instrument *tools, uint32_t count, crn_build_place *place)
{
    crn_entry entry = reference_entry();
    return crn_model_build(&r->model, tools, count, NULL, &entry, place);
}

/* The test has two uniform tools, and puts the tip of the outer one at 101 positions in one cell. The
 * expected stiffness W of the cell follows from 1/W = (cell - part) / EI + part / (EI + EI'), where the outer
 * tool with the stiffness EI' covers the length `part` of the cell. The tolerance of the joint's stiffness is
 * 1/1000, for the rounding of the reciprocals and of the cell's length. */
static void check_divided_cell(double inner_N_m2, double outer_N_m2, uint32_t element_um)
{
    rig *r = calloc(1, sizeof *r);
    crn_build_place place;
    const crn_instrument tools[2] = {make_tool(inner_N_m2, element_um * 300, element_um, 445, 0),
                                     make_tool(outer_N_m2, element_um * 300, element_um, 900, 500)};
    assert_int_equal(build(r, tools, 2, &place), CRN_BUILD_OK);
    const uint32_t inserted_um[3] = {element_um * 100, element_um * 50, 0};
    crn_state_init(&r->model, &r->state, inserted_um);
    const int32_t lead = r->state.words.tools[0].inserted_m_q30;
    const uint32_t node = 50;
    const int32_t begin = r->model.mesh[node - 1].cell_end_m_q30, end = r->model.mesh[node].cell_end_m_q30;
    const double cell = (end - begin) / Q30;
    for (int step = 0; step <= 102; step++) {
        int32_t offset =
            step == 101 ? end - 1 : (step == 102 ? begin + 1 : end - (int32_t)(step * (end - begin) / 100.0));
        r->state.words.tools[1].inserted_m_q30 = lead - offset;
        crn_line_update(&r->model, &r->state);
        const double part = (end - offset) / Q30;
        const double exact = 1 / ((cell - part) / inner_N_m2 + part / (inner_N_m2 + outer_N_m2));
        const double bend = r->state.line.nodes[node].joint.bend_N_m_q26 / Q26;
        if (fabs(bend / exact - 1) > 1e-3)
            fail_msg("EI %g + %g, cell %g mm, covered %.9f mm: W %.6f, series average %.6f", inner_N_m2,
                     outer_N_m2, 1e3 * cell, 1e3 * part, bend, exact);
    }
    free(r);
}

static void a_tip_anywhere_in_a_cell_gives_the_series_average(void **context)
{
    (void)context;
    check_divided_cell(1.85e-3, 4e-4, 1000);
    check_divided_cell(4.9e-3, 1e-3, 2000);
    check_divided_cell(3e-2, 1e-3, 4000);
    check_divided_cell(5e-6, 5e-4, 1000);
}

/* The twist stiffness of a wire grows by a factor of 500 over 300 mm. At the tip of the catheter around the
 * wire, the twist stiffness keeps its value GJ(arc) / cell. The tolerance of 2 % allows for the change of
 * stiffness that the taper causes over one cell. */
static void a_catheters_tip_leaves_the_wires_twist_stiffness(void **context)
{
    (void)context;
    rig *r = calloc(1, sizeof *r);
    crn_build_place place;
    crn_instrument tools[2] = {make_tool(1e-3, 600000, 4000, 445, 0),
                               make_tool(4e-4, 600000, 4000, 900, 500)};
    tools[0].knot_count = 3;
    tools[0].knots[2] = tools[0].knots[1];
    tools[0].knots[1].arc_um = 300000;
    tools[0].knots[0].twist_stiffness_nN_m2 = 2000;
    tools[0].knots[1].twist_stiffness_nN_m2 = tools[0].knots[2].twist_stiffness_nN_m2 = 1000000;
    assert_int_equal(build(r, tools, 2, &place), CRN_BUILD_OK);
    for (uint32_t behind_um = 101000; behind_um < 400000; behind_um += 50000) {
        const uint32_t inserted_um[3] = {500000, 500000 - behind_um, 0};
        crn_state_init(&r->model, &r->state, inserted_um);
        uint32_t node = 0;
        while (r->model.mesh[node].cell_end_m_q30 < r->state.line.offset_m_q30[1]) node++;
        const double arc = r->model.mesh[node].arc_m_q30 / Q30;
        const double exact = (arc < 0.3 ? 2e-6 + (1e-3 - 2e-6) * arc / 0.3 : 1e-3) / 0.004;
        const double twist = r->state.line.nodes[node].joint.twist_N_m_q26[0] / Q26;
        if (fabs(twist / exact - 1) > 0.02)
            fail_msg("catheter's tip %u um behind: twist stiffness %.5f N m, the wire's own %.5f", behind_um,
                     twist, exact);
    }
    free(r);
}

/* --- a pass that builds what has moved ------------------------------------------------------------------ */

/* A wire with a soft tip and a taper, a catheter with a bend between straight parts and a short stiff ring,
 * and an outer catheter of one part. */
static void build_three_tools(rig *r, uint32_t axial_max_N, uint32_t tip_nN_m2)
{
    crn_instrument tools[3] = {make_tool(1e-3, 600000, 2000, 445, 0), make_tool(4e-4, 500000, 3000, 900, 500),
                               make_tool(2e-3, 400000, 4000, 1300, 950)};
    crn_instrument *wire = &tools[0], *catheter = &tools[1];
    wire->knot_count = 4;
    wire->knots[3] = wire->knots[2] = wire->knots[1];
    wire->knots[1] = wire->knots[0];
    wire->knots[0].bend_stiffness_nN_m2 = wire->knots[1].bend_stiffness_nN_m2 = tip_nN_m2;
    wire->knots[1].arc_um = 60000;
    wire->knots[2].arc_um = 90000;
    const uint32_t arcs_um[] = {0, 15000, 15000, 45000, 45000, 120000, 121000, 122000};
    catheter->knots[9] = catheter->knots[8] = catheter->knots[1];
    for (uint32_t i = 0; i < 8; i++) {
        catheter->knots[i] = catheter->knots[0];
        catheter->knots[i].arc_um = arcs_um[i];
    }
    catheter->knots[2].rest_curvature1_per_m_milli = catheter->knots[3].rest_curvature1_per_m_milli = 20000;
    catheter->knots[3].rest_curvature2_per_m_milli = 5000;
    catheter->knots[6].bend_stiffness_nN_m2 *= 3;
    catheter->knot_count = 9;
    for (int k = 0; k < 3; k++) tools[k].axial_stiffness_max_N = axial_max_N;
    crn_build_place place;
    assert_int_equal(build(r, tools, 3, &place), CRN_BUILD_OK);
}

static void insert(rig *r, const int32_t inserted_m_q30[3])
{
    uint32_t free_count = 0;
    for (uint32_t k = 0; k < 3; k++) r->state.words.tools[k].inserted_m_q30 = inserted_m_q30[k];
    const int32_t lead = crn_lead_inserted(&r->model, &r->state.words);
    while (r->model.mesh[free_count].arc_m_q30 < lead) free_count++;
    r->state.words.free_count = free_count;
    crn_line_update(&r->model, &r->state);
}

static void assert_same_line(const rig *kept, const rig *anew, int step)
{
    const crn_line *a = &kept->state.line, *b = &anew->state.line;
    assert_int_equal(a->edge_compliance_m_N_q40, b->edge_compliance_m_N_q40);
    assert_int_equal(a->steady, b->steady);
    for (uint32_t i = 0; i < kept->state.words.free_count + 3; i++) {
        crn_line_node node = a->nodes[i];
        if (i > a->steady) node.compliance_m_N_q40 = b->nodes[i].compliance_m_N_q40; /* not read there */
        if (memcmp(&node, &b->nodes[i], sizeof node) != 0)
            fail_msg("step %d: node %u differs from the node of a pass that builds all", step, i);
    }
}

/* With 100 N and a soft tip, the compliance of the line saturates. Three tools slide by up to 0.4 mm in a
 * step, and jump in some steps. Now and then a tool rests. After each step, the line equals the line of a
 * pass that builds every node. */
static void check_passes(uint32_t axial_max_N, uint32_t tip_nN_m2)
{
    rig *kept = calloc(1, sizeof *kept), *anew = calloc(1, sizeof *anew);
    const uint32_t inserted_um[3] = {300000, 250000, 200000};
    build_three_tools(kept, axial_max_N, tip_nN_m2);
    build_three_tools(anew, axial_max_N, tip_nN_m2);
    crn_state_init(&kept->model, &kept->state, inserted_um);
    crn_state_init(&anew->model, &anew->state, inserted_um);
    const int32_t mm = 1073742, most[3] = {480 * mm, 440 * mm, 380 * mm}, least = 20 * mm;
    int32_t inserted[3] = {300 * mm, 250 * mm, 200 * mm};
    uint32_t chance = 1;
    for (int step = 0; step < 4000; step++) {
        for (int k = 0; k < 3; k++) {
            chance = chance * 1664525u + 1013904223u;
            const int32_t reach = (chance >> 8) % 50 == 0 ? 60 * mm : 2 * mm / 5;
            const int32_t way = (int32_t)(chance >> 3) % reach;
            if ((chance >> 28) < 6) continue; /* it rests */
            inserted[k] += step / 500 % 2 == 0 ? way : -way;
            inserted[k] = crn_clamp(inserted[k], least, most[k]);
        }
        insert(kept, inserted);
        anew->state.line.count = 0;
        insert(anew, inserted);
        assert_same_line(kept, anew, step);
    }
    free(kept);
    free(anew);
}

static void a_pass_that_keeps_nodes_gives_the_values_of_one_that_builds_all(void **context)
{
    (void)context;
    check_passes(10000, 20000);
    check_passes(100, 300);
}

/* --- refusals ------------------------------------------------------------------------------------------- */

static void check_refused(const crn_instrument *tools, uint32_t count, crn_build_status status, uint32_t tool,
                          uint32_t knot)
{
    rig *r = calloc(1, sizeof *r);
    crn_build_place place;
    assert_int_equal(build(r, tools, count, &place), status);
    assert_int_equal(place.tool, tool);
    assert_int_equal(place.knot, knot);
    free(r);
}

/* Elements of 4 mm cannot follow a tip of 3 mm radius, because each element would turn by 1.33 rad. Elements
 * of 3 mm can follow a tip of 3 mm radius, because each element turns by 1 rad. */
static void a_curve_tighter_than_the_elements_is_refused_at_its_knot(void **context)
{
    (void)context;
    crn_instrument tool = make_tool(1e-4, 600000, 4000, 445, 0);
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[1];
    tool.knots[1] = tool.knots[2] = tool.knots[0];
    tool.knots[1].arc_um = 100000;
    tool.knots[2].arc_um = 130000;
    tool.knots[1].rest_curvature1_per_m_milli = tool.knots[2].rest_curvature2_per_m_milli = 0;
    tool.knots[2].rest_curvature1_per_m_milli = 333000;
    tool.knots[3].rest_curvature1_per_m_milli = 333000;
    check_refused(&tool, 1, CRN_BUILD_ELEMENTS, 0, 1); /* between knots 1 and 2 the curve becomes too tight */
    tool.element_tip_um = tool.element_shaft_um = 3000;
    rig *r = calloc(1, sizeof *r);
    crn_build_place place;
    assert_int_equal(build(r, &tool, 1, &place), CRN_BUILD_OK);
    free(r);
}

static void a_tool_that_cannot_reach_the_shortest_line_is_refused(void **context)
{
    (void)context;
    const crn_instrument tools[2] = {make_tool(1e-4, 20000, 8000, 445, 0),
                                     make_tool(4e-4, 600000, 8000, 900, 500)};
    check_refused(tools, 2, CRN_BUILD_LENGTH, 0, 0);
}

/* With elements of 1 mm, a twist stiffness of 3e-2 N m^2 gives each joint a stiffness of 30 N m, beyond the
 * limit of 16 N m. */
static void a_twist_beyond_the_joints_format_is_refused(void **context)
{
    (void)context;
    crn_instrument tool = make_tool(1e-3, 200000, 1000, 445, 0);
    for (uint32_t i = 0; i < tool.knot_count; i++) tool.knots[i].twist_stiffness_nN_m2 = 30000000;
    check_refused(&tool, 1, CRN_BUILD_OVERFLOW, 0, 0);
}

/* The tool of this test has a bending stiffness of 1e-7 N m^2 over its first 100 mm and of 3e-2 N m^2 behind
 * them. With elements of 8 mm, each of the two stiffnesses alone would be allowed. No single exponent of the
 * number format represents both stiffnesses with enough bits; the computed shape of the tip would be noise,
 * so the core refuses the tool. */
static void a_tip_too_soft_beside_its_shaft_is_refused(void **context)
{
    (void)context;
    crn_instrument tool = make_tool(3e-2, 600000, 8000, 445, 0);
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[2] = tool.knots[1];
    tool.knots[1] = tool.knots[0];
    tool.knots[1].arc_um = 100000;
    tool.knots[2].arc_um = 101000;
    tool.knots[0].bend_stiffness_nN_m2 = tool.knots[1].bend_stiffness_nN_m2 = 100;
    check_refused(&tool, 1, CRN_BUILD_OVERFLOW, 0, 0);
}

static void a_mass_beyond_the_nodes_format_is_refused(void **context)
{
    (void)context;
    crn_instrument tools[3] = {make_tool(1e-3, 600000, 8000, 445, 0), make_tool(1e-3, 600000, 8000, 900, 500),
                               make_tool(1e-3, 600000, 8000, 1300, 950)};
    for (int k = 0; k < 3; k++)
        for (uint32_t i = 0; i < tools[k].knot_count; i++) tools[k].knots[i].mass_mg_per_m = 100000;
    check_refused(tools, 3, CRN_BUILD_OVERFLOW, 0, 0); /* 3 x 0.1 kg/m x 8 mm = 2.4 g */
}

/* --- weight and inertia in blood -------------------------------------------------------------------------
 */

enum { MILLIGRAMS_WIRE = 3900, MILLIGRAMS_CATHETER = 2500 };

/* Weight and inertia of one node of a line in blood, in mg per m; the node lies in the middle of the line. */
typedef struct node_mass {
    double weight_mg_m, inertia_mg_m;
} node_mass;

static node_mass mass_in_blood(const crn_instrument *tools, uint32_t count, uint32_t blood_kg_m3)
{
    rig *r = calloc(1, sizeof *r);
    crn_entry entry = reference_entry();
    entry.blood_kg_m3 = blood_kg_m3;
    crn_build_place place;
    assert_int_equal(crn_model_build(&r->model, tools, count, NULL, &entry, &place), CRN_BUILD_OK);
    const uint32_t inserted_um[3] = {200000, 199000, 198000};
    crn_state_init(&r->model, &r->state, inserted_um);
    const uint32_t node = 50;
    const double cell_m = (r->model.mesh[node].cell_end_m_q30 - r->model.mesh[node - 1].cell_end_m_q30) / Q30;
    const crn_line_node *here = &r->state.line.nodes[node];
    const node_mass mass = {1e6 * here->weight_kg_q40 / 1099511627776.0 / cell_m,
                            1e6 * here->mass_kg_q40 / 1099511627776.0 / cell_m};
    free(r);
    return mass;
}

/* A tool weighs m - rho pi (ro^2 - ri^2) per length in blood, and a wire in a catheter's lumen loses its own
 * displacement. Moved across, the line carries along the blood in the catheter around the wire, and as much
 * as the catheter's outside displaces. In air, weight and inertia are the mass. The tolerance of 0.5 mg/m
 * stands for the rounding of a node's mass, 0.2 mg/m. */
static void tools_in_blood_lose_weight_and_gain_inertia(void **context)
{
    (void)context;
    crn_instrument tools[2] = {make_tool(1e-3, 600000, 2000, 445, 0),
                               make_tool(1e-3, 600000, 2000, 835, 485)};
    for (uint32_t i = 0; i < tools[0].knot_count; i++) {
        tools[0].knots[i].mass_mg_per_m = MILLIGRAMS_WIRE;
        tools[1].knots[i].mass_mg_per_m = MILLIGRAMS_CATHETER;
    }
    const double rho = 1060e6 * acos(-1.0), wire = rho * 445e-6 * 445e-6, bore = rho * 485e-6 * 485e-6,
                 outside = rho * 835e-6 * 835e-6;
    const node_mass alone = mass_in_blood(tools, 1, CRN_BLOOD_kg_m3);
    assert_true(fabs(alone.weight_mg_m - (MILLIGRAMS_WIRE - wire)) < 0.5);
    assert_true(fabs(alone.inertia_mg_m - (MILLIGRAMS_WIRE + wire)) < 0.5);
    const node_mass both = mass_in_blood(tools, 2, CRN_BLOOD_kg_m3);
    const double sum = MILLIGRAMS_WIRE + MILLIGRAMS_CATHETER;
    assert_true(fabs(both.weight_mg_m - (sum - wire - (outside - bore))) < 0.5);
    assert_true(fabs(both.inertia_mg_m - (sum + (bore - wire) + outside)) < 0.5);
    const node_mass air = mass_in_blood(tools, 2, 0);
    assert_true(fabs(air.weight_mg_m - sum) < 0.5 && air.inertia_mg_m == air.weight_mg_m);
}

/* A wide, light tool floats: 0.5 g/m with a radius of 2 mm displaces 13.3 g/m. Its inertia stays that of a
 * tool in blood. */
static void a_light_tool_floats(void **context)
{
    (void)context;
    crn_instrument tool = make_tool(1e-3, 600000, 2000, 2000, 0);
    for (uint32_t i = 0; i < tool.knot_count; i++) tool.knots[i].mass_mg_per_m = 500;
    const double blood = 1060e6 * acos(-1.0) * 4e-6;
    const node_mass mass = mass_in_blood(&tool, 1, CRN_BLOOD_kg_m3);
    assert_true(fabs(mass.weight_mg_m - (500 - blood)) < 1.5);
    assert_true(fabs(mass.inertia_mg_m - (500 + blood)) < 1.5);
}

/* Where the tip of a wide, floating tool lies in a cell, the cell weighs less than nothing and moves little
 * blood along. Its inertia is never below that of 0.5 g/m, the lightest tool. */
static void a_cell_is_never_lighter_than_the_lightest_tool(void **context)
{
    (void)context;
    crn_instrument tools[2] = {make_tool(1e-3, 600000, 2000, 100, 0),
                               make_tool(1e-3, 600000, 2000, 2000, 110)};
    for (int k = 0; k < 2; k++)
        for (uint32_t i = 0; i < tools[k].knot_count; i++) tools[k].knots[i].mass_mg_per_m = 500;
    crn_entry entry = reference_entry();
    entry.blood_kg_m3 = CRN_BLOOD_kg_m3;
    crn_build_place place;
    rig *r = calloc(1, sizeof *r);
    assert_int_equal(crn_model_build(&r->model, tools, 2, NULL, &entry, &place), CRN_BUILD_OK);
    double least_mg_m = 1e9;
    for (uint32_t outer_um = 150000; outer_um < 152000; outer_um += 100) {
        const uint32_t inserted_um[2] = {200000, outer_um};
        crn_state_init(&r->model, &r->state, inserted_um);
        for (uint32_t i = 1; i < 90; i++) {
            const double cell_m =
                (r->model.mesh[i].cell_end_m_q30 - r->model.mesh[i - 1].cell_end_m_q30) / Q30;
            least_mg_m =
                fmin(least_mg_m, 1e6 * r->state.line.nodes[i].mass_kg_q40 / 1099511627776.0 / cell_m);
        }
    }
    assert_true(fabs(least_mg_m - 500) < 0.5);
    free(r);
}

/* --- the matrix of a joint -------------------------------------------------------------------------------
 */

/* A joint's part of the matrix is W (a, c)^T (a, c) with a and c, the inverse lengths of its edges, so it has
 * the rank one: p r = q^2 and p / q = a / c. The end of the sheath makes W larger in the joints that it cuts.
 */
static void the_matrix_of_a_joint_is_that_of_one_rotation(void **context)
{
    (void)context;
    crn_instrument wire = make_tool(1e-3, 600000, 2000, 445, 0);
    wire.element_tip_um = 1000;
    wire.element_fine_um = 40000;
    crn_build_place place;
    rig *r = calloc(1, sizeof *r);
    assert_int_equal(build(r, &wire, 1, &place), CRN_BUILD_OK);
    double stiffest = 0;
    for (uint32_t inserted_um = 50000; inserted_um < 52000; inserted_um += 130) {
        crn_state_init(&r->model, &r->state, &inserted_um);
        crn_input input = {0};
        crn_rod_feed(&r->model, &r->state, &input);
        for (uint32_t i = 2; i <= r->state.words.free_count; i++) {
            const crn_joint *joint = crn_rod_joint(&r->state, i);
            const double a_per_c = (double)r->model.mesh[i].length_m_q30 / r->model.mesh[i - 1].length_m_q30;
            assert_true(fabs((double)joint->p * joint->r / joint->q / joint->q - 1) < 1e-5);
            assert_true(fabs((double)joint->p / joint->q / a_per_c - 1) < 1e-5);
            stiffest =
                fmax(stiffest, joint->bend_N_m_q26 / (double)r->state.line.nodes[i].joint.bend_N_m_q26);
        }
    }
    assert_true(stiffest > 3);
    free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tip_anywhere_in_a_cell_gives_the_series_average),
        cmocka_unit_test(a_catheters_tip_leaves_the_wires_twist_stiffness),
        cmocka_unit_test(a_pass_that_keeps_nodes_gives_the_values_of_one_that_builds_all),
        cmocka_unit_test(a_curve_tighter_than_the_elements_is_refused_at_its_knot),
        cmocka_unit_test(a_tool_that_cannot_reach_the_shortest_line_is_refused),
        cmocka_unit_test(a_twist_beyond_the_joints_format_is_refused),
        cmocka_unit_test(a_tip_too_soft_beside_its_shaft_is_refused),
        cmocka_unit_test(a_mass_beyond_the_nodes_format_is_refused),
        cmocka_unit_test(tools_in_blood_lose_weight_and_gain_inertia),
        cmocka_unit_test(a_light_tool_floats),
        cmocka_unit_test(a_cell_is_never_lighter_than_the_lightest_tool),
        cmocka_unit_test(the_matrix_of_a_joint_is_that_of_one_rotation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
