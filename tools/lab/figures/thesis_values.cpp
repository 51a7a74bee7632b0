// The values come from section 5.4.2 of the thesis and from the table under Figure 5.14. Section 5.4.2 states
// compressions of 0.45, 2.98 and 1.40 %. For 100 and 200 iterations section 5.4.2 states 0.41 and 0.79 % less
// compression than for 50 iterations.
#include "tools/lab/figures/thesis_values.hpp"
#include <map>

namespace vcsim3
{

std::optional<double> thesis_compression_pct(const std::string &mode_token)
{
    static const std::map<std::string, double> stated = {
        {"global", 0.45},          {"local25", 2.98},         {"local50", 1.40},
        {"local100", 1.40 - 0.41}, {"local200", 1.40 - 0.79},
    };
    const auto found = stated.find(mode_token);
    return found == stated.end() ? std::nullopt : std::optional(found->second);
}

std::optional<ThesisTimes> thesis_times(const std::string &mode_token)
{
    static const std::map<std::string, ThesisTimes> stated = {
        {"global", {0.05, 0.05, 0.18, 0.57, 0.86}},  {"penalty", {0.05, 0.01, 0.29, 0.47, 0.81}},
        {"local1", {0.05, 0.02, 0.18, 0.41, 0.66}},  {"local5", {0.05, 0.08, 0.18, 0.45, 0.75}},
        {"local10", {0.05, 0.16, 0.18, 0.52, 0.90}}, {"local25", {0.05, 0.32, 0.17, 0.54, 1.09}},
        {"local50", {0.05, 0.80, 0.17, 0.53, 1.56}}, {"local100", {0.05, 1.56, 0.17, 0.57, 2.36}},
    };
    const auto found = stated.find(mode_token);
    return found == stated.end() ? std::nullopt : std::optional(found->second);
}

} // namespace vcsim3
