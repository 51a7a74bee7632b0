#include "host/patient/layering.hpp"
#include <algorithm>
#include <numbers>

namespace crn
{

std::vector<double> mean_flows_ml_s(const FlowCells &cells)
{
    std::vector<double> flows(cells.size(), 0.0);
    for (std::size_t i = cells.size(); i-- > 0;) { // a cell comes after the cell that feeds it
        flows[i] += cells[i].outlet_ml_s;
        if (cells[i].upstream >= 0) flows[static_cast<std::size_t>(cells[i].upstream)] += flows[i];
    }
    return flows;
}

double settled_share(double iodine_mg_per_ml, double radius_mm, double flow_ml_s)
{
    constexpr double g_m_s2 = 9.81, excess_per_mg_ml = (1.39 / 1.055 - 1.0) / 350.0;
    constexpr double mixed_below = 0.25, complete_from = 1.5, most = 0.9;
    const double radius_m = radius_mm * 1e-3;
    const double speed_m_s = std::max(flow_ml_s * 1e-6 / (std::numbers::pi * radius_m * radius_m), 1e-3);
    const double richardson =
        g_m_s2 * excess_per_mg_ml * iodine_mg_per_ml * 2.0 * radius_m / (speed_m_s * speed_m_s);
    return std::clamp((richardson - mixed_below) / (complete_from - mixed_below), 0.0, most);
}

} // namespace crn
