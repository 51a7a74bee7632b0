/* The scenes are scripted from integers only, so they are the same on every machine. core_hash.c runs them.
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

/* Makes the model and first state of a scene; returns false when the core refuses them. */
bool core_scene_start(uint32_t scene, crn_model *model, crn_state *state);

/* Returns the position of the simulated hand at a tick (from 1). `variant` changes the hand's motion a
 * little. */
crn_input core_scene_hand(uint32_t scene, uint32_t tick, uint32_t variant);

#endif
