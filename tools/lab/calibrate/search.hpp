// The search for the best numbers by pagmo: the thesis' genetic algorithm, and beside it CMA-ES and
// differential evolution with the same budget. Trials are shares 0 .. 1 of the parameters' ranges.
//
// pagmo's algorithms request one trial after the other. We therefore run each generation twice. First we
// advance a copy of the algorithm with a problem that only records the requested trials; a whole generation
// is drawn before any answer matters. The workers then evaluate these trials together. Finally we advance the
// algorithm itself with a problem that answers from them. The result is what the algorithm would have done
// alone, whatever the number of workers.
#pragma once
#include "tools/lab/calibrate/workers.hpp"
#include <cstdint>

namespace crn::calibrate
{

enum class Method { genetic, cmaes, differential };
const char *method_token(Method method); // "genetic", "cmaes", "differential"
std::optional<Method> method_of(const std::string &token);

// The budget of one search, as in the thesis: 50 generations of 50.
constexpr unsigned trial_budget = 2500;
// Returns the number of trials per generation that suits a method. It is the thesis' 50, or a third of that
// for CMA-ES, which learns from every generation and needs few trials for up to five numbers
// (docs/calibrate.md, "Search").
unsigned default_population(Method method);

struct SearchSettings {
    Method method = Method::cmaes;
    unsigned population = 50;  // 8 .. 10000, even
    unsigned generations = 50; // the first one is drawn evenly over the ranges
    std::uint32_t seed = 1;
    double stop_spread_mm =
        0.0; // has_converged() compares with it; 0: only the number of generations ends a search
};

// `settings` completed for a method. Without given values it takes the method's population and as many
// generations as the budget allows, at least 50.
SearchSettings sized(SearchSettings settings, Method method, std::optional<unsigned> population,
                     std::optional<unsigned> generations);

struct Trial {
    std::vector<double> shares;
    Verdict verdict;
};

// All state on which the next generation depends.
struct SearchState {
    unsigned generation = 0;       // number of completed generations
    std::vector<Trial> trials;     // all trials, in the order in which they were drawn
    std::vector<Trial> population; // the algorithm's present population
    std::string algorithm;         // pagmo's own state, as its archive writes it
};

struct GenerationFigures {
    unsigned evaluations = 0; // number up to the end of this generation
    double best = 0.0,
           mean =
               0.0; // objective: best of all so far; mean of this generation's trials that were not refused
    double best_error_mm = 0.0; // equation 19 of the best trial so far
};

using EvaluateShares = std::function<std::vector<Verdict>(const std::vector<std::vector<double>> &)>;

// Runs one more generation. `late` receives the number of trials that were not in the table; it is 0 unless
// pagmo's behaviour has changed.
void advance(const SearchSettings &settings, std::size_t parameter_count, const EvaluateShares &evaluate,
             SearchState &state, std::size_t *late = nullptr);

// Returns whether the whole population is within `stop_spread_mm` of the best. It depends on the state alone,
// so a search that was stopped and resumed ends at the same generation.
bool has_converged(const SearchSettings &settings, const SearchState &state);

// Returns the first of the best trials. The state must have at least one.
const Trial &best_of(const SearchState &state);
std::vector<GenerationFigures> curve_of(const SearchState &state, unsigned population);

} // namespace crn::calibrate
