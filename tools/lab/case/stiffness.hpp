// Two numbers describe how stiff an instrument is: EI of its shaft, and alpha, the ratio of EI at its tip to
// EI of its shaft.
//
// An instrument file states EI along the whole length. Other values of the two numbers keep its layout: where
// the file's EI is (EI of the shaft) * alpha_file^w, it becomes (new EI of the shaft) * alpha^w. The weight w
// is thus 1 at the tip, 0 on the shaft, and between them on a taper. EI of the shaft scales everything, and
// alpha states how soft the tip is relative to the shaft. GJ keeps its ratio to EI.
#pragma once
#include "shared/wire/wire.h"

namespace crn::insertion
{

struct Stiffness {
    double shaft_N_m2 = 0.0;     // EI of the shaft
    double tip_over_shaft = 0.0; // alpha
};

// The file's own numbers: its first knot is the tip, its last one the shaft. The device requires at least two
// knots.
Stiffness stiffness_of(const crn_wire_instrument &table);

// The weight w of a place whose EI in the file is `bend_N_m2`; 0 everywhere on an instrument with alpha 1.
double tip_weight(double bend_N_m2, const Stiffness &nominal);

// Returns the same instrument with other stiffness. Knots are rounded to nN m^2 and kept within the core's
// limits (1e-7 to 3e-2 N m^2, EI and GJ). Throws CaseError when a number is not above 0, or when alpha should
// change although the file's alpha is 1.
crn_wire_instrument with_stiffness(const crn_wire_instrument &table, const Stiffness &wanted);

} // namespace crn::insertion
