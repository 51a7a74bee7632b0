#include "hil_tests/cases/cases.hpp"
#include <vector>

namespace hil
{

std::span<const Case> all_cases()
{
    static const std::vector<Case> all = [] {
        std::vector<Case> joined;
        for (std::span<const Case> group : {session_cases(), exchange_cases(), pedal_cases(), safety_cases(),
                                            unplug_cases(), haptic_cases()})
            joined.insert(joined.end(), group.begin(), group.end());
        return joined;
    }();
    return all;
}

} // namespace hil
