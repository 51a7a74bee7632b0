/* Writes parts of vessel files (docs/vessels.md). */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <string>

namespace anatomy
{

/* Returns a text in the quotes of TOML. */
std::string quoted_text(const std::string &text);

/* Returns ", name = ..., source = ...", or "" for a station without a name. */
std::string name_text(const std::string &name, const std::string &source);

/* Returns the line of a station with a position. */
std::string station_text(const Station &station);

} // namespace anatomy
