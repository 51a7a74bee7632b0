// Opens what `cournand` shows when it is called without any other word.
#pragma once

namespace crn
{

// Opens the window on the scene that comes with the program, with a J wire in the patient. Returns the exit
// code, and throws as run_window() does.
int open_start();

} // namespace crn
