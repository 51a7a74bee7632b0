#include "tools/chip/figures.hpp"
#include "tools/chip/instruction.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
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
    if (ticks.empty()) throw PriceError("there is no tick to price; record a longer session");
    std::printf("ticks %zu\n", ticks.size());
    print("instructions", ticks, [](const TickPrice &t) { return t.instructions; });
    print("core_cycles", ticks, [](const TickPrice &t) { return t.core_cycles; });
    print("branch_cycles", ticks, [](const TickPrice &t) { return t.branch_cycles; });
    print("lines", ticks, [](const TickPrice &t) { return t.lines; });
    print("bricks", ticks, [](const TickPrice &t) { return t.bricks; });
    print("motion_rows", ticks, [](const TickPrice &t) { return t.motion_rows; });
    print("misses", ticks, [](const TickPrice &t) { return t.misses; });
    print("near_misses", ticks, [](const TickPrice &t) { return t.near_misses; });
    for (const Board &board : boards)
        print("cycles_" + std::string(board.name), ticks,
              [&](const TickPrice &t) { return t.cycles(board); });
}

void print_functions(const Processor &processor, const std::vector<Spent> &spent, std::size_t ticks)
{
    const double miss_cycles = boards[0].line_ns * boards[0].core_MHz * 1e-3;
    std::map<std::string, Spent> by_name;
    for (const Spent &block : spent) {
        Spent &sum = by_name[processor.function_at(block.address)];
        sum.cycles += block.cycles;
        sum.misses += block.misses;
        sum.near_misses += block.near_misses;
    }
    std::vector<std::pair<double, std::string>> order;
    for (const auto &[name, sum] : by_name)
        order.emplace_back(static_cast<double>(sum.cycles) + static_cast<double>(sum.misses) * miss_cycles,
                           name);
    std::sort(order.rbegin(), order.rend());
    for (const auto &[cycles, name] : order)
        if (cycles > 0.0)
            std::printf("%-32s %9.0f cycles, %8.0f of them without misses, %6.1f misses, %6.1f near\n",
                        name.c_str(), cycles / static_cast<double>(ticks),
                        static_cast<double>(by_name[name].cycles) / static_cast<double>(ticks),
                        static_cast<double>(by_name[name].misses) / static_cast<double>(ticks),
                        static_cast<double>(by_name[name].near_misses) / static_cast<double>(ticks));
}

} // namespace chip
