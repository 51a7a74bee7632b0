#include "tools/lab/validate/cases.hpp"

namespace crn::validate
{

std::vector<Case> all_cases()
{
    std::vector<Case> all;
    for (auto list : {bend_cases, motion_cases, buckle_cases, twist_cases, wall_cases, push_cases, turn_cases,
                      coaxial_cases, nested_cases}) {
        for (Case &one : list()) all.push_back(one);
    }
    return all;
}

} // namespace crn::validate
