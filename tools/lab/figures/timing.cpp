#include "tools/lab/figures/timing.hpp"
#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>

namespace vcsim3
{
namespace
{

constexpr int rounds = 60, steps_per_round = 10;

// Simulates a single rod, either the baseline's or ours, and starts from the end of the rod's compression
// run.
class Runner
{
  public:
    Runner(const CompressionResult &run, const Preset &preset, const Vessel &vessel, const Protocol &protocol)
    {
        Mode mode;
        bool is_restored;
        if (parse_mode(run.token, mode)) {
            simulation_.emplace(make_simulation(preset, mode, vessel, protocol));
            is_restored = simulation_->restore(to_numbers(run.state));
        } else {
            direct_.emplace(make_direct(preset, vessel, protocol));
            is_restored = direct_->restore(run.state);
        }
        if (!is_restored)
            throw std::runtime_error("the state of " + run.name +
                                     " does not fit this preset and protocol: make all figures in one run");
    }

    void step(PhaseTimes *times)
    {
        if (simulation_) {
            simulation_->step(times);
        } else {
            direct_->tick(0.0);
        }
    }

    bool is_direct() const { return direct_.has_value(); }
    int steps_per_ms() const { return simulation_ ? simulation_->settings().substeps : 1; }

  private:
    std::optional<Simulation> simulation_;
    std::optional<DirectRod> direct_;
};

TimingResult time_step(Runner &runner)
{
    using Clock = std::chrono::steady_clock;
    TimingResult result;
    const Clock::time_point start = Clock::now();
    runner.step(&result.step);
    const double all_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (runner.is_direct()) result.direct_s = all_s;
    return result;
}

void keep_fastest(TimingResult &best, const TimingResult &now)
{
    const auto keep = [](double &kept, double seen) { kept = std::min(kept, seen); };
    keep(best.step.integrator_s, now.step.integrator_s);
    keep(best.step.constraints_s, now.step.constraints_s);
    keep(best.step.cosserat_s, now.step.cosserat_s);
    keep(best.step.collisions_s, now.step.collisions_s);
    keep(best.direct_s, now.direct_s);
}

} // namespace

// The option --toggle-collect of callgrind refers to this function by its name.
extern "C" __attribute__((noinline)) void vcsim3_measured_step(void *runner);
extern "C" void vcsim3_measured_step(void *runner)
{
    static_cast<Runner *>(runner)->step(nullptr);
}

std::vector<TimingResult> time_steps(const std::vector<CompressionResult> &runs, const Preset &preset,
                                     const Vessel &vessel, const Protocol &protocol, const Watch &watch)
{
    std::vector<Runner> runners;
    std::vector<TimingResult> best(runs.size());
    for (const CompressionResult &run : runs) runners.emplace_back(run, preset, vessel, protocol);
    for (int round = 0; round < rounds; round++) {
        for (std::size_t i = 0; i < runs.size(); i++) {
            for (int step = 0; step < steps_per_round; step++) {
                const TimingResult now = time_step(runners[i]);
                if (round == 0 && step == 0) best[i] = now;
                keep_fastest(best[i], now);
            }
            if (watch &&
                !watch((round + static_cast<double>(i + 1) / static_cast<double>(runs.size())) / rounds))
                throw Interrupted();
        }
    }
    for (std::size_t i = 0; i < runs.size(); i++) {
        best[i].name = runs[i].name;
        best[i].token = runs[i].token;
        best[i].steps_per_ms = runners[i].steps_per_ms();
    }
    return best;
}

void run_measured_steps(const CompressionResult &run, int count, const Preset &preset, const Vessel &vessel,
                        const Protocol &protocol)
{
    Runner runner(run, preset, vessel, protocol);
    for (int i = 0; i < count; i++) vcsim3_measured_step(&runner);
}

} // namespace vcsim3
