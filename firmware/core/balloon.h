/* An angioplasty balloon on a tool: balls along the line that grow against the wall with the inflator's
 * pressure.
 *
 * Ball j lies at a fixed arc length of its tool. A spring ties its centre c to the line there; its radius
 * follows the maker's table of pressure and diameter as long as there is space. In every tick it grows a
 * little and is moved off the wall that it meets. Where that gives no space it is confined: it fills the
 * vessel, presses on the wall with the pressure that is left after stretching the balloon itself, and holds
 * by friction,
 *
 *     N = (p - p_table(r)) 2 pi r ds          |K e_t + N dr/ds| <= mu (N + K |e_n|)
 *
 * e is the vector from c to the line, e_t its component along the line and e_n across it. The term N dr/ds
 * drives a balloon out of a taper. docs/balloon.md. Private to firmware/core. */
#ifndef CRN_BALLOON_H
#define CRN_BALLOON_H

#include "firmware/core/rod.h"

/* Set-up. The check returns CRN_BUILD_BALLOON for an invalid table, or for more than one tool with a
 * balloon. */
crn_build_status crn_balloon_check(const crn_instrument *tools, uint32_t tool_count, crn_build_place *place);
void crn_balloon_build(crn_balloon_model *balloon, const crn_instrument *tools, uint32_t tool_count);

/* Radius of a balloon that no wall confines. Format: Pa -> Q30 m. Overflow: pressures are limited to
 * CRN_PRESSURE_MAX_Pa. */
int32_t crn_balloon_free_radius(const crn_balloon_model *balloon, int32_t pressure_Pa);
/* Pressure at which an unconfined balloon has this radius: the load that its own wall bears. Format: Q30 m ->
 * Pa; 0 while it unfolds. */
int32_t crn_balloon_own_pressure(const crn_balloon_model *balloon, int32_t radius_m_q30);

/* crn_balloon_find runs before the solve, after the contacts were found: balls grow and meet the wall at the
 * predicted configuration. crn_balloon_forces adds their springs to the matrix and the forces. After the
 * solve, what the wall cannot hold slips. */
void crn_balloon_find(const crn_model *model, crn_state *state, int32_t inflator_Pa);
void crn_balloon_forces(const crn_model *model, crn_state *state);
void crn_balloon_finish(const crn_model *model, crn_state *state, crn_output *output);

bool crn_balloon_is_valid(const crn_model *model, const crn_balloon_state *balloon);

#endif
