/* This header handles contact between a tool and the struts of deployed stents. A tool inside the stent stays
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
#ifndef CRN_STRUT_H
#define CRN_STRUT_H

#include "firmware/core/core_state.h"

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

#endif
