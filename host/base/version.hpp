// Returns the text that a program prints for --version.
#pragma once
#include "shared/version.h"
#include <string>

namespace crn
{

inline std::string version_of(const std::string &program)
{
    return program + " " CRN_VERSION " (Cournand)";
}

} // namespace crn
