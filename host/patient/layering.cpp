#include "host/patient/layering.hpp"
#include <algorithm>
#include <numbers>

namespace crn
{

namespace
{

void even_out(const FlowCells &cells, std::size_t begin, std::size_t end, const std::vector<double> &flows,
              std::vector<double> &even)
{
    constexpr double reach_radii = 3.0;
    for (std::size_t i = begin; i < end; ++i) {
        double sum = flows[i] * cells[i].length_mm, length_mm = cells[i].length_mm;
        const auto add = [&](std::size_t at, double &left_mm) {
            const double part_mm = std::min(left_mm, cells[at].length_mm);
            sum += flows[at] * part_mm;
            length_mm += part_mm;
            left_mm -= part_mm;
        };
        double up_mm = reach_radii * cells[i].radius_mm, down_mm = up_mm;
        for (std::size_t at = i; at > begin && up_mm > 0.0; --at) add(at - 1, up_mm);
        for (std::size_t at = i + 1; at < end && down_mm > 0.0; ++at) add(at, down_mm);
        even[i] = sum / length_mm;
    }
}

} // namespace

std::vector<double> mean_flows_ml_s(const FlowCells &cells)
{
    std::vector<double> flows(cells.size(), 0.0);
    for (std::size_t i = cells.size(); i-- > 0;) { // a cell comes after the cell that feeds it
        flows[i] += cells[i].outlet_ml_s;
        if (cells[i].upstream >= 0) flows[static_cast<std::size_t>(cells[i].upstream)] += flows[i];
    }
    std::vector<double> even = flows;
    for (std::size_t branch = 0; branch < cells.branch_count(); ++branch)
        even_out(cells, cells.branch_begin(branch), cells.branch_begin(branch + 1), flows, even);
    return even;
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
