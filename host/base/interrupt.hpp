// Ctrl-C and SIGTERM are handled alike in all our programs. Loops check the flag, close their files and end;
// the second signal ends code that does not check it.
#pragma once

namespace crn
{

// From now on the first Ctrl-C or SIGTERM only sets the flag. The second one removes pending files and ends
// the program by that signal, wherever it is.
void watch_for_interrupt();
bool is_interrupted();

} // namespace crn
