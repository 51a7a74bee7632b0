// The statements of a session script that ask something of heart and breath (docs/session.md, docs/heart.md).
// May include: session_line, rhythm_order. Called by: session.cpp.
#pragma once
#include "host/app/rhythm_order.hpp"
#include "host/app/session_line.hpp"

namespace crn
{

const std::vector<std::string> &rhythm_verbs();

// The rest of a line that begins with one of them. Throws FileError with place and range.
RhythmOrder parse_rhythm(LineParser &line, const std::string &verb);

} // namespace crn
