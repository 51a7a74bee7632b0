// An instrument file with fitted numbers, made from the nominal one. Shape, appearance and construction stay;
// stiffness, radius, mass and friction become the fitted ones, with the fit as their source. `cournand` loads
// the file like any other.
#pragma once
#include "host/model/instrument.hpp"
#include <string>

namespace crn::calibrate
{

// Returns the numbers at a place of an instrument's table, linear between knots. At a step it returns the
// knot before the step (`is_after` false) or the one behind it.
crn_wire_knot knot_at(const crn_wire_instrument &table, double arc_mm, bool is_after);

// Returns the text of the file. `nominal` is "file.toml" or "file.toml:preset", `fitted` its table with other
// numbers, and `source` the text after every fitted value. The only preset is called physical. Throws
// FileError when a preset has no sections of its own.
std::string fitted_instrument_text(const std::string &nominal, const crn_wire_instrument &fitted,
                                   const std::string &source);

} // namespace crn::calibrate
