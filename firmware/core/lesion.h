/* This header has the lesions that give way, the struts that hold them open, and the walls that tools push
 * aside.
 *
 * A lesion that "gives way" is a narrowed part of a vessel that a balloon can open towards the healthy
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

/* --- the struts of deployed stents (strut.c) --------------------------------------------------------------
 *
 * A tool inside the stent stays
 * inside; a tool outside the stent is confined between struts and vessel wall.
 *
 * A stent is represented by a chain of strut rings. A ring is a circle along the inside of the struts, with a
 * thickness, in the reference pose of a vessel that moves:
 *
 *      ring k        ring k + 1     Between joined neighbours lies a shell of revolution. Axis and radius are
 *        |  ___---====  |           linear in u, the fraction of the distance between the planes across the
 *        R_k            R_k+1       chain at either ring.
 *      - c_k ---------- c_k+1 -
 *
 *      depth of a node of radius r at rho from the axis, s = dR/dx, g = sqrt(1 + s^2):
 *        inside the middle of the struts   (rho - R) / g + r                 normal (s t - e) / g
 *        outside                           (R + thickness - rho) / g + r,    the opposite normal
 *
 * The position of a node's centre decides on which side of the struts the node lies. Each end of the chain of
 * strut rings is a rounded edge. The contact normal at the rounded end of a stent is tilted at least 45
 * degrees to one side, so that no friction holds a tip there. Commands move an existing strut ring by at most
 * 5 um a tick. If no strut ring exists, the struts cost only one additional comparison for each node. The
 * file docs/lesions.md explains more. */

/* Begins a tick: the function moves the strut rings towards their commanded positions, and computes a box
 * that contains all of them. */
void crn_struts_step(crn_state *state);

/* Finds the shell of stent struts in which a node of the given radius lies deepest, in the reference pose,
 * and samples the surface of this shell. The distance to the struts is negative on the side of the struts on
 * which the node lies, and the normal points away from the struts. Returns false if no shell is within half a
 * millimetre of the node. */
bool crn_struts_contact(const crn_strut_state *struts, const crn_vec3 *place_m_q30, int32_t radius_m_q30,
                        crn_lumen_sample *sample);

/* Samples the struts as crn_struts_contact does, but takes a point in patient coordinates, and allows for the
 * motion of the vessel. */
bool crn_struts_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, int32_t radius_m_q30, crn_lumen_sample *sample);

/* Samples the struts during a tick, right after the wall was sampled at this point. Most points lie outside
 * the box around all strut rings, and for these points the function returns false at once. */
bool crn_struts_here(const crn_model *model, crn_state *state, const crn_vec3 *world_m_q30,
                     int32_t radius_m_q30, crn_lumen_sample *sample);

bool crn_struts_are_valid(const crn_strut_state *struts);

/* --- walls that give way (wall/wall.c, docs/walls.md) -----------------------------------------------------
 */

/* Makes the laws of a scene ready; for set-up. */
void crn_wall_build(const crn_walls *walls, crn_wall_ready ready[CRN_WALL_LAW_MAX + 1]);

/* Returns how far the vessel is displaced at an arc length behind the leading tip. */
crn_wall_give crn_wall_give_at(const crn_wall_state *wall, int32_t arc_m_q30);

/* Lets the walls give way under the contacts of this tick; after crn_contact_finish(). */
void crn_wall_step(const crn_model *model, crn_state *state);

/* Returns whether a restored state is one that ticks could have made. */
bool crn_wall_is_valid(const crn_model *model, const crn_wall_state *wall);

/* Where the wall at rest is looked at for a node: the node's position, less the way that the wall has given
 * there; the wall has also widened there. */
typedef struct crn_wall_view {
    const crn_vec3 *at_m_q30;
    int32_t widen_m_q30;
    crn_vec3 moved_m_q30; /* where `at_m_q30` points if the wall has given way */
} crn_wall_view;

/* Changes a view by the way at an arc length. */
void crn_wall_move_view(const crn_wall_state *wall, int32_t arc_m_q30, crn_wall_view *view);

/* A view must not be copied, because it may point into itself. */
static inline void crn_wall_look(const crn_model *model, const crn_state *state, uint32_t i,
                                 const crn_vec3 *at_m_q30, crn_wall_view *view)
{
    view->at_m_q30 = at_m_q30;
    view->widen_m_q30 = 0;
    if (state->words.wall.used != 0) {
        crn_wall_move_view(&state->words.wall, model->mesh[i].arc_m_q30, view);
    }
}

#endif
