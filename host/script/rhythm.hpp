// The statements of a session script that ask something of heart and breath (docs/session.md, docs/heart.md).
#pragma once
#include "host/script/line.hpp"
#include "shared/wire/wire.h"
#include <cstdint>

namespace crn
{

inline constexpr std::uint16_t premature_usual_milli = 600; // of the interval: when a premature beat comes

const std::vector<std::string> &rhythm_verbs();

// The rest of a line that begins with one of them. Throws FileError with place and range.
crn_wire_order parse_rhythm(LineParser &line, const std::string &verb);

} // namespace crn
