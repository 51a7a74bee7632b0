/* A lesion that gives way is a stretch of a narrowed vessel that a balloon opens towards the healthy vessel.
 *
 * The lumen's field describes the narrowed vessel. Along a lesion a few stations hold the centrelines of the
 * healthy vessel and of the remaining channel, with their radii R and r. The state holds how far each station
 * is open, from 0 to 1. The map from the narrowed to the healthy wall is the one that the baker used; it
 * scales everything around the channel by R / r. So the wall of a lesion with the opening w is where
 * phi(X(x)) = 0,
 *
 *     X = c + k (x - c_w),   k = r / (r + w (R - r)),   c_w = c + w (C - c)          c, C: middle of channel and vessel
 *     gradient               k grad phi + t (B . grad phi),   B = c' - k c_w' + k' (x - c_w),   t along the vessel
 *
 * All terms are evaluated at the foot of x on the vessel's centreline. A point in the narrowed lumen stays in
 * the lumen (docs/lesions.md). All places are in the reference pose of a vessel that moves. Where no lesion
 * is open the cost is one comparison. shared/scene checks the data before use (they are hostile until
 * checked). */
#ifndef CRN_LESION_H
#define CRN_LESION_H

#include "firmware/core/core_state.h"

/* Samples the wall where a lesion is open, in the reference pose. Returns false where there is no open
 * lesion; the lumen's own field holds there. */
bool crn_lesion_contact(const crn_lumen *lumen, const crn_lesion_state *lesions, const crn_vec3 *place_m_q30,
                        crn_lumen_sample *sample);

/* Holds the map of an open lesion at one place along the lesion, for many look-ups near that place, in the
 * reference pose. */
typedef struct crn_lesion_section {
    crn_vec3 middle_m_q30, channel_m_q30;
    int32_t ratio_q30, widened_q24; /* k and 1 / k */
} crn_lesion_section;

/* Returns false where there is no open lesion. Where two lesions overlap, the section is that of the first
 * one. */
bool crn_lesion_section_at(const crn_lumen *lumen, const crn_lesion_state *lesions,
                           const crn_vec3 *place_m_q30, crn_lesion_section *section);
/* Returns the distance to the wall in that section. The distance is accurate at the wall itself where the
 * wall runs along the vessel. Format: Q30 m, limited to 15.6 mm. */
int32_t crn_lesion_section_distance(const crn_lumen *lumen, const crn_lesion_section *section,
                                    const crn_vec3 *place_m_q30);

/* Does the same as crn_lesion_contact at a place in world coordinates, where the vessel may have moved. */
bool crn_lesion_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, crn_lumen_sample *sample);

/* Computes how far along a lesion a place lies. Format: Q30 m from its first station. Returns false beyond
 * the lesion's ends or far from it. */
bool crn_lesion_arc(const crn_lesion *lesion, const crn_vec3 *place_m_q30, int32_t *arc_m_q30);

/* Advances the lesions by one tick: they open under the pressure of a balloon's balls on the wall, recoil
 * without it, and keep the part that does not recoil. */
void crn_lesions_give_way(const crn_model *model, crn_state *state);

bool crn_lesion_is_valid(const crn_lumen *lumen, const crn_lesion_state *lesions);

#endif
