// Lists the cases of the validation suite. Each case of the suite sets up a rod, loads the rod, and compares
// the result with a reference.
#pragma once
#include "tools/lab/validate/report.hpp"

#include <functional>

namespace crn::validate
{

struct Case {
    std::string name;
    std::function<void(Result &, bool quick)>
        run; // quick: fewer figures, so that the whole suite takes seconds
};

// Returns all validation cases in the order of the report.
std::vector<Case> all_cases();

// Each of the following functions returns the validation cases of one source file.
std::vector<Case> bend_cases();
std::vector<Case> motion_cases();
std::vector<Case> buckle_cases();
std::vector<Case> twist_cases();
std::vector<Case> wall_cases();
std::vector<Case> push_cases();
std::vector<Case> turn_cases();
std::vector<Case> coaxial_cases();
std::vector<Case> nested_cases();

} // namespace crn::validate
