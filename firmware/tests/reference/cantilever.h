/* The elastica cases use a cantilever held by the introducer sheath: a uniform rod of `elements` free
 * elements, without a lumen. The table values are those of the inextensible elastica, solved by shooting to
 * 1e-6 (docs/validation.md names the source). */
#ifndef CRN_REFERENCE_CANTILEVER_H
#define CRN_REFERENCE_CANTILEVER_H

#include "firmware/core/core_state.h"

/* A load case has a dimensionless load, and (L - x) / L and y / L of the tip. */
typedef struct reference_elastica {
    double load, shortening, deflection;
} reference_elastica;

enum { REFERENCE_TIP_LOADS = 6, REFERENCE_SELF_WEIGHTS = 6 };
extern const reference_elastica reference_tip_load[REFERENCE_TIP_LOADS];       /* P L^2 / EI */
extern const reference_elastica reference_self_weight[REFERENCE_SELF_WEIGHTS]; /* w L^3 / EI */

/* The rods are 0.1 m long up to EI 1e-5 N m^2, and 0.5 m above. */
double reference_length_m(double bend_N_m2);

/* Lets the rod settle until the tip's error changes by less than 1e-5 % of L in 500 ms, for at most
 * `ticks_max` ticks. Returns the distance of the tip from the closed form in percent of the length. The mass
 * per length does not affect a static shape; it is chosen so that the slowest motion decays within
 * seconds. */
double reference_tip_load_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                    uint32_t ticks_max);
double reference_self_weight_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                       uint32_t ticks_max);

#endif
