/* The scripted scenes of the core use only integers, so they are identical on every machine. The program
 * core_hash.c runs the scenes.
 */
#ifndef CRN_CHECK_CORE_SCENES_H
#define CRN_CHECK_CORE_SCENES_H

#include "firmware/core/core_state.h"

enum { CORE_SCENE_COUNT = 7 };

typedef struct core_scene {
    const char *name;
    uint32_t ticks;
} core_scene;

extern const core_scene core_scenes[CORE_SCENE_COUNT];

/* Makes the core's model and first state for a scene; returns false when the core refuses the model or the
 * state. */
bool core_scene_start(uint32_t scene, crn_model *model, crn_state *state);

/* Returns the positions of the simulated user's hands at a tick (ticks are counted from 1). Each value of
 * `variant` gives a slightly different motion of the simulated hand. */
crn_input core_scene_hand(uint32_t scene, uint32_t tick, uint32_t variant);

#endif
