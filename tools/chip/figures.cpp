#include "tools/chip/figures.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

namespace chip
{

namespace
{

void print(const std::string &name, const std::vector<TickPrice> &ticks,
           const std::function<double(const TickPrice &)> &quantity)
{
    std::vector<double> values;
    for (const TickPrice &tick : ticks) values.push_back(quantity(tick));
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    std::printf("%s %.0f %.0f %.0f\n", name.c_str(), sum / static_cast<double>(values.size()),
                percentile(values, 0.999), *std::max_element(values.begin(), values.end()));
}

} // namespace

double percentile(std::vector<double> values, double share)
{
    std::sort(values.begin(), values.end());
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

void print_figures(const std::vector<TickPrice> &ticks)
{
    std::printf("ticks %zu\n", ticks.size());
    print("instructions", ticks, [](const TickPrice &t) { return t.instructions; });
    print("core_cycles", ticks, [](const TickPrice &t) { return t.core_cycles; });
    print("branch_cycles", ticks, [](const TickPrice &t) { return t.branch_cycles; });
    print("lines", ticks, [](const TickPrice &t) { return t.lines; });
    print("bricks", ticks, [](const TickPrice &t) { return t.bricks; });
    print("motion_rows", ticks, [](const TickPrice &t) { return t.motion_rows; });
    print("misses", ticks, [](const TickPrice &t) { return t.misses; });
    for (const Board &board : boards)
        print("cycles_" + std::string(board.name), ticks,
              [&](const TickPrice &t) { return t.cycles(board); });
}

} // namespace chip
