// Ways into the vessels that chance alone would not find: over the wire, round the arch into a coronary
// artery, into a renal artery; and what is done with a balloon. Each is a sequence of statements whose
// numbers are drawn about those of the shipped sessions.
#pragma once
#include "hil_tests/soak/scribe.hpp"

namespace soak
{

void plan_deep(Scribe &scribe);           // the innermost tool far ahead of the others
void plan_over_the_wire(Scribe &scribe);  // at least two tools
void plan_coronary(Scribe &scribe);       // three tools: as pci_lad.session
void plan_coronary_guide(Scribe &scribe); // two tools: as coronary.session
void plan_renal(Scribe &scribe);          // three tools: as pci_renal.session
// Bring the balloon somewhere, fill it, move what it is on, empty it. `load`: with the next stent.
void plan_balloon(Scribe &scribe, std::size_t balloon, bool load);

} // namespace soak
