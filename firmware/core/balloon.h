/* This header models an angioplasty balloon on a tool as a row of balls (spheres) along the tools' common
 * centreline. The balls that represent the balloon grow against the vessel wall with the inflator's pressure.
 *
 * Ball j of the balloon lies at a fixed arc length of the tool that carries the balloon. A spring ties the
 * centre c of a ball to the tools' centreline at the arc length of the ball. The ball's radius follows the
 * manufacturer's table of pressure and diameter as long as the vessel leaves space. In every tick a ball of
 * the balloon grows a little and is moved away from any wall that it touches. Where this leaves no space, the
 * ball is confined: it fills the vessel, presses on the wall with the pressure that remains after stretching
 * the balloon itself, and holds by friction,
 *
 *     N = (p - p_table(r)) 2 pi r ds          |K e_t + N dr/ds| <= mu (N + K |e_n|)
 *
 * The vector e leads from the ball's centre c to the tools' centreline; e_t is the component of e along the
 * centreline, and e_n is the component across. The term N dr/ds is the force that drives a balloon out of a
 * tapered vessel (docs/balloon.md). Private to firmware/core. */
#ifndef CRN_BALLOON_H
#define CRN_BALLOON_H

#include "firmware/core/rod.h"

/* Set-up. The function crn_balloon_check returns true if a tool has a valid balloon or no balloon. */
bool crn_balloon_check(const crn_instrument *tool);
void crn_balloon_build(crn_balloon_model *balloon, const crn_instrument *tool);

/* Returns the radius of a balloon that no wall confines. Format: Pa -> Q30 m. Overflow is impossible, because
 * pressures are limited to CRN_PRESSURE_MAX_Pa. */
int32_t crn_balloon_free_radius(const crn_balloon_model *balloon, int32_t pressure_Pa);
/* Returns the pressure at which an unconfined balloon has the given radius. The balloon's own wall bears the
 * pressure that crn_balloon_own_pressure returns. Format: Q30 m -> Pa; 0 while it unfolds. */
int32_t crn_balloon_own_pressure(const crn_balloon_model *balloon, int32_t radius_m_q30);

/* Returns how far a ball lies behind the leading tip along the tools. Q30 m. */
int32_t crn_balloon_arc(const crn_model *model, const crn_state *state, uint32_t ball);

/* The function crn_balloon_find runs before the solve, after the contacts with the wall were found. In
 * crn_balloon_find the balloon's balls grow against the wall at the predicted configuration, and the springs
 * between balls and centreline are added to the matrix. The function crn_balloon_forces adds the forces of
 * the springs between balls and centreline to the right side of the linear system. After the solve,
 * crn_balloon_finish moves each ball along the tools' centreline where the force on the ball exceeds the
 * friction of the wall. */
void crn_balloon_find(const crn_model *model, crn_state *state, int32_t inflator_Pa);
void crn_balloon_forces(const crn_model *model, crn_state *state);
void crn_balloon_finish(const crn_model *model, crn_state *state, crn_output *output);

/* Checks the restored state of a balloon with the given number of balls; the number is 0 if no nested tool
 * has a balloon. */
bool crn_balloon_is_valid(uint32_t ball_count, const crn_balloon_state *balloon);

#endif
