#include "tools/lab/calibrate/result.hpp"
#include <algorithm>
#include <cmath>

namespace crn::calibrate
{
namespace
{

std::vector<double> values_of(const std::vector<Parameter> &parameters, const std::vector<double> &shares)
{
    std::vector<double> values;
    for (std::size_t i = 0; i < parameters.size(); i++) values.push_back(parameters[i].value_at(shares[i]));
    return values;
}

ParameterResult judged(const Parameter &parameter, double share, const Identified &identified, bool has_force)
{
    ParameterResult result{parameter, parameter.value_at(share), identified, identified.is_determined, "",
                           0.0};
    if (parameter.scales_force && !has_force) {
        result.is_determined = false;
        result.why = "no force trace: a rigid lumen shows ratios of stiffness only";
    } else if (!result.is_determined) {
        result.why = "the data leave it open: it can go over nearly all of its range";
    }
    result.kept = result.fitted;
    return result;
}

// Resets those fitted numbers that the data leave undetermined to their values in the instrument file, one
// after the other. A number is reset only if the objective rises by no more than the noise explains.
Verdict keep_nominal(std::vector<ParameterResult> &parameters, double limit, const EvaluateShares &evaluate,
                     Verdict best)
{
    const auto shares = [&] {
        std::vector<double> list;
        for (const ParameterResult &p : parameters) list.push_back(p.parameter.share_of(p.kept));
        return list;
    };
    for (ParameterResult &p : parameters) {
        if (p.is_determined) continue;
        p.kept = p.parameter.nominal;
        const Verdict verdict = evaluate({shares()}).at(0);
        if (verdict.objective <= limit) {
            best = verdict;
            continue;
        }
        p.kept = p.fitted;
        p.why += "; the file's value fits worse, so the fitted one is kept";
    }
    return best;
}

// Repeats the simulated insertion with shorter elements and without the other shortcuts. If the core's number
// format cannot represent the shorter elements, the fit is still valid, but there is no result without
// shortcuts.
std::optional<Insertion> careful_insertion(const Evaluator &careful, const std::vector<double> &values,
                                           std::size_t depth_count)
{
    try {
        return careful.insert(values, depth_count);
    } catch (const TrialRefused &) {
        return std::nullopt;
    }
}

std::vector<DepthResult> depths_of(const insertion::Case &c, const Judge &judge, const Insertion &made,
                                   const std::optional<Insertion> &careful)
{
    std::vector<DepthResult> depths;
    for (std::size_t i = 0; i < c.depths.size(); i++) {
        DepthResult depth;
        depth.name = c.depths[i].name;
        depth.inserted_mm = c.depths[i].inserted_mm;
        depth.is_fitted = i < judge.settings().fit_depths;
        depth.simulated_mm = made.nodes_mm.at(i);
        depth.reference_mm = judge.references_mm()[i];
        depth.distances = distances_of(depth.simulated_mm, depth.reference_mm);
        depth.settle_ticks = made.settle_ticks.at(i);
        if (judge.has_force()) depth.force_error = judge.force_error_to(made, i);
        if (careful) {
            std::vector<Vector3d> line = careful->nodes_mm.at(i);
            line.push_back(c.mouth_mm);
            depth.short_cuts_mm = distances_of(depth.simulated_mm, line).rms_mm;
        }
        depths.push_back(std::move(depth));
    }
    return depths;
}

Distances average_of(const std::vector<DepthResult> &depths)
{
    Distances average;
    const double share = 1.0 / static_cast<double>(depths.size());
    for (const DepthResult &depth : depths) {
        average.rms_mm += share * depth.distances.rms_mm;
        average.mean_mm += share * depth.distances.mean_mm;
        average.deviation_mm += share * depth.distances.deviation_mm;
        average.max_mm += share * depth.distances.max_mm;
        average.count += depth.distances.count;
    }
    return average;
}

const Finished &best_search(const std::vector<Finished> &searches)
{
    return *std::min_element(searches.begin(), searches.end(), [](const Finished &a, const Finished &b) {
        return best_of(a.state).verdict.objective < best_of(b.state).verdict.objective;
    });
}

} // namespace

Result make_result(const insertion::Case &c, const Evaluator &evaluator, const Evaluator &careful,
                   const Judge &judge, const std::vector<Finished> &searches, const EvaluateShares &evaluate,
                   const IdentifySettings &settings)
{
    const Finished &chosen = best_search(searches);
    const Trial &best = best_of(chosen.state);
    if (best.verdict.is_refused())
        throw TrialRefused("no trial could be made: every insertion was refused; does the case's "
                           "mouth lie in the "
                           "lumen, and does its instrument fit there?");
    Result result;
    result.name = c.name;
    result.instrument = evaluator.instrument_name();
    result.rod = evaluator.rod();
    result.search = chosen.settings;
    result.noise_mm = settings.noise_mm;
    result.has_force = judge.has_force();
    result.best = best.verdict;
    result.evaluations = static_cast<unsigned>(chosen.state.trials.size());
    const std::vector<Parameter> &parameters = evaluator.parameters();
    const std::vector<Identified> identified =
        identify(parameters, best, chosen.state.trials, evaluate, settings);
    for (std::size_t i = 0; i < parameters.size(); i++)
        result.parameters.push_back(judged(parameters[i], best.shares[i], identified[i], result.has_force));
    result.kept =
        keep_nominal(result.parameters, best.verdict.objective + settings.noise_mm, evaluate, best.verdict);
    std::vector<double> shares;
    for (const ParameterResult &p : result.parameters) shares.push_back(p.parameter.share_of(p.kept));
    const std::vector<double> values = values_of(parameters, shares);
    result.instrument_file = evaluator.instrument_text(values, "fitted by calibrate from case " + c.name);
    result.depths = depths_of(c, judge, evaluator.insert(values, c.depths.size()),
                              careful_insertion(careful, values, c.depths.size()));
    result.average = average_of(result.depths);
    for (const Finished &search : searches)
        result.methods.push_back({search.settings, best_of(search.state).verdict.objective,
                                  curve_of(search.state, search.settings.population)});
    return result;
}

} // namespace crn::calibrate
