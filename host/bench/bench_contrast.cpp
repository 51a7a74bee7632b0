// Measures the time for simulating one millisecond of contrast medium, and the time for drawing the medium
// into a picture (docs/contrast.md). The first case is a vessel tree of 2,000 cells (short pieces of a
// vessel), all filled with medium. The heart beats, and every step has an injection. The second case adds
// 3,000 small vessels. The third case is the shipped aorta with its renal arteries filled.
#include "firmware/bench/bench.h"
#include "host/effects/contrast_flow.hpp"
#include "host/patient/contrast.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <memory>
#include <string>

using namespace crn;

namespace
{

constexpr std::size_t cells_wanted = 2000;
constexpr int warm_ticks = 12000, measured_ticks = 20,
              rounds = 500; // short rounds, so that some are not interrupted

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

// Makes an aorta with side branches along its whole length, so wide that it begins at the heart and stores
// blood; the tree has `cells_wanted` cells.
VesselTree tree_of_cells()
{
    VesselTree tree{{straight(0, {0, 0.3, 0}, {0, -0.3, 0}, 0.013)}};
    tree.branches[0].flow_ml_s = 300.0;
    for (int i = 0; FlowCells(tree).size() < cells_wanted; ++i) {
        const double y = 0.3 - 0.06 * (1 + i % 9), side = i % 2 == 0 ? 1.0 : -1.0;
        tree.branches.push_back(straight(i + 1, {0, y, 0}, {0.06 * side, y - 0.001 * i, 0.02}, 0.0025));
        tree.branches.back().parent = 0;
        tree.branches.back().parent_point = static_cast<std::size_t>(1 + i % 9);
    }
    return tree;
}

// Adds trees of small vessels behind the ends of the branches: each small vessel has four pieces and divides
// into two further ones, until there are `wanted`.
VesselTree with_small_vessels(VesselTree tree, std::size_t wanted)
{
    if (wanted == 0) return tree;
    const auto add = [&](int parent, std::size_t point, const Eigen::Vector3d &from_m, double side) {
        VesselBranch vessel;
        vessel.parent = parent;
        vessel.parent_point = point;
        vessel.flow_ml_s = 2e-3;
        for (int i = 0; i <= 4; ++i) {
            vessel.points_m.push_back(from_m + 0.003 * i * Eigen::Vector3d(0.5, side, 0.5));
            vessel.radii_m.push_back(0.25e-3);
        }
        tree.small.push_back(vessel);
    };
    for (std::size_t b = 1; b < tree.branches.size(); ++b)
        add(static_cast<int>(b), 10, tree.branches[b].points_m.back(), 0.5);
    for (std::size_t v = 0; tree.small.size() < wanted; ++v)
        for (double side : {-1.0, 1.0})
            add(static_cast<int>(tree.branches.size() + v), 4, tree.small[v].points_m.back(), side);
    return tree;
}

class Bench
{
  public:
    explicit Bench(std::size_t small_vessels) : contrast_(with_small_vessels(tree_of_cells(), small_vessels))
    {
        const CatheterMouth mouth{{0, 0.29, 0}, 1.0};
        contrast_.set_mouths({&mouth, 1});
        while (tick_ < warm_ticks) step();
        std::size_t filled = 0;
        for (std::size_t i = 0; i < contrast_.cells().size(); ++i)
            filled += contrast_.iodine_mg_per_ml(i) > 1.0;
        if (filled < contrast_.cells().size() - 20) bench_fail("the tree of the benchmark has not filled");
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

double step_us(const bench_case *self)
{
    bench = std::make_unique<Bench>(static_cast<std::size_t>(self->argument));
    double fastest_us = 1e9;
    for (int round = 0; round < rounds; ++round) {
        const double begin_us = bench_now_us();
        for (int i = 0; i < measured_ticks; ++i) measured_contrast_step();
        fastest_us = std::min(fastest_us, (bench_now_us() - begin_us) / measured_ticks);
    }
    return fastest_us;
}

double step_instructions(const bench_case *self)
{
    bench = std::make_unique<Bench>(static_cast<std::size_t>(self->argument));
    for (int i = 0; i < measured_ticks; ++i) measured_contrast_step();
    return 0.0;
}

// Places a catheter in the aorta with its tip above the renal arteries.
WireFrame catheter_at(std::uint32_t tick)
{
    WireFrame wire;
    wire.tick = tick;
    wire.tip_arc_m = {0.0};
    for (int i = 0; i < 60; ++i) {
        WireNode node;
        node.position_m = {0.005, -0.02 - 0.002 * i, 0.0};
        node.arc_m = 0.002 * i;
        node.radius_m = 0.0008;
        wire.nodes.push_back(node);
    }
    return wire;
}

// Draws many pictures in the view of renal.session, with or without the medium, and returns the shortest
// drawing time in ms.
double frame_ms(const bench_case *self)
{
    Bodies bodies;
    std::string error;
    if (!read_bodies("out/aorta.bodies", bodies, error)) bench_fail(error.c_str());
    if (bodies.vessels.branches.empty()) bench_fail("out/aorta.bodies has no tree of vessels: bake it again");
    XrayScene scene;
    if (!scene.set_bodies(bodies, error)) bench_fail(error.c_str());
    Instrument catheter;
    catheter.table.knots_count = 1;
    catheter.table.knots[0].radius_inner_um = 500;
    PatientContrast contrast(bodies.vessels, {catheter});
    contrast.command(0, {RoomAction::inject, {15000, 10000, 0}});
    for (std::uint32_t tick = 0; tick <= 1600; tick += PatientContrast::look_every_ticks)
        contrast.advance(catheter_at(tick));
    Xray xray(scene, 2);
    XraySettings settings;
    settings.carm.isocentre_m = {0.0, -0.045, 0.0};
    settings.carm.field_m = 0.25;
    settings.size = 512;
    const RadiopaqueInstrument look = guidewire_look();
    const std::vector<SweptCurve> none;
    XrayPicture picture;
    XrayMemory memory;
    double fastest_ms = 1e9;
    for (std::uint32_t tick = 1601; tick < 1641; ++tick) {
        WireFrame wire = catheter_at(tick);
        const double begin_us = bench_now_us();
        if (self->argument) contrast.colour(wire);
        xray.render(settings, XrayFrame{{&look, 1}, wire, self->argument ? contrast.curves() : none}, 1,
                    &memory, picture);
        fastest_ms = std::min(fastest_ms, (bench_now_us() - begin_us) * 1e-3);
    }
    return fastest_ms;
}

const bench_case cases[] = {
    {"contrast.frame_ms", "ms", "size=512 view=kept threads=2 medium=none", nullptr, 0, frame_ms, 0},
    {"contrast.frame_ms", "ms", "size=512 view=kept threads=2 medium=aorta+renals", nullptr, 0, frame_ms, 1},
    {"contrast.step_us", "us", "cells=2000", nullptr, 0, step_us, 0},
    {"contrast.step_us", "us", "branches=3000", nullptr, 0, step_us, 3000},
    {"contrast.step_instructions", "instructions", "cells=2000", "measured_contrast_step", measured_ticks,
     step_instructions, 0},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
