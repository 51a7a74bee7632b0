// Measures the computing time per picture for a stent with a thousand struts in a beating artery. The program
// also measures how well the shipped stent stays in place during one minute in the left anterior descending
// artery (LAD) of the shipped heart (docs/stent.md).
#include "firmware/bench/bench.h"
#include "host/stent/tests/stent_heart.hpp"
#include "host/stent/tests/stent_vessel.hpp"
#include <algorithm>
#include <memory>
#include <string>

using namespace crn;

namespace
{

constexpr int pictures_per_beat = 12, rounds = 40; // 75 /min at 15 pictures a second

// The stent of this benchmark has twice as many crowns and three times as many rings as the shipped stent,
// which makes 1,008 struts and 1,008 points.
StentDesign thousand_struts()
{
    StentDesign design = read_stent("shared/examples/stents/coronary_3_0x18.toml");
    design.rings = 42;
    design.crowns = 12;
    design.links = 4;
    design.strut_length_mm = 0.85;
    design.length_mm = 38.0;
    return design;
}

// The stent is inflated for two and a half heartbeats and deployed; then it moves with the beating artery.
class Bench
{
  public:
    Bench()
        : vessel_(beating_artery(true), 0, 2, 48, &*heart_.motion),
          stent_(thousand_struts(), artery_middle_mm)
    {
        for (int i = 0; i < 6 * pictures_per_beat; ++i) {
            const double up = std::clamp(std::min(i, 40 - i) / 8.0, 0.0, 1.0);
            move();
            BalloonPose pose;
            for (std::size_t k = 0; k < vessel_.line_mm().size(); ++k)
                if (std::abs(vessel_.along_mm(k) - artery_middle_mm) <= 21)
                    pose.points.push_back({vessel_.along_mm(k), vessel_.line_mm()[k],
                                           0.4 + up * (vessel_.radius_mm()[k] - 0.4)});
            stent_.step({&vessel_.wall(), i < 45 ? &pose : nullptr});
        }
        if (stent_.points().size() < 1000 || stent_figures(stent_, &vessel_.wall()).apposed_share < 0.95)
            bench_fail("the stent of the benchmark does not lie on its wall");
    }
    void move()
    {
        const double phase = static_cast<double>(picture_++ % pictures_per_beat) / pictures_per_beat;
        vessel_.move({static_cast<std::uint32_t>(phase * 0x1p32), 0}, opened_);
    }
    void step() { stent_.step({&vessel_.wall()}); }

  private:
    BeatingLattice heart_;
    VesselWall vessel_;
    Stent stent_;
    int picture_ = 0;
    std::vector<std::vector<double>> opened_ = {{1.0}};
};

std::unique_ptr<Bench> bench;

extern "C" BENCH_MEASURED void measured_stent_step()
{
    bench->step();
}

// Returns the mean computing time per picture of a heartbeat, or the time for the slowest picture of the
// beat. For each picture of the beat, the function takes the shortest time over many beats.
double step_us(const bench_case *self)
{
    bench = std::make_unique<Bench>();
    std::vector<double> fastest_us(pictures_per_beat, 1e9);
    for (int i = 0; i < rounds * pictures_per_beat; ++i) {
        bench->move();
        const double begin_us = bench_now_us();
        measured_stent_step();
        double &fastest = fastest_us[static_cast<std::size_t>(i % pictures_per_beat)];
        fastest = std::min(fastest, bench_now_us() - begin_us);
    }
    if (self->argument) return *std::max_element(fastest_us.begin(), fastest_us.end());
    double sum = 0.0;
    for (double us : fastest_us) sum += us;
    return sum / pictures_per_beat;
}

double wall_us(const bench_case *)
{
    bench = std::make_unique<Bench>();
    double fastest_us = 1e9;
    for (int i = 0; i < rounds * pictures_per_beat; ++i) {
        const double begin_us = bench_now_us();
        bench->move();
        fastest_us = std::min(fastest_us, bench_now_us() - begin_us);
    }
    return fastest_us;
}

double step_instructions(const bench_case *)
{
    bench = std::make_unique<Bench>();
    for (int i = 0; i < pictures_per_beat; ++i) {
        bench->move();
        measured_stent_step();
    }
    return 0.0;
}

// The shipped stent lies 22 mm from the beginning of the LAD of the shipped heart; for two seconds, a balloon
// opens it to the artery's own width. The test lasts 60 s at 70 beats per minute and 15 pictures per second.
// Result 0 is the largest distance in mm between a crown of the stent and the point to which the wall moves
// it. Result 1 is the depth in mm of the deepest strut in the wall. Result 2 is the smallest apposition of
// the stent to the wall, in %.
double in_the_heart(const bench_case *self)
{
    Bodies bodies;
    std::string error;
    if (!read_bodies("out/heart.bodies", bodies, error)) bench_fail((error + " (make coronary)").c_str());
    const std::optional<Motion> motion = read_motion("out/heart.scene", error);
    if (!motion) bench_fail("out/heart.scene does not move: make coronary");
    std::size_t lad = 0;
    while (lad < bodies.vessels.branches.size() && bodies.vessels.branches[lad].name != "LAD") ++lad;
    constexpr double at_mm = 22.0;
    VesselWall vessel(bodies.vessels, lad, at_mm - 15, at_mm + 15, &*motion);
    Stent stent(read_stent("shared/examples/stents/coronary_3_0x18.toml"), at_mm);
    const std::vector<std::vector<double>> opened(bodies.vessels.lesions.size(), {1.0});
    double off_mm = 0.0, deepest_mm = 0.0, apposed = 1.0;
    std::vector<WallFoot> held;
    for (int i = 0; i < 65 * 15; ++i) {
        const double time_s = i / 15.0, up = std::clamp(std::min(time_s, 4.0 - time_s), 0.0, 1.0);
        vessel.move({static_cast<std::uint32_t>(std::fmod(time_s * 70 / 60, 1.0) * 0x1p32), 0}, opened);
        BalloonPose pose;
        for (std::size_t k = 0; k < vessel.line_mm().size(); ++k)
            if (std::abs(vessel.along_mm(k) - at_mm) <= 10)
                pose.points.push_back(
                    {vessel.along_mm(k), vessel.line_mm()[k], 0.4 + up * (vessel.radius_mm()[k] - 0.4)});
        stent.step({&vessel.wall(), time_s < 5 ? &pose : nullptr});
        if (time_s < 5) continue;
        if (held.empty())
            for (const StentPoint &point : stent.points())
                held.push_back(vessel.wall().walk(point.place_mm, point.foot.triangle));
        for (std::size_t k = 0; k < held.size(); ++k) {
            if (!held[k].is_known()) bench_fail("a crown in the LAD has no wall near it");
            off_mm = std::max(off_mm, (vessel.wall().place(held[k]) - stent.points()[k].place_mm).norm());
        }
        if (self->argument == 1) deepest_mm = std::max(deepest_mm, deepest_strut_mm(stent, vessel.wall()));
        if (self->argument == 2)
            apposed = std::min(apposed, stent_figures(stent, &vessel.wall()).apposed_share);
    }
    return self->argument == 0 ? off_mm : self->argument == 1 ? deepest_mm : 100 * apposed;
}

const bench_case cases[] = {
    {"stent.step_us", "us", "struts=1008 beat=mean", nullptr, 0, step_us, 0},
    {"stent.step_us", "us", "struts=1008 beat=slowest", nullptr, 0, step_us, 1},
    {"stent.step_instructions", "instructions", "struts=1008 beat=mean", "measured_stent_step",
     pictures_per_beat, step_instructions, 0},
    {"stent.wall_us", "us", "vertices=2232", nullptr, 0, wall_us, 0},
    {"stent.heart_off_mm", "mm", "at=LAD seconds=60", nullptr, 0, in_the_heart, 0},
    {"stent.heart_depth_mm", "mm", "at=LAD seconds=60", nullptr, 0, in_the_heart, 1},
    {"stent.heart_apposed_pct", "%", "at=LAD seconds=60", nullptr, 0, in_the_heart, 2},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
