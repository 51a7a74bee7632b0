/* Asserts that a sample file which a test has changed is refused with a stated status and place. */
#ifndef CRN_SCENE_REFUSAL_H
#define CRN_SCENE_REFUSAL_H

#include "shared/scene/tests/scene_sample.h"

static inline void refuses_sealed(uint8_t *file, size_t bytes, crn_scene_status wanted, uint32_t wanted_where)
{
    crn_scene scene;
    uint32_t where = 0;
    sample_seal(file, bytes);
    assert_int_equal(crn_scene_open(file, bytes, &scene, &where), wanted);
    assert_int_equal(where, wanted_where);
}

#endif
