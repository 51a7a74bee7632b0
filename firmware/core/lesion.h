/* Lesions that give way: stretches of a narrowed vessel that a balloon opens towards the healthy one.
 *
 * The lumen's field is that of the narrowed vessel. Along a lesion a few stations hold the centreline of the
 * healthy vessel and of the channel that is left, with their radii R and r; the state holds how far each is
 * open, 0 .. 1. The way from the narrowed to the healthy wall is the baker's own: everything about the
 * channel is scaled by R / r. So the wall of a lesion that is open by w is where phi(X(x)) = 0,
 *
 *     X = c + k (x - c_w),   k = r / (r + w (R - r)),   c_w = c + w (C - c)          c, C: middle of channel and vessel
 *     gradient               k grad phi + t (B . grad phi),   B = c' - k c_w' + k' (x - c_w),   t along the vessel
 *
 * all at the foot of x on the vessel's centreline, and what was lumen stays lumen. docs/lesions.md. In the
 * reference pose of a vessel that moves. Where no lesion is open it costs one comparison. Checked before use
 * by shared/scene (hostile until checked). */
#ifndef CRN_LESION_H
#define CRN_LESION_H

#include "firmware/core/core_state.h"

/* The wall where a lesion is open; false: no open lesion is there, and the lumen is as it was described. In
 * the reference pose. */
bool crn_lesion_contact(const crn_lumen *lumen, const crn_lesion_state *lesions, const crn_vec3 *place_m_q30,
                        crn_lumen_sample *sample);

/* The map of an open lesion at one place along it, for many look-ups near there. In the reference pose. */
typedef struct crn_lesion_section {
    crn_vec3 middle_m_q30, channel_m_q30;
    int32_t ratio_q30, widened_q24; /* k and 1 / k */
} crn_lesion_section;

/* false: no open lesion is there. Of two, the first. */
bool crn_lesion_section_at(const crn_lumen *lumen, const crn_lesion_state *lesions,
                           const crn_vec3 *place_m_q30, crn_lesion_section *section);
/* Distance to the wall in that section: right at the wall, where it runs along the vessel. Format: Q30 m,
 * limited to 15.6 mm. */
int32_t crn_lesion_section_distance(const crn_lumen *lumen, const crn_lesion_section *section,
                                    const crn_vec3 *place_m_q30);

/* As crn_lesion_contact at a place in the world, where the vessel may have moved. */
bool crn_lesion_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, crn_lumen_sample *sample);

/* Where a place lies along a lesion. Format: Q30 m from its first station. false: beyond its ends or not near
 * it. */
bool crn_lesion_arc(const crn_lesion *lesion, const crn_vec3 *place_m_q30, int32_t *arc_m_q30);

/* One tick: lesions open under the pressure that a balloon's balls have on the wall, spring back without, and
 * keep what they do not spring back from. */
void crn_lesions_give_way(const crn_model *model, crn_state *state);

bool crn_lesion_is_valid(const crn_lumen *lumen, const crn_lesion_state *lesions);

#endif
