// Determines what `cournand` does when it is called without arguments.
#pragma once
#include <string>

namespace crn
{

// Returns true if the environment names a display (DISPLAY or WAYLAND_DISPLAY).
bool has_display();

// Returns a text, short enough for one screen, about what the user can do without a display. `program` is the
// word with which the user called the program, so that the user can copy every printed command.
std::string start_text(const std::string &program);

} // namespace crn
