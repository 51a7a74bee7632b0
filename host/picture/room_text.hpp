// Writes the state of the X-ray room as the short texts of the display: angles, what the screen shows, mask,
// roadmap, and the session's time. The burnt-in display of files and the window use the same texts.
#pragma once
#include "host/room/room_screen.hpp"
#include <string>
#include <vector>

namespace crn
{

// Returns the value, or 0 if the value is not finite.
double finite_or_zero(double value);
// Rounds a value to a multiple of 1/steps, and never returns a negative zero, which would be printed as
// "-0.00".
double rounded_to(double value, double steps);
// Returns the angles of the C-arm in whole degrees, such as "LAO 30\x7f CRA 10\x7f", where \x7f is the degree
// sign of the display's own font.
std::string angles_text(const CArm &carm);
const char *name_of(RunKind kind);
// Returns the text for the state of the screen (such as live or held), which is the largest text of the
// display.
std::string state_text(const RoomStatus &room);
// If a subtraction mask or a roadmap is in use, returns a line of text about each of them.
std::vector<std::string> processing_texts(const RoomStatus &room);
// Returns minutes and seconds, such as "02:07.5".
std::string session_clock(double time_s);

} // namespace crn
