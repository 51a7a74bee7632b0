#include "host/assess/signals.hpp"
#include <algorithm>

namespace crn
{

namespace
{

std::vector<double> pushes_against_a_fixed_tip(const SessionLog &log, std::size_t k)
{
    std::vector<double> fixed_mm;
    Eigen::Vector3d anchor_mm = Eigen::Vector3d::Zero();
    double from_mm = 0.0;
    for (const SessionMoment &moment : log.moments) {
        const ToolMoment &tool = moment.tools[k];
        const bool has_moved = fixed_mm.empty() || !tool.has_tip ||
                               (tool.tip_mm - anchor_mm).norm() > SessionSignals::tip_rests_mm;
        if (has_moved) {
            anchor_mm = tool.tip_mm;
            from_mm = tool.inserted_mm;
        }
        from_mm = std::min(from_mm, tool.inserted_mm);
        fixed_mm.push_back(tool.inserted_mm - from_mm);
    }
    return fixed_mm;
}

} // namespace

SessionSignals::SessionSignals(const SessionLog &log) : log_(log)
{
    for (std::size_t k = 0; k < tools_.size(); ++k) {
        ToolSignals &tool = tools_[k];
        tool.fixed_mm = pushes_against_a_fixed_tip(log, k);
        for (std::size_t i = 0; i < log.moments.size(); ++i) {
            const std::size_t before = i - std::min(i, window_moments);
            const double seconds = (log.moments[i].tick - log.moments[before].tick) * 1e-3;
            const ToolMoment &now = log.moments[i].tools[k], &then = log.moments[before].tools[k];
            const double rate = seconds > 0.0 ? 1.0 / seconds : 0.0;
            tool.hand_mm_s.push_back((now.inserted_mm - then.inserted_mm) * rate);
            tool.turn_deg_s.push_back((now.turned_deg - then.turned_deg) * rate);
            tool.tip_mm_s.push_back(now.has_tip && then.has_tip ? (now.tip_mm - then.tip_mm).norm() * rate
                                                                : 0.0);
        }
    }
}

} // namespace crn
