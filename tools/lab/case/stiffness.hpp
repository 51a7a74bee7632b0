// The two numbers that say how stiff an instrument is: EI of its shaft and alpha, EI of its tip over that.
//
// An instrument file has EI along the whole length. Other values of the two numbers keep its layout: where
// the file's EI is (EI of the shaft) * alpha_file^w, it becomes (new EI of the shaft) * alpha^w. So w is 1 at
// the tip, 0 on the shaft, and between them on a taper; E scales the shaft, alpha says how soft the tip is
// against it. GJ keeps its ratio to EI.
#pragma once
#include "shared/wire/wire.h"

namespace crn::insertion
{

struct Stiffness {
    double shaft_N_m2 = 0.0;     // EI of the shaft
    double tip_over_shaft = 0.0; // alpha
};

// The file's own: its first knot is the tip, its last one the shaft. At least two knots, as the device
// demands.
Stiffness stiffness_of(const crn_wire_instrument &table);

// w of a place whose EI in the file is `bend_N_m2`; 0 everywhere on an instrument with alpha 1.
double tip_weight(double bend_N_m2, const Stiffness &nominal);

// The same instrument with other stiffness. Knots are rounded to nN m^2 and kept within what the core takes
// (1e-7 to 3e-2 N m^2, EI and GJ). Throws CaseError where a number is not above 0, or where alpha shall
// change and the file's is 1.
crn_wire_instrument with_stiffness(const crn_wire_instrument &table, const Stiffness &wanted);

} // namespace crn::insertion
