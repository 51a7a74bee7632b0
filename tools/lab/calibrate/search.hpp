// The search for the best numbers by pagmo: the thesis' genetic algorithm, and beside it CMA-ES and
// differential evolution with the same budget. Trials are shares 0 .. 1 of the parameters' ranges.
//
// pagmo's algorithms ask for one trial after the other. So a generation is made twice: a copy of the
// algorithm is advanced with a problem that only notes what it is asked (all of a generation is drawn before
// the answers matter), the workers evaluate these trials together, and then the algorithm itself is advanced
// with a problem that answers from them. What it does is what it would have done alone, whatever the number
// of workers.
#pragma once
#include "tools/lab/calibrate/workers.hpp"
#include <cstdint>

namespace crn::calibrate
{

enum class Method { genetic, cmaes, differential };
const char *method_token(Method method); // "genetic", "cmaes", "differential"
std::optional<Method> method_of(const std::string &token);

// Of one search, as in the thesis: 50 generations of 50.
constexpr unsigned trial_budget = 2500;
// Trials per generation that suit a method: the thesis' 50; a third of that for CMA-ES, which learns from
// every generation and needs few for five numbers or less (docs/calibrate.md, "Search").
unsigned default_population(Method method);

struct SearchSettings {
    Method method = Method::cmaes;
    unsigned population = 50;  // 8 .. 10000, even
    unsigned generations = 50; // the first one is drawn evenly over the ranges
    std::uint32_t seed = 1;
    double stop_spread_mm = 0.0; // has_converged() below it; 0: the generations end a search
};

// `settings` for a method: with its population and as many generations as the budget has room for, but 50 at
// least, where none are given.
SearchSettings sized(SearchSettings settings, Method method, std::optional<unsigned> population,
                     std::optional<unsigned> generations);

struct Trial {
    std::vector<double> shares;
    Verdict verdict;
};

// Everything that the next generation depends on.
struct SearchState {
    unsigned generation = 0;       // that are done
    std::vector<Trial> trials;     // all, in the order in which they were drawn
    std::vector<Trial> population; // that the algorithm holds
    std::string algorithm;         // pagmo's own, as its archive writes it
};

struct GenerationFigures {
    unsigned evaluations = 0; // until its end
    double best = 0.0,
           mean = 0.0;          // objective: of all so far; of this generation's trials that were not refused
    double best_error_mm = 0.0; // equation 19 of the best so far
};

using EvaluateShares = std::function<std::vector<Verdict>(const std::vector<std::vector<double>> &)>;

// One more generation. `late` gets the number of trials that were not in the table, which is 0 unless pagmo
// has changed its ways.
void advance(const SearchSettings &settings, std::size_t parameter_count, const EvaluateShares &evaluate,
             SearchState &state, std::size_t *late = nullptr);

// Whether all that the algorithm holds is as good as the best but for `stop_spread_mm`. From the state alone,
// so a search that was stopped and resumed ends at the same generation.
bool has_converged(const SearchSettings &settings, const SearchState &state);

// The first of the best trials. The state has at least one.
const Trial &best_of(const SearchState &state);
std::vector<GenerationFigures> curve_of(const SearchState &state, unsigned population);

} // namespace crn::calibrate
