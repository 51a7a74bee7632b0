// The statements of a session script that ask something of heart and breath (docs/session.md, docs/heart.md).
#pragma once
#include "host/script/line.hpp"
#include "host/script/rhythm_order.hpp"

namespace crn
{

const std::vector<std::string> &rhythm_verbs();

// The rest of a line that begins with one of them. Throws FileError with place and range.
RhythmOrder parse_rhythm(LineParser &line, const std::string &verb);

} // namespace crn
