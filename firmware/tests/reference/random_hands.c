/* Random sessions; see random_hands.h. */
#include "firmware/tests/reference/random_hands.h"
#include "firmware/core/lesion.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdlib.h>

static const double Q30 = 1073741824.0;
enum { RELEASE_TICKS = 300, SPEED_TICKS = 200, EXACT_EVERY = 10 };

/* Makes a tool that is curved and soft over the first `bent_mm` behind its tip. */
static crn_instrument make_tool(double tip_N_m2, double shaft_N_m2, double curve_per_m, double bent_mm,
                                uint32_t radius_um, uint32_t bore_um)
{
    crn_instrument tool = reference_wire(shaft_N_m2, 900000, 4000, 0.1);
    tool.element_tip_um = 1000;
    tool.element_fine_um = 40000;
    tool.lumen_friction_milli = 50;
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[1];
    for (int i = 0; i < 3; i++) tool.knots[i] = tool.knots[0];
    for (int i = 0; i < 4; i++) {
        tool.knots[i].radius_outer_um = radius_um;
        tool.knots[i].radius_inner_um = bore_um;
    }
    tool.knots[1].arc_um = tool.knots[2].arc_um = (uint32_t)lround(1000 * bent_mm);
    for (int i = 0; i < 2; i++) {
        tool.knots[i].bend_stiffness_nN_m2 = tool.knots[i].twist_stiffness_nN_m2 =
            (uint32_t)lround(1e9 * tip_N_m2);
        tool.knots[i].rest_curvature1_per_m_milli = (int32_t)lround(1000 * curve_per_m);
    }
    tool.knots[2].bend_stiffness_nN_m2 = tool.knots[1].bend_stiffness_nN_m2; /* it tapers to the end */
    return tool;
}

typedef struct session {
    crn_model model;
    crn_state state;
    crn_input input;
    crn_output output;
    reference_tube *vessel;
    crn_lumen lumen;
    crn_walls walls;
    uint8_t *law_of_brick;
    reference_random random;
    int32_t speed[CRN_TOOL_MAX], turn[CRN_TOOL_MAX];
} session;

/* A soft and a stiff law, each for every other pair of bricks along the trunk. */
static void soften(session *s)
{
    static const crn_wall_law laws[] = {{5000, 50000, 50, 10000, 10000, 2000, {0, 0}},
                                        {40000, 200000, 200, 5000, 5000, 500, {0, 0}}};
    const uint32_t *n = s->lumen.brick_count_xyz;
    s->law_of_brick = malloc((size_t)n[0] * n[1] * n[2]);
    for (uint32_t i = 0; i < n[0] * n[1] * n[2]; i++) s->law_of_brick[i] = (uint8_t)(1 + i % n[0] / 2 % 2);
    s->walls = (crn_walls){2, laws, s->law_of_brick};
    s->lumen.walls = &s->walls;
}

static session *start(uint32_t tool_count, uint32_t number)
{
    static const double shaft_N_m2[] = {2e-4, 5e-4, 1.85e-3, 4.9e-3, 1e-3};
    const reference_piece trunk = {0.2, 0, 0};
    const reference_piece left[] = {{0.08, 1.2, 0}, {0.2, 0.5, 0.4}};
    const reference_piece right[] = {{0.08, 0.9, 3.14}, {0.2, -0.6, 1}};
    const uint32_t inserted_um[] = {60000, 40000, 20000};
    crn_instrument tools[] = {
        make_tool(number % 4 == 0 ? 2e-6 : 1e-5, shaft_N_m2[number % 5], number % 2 ? 66 : 0, 20, 445, 0),
        make_tool(2e-4, 4e-4 + 1e-4 * (number % 6), 30, 40, 800, 500),
        make_tool(5e-4, 8e-4, number % 2 ? 0 : 15, 40, 1150, 850)};
    if (number >= REFERENCE_HANDS_WITH_MATERIALS) {
        tools[0].material = (crn_material){CRN_SUPERELASTIC, 5000, 60000, 100, 400, 6000};
        tools[1].material = tools[2].material = (crn_material){CRN_PLASTIC, 8000, 40000, 100, 0, 0};
    }
    crn_entry entry = reference_entry();
    crn_build_place place;
    session *s = calloc(1, sizeof *s);
    s->vessel = reference_fork_make(&trunk, left, right, 0.005, 1);
    s->random = reference_random_seed(1000 + number);
    s->lumen = s->vessel->lumen;
    if (number >= REFERENCE_HANDS_WITH_WALLS) soften(s);
    if (crn_model_build(&s->model, tools, tool_count, &s->lumen, &entry, &place) != CRN_BUILD_OK) abort();
    crn_state_init(&s->model, &s->state, inserted_um);
    return s;
}

static void move_hands(session *s, uint32_t tool_count, int tick)
{
    for (uint32_t k = 0; k < tool_count; k++) {
        if (tick % SPEED_TICKS == 0) {
            double inserted_m = crn_state_inserted(&s->state, k) / Q30;
            s->speed[k] = (int32_t)reference_random_below(&s->random, 1073742) - 536871;
            s->turn[k] = (int32_t)reference_random_below(&s->random, 16400000) - 8200000;
            if (reference_random_below(&s->random, 4) == 0) s->speed[k] = 0;
            if (inserted_m > 0.5) s->speed[k] = -abs(s->speed[k]);
            if (inserted_m < 0.02) s->speed[k] = abs(s->speed[k]);
        }
        s->input.hands[k].feed_m_q30 = crn_add_sat(s->input.hands[k].feed_m_q30, s->speed[k]);
        s->input.hands[k].turn32 += (uint32_t)s->turn[k];
    }
}

/* Returns the largest depth of any node beyond the wall in mm, by the exact distance to the wall, which the
 * tools have pushed aside. */
static double exact_depth_mm(const session *s)
{
    double deepest = -1e3;
    for (uint32_t i = 0; i < crn_state_free_count(&s->state); i++) {
        crn_vec3 p = crn_state_position(&s->state, i);
        const crn_wall_give give = crn_wall_give_at(&s->state.words.wall, crn_model_arc(&s->model, i));
        double x[3];
        for (int k = 0; k < 3; k++) x[k] = (p.v[k] - give.way_m_q30.v[k]) / Q30;
        double depth_m =
            reference_tube_distance(s->vessel, x) + (crn_state_radius(&s->state, i) - give.widen_m_q30) / Q30;
        deepest = fmax(deepest, 1e3 * depth_m);
    }
    return deepest;
}

void reference_random_hands(uint32_t tool_count, uint32_t number, int ticks, reference_hands_result *result)
{
    session *s = start(tool_count, number);
    for (int t = 0; t < ticks; t++) {
        move_hands(s, tool_count, t);
        crn_step(&s->model, &s->state, &s->input, &s->output);
        if (t < RELEASE_TICKS) continue;
        double strain_pct = 100 * fabs(s->output.strain_max_q30 / Q30);
        double depth_mm = 1e3 * s->output.penetration_max_m_q30 / Q30;
        if (t % EXACT_EVERY == 0) depth_mm = fmax(depth_mm, exact_depth_mm(s));
        result->ticks++;
        result->saturated += (s->output.fault_bits & CRN_FAULT_SATURATED) != 0;
        result->deep += depth_mm > 1;
        result->long_045 += strain_pct > 0.45;
        result->strain_max_pct = fmax(result->strain_max_pct, strain_pct);
        result->depth_max_mm = fmax(result->depth_max_mm, depth_mm);
        for (uint32_t j = 0; j < s->state.words.wall.used; j++) {
            const int32_t *way = s->state.words.wall.stations[j].way_m_q30.v;
            result->way_max_mm =
                fmax(result->way_max_mm, 1e3 * sqrt(pow(way[0], 2) + pow(way[1], 2) + pow(way[2], 2)) / Q30);
        }
    }
    result->sets_bits |= s->state.words.set.used_bits;
    reference_tube_free(s->vessel);
    free(s->law_of_brick);
    free(s);
}
