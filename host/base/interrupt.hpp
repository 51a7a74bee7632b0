// The signals Ctrl-C (SIGINT) and SIGTERM have the same effect in all programs of this repository. Long loops
// check the flag that the first signal sets, close their files and end. A second signal also ends code that
// does not check this flag.
#pragma once

namespace crn
{

// Installs signal handlers: from now on the first Ctrl-C or SIGTERM only sets a flag. The second signal
// (Ctrl-C or SIGTERM) removes pending files and ends the program, whatever the program is doing.
void watch_for_interrupt();
bool is_interrupted();

} // namespace crn
