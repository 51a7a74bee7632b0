// What a millisecond of contrast medium costs: docs/contrast.md. A tree of 2,000 cells, medium in every one of them, a beating
// heart and an injection in every step.
#include "firmware/bench/bench.h"
#include "host/effects/contrast_flow.hpp"
#include <algorithm>
#include <memory>
#include <string>

using namespace seld;

namespace
{

constexpr std::size_t cells_wanted = 2000;
constexpr int warm_ticks = 12000, measured_ticks = 20, rounds = 500; // short ones: some are not interrupted

VesselBranch straight(int index, const Eigen::Vector3d &from_m, const Eigen::Vector3d &to_m, double radius_m)
{
    VesselBranch branch;
    branch.name = std::to_string(index);
    for (int i = 0; i <= 10; ++i) {
        branch.points_m.push_back(from_m + 0.1 * i * (to_m - from_m));
        branch.radii_m.push_back(radius_m);
    }
    return branch;
}

// An aorta with side branches all along it, until there are as many cells as asked for.
VesselTree tree_of_cells()
{
    VesselTree tree{{straight(0, {0, 0.3, 0}, {0, -0.3, 0}, 0.01)}};
    for (int i = 0; FlowCells(tree).size() < cells_wanted; ++i) {
        const double y = 0.3 - 0.06 * (1 + i % 9), side = i % 2 == 0 ? 1.0 : -1.0;
        tree.branches.push_back(straight(i + 1, {0, y, 0}, {0.06 * side, y - 0.001 * i, 0.02}, 0.0025));
        tree.branches.back().parent = 0;
        tree.branches.back().parent_point = static_cast<std::size_t>(1 + i % 9);
    }
    return tree;
}

class Bench
{
  public:
    Bench() : contrast_(tree_of_cells())
    {
        const CatheterMouth mouth{{0, 0.29, 0}, 1.0};
        contrast_.set_mouths({&mouth, 1});
        while (tick_ < warm_ticks) step();
        std::size_t filled = 0;
        for (std::size_t i = 0; i < contrast_.cells().size(); ++i)
            filled += contrast_.iodine_mg_per_ml(i) > 1.0;
        if (filled < contrast_.cells().size() - 10) bench_fail("the tree of the benchmark has not filled");
    }
    void step() { contrast_.step(flow_drive(steady_beat(tick_++, 70)), {15.0, 350.0}); }

  private:
    ContrastFlow contrast_;
    std::uint32_t tick_ = 0;
};

std::unique_ptr<Bench> bench;

extern "C" BENCH_MEASURED void measured_contrast_step()
{
    bench->step();
}

double step_us(const bench_case *)
{
    bench = std::make_unique<Bench>();
    double fastest_us = 1e9;
    for (int round = 0; round < rounds; ++round) {
        const double begin_us = bench_now_us();
        for (int i = 0; i < measured_ticks; ++i) measured_contrast_step();
        fastest_us = std::min(fastest_us, (bench_now_us() - begin_us) / measured_ticks);
    }
    return fastest_us;
}

double step_instructions(const bench_case *)
{
    bench = std::make_unique<Bench>();
    for (int i = 0; i < measured_ticks; ++i) measured_contrast_step();
    return 0.0;
}

const bench_case cases[] = {
    {"contrast.step_us", "us", "cells=2000", nullptr, 0, step_us, 0},
    {"contrast.step_instructions", "instructions", "cells=2000", "measured_contrast_step", measured_ticks,
     step_instructions, 0},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
