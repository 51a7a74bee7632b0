// Provides routes into the vessels that random motion would not find: over the wire, round the arch into a
// coronary artery, or into a renal artery. This header also provides sequences that use a balloon. A plan is
// a sequence of script statements; its numbers are chosen at random near those of the shipped sessions.
#pragma once
#include "hil_tests/soak/scribe.hpp"

namespace soak
{

void plan_deep(Scribe &scribe);           // the innermost tool far ahead of the others
void plan_over_the_wire(Scribe &scribe);  // at least two tools
void plan_coronary(Scribe &scribe);       // three tools of an angioplasty, nested
void plan_coronary_guide(Scribe &scribe); // two tools, like coronary.session
void plan_renal(Scribe &scribe);          // three tools of an angioplasty, nested
// Advances the balloon to a point, fills the balloon, moves the tool that has the balloon, and empties the
// balloon. `load`: with the next stent.
void plan_balloon(Scribe &scribe, std::size_t balloon, bool load);

} // namespace soak
