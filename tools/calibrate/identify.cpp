// One number at a time is moved away from the optimum, over a ladder of doubling steps and then by halving between the last step
// that noise explains and the first that it does not. That misses numbers that make up for each other; trials of the search that
// are as good as the best one show those, so the range is widened to them.
#include "tools/calibrate/identify.hpp"
#include <algorithm>
#include <array>

namespace seld::calibrate
{
namespace
{

constexpr std::array<double, 8> ladder = {0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 1.0};
constexpr int halvings = 4;

// One parameter in one direction.
struct Side {
    std::size_t parameter;
    double direction;  // -1 or +1
    double good = 0.0; // farthest offset that noise explains
    double bad = 0.0;  // nearest beyond it; 0: none
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

void climb(std::vector<Side> &sides, const Trial &best, double limit, const EvaluateShares &evaluate)
{
    std::vector<std::vector<double>> batch;
    for (const Side &side : sides)
        for (const double offset : ladder) batch.push_back(shares_at(best, side, offset));
    const std::vector<Verdict> verdicts = evaluate(batch);
    for (std::size_t s = 0; s < sides.size(); s++)
        for (std::size_t k = 0; k < ladder.size(); k++) {
            if (verdicts[s * ladder.size() + k].objective > limit) {
                sides[s].bad = ladder[k];
                break;
            }
            sides[s].good = ladder[k];
        }
}

void halve(std::vector<Side> &sides, const Trial &best, double limit, const EvaluateShares &evaluate)
{
    std::vector<std::vector<double>> batch;
    for (const Side &side : sides)
        batch.push_back(shares_at(best, side, side.bad > 0.0 ? (side.good + side.bad) / 2 : side.good));
    const std::vector<Verdict> verdicts = evaluate(batch);
    for (std::size_t s = 0; s < sides.size(); s++) {
        if (sides[s].bad <= 0.0) continue;
        const double middle = (sides[s].good + sides[s].bad) / 2;
        (verdicts[s].objective > limit ? sides[s].bad : sides[s].good) = middle;
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

} // namespace seld::calibrate
