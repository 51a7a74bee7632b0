// Searches for the best parameter values with the library pagmo, by the thesis' genetic algorithm. The caller
// can choose CMA-ES or differential evolution instead of the genetic algorithm, with the same budget of
// trials. A trial gives the value of each parameter as its position 0 .. 1 in the parameter's range.
//
// The algorithms of the library pagmo request one trial after the other. To evaluate
// all trials of a generation in parallel, we run each generation twice. In the first run, a copy of the
// algorithm runs on a problem that only records the requested trials. No trial of a generation depends on the
// result of another trial of that generation. The workers (threads or processes) evaluate the recorded trials
// of a generation at the same time. In the second run, pagmo's own algorithm runs the generation and receives
// the recorded results at once. The outcome of the search equals that of pagmo's algorithm alone, for any
// number of workers.
#pragma once
#include "tools/lab/calibrate/workers.hpp"
#include <cstdint>

namespace crn::calibrate
{

enum class Method { genetic, cmaes, differential };
const char *method_token(Method method); // "genetic", "cmaes", "differential"
std::optional<Method> method_of(const std::string &token);

// By default one search has the budget of the thesis, which is 50 generations of 50 trials.
constexpr unsigned trial_budget = 2500;
// Returns the number of trials per generation that suits a method. A generation has 50 trials, as in the
// thesis, or 16 trials with CMA-ES. CMA-ES learns from every generation, so it needs few trials per
// generation to fit up to five numbers (docs/calibrate.md, "Search").
unsigned default_population(Method method);

struct SearchSettings {
    Method method = Method::cmaes;
    unsigned population = 50;  // 8 .. 10000, even
    unsigned generations = 50; // the first one is drawn evenly over the ranges
    std::uint32_t seed = 1;
    double stop_spread_mm =
        0.0; // has_converged() compares with it; 0: only the number of generations ends a search
};

// `settings` completed for a method. If `population` or `generations` is not given, the function takes the
// method's usual population and as many generations as the budget permits, but at least 50.
SearchSettings sized(SearchSettings settings, Method method, std::optional<unsigned> population,
                     std::optional<unsigned> generations);

struct Trial {
    std::vector<double> shares;
    Verdict verdict;
};

// Holds all data of a search on which its next generation depends.
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

// Runs one more generation. `late` receives the number of trials that pagmo requested although they had not
// been recorded; this number is 0 unless pagmo's behaviour has changed.
void advance(const SearchSettings &settings, std::size_t parameter_count, const EvaluateShares &evaluate,
             SearchState &state, std::size_t *late = nullptr);

// Returns whether the objective of every member of the population is within `stop_spread_mm` of the best
// objective. The result depends only on the state, so a search that was stopped and resumed ends at the same
// generation.
bool has_converged(const SearchSettings &settings, const SearchState &state);

// Returns the trial with the lowest objective; of several equally good trials, it returns the first. The
// search's state must contain at least one trial.
const Trial &best_of(const SearchState &state);
std::vector<GenerationFigures> curve_of(const SearchState &state, unsigned population);

} // namespace crn::calibrate
