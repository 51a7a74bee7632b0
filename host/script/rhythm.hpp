// Parses the statements of a session script that control heart and breath (docs/session.md, docs/heart.md).
#pragma once
#include "host/script/line.hpp"
#include "shared/wire/wire.h"
#include <cstdint>

namespace crn
{

inline constexpr std::uint16_t premature_usual_milli = 600; // share of the interval before the beat

const std::vector<std::string> &rhythm_verbs();

// Parses the words after the verb of a statement that controls heart or breath. Throws FileError; the message
// gives the position in the script and, if a number is out of range, the allowed range.
crn_wire_order parse_rhythm(LineParser &line, const std::string &verb);

} // namespace crn
