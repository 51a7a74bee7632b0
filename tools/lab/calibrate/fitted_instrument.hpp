// An instrument file with fitted numbers, made from the nominal one: shape, look and construction stay,
// stiffness, radius, mass and friction are those that were fitted, with that as their source. `cournand`
// loads it like any other.
#pragma once
#include "host/model/instrument.hpp"
#include <string>

namespace crn::calibrate
{

// Numbers along an instrument's table, linear between knots; at a step the knot before (`is_after` false) or
// behind it.
crn_wire_knot knot_at(const crn_wire_instrument &table, double arc_mm, bool is_after);

// The text of the file: `nominal` as "file.toml" or "file.toml:preset", `fitted` its table with other
// numbers, `source` what stands behind every fitted value. The one preset is called physical. Throws
// FileError where a preset has no sections of its own.
std::string fitted_instrument_text(const std::string &nominal, const crn_wire_instrument &fitted,
                                   const std::string &source);

} // namespace crn::calibrate
