// Of all files in this folder, only this file includes the libraries pagmo and boost.
#include "tools/lab/calibrate/search.hpp"
#include <algorithm>
#include <boost/archive/text_iarchive.hpp>
#include <boost/archive/text_oarchive.hpp>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/de.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <random>
#include <sstream>

namespace crn::calibrate
{
namespace
{

using Numbers = std::vector<double>;

// Holds the data that all copies of an optimisation problem share: the requested trials and the result of
// each trial.
struct Exchange {
    bool is_collecting = false;
    std::vector<Numbers> asked;
    std::map<Numbers, double> answers;
    std::vector<Numbers> late;
    EvaluateShares evaluate;
};

// The library pagmo copies its problems, so each problem contains only a pointer to these data.
struct SharedProblem {
    std::size_t count = 1;
    Exchange *exchange = nullptr;

    Numbers fitness(const Numbers &shares) const
    {
        Exchange &e = *exchange;
        if (e.is_collecting) {
            e.asked.push_back(shares);
            return {0.0};
        }
        auto answer = e.answers.find(shares);
        if (answer == e.answers.end()) {
            e.late.push_back(shares);
            answer = e.answers.emplace(shares, e.evaluate({shares}).at(0).objective).first;
        }
        return {answer->second};
    }
    std::pair<Numbers, Numbers> get_bounds() const { return {Numbers(count, 0.0), Numbers(count, 1.0)}; }
    // SearchState stores the state of the search, so the functions with which pagmo would store a problem do
    // nothing.
    template <typename Archive> void serialize(Archive &, unsigned) {}
};

// All tolerances are 0, so that a search ends only when its budget is used up, and the three methods can be
// compared.
pagmo::algorithm fresh_algorithm(const SearchSettings &settings)
{
    switch (settings.method) {
    case Method::genetic:
        // The genetic algorithm chooses pairs by tournament, crosses them with probability 0.9, and mutates
        // each number with probability 1/20. The best of the parents and children survive.
        return pagmo::algorithm(
            pagmo::sga(1, 0.9, 10.0, 0.05, 10.0, 2, "sbx", "polynomial", "tournament", settings.seed));
    case Method::differential:
        return pagmo::algorithm(pagmo::de(1, 0.8, 0.9, 2, 0.0, 0.0, settings.seed));
    case Method::cmaes:
        break;
    }
    return pagmo::algorithm(pagmo::cmaes(1, -1, -1, -1, -1, 0.3, 0.0, 0.0, true, true, settings.seed));
}

std::string to_text(const pagmo::algorithm &algorithm)
{
    std::ostringstream stream;
    {
        boost::archive::text_oarchive archive(stream);
        archive << algorithm;
    }
    return stream.str();
}

pagmo::algorithm from_text(const std::string &text)
{
    std::istringstream stream(text);
    pagmo::algorithm algorithm;
    boost::archive::text_iarchive archive(stream);
    archive >> algorithm;
    return algorithm;
}

pagmo::population population_of(const SearchState &state, std::size_t count, Exchange &exchange)
{
    pagmo::population population(pagmo::problem(SharedProblem{count, &exchange}), 0, 0);
    for (const Trial &one : state.population) population.push_back(one.shares, {one.verdict.objective});
    return population;
}

// Draws evenly distributed random numbers with 53 bits; the C++ standard defines the generator bit for bit.
std::vector<Numbers> first_trials(const SearchSettings &settings, std::size_t count)
{
    std::mt19937_64 generator(settings.seed);
    std::vector<Numbers> trials(settings.population, Numbers(count));
    for (Numbers &trial : trials)
        for (double &share : trial) share = static_cast<double>(generator() >> 11) * 0x1p-53;
    return trials;
}

void keep(SearchState &state, const std::vector<Numbers> &trials, const std::vector<Verdict> &verdicts)
{
    for (std::size_t i = 0; i < trials.size(); i++) state.trials.push_back({trials[i], verdicts.at(i)});
}

} // namespace

const char *method_token(Method method)
{
    return method == Method::genetic ? "genetic" : method == Method::cmaes ? "cmaes" : "differential";
}

unsigned default_population(Method method)
{
    return method == Method::cmaes ? 16 : 50;
}

SearchSettings sized(SearchSettings settings, Method method, std::optional<unsigned> population,
                     std::optional<unsigned> generations)
{
    constexpr unsigned least_generations = 50; // a single random draw is no search
    settings.method = method;
    settings.population = population.value_or(default_population(method));
    settings.generations =
        generations.value_or(std::max(least_generations, trial_budget / settings.population));
    return settings;
}

std::optional<Method> method_of(const std::string &token)
{
    for (const Method method : {Method::genetic, Method::cmaes, Method::differential})
        if (token == method_token(method)) return method;
    return std::nullopt;
}

void advance(const SearchSettings &settings, std::size_t parameter_count, const EvaluateShares &evaluate,
             SearchState &state, std::size_t *late)
{
    if (late) *late = 0;
    if (state.generation == 0) {
        const std::vector<Numbers> trials = first_trials(settings, parameter_count);
        keep(state, trials, evaluate(trials));
        state.population = state.trials;
        state.algorithm = to_text(fresh_algorithm(settings));
        state.generation = 1;
        return;
    }
    Exchange exchange;
    exchange.evaluate = evaluate;
    const pagmo::algorithm algorithm = from_text(state.algorithm);
    const pagmo::population before = population_of(state, parameter_count, exchange);

    exchange.is_collecting = true;
    pagmo::algorithm(algorithm).evolve(before);
    exchange.is_collecting = false;
    const std::vector<Verdict> verdicts = evaluate(exchange.asked);
    for (std::size_t i = 0; i < exchange.asked.size(); i++)
        exchange.answers[exchange.asked[i]] = verdicts.at(i).objective;

    const pagmo::population after = algorithm.evolve(before);
    keep(state, exchange.asked, verdicts);
    for (const Numbers &trial : exchange.late)
        state.trials.push_back({trial, {exchange.answers[trial], exchange.answers[trial], 0.0}});
    state.population.clear();
    for (std::size_t i = 0; i < after.size(); i++)
        state.population.push_back({after.get_x()[i], {after.get_f()[i][0], 0.0, 0.0}});
    state.algorithm = to_text(algorithm);
    state.generation++;
    if (late) *late = exchange.late.size();
}

bool has_converged(const SearchSettings &settings, const SearchState &state)
{
    if (settings.stop_spread_mm <= 0.0 || state.population.empty()) return false;
    const auto [best, worst] = std::minmax_element(
        state.population.begin(), state.population.end(),
        [](const Trial &a, const Trial &b) { return a.verdict.objective < b.verdict.objective; });
    return worst->verdict.objective - best->verdict.objective < settings.stop_spread_mm;
}

const Trial &best_of(const SearchState &state)
{
    const Trial *best = &state.trials.at(0);
    for (const Trial &trial : state.trials)
        if (trial.verdict.objective < best->verdict.objective) best = &trial;
    return *best;
}

std::vector<GenerationFigures> curve_of(const SearchState &state, unsigned population)
{
    std::vector<GenerationFigures> curve;
    GenerationFigures figures;
    figures.best = Verdict::refused_objective;
    double sum = 0.0, count = 0.0;
    for (const Trial &trial : state.trials) {
        figures.evaluations++;
        if (!trial.verdict.is_refused()) {
            sum += trial.verdict.objective;
            count += 1.0;
        }
        if (trial.verdict.objective < figures.best) {
            figures.best = trial.verdict.objective;
            figures.best_error_mm = trial.verdict.error_mm;
        }
        if (figures.evaluations % population == 0 || figures.evaluations == state.trials.size()) {
            figures.mean = count > 0.0 ? sum / count : Verdict::refused_objective;
            curve.push_back(figures);
            sum = count = 0.0;
        }
    }
    return curve;
}

} // namespace crn::calibrate
