// Two numbers describe how stiff an instrument is: EI of its shaft, and alpha, the ratio of EI at its tip to
// EI of its shaft.
//
// An instrument file states EI at every place along the length. If the two numbers change, the distribution
// of stiffness along the instrument stays the same. Where the file's EI is (EI of the shaft) * alpha_file^w,
// the new EI is (new EI of the shaft) * alpha^w. The weight w is thus 1 at the tip and 0 on the shaft, and it
// lies between 0 and 1 on a taper. The EI of the shaft scales the whole instrument, and alpha states how soft
// the tip is relative to the shaft. GJ keeps its ratio to EI.
#pragma once
#include "shared/wire/wire.h"

namespace crn::insertion
{

struct Stiffness {
    double shaft_N_m2 = 0.0;     // EI of the shaft
    double tip_over_shaft = 0.0; // alpha
};

// Returns the file's own two numbers: the first knot is the tip, and the last knot is the shaft. The device
// requires that an instrument has at least two knots.
Stiffness stiffness_of(const crn_wire_instrument &table);

// Returns the weight w of a place whose EI in the file is `bend_N_m2`; it is 0 everywhere on an instrument
// with alpha 1.
double tip_weight(double bend_N_m2, const Stiffness &nominal);

// Returns the same instrument with another stiffness. The EI and GJ of knots are rounded to nN m^2 and kept
// within the core's limits (1e-7 to 3e-2 N m^2). Throws Fault when a number is not above 0, or when alpha
// should change although the file's alpha is 1.
crn_wire_instrument with_stiffness(const crn_wire_instrument &table, const Stiffness &wanted);

} // namespace crn::insertion
