// Two numbers describe how stiff an instrument is: EI of its shaft, and alpha, the ratio of EI at its tip to
// EI of its shaft.
//
// An instrument file states EI at every position along the instrument. The shaft's EI and alpha do not change
// how EI is distributed between tip and shaft. Where the instrument file's EI is (EI of the shaft) *
// alpha_file^w, with a weight w between 0 and 1, the new EI is (new EI of the shaft) * alpha^w. The weight w
// is thus 1 at the tip and 0 on the shaft, and it lies between 0 and 1 on a taper. The EI of the shaft scales
// the whole instrument, and alpha states how soft the tip is relative to the shaft. GJ keeps its ratio to EI.
#pragma once
#include "shared/wire/wire.h"

namespace crn::insertion
{

struct Stiffness {
    double shaft_N_m2 = 0.0;     // EI of the shaft
    double tip_over_shaft = 0.0; // alpha
};

// Returns EI of the shaft and alpha as the instrument file states them; the first knot of its table is the
// tip, and the last knot is the shaft. The device requires that an instrument has at least two knots.
Stiffness stiffness_of(const crn_wire_instrument &table);

// Returns the weight w of a position at which the instrument file states an EI of `bend_N_m2`. On an
// instrument with alpha 1 (tip as stiff as the shaft), the weight w is 0 everywhere.
double tip_weight(double bend_N_m2, const Stiffness &nominal);

// Returns a copy of the instrument whose EI of the shaft and alpha have the given values. The EI and GJ of
// the table's knots are rounded to 1 nN m^2 and kept within the core's limits (1e-7 to 3e-2 N m^2). Throws
// Fault if EI of the shaft or alpha is not above 0. Also throws Fault if another alpha is requested although
// the instrument file's alpha is 1.
crn_wire_instrument with_stiffness(const crn_wire_instrument &table, const Stiffness &wanted);

} // namespace crn::insertion
