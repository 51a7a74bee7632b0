// Moves each fitted number away from its best value in steps that double in size, until the objective rises
// by more than the noise explains. Then the search bisects the interval between the last two steps. A search
// that moves only one number at a time does not discover that two numbers compensate each other. Some trials
// of the search are as good as the best one, although their numbers differ; the range of each number is
// widened to include these trials.
#include "tools/lab/calibrate/identify.hpp"
#include <algorithm>
#include <array>

namespace crn::calibrate
{
namespace
{

constexpr std::array<double, 8> ladder = {0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 1.0};
constexpr int halvings = 4;

// One parameter in one direction.
struct Side {
    std::size_t parameter;
    double direction;  // -1 or +1
    double good = 0.0; // largest offset that noise explains
    double bad = 0.0;  // nearest offset beyond it; 0: none
};

double moved(const Trial &best, const Side &side, double offset)
{
    return std::clamp(best.shares[side.parameter] + side.direction * offset, 0.0, 1.0);
}

std::vector<double> shares_at(const Trial &best, const Side &side, double offset)
{
    std::vector<double> shares = best.shares;
    shares[side.parameter] = moved(best, side, offset);
    return shares;
}

// Returns the number of trial steps up to the first one that reaches the bound of the parameter; any larger
// step would give the same trial.
std::size_t steps_to_bound(const Trial &best, const Side &side)
{
    const double room =
        side.direction > 0.0 ? 1.0 - best.shares[side.parameter] : best.shares[side.parameter];
    const auto last = std::find_if(ladder.begin(), ladder.end(), [&](double step) { return step >= room; });
    return last == ladder.end() ? ladder.size() : static_cast<std::size_t>(last - ladder.begin()) + 1;
}

void climb(std::vector<Side> &sides, const Trial &best, double limit, const EvaluateShares &evaluate)
{
    std::vector<std::vector<double>> batch;
    for (const Side &side : sides)
        for (std::size_t k = 0; k < steps_to_bound(best, side); k++)
            batch.push_back(shares_at(best, side, ladder[k]));
    const std::vector<Verdict> verdicts = evaluate(batch);
    std::size_t first = 0;
    for (Side &side : sides) {
        const std::size_t steps = steps_to_bound(best, side);
        for (std::size_t k = 0; k < steps && side.bad <= 0.0; k++)
            (verdicts[first + k].objective > limit ? side.bad : side.good) = ladder[k];
        first += steps;
    }
}

void halve(std::vector<Side> &sides, const Trial &best, double limit, const EvaluateShares &evaluate)
{
    std::vector<std::vector<double>> batch;
    for (const Side &side : sides)
        if (side.bad > 0.0) batch.push_back(shares_at(best, side, (side.good + side.bad) / 2));
    if (batch.empty()) return;
    const std::vector<Verdict> verdicts = evaluate(batch);
    std::size_t next = 0;
    for (Side &side : sides) {
        if (side.bad <= 0.0) continue;
        const double middle = (side.good + side.bad) / 2;
        (verdicts[next++].objective > limit ? side.bad : side.good) = middle;
    }
}

} // namespace

std::vector<Identified> identify(const std::vector<Parameter> &parameters, const Trial &best,
                                 const std::vector<Trial> &trials, const EvaluateShares &evaluate,
                                 const IdentifySettings &settings)
{
    const double limit = best.verdict.objective + settings.noise_mm;
    std::vector<Side> sides;
    for (std::size_t i = 0; i < parameters.size(); i++)
        for (const double direction : {-1.0, 1.0}) sides.push_back({i, direction});
    if (settings.is_wanted) climb(sides, best, limit, evaluate);
    for (int i = 0; settings.is_wanted && i < halvings; i++) halve(sides, best, limit, evaluate);

    std::vector<Identified> result;
    for (std::size_t i = 0; i < parameters.size(); i++) {
        double low = moved(best, sides[2 * i], sides[2 * i].good);
        double high = moved(best, sides[2 * i + 1], sides[2 * i + 1].good);
        for (const Trial &trial : trials) {
            if (trial.verdict.objective > limit) continue;
            low = std::min(low, trial.shares[i]);
            high = std::max(high, trial.shares[i]);
        }
        result.push_back({parameters[i].value_at(low), parameters[i].value_at(high), high - low,
                          high - low < settings.spans_share});
    }
    return result;
}

} // namespace crn::calibrate
