// Names the tools of a session's report.
#pragma once
#include "host/patient/patient.hpp"
#include <vector>

namespace crn
{

// Returns the tools that are nested in the vessels at the end of a session, for its report; a position
// without a tool has the name "nothing".
std::vector<Instrument> reported_tools(const Patient &patient);
// Returns the nested tools; a position without a tool gets the name "nothing".
std::vector<Instrument> with_free_positions(std::vector<Instrument> tools);

} // namespace crn
