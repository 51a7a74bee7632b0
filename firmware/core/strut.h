/* Struts of stents that were deployed, as a wire meets them: from inside it stays inside, from outside it is
 * held between struts and wall.
 *
 * A stent is a chain of rings, circles of the struts' inside with a thickness, in the reference pose of a
 * vessel that moves:
 *
 *      ring k        ring k + 1             between neighbours that are joined a shell of revolution: axis and radius are linear in u,
 *        |  ___---====  |                   the share of the way between the planes across the chain at either ring
 *        R_k            R_k+1
 *      - c_k ---------- c_k+1 -             depth of a node of radius r at rho from the axis, s = dR/dx, g = sqrt(1 + s^2):
 *                                             inside the middle of the struts   (rho - R) / g + r          normal (s t - e) / g
 *                                             outside                           (R + thickness - rho) / g + r,  the other way
 *
 * The side is the one on which the node's centre lies. An end of the chain is a round edge; its normal leads
 * at least by 45 degrees to one side, so that no friction holds a tip there. Orders move a ring that is there
 * by 5 um a tick. Where there is no ring it costs a comparison for each node. docs/lesions.md. */
#ifndef CRN_STRUT_H
#define CRN_STRUT_H

#include "firmware/core/core_state.h"

/* A tick begins: rings go on to where they were ordered to, and a box is put about all of them. */
void crn_struts_step(crn_state *state);

/* The deepest of the shells around or beside a node of this radius: distance below 0 on its own side, normal
 * away from the struts. false: none within half a millimetre of it. In the reference pose. */
bool crn_struts_contact(const crn_strut_state *struts, const crn_vec3 *place_m_q30, int32_t radius_m_q30,
                        crn_lumen_sample *sample);

/* The same at a place in the world, where the vessel may have moved. */
bool crn_struts_wall(const crn_model *model, const crn_state_words *words, crn_motion_pose *pose,
                     const crn_vec3 *world_m_q30, int32_t radius_m_q30, crn_lumen_sample *sample);

/* The same in a tick, right after the wall was looked at there; most places are ruled out by the tick's box.
 */
bool crn_struts_here(const crn_model *model, crn_state *state, const crn_vec3 *world_m_q30,
                     int32_t radius_m_q30, crn_lumen_sample *sample);

bool crn_struts_are_valid(const crn_strut_state *struts);

#endif
