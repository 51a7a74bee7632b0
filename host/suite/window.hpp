// Shows the window of `cournand view`. The user controls the hand, the pedals and the C-arm by keyboard, and
// sees the same pictures that `cournand run` makes. The program records the user's input in the same way as
// the commands of a script. A replay of the recording gives results that are equal bit for bit.
#pragma once
#include "host/command/view_options.hpp"

namespace crn
{

// Checks that the output files can be written, and then opens the window. Returns 0, or 1 if a signal closed
// the window or the session ended with a fault. Throws std::runtime_error if the computer has no display or
// no OpenGL 3.3, or if a file is bad; the exit code is then 1.
int run_window(WindowOptions options);
// Opens the start screen, as the command `cournand` without any argument does. Returns the same values and
// throws the same exceptions as run_window().
int open_start();

} // namespace crn
