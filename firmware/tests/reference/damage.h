/* Saved states that are invalid. A test includes this header after cmocka.h and core_state.h. */
#ifndef CRN_TEST_DAMAGE_H
#define CRN_TEST_DAMAGE_H

#include "firmware/core/core_state.h"

#include <stdlib.h>

typedef struct damaged_word {
    size_t offset; /* in a part of the state's words */
    uint32_t value;
} damaged_word;

/* Checks that the unchanged state can be restored. Writes each of the damaged `words`, one at a time, into
 * the part of the saved state that begins at `part`. The core must refuse every damaged state. */
static inline void refuses_each(crn_model *model, crn_state *state, size_t part, const damaged_word *words,
                                size_t count)
{
    uint8_t *bytes = malloc(crn_state_bytes());
    crn_state_save(state, bytes);
    assert_true(crn_state_restore(model, state, bytes));
    for (size_t i = 0; i < count; i++) {
        crn_state_save(state, bytes);
        for (int k = 0; k < 4; k++)
            bytes[part + words[i].offset + (size_t)k] = (uint8_t)(words[i].value >> 8 * k);
        assert_false(crn_state_restore(model, state, bytes));
    }
    free(bytes);
}

#endif
