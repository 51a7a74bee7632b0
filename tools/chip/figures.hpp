// The figures of many priced ticks, as lines "name value" for tools/bench/budget.py.
#pragma once
#include "tools/chip/pricer.hpp"
#include <cstdint>
#include <vector>

namespace chip
{

// The value that the given share of the values does not exceed (nearest rank); `values` is not empty.
double percentile(std::vector<double> values, double share);

// Prints mean, 99.9th percentile and largest value of every quantity of these ticks.
void print_figures(const std::vector<TickPrice> &ticks);

// Prints cycles and misses of a tick for each function, the dearest on the first board first.
void print_functions(const Processor &processor, const std::vector<Spent> &spent, std::size_t ticks);

} // namespace chip
