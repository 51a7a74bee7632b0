// Ctrl-C and SIGTERM, the same for every program of ours. Loops ask, close their files and end; whatever does
// not ask is ended by the second signal.
#pragma once

namespace crn
{

// From now on the first Ctrl-C or SIGTERM only raises the flag. The second one removes files under way and
// ends the program by that signal, wherever it is.
void watch_for_interrupt();
bool is_interrupted();

} // namespace crn
