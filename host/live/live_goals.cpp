#include "host/live/live_goals.hpp"
#include "host/base/format.hpp"

namespace crn
{
namespace
{

// The live session checks its goals less often than the final marking does, because computing the residual
// stenosis takes milliseconds, during which the physics waits.
constexpr std::uint32_t look_ticks = 4 * GoalWatch::look_every_ticks;

} // namespace

LiveGoals::LiveGoals(std::shared_ptr<const Case> lesson, LiveSession &session)
    : lesson_(std::move(lesson)), tips_(session.anatomy().bodies.vessels, session.anatomy().motion),
      witness_(tips_.map(), session.patient()), goals_(*lesson_, tips_.map())
{
}

void LiveGoals::look(const SessionFrame &frame)
{
    const std::uint32_t tick = frame.wire.tick;
    if (tick < next_) return;
    next_ = tick + look_ticks - tick % look_ticks;
    std::vector<double> inserted_m, turned_deg;
    for (const ToolReading &tool : frame.tools) {
        inserted_m.push_back(tool.inserted_m);
        turned_deg.push_back(tool.turned_deg);
    }
    const std::vector<TipPlace> places = tips_.at(frame.wire);
    goals_.look({inserted_m, places, &witness_, tick}, turned_deg);
    auto texts = std::make_shared<std::vector<std::string>>();
    for (const TipPlace &tip : places)
        texts->push_back(!tip.is_known ? std::string()
                                       : formatted("%.0f mm inside %s", tip.inside_m * 1e3,
                                                   tips_.map().vessels()[tip.place.vessel].name.c_str()));
    tip_texts_.put(std::move(texts));
    results_.put(std::make_shared<const std::vector<GoalResult>>(goals_.results()));
}

} // namespace crn
