// Measures how long the X-ray picture of a patient's CT takes (docs/bench.md and docs/xray.md). The CT is
// made here: a trunk of 512^3 voxels of 0.7 mm with fat, lungs, spine, ribs and noise.
#include "firmware/bench/bench.h"
#include "host/xray/tests/voxel_shapes.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <vector>

using namespace crn;

namespace
{

constexpr int edge = 512;
constexpr int rounds = 6; // the fastest counts, since the machine does other work too

struct Look {
    double primary_deg, secondary_deg, y_m;
};
constexpr Look looks[] = {{0, 0, 0.0},  {45, -30, 0.03}, {-30, 0, 0.05},
                          {90, 0, 0.0}, {45, 0, 0.05},   {10, -30, -0.05}};

// Returns the mean, over all views, of the shortest time of a frame. `argument` is 1 for a kept view.
double ct_frame_ms(const bench_case *self)
{
    const bool keeps = self->argument != 0;
    XrayScene scene;
    std::string error;
    if (!scene.set_bodies({{}, {}, {}, std::make_shared<CtVolume>(trunk_volume(edge, 0.7))}, error))
        bench_fail(error.c_str());
    Xray xray(scene, 2);
    XraySettings settings;
    XrayPicture picture;
    std::vector<double> best(std::size(looks), 1e9), processor(best);
    for (int round = -1; round < rounds; ++round)
        for (std::size_t i = 0; i < std::size(looks); ++i) {
            settings.carm.primary_deg = looks[i].primary_deg;
            settings.carm.secondary_deg = looks[i].secondary_deg;
            settings.carm.isocentre_m = {0.0, looks[i].y_m, 0.0};
            settings.beam.fixed_technique = XrayTechnique{80, 60, 6, 0.3, 0.4};
            const auto render = [&] { xray.render(settings, {}, WireFrame{}, 7, picture); };
            if (keeps) render();
            const double begin_us = bench_now_us(), begin_ms = bench_processor_ms();
            render();
            if (round < 0) continue; // the beam's table is made once
            best[i] = std::min(best[i], (bench_now_us() - begin_us) * 1e-3);
            processor[i] = std::min(processor[i], bench_processor_ms() - begin_ms);
            if (xray.last_render_used_cache() != keeps)
                bench_fail("the view was kept when it should not be, or the reverse");
        }
    double sum = 0.0;
    for (double ms : best) sum += ms;
    std::fprintf(stderr, "%d^3 voxels; by view:", edge);
    for (double ms : best) std::fprintf(stderr, " %.2f", ms);
    std::fprintf(stderr, " ms; processor time, both threads:");
    for (double ms : processor) std::fprintf(stderr, " %.2f", ms);
    std::fprintf(stderr, " ms\n");
    return sum / static_cast<double>(best.size());
}

const bench_case cases[] = {
    {"xray.ct_frame_ms", "ms", "size=512 view=moved voxels=512^3 threads=2", nullptr, 0, ct_frame_ms, 0},
    {"xray.ct_frame_ms", "ms", "size=512 view=kept voxels=512^3 threads=2", nullptr, 0, ct_frame_ms, 1},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
