/* A line of tools with what its ticks need, and a bound with its name: for tests of the rod. Include after cmocka.h.
 * May include: core_state.h, tube_lumen.h. Called by: firmware/tests. */
#ifndef SELD_REFERENCE_ROD_RIG_H
#define SELD_REFERENCE_ROD_RIG_H

#include <stdlib.h>

#include "firmware/core/core_state.h"
#include "firmware/tests/reference/tube_lumen.h"

typedef struct rig {
    seld_model model;
    seld_state state;
    seld_input input;
    seld_output output;
} rig;

/* Tools that enter where every reference scene is entered; one length inserted for each. Freed by the caller. */
static inline rig *rig_of(const seld_instrument *tools, uint32_t count, const seld_lumen *lumen,
                          const uint32_t *inserted_um)
{
    rig *r = calloc(1, sizeof *r);
    seld_entry entry = reference_entry();
    seld_build_place place;
    assert_int_equal(seld_model_build(&r->model, tools, count, lumen, &entry, &place), SELD_BUILD_OK);
    seld_state_init(&r->model, &r->state, inserted_um);
    return r;
}

static inline rig *rig_make(const seld_instrument *wire, const seld_lumen *lumen, uint32_t inserted_um)
{
    return rig_of(wire, 1, lumen, &inserted_um);
}

static inline void rig_step(rig *r)
{
    seld_step(&r->model, &r->state, &r->input, &r->output);
}

static inline void check_below(const char *what, double value, double most)
{
    if (!(value <= most)) fail_msg("%s = %g, allowed %g", what, value, most);
}

#endif
