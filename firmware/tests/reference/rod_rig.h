/* For tests of the rod, this header provides a set of nested tools with all data that its ticks need. The
 * header also provides a function that checks a value against a bound and prints the value's name. Include it
 * after cmocka.h. */
#ifndef CRN_REFERENCE_ROD_RIG_H
#define CRN_REFERENCE_ROD_RIG_H

#include <stdlib.h>

#include "firmware/core/core_state.h"
#include "firmware/tests/reference/tube_lumen.h"

typedef struct rig {
    crn_model model;
    crn_state state;
    crn_input input;
    crn_output output;
} rig;

/* Places the tools at the entry that all reference scenes share; each tool has its own inserted length. The
 * caller frees the rig. */
static inline rig *rig_of(const crn_instrument *tools, uint32_t count, const crn_lumen *lumen,
                          const uint32_t *inserted_um)
{
    rig *r = calloc(1, sizeof *r);
    crn_entry entry = reference_entry();
    crn_build_place place;
    assert_int_equal(crn_model_build(&r->model, tools, count, lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    return r;
}

static inline rig *rig_make(const crn_instrument *wire, const crn_lumen *lumen, uint32_t inserted_um)
{
    return rig_of(wire, 1, lumen, &inserted_um);
}

static inline void rig_step(rig *r)
{
    crn_step(&r->model, &r->state, &r->input, &r->output);
}

static inline void check_below(const char *what, double value, double most)
{
    if (!(value <= most)) fail_msg("%s = %g, allowed %g", what, value, most);
}

#endif
