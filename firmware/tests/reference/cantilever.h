/* The elastica cases use a cantilever that the introducer sheath holds: a uniform rod of `elements` free
 * elements, without a lumen. The table values come from the inextensible elastica, solved by the shooting
 * method to 1e-6 (docs/validation.md names the source). */
#ifndef CRN_REFERENCE_CANTILEVER_H
#define CRN_REFERENCE_CANTILEVER_H

#include "firmware/core/core_state.h"

/* A load case consists of a dimensionless load and the expected tip position, as (L - x) / L and y / L. */
typedef struct reference_elastica {
    double load, shortening, deflection;
} reference_elastica;

enum { REFERENCE_TIP_LOADS = 6, REFERENCE_SELF_WEIGHTS = 6 };
extern const reference_elastica reference_tip_load[REFERENCE_TIP_LOADS];       /* P L^2 / EI */
extern const reference_elastica reference_self_weight[REFERENCE_SELF_WEIGHTS]; /* w L^3 / EI */

/* The rods are 0.1 m long for an EI up to 1e-5 N m^2, and 0.5 m long for a larger EI. */
double reference_length_m(double bend_N_m2);

/* Lets the rod settle until the error of the tip's position changes by less than 1e-5 % of L in 500 ms, for
 * at most `ticks_max` ticks. Returns the distance between the tip and its position by the closed form, in
 * percent of the rod's length. The mass per length does not affect a static shape; its value is chosen so
 * that the slowest motion decays within seconds. */
double reference_tip_load_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                    uint32_t ticks_max);
double reference_self_weight_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                       uint32_t ticks_max);

#endif
