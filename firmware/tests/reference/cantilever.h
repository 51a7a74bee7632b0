/* A cantilever held by the inserter, for the elastica cases: a uniform rod of `elements` free elements,
 * without a lumen. Table values: inextensible elastica, solved by shooting to 1e-6 (docs/validation.md names
 * the source). */
#ifndef CRN_REFERENCE_CANTILEVER_H
#define CRN_REFERENCE_CANTILEVER_H

#include "firmware/core/core_state.h"

/* One load case: dimensionless load, (L - x) / L and y / L of the tip. */
typedef struct reference_elastica {
    double load, shortening, deflection;
} reference_elastica;

enum { REFERENCE_TIP_LOADS = 6, REFERENCE_SELF_WEIGHTS = 6 };
extern const reference_elastica reference_tip_load[REFERENCE_TIP_LOADS];       /* P L^2 / EI */
extern const reference_elastica reference_self_weight[REFERENCE_SELF_WEIGHTS]; /* w L^3 / EI */

/* Length of the cases: 0.1 m up to EI 1e-5 N m^2, 0.5 m above. */
double reference_length_m(double bend_N_m2);

/* Settles the rod (until the tip's error changes by less than 1e-5 % of L in 500 ms, at most `ticks_max`) and
 * returns the distance of the tip from the closed form in percent of the length. The mass per length does not
 * enter a static shape; it is chosen so that the slowest motion decays within seconds. */
double reference_tip_load_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                    uint32_t ticks_max);
double reference_self_weight_error_pct(const reference_elastica *load, double bend_N_m2, uint32_t elements,
                                       uint32_t ticks_max);

#endif
