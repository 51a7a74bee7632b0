/* This file runs the elastica cases (large bending of a cantilever) on the core; see cantilever.h. */
#include "firmware/tests/reference/cantilever.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdlib.h>

const reference_elastica reference_tip_load[REFERENCE_TIP_LOADS] = {
    {0.5, .015919, .162144}, {1, .056433, .301721}, {2, .160642, .493457},
    {4, .328941, .669964},   {5, .387628, .713792}, {10, .554996, .810609}};
const reference_elastica reference_self_weight[REFERENCE_SELF_WEIGHTS] = {
    {1, .008754, .123471},  {2, .033107, .238507},  {5, .153343, .495905},
    {10, .343646, .700200}, {20, .554768, .829881}, {50, .754985, .907917}};

enum { MASS_mg_per_m = 1000, SETTLE_TICKS = 500 };

double reference_length_m(double bend_N_m2)
{
    return bend_N_m2 <= 1e-5 ? 0.1 : 0.5;
}

typedef struct cantilever {
    crn_model model;
    crn_state state;
    double length_m;
} cantilever;

/* The length of the elements is L / n, rounded up to whole micrometres. Because the elements' length is
 * rounded up, the introducer sheath's distal end lies inside the last element, and the sheath covers a part
 * of this element. */
static cantilever *make(double bend_N_m2, uint32_t elements)
{
    cantilever *c = malloc(sizeof *c);
    c->length_m = reference_length_m(bend_N_m2);
    uint32_t element_um = (uint32_t)ceil(c->length_m * 1e6 / elements);
    crn_instrument wire = reference_wire(bend_N_m2, element_um * (elements + 8), element_um, 0);
    wire.knots[0].mass_mg_per_m = wire.knots[1].mass_mg_per_m = MASS_mg_per_m;
    crn_entry entry = reference_entry();
    crn_build_place place;
    if (crn_model_build(&c->model, &wire, 1, NULL, &entry, &place) != CRN_BUILD_OK) abort();
    crn_model_set_gravity(&c->model, 0, 0, 0);
    uint32_t inserted_um = (uint32_t)lround(c->length_m * 1e6);
    crn_state_init(&c->model, &c->state, &inserted_um);
    c->length_m = crn_state_inserted(&c->state, 0) / 1073741824.0;
    return c;
}

static double error_pct(const cantilever *c, const reference_elastica *load)
{
    crn_vec3 tip = crn_state_position(&c->state, 0);
    double shortening = 1 - tip.v[0] / 1073741824.0 / c->length_m;
    double deflection = fabs(tip.v[2] / 1073741824.0 / c->length_m);
    return 100 * hypot(shortening - load->shortening, deflection - load->deflection);
}

static double settle(cantilever *c, const reference_elastica *load, uint32_t ticks_max)
{
    crn_input input = {0};
    crn_output output;
    double before = 0, now = 100;
    for (uint32_t tick = 0; tick < ticks_max && fabs(now - before) > 1e-5; tick += SETTLE_TICKS) {
        for (int i = 0; i < SETTLE_TICKS; i++) crn_step(&c->model, &c->state, &input, &output);
        before = now;
        now = error_pct(c, load);
    }
    free(c);
    return now;
}

double reference_tip_load_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                    uint32_t ticks_max)
{
    cantilever *c = make(bend_N_m2, elements);
    double force_N = load->load * bend_N_m2 / (c->length_m * c->length_m);
    crn_model_set_tip_load(&c->model, crn_vec3_make(0, 0, (int32_t)lround(-force_N * 4194304)));
    return settle(c, load, ticks_max);
}

double reference_self_weight_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                       uint32_t ticks_max)
{
    cantilever *c = make(bend_N_m2, elements);
    double weight_N_m = load->load * bend_N_m2 / pow(c->length_m, 3);
    crn_model_set_gravity(&c->model, 0, 0, -(int32_t)lround(weight_N_m / (MASS_mg_per_m * 1e-6) * 1000));
    return settle(c, load, ticks_max);
}
