// Makes an instrument file with fitted numbers from the nominal instrument file. Shape, appearance and
// construction stay. Stiffness, radius, mass and friction get the fitted values, and the `source` beside each
// value names the fit. The program `cournand` loads the written file like any other instrument file.
#pragma once
#include "host/model/instrument.hpp"
#include <string>

namespace crn::calibrate
{

// Returns the properties at one position of an instrument's table, interpolated linearly between knots. Where
// the properties change abruptly, the function returns the knot before the change (`is_after` false) or the
// knot behind it.
crn_wire_knot knot_at(const crn_wire_instrument &table, double arc_mm, bool is_after);

// Returns the text of the fitted instrument's file. `nominal` is "file.toml" or "file.toml:preset", `fitted`
// is the table of that instrument with other numbers, and `source` is the text that is written after every
// fitted value. The written file has one preset, which is called physical. Throws FileError when a preset has
// no sections of its own.
std::string fitted_instrument_text(const std::string &nominal, const crn_wire_instrument &fitted,
                                   const std::string &source);

} // namespace crn::calibrate
