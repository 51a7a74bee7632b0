// Provides the values that the text of the thesis states for Figures 5.11, 5.13 and 5.14. None of the
// comparison values was obtained by measuring the bars that the thesis prints in its figures.
#pragma once
#include <optional>
#include <string>

namespace vcsim3
{

// Returns the compression in percent, or nothing if the thesis shows the compression only as a bar. The axis
// of compression in the thesis' printed figure ends at 14 %.
std::optional<double> thesis_compression_pct(const std::string &mode_token);
inline constexpr double thesis_compression_axis_pct = 14.0;

// Returns the milliseconds per step on a Core2 Quad at 2.66 GHz, or nothing for the mode "200 local", which
// Figure 5.14 omits.
struct ThesisTimes {
    double integrator_ms, constraints_ms, cosserat_ms, collisions_ms, total_ms; // the total as printed
};
std::optional<ThesisTimes> thesis_times(const std::string &mode_token);

} // namespace vcsim3
