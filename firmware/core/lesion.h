/* A lesion that "gives way" is a narrowed part of a vessel that a balloon can open towards the healthy
 * vessel.
 *
 * The lumen's distance field describes the narrowed vessel. A lesion has a few points along its length,
 * called stations. Each station has the centrelines of the healthy vessel and of the remaining channel, and
 * their radii R and r. The core's state holds the opening of each point (station) of a lesion, from 0
 * (closed) to 1 (healthy vessel). The map from the narrowed to the healthy wall scales everything around the
 * channel by R / r, as the program that bakes the scene also does. So the wall of a lesion with the opening w
 * is where phi(X(x)) = 0,
 *
 *     X = c + k (x - c_w),   k = r / (r + w (R - r)),   c_w = c + w (C - c)          c, C: middle of channel and vessel
 *     gradient               k grad phi + t (B . grad phi),   B = c' - k c_w' + k' (x - c_w),   t along the vessel
 *
 * All terms of the map are evaluated at the foot of x, that is, the point of the vessel's centreline that is
 * nearest to x. A point inside the narrowed lumen stays inside the lumen when the lesion opens
 * (docs/lesions.md). All positions of a lesion are in the reference pose of a vessel that moves. If no lesion
 * is open, a sample of the wall needs only one additional comparison. The code in shared/scene checks the
 * data before use, because they may come from an attacker. */
#ifndef CRN_LESION_H
#define CRN_LESION_H

#include "firmware/core/core_state.h"

/* Samples the vessel wall at a point in the reference pose where a lesion is open. Returns false if no lesion
 * is open at the point; in this case the lumen's own distance field describes the wall. */
bool crn_lesion_contact(const crn_lumen *lumen, const crn_lesion_state *lesions, const crn_vec3 *place_m_q30,
                        crn_lumen_sample *sample);

/* Holds the map that widens an open lesion at one position along the lesion, in the reference pose, for many
 * look-ups near that position. */
typedef struct crn_lesion_section {
    crn_vec3 middle_m_q30, channel_m_q30;
    int32_t ratio_q30, widened_q24; /* k and 1 / k */
} crn_lesion_section;

/* Returns false where no lesion is open. If two lesions overlap, the function uses the map of the lesion with
 * the lower number. */
bool crn_lesion_section_at(const crn_lumen *lumen, const crn_lesion_state *lesions,
                           const crn_vec3 *place_m_q30, crn_lesion_section *section);
/* Returns the distance to the vessel wall where the lesion is opened as `section` describes. The distance to
 * the wall of an opened lesion is accurate at the wall itself, provided that the wall runs along the vessel.
 * Format: Q30 m, limited to 15.6 mm. */
int32_t crn_lesion_section_distance(const crn_lumen *lumen, const crn_lesion_section *section,
                                    const crn_vec3 *place_m_q30);

/* Samples the wall of an open lesion as crn_lesion_contact does, but at a point in patient coordinates, where
 * the vessel may have moved. */
bool crn_lesion_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, crn_lumen_sample *sample);

/* Computes the arc length along a lesion at which a point lies. Format: Q30 m from its first station. Returns
 * false for a point beyond the lesion's ends or far from the lesion. */
bool crn_lesion_arc(const crn_lesion *lesion, const crn_vec3 *place_m_q30, int32_t *arc_m_q30);

/* Advances the lesions by one tick. A lesion opens under the pressure of a balloon on the wall; without this
 * pressure it recoils, except for the part of the opening that is permanent. */
void crn_lesions_give_way(const crn_model *model, crn_state *state);

bool crn_lesion_is_valid(const crn_lumen *lumen, const crn_lesion_state *lesions);

#endif
