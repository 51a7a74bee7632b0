// What `cournand` does without any other word.
#pragma once
#include <string>

namespace crn
{

// Returns true if the environment names a display (DISPLAY or WAYLAND_DISPLAY).
bool has_display();

// Returns a text of one screenful about what the user can do without a display. `program` is the word by
// which the user has called the program, so that every command works as it is printed.
std::string start_text(const std::string &program);

} // namespace crn
