/* This header declares the checks for two harmful effects of a motor: the motor moves a carriage that no hand
 * holds, or the motor sustains an oscillation of the carriage. */
#ifndef CRN_CARRIAGE_H
#define CRN_CARRIAGE_H

#include "firmware/app/safety/safety.h"

/* Returns the travel of the carriage since the last timer edge in counts, positive into the patient, and at
 * most twice the largest plausible jump. */
int32_t crn_carriage_moved(const crn_safety *safety, const crn_port_inputs *rig, uint32_t track);

/* Returns the largest force that the motor of this track may give now. */
int32_t crn_carriage_bound_mN(crn_safety *safety, const crn_port_inputs *rig, uint32_t track,
                              int32_t asked_mN);

/* Checks a driven track at this timer edge; *value receives the value of the fault, if the check finds one.
 */
crn_fault_code crn_carriage_check(crn_safety *safety, const crn_safety_input *input, uint32_t track,
                                  int32_t *value);

/* Holds the measurements of one timer edge for a carriage. */
typedef struct crn_carriage_edge {
    int32_t moved_counts;
    int32_t driven_mN, measured_mN;
    uint32_t pm_per_count;
    bool is_felt; /* the force sensor is in order */
} crn_carriage_edge;

/* Returns true while the motor has sustained an oscillation of the carriage for too long. */
bool crn_cycle_lasts(crn_safety_cycle *cycle, const crn_carriage_edge *edge);

#endif
