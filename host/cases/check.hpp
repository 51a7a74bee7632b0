// Finds all faults of a case before a trainee plays it.
#pragma once
#include "host/cases/case.hpp"
#include <string>
#include <vector>

namespace crn
{

// Returns one message per fault: "FILE:LINE: what is wrong; remedy". An empty list means that the case can be
// played. The check needs the program `anatomy` for the names of the vessels, and makes no scene.
std::vector<std::string> case_faults(const std::string &path);

} // namespace crn
