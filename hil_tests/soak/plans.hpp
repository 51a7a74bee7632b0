// This header has routes into the vessels that chance alone would not find: over the wire, round the arch
// into a coronary artery, into a renal artery. The header also has sequences that use a balloon. Each plan is
// a sequence of statements whose numbers are drawn around those of the shipped sessions.
#pragma once
#include "hil_tests/soak/scribe.hpp"

namespace soak
{

void plan_deep(Scribe &scribe);           // the innermost tool far ahead of the others
void plan_over_the_wire(Scribe &scribe);  // at least two tools
void plan_coronary(Scribe &scribe);       // three tools, like pci_lad.session
void plan_coronary_guide(Scribe &scribe); // two tools, like coronary.session
void plan_renal(Scribe &scribe);          // three tools, like pci_renal.session.
// Brings the balloon to a place, fills it, moves the tool that carries it, and empties it. `load`: with the
// next stent.
void plan_balloon(Scribe &scribe, std::size_t balloon, bool load);

} // namespace soak
