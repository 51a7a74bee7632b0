#include "tools/lab/figures/study.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace vcsim3
{
namespace
{

// Calls work(0) .. work(count - 1) on several threads. If a call throws an exception, the other calls stop
// and this function rethrows the first exception.
void in_parallel(int count, int threads, const std::function<void(int)> &work)
{
    std::atomic<int> next = 0;
    std::exception_ptr failure;
    std::mutex guard;
    const auto worker = [&] {
        for (int i = next++; i < count; i = next++) {
            try {
                work(i);
            } catch (...) {
                const std::lock_guard lock(guard);
                if (!failure) failure = std::current_exception();
                next = count;
            }
        }
    };
    std::vector<std::thread> pool;
    for (int i = 1; i < threads; i++) pool.emplace_back(worker);
    worker();
    for (std::thread &thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

// Computes the completed fraction of many jobs that take different times.
class Progress
{
  public:
    Progress(std::string title, std::vector<double> weights, const Report &report)
        : title_(std::move(title)), weights_(std::move(weights)), done_(weights_.size(), 0.0), report_(report)
    {
    }

    Watch watch(std::size_t job)
    {
        return [this, job](double share) {
            const std::lock_guard lock(guard_);
            done_[job] = share;
            double sum = 0.0, all = 0.0;
            for (std::size_t i = 0; i < weights_.size(); i++) {
                sum += weights_[i] * done_[i];
                all += weights_[i];
            }
            return report_(title_, sum / all);
        };
    }

    void say(const std::string &line)
    {
        const std::lock_guard lock(guard_);
        report_(line, -1.0);
    }

  private:
    std::string title_;
    std::vector<double> weights_, done_;
    const Report &report_;
    std::mutex guard_;
};

std::string said(const CompressionResult &run)
{
    std::string text;
    if (!run.is_sound) {
        text = crn::formatted("%-10s burst", run.name.c_str());
    } else {
        text = crn::formatted(
            "%-10s compression %8.4f %% pushing, %8.4f %% at rest, %3d contacts, %.3f N at the hand",
            run.name.c_str(), run.pushing_pct, run.holding_pct, run.contacts, run.handle_N);
    }
    return text;
}

void add_runs(Study &study, const StudySettings &settings, const Vessel &vessel, const Report &report)
{
    const std::size_t baseline = settings.modes.size();
    std::vector<double> weights; // relative duration of each job
    for (const Mode &mode : settings.modes)
        weights.push_back(20.0 + (mode.kind == Mode::Kind::local ? mode.iterations : 1));
    weights.push_back(5.0);
    study.runs.resize(baseline + 1);
    Progress progress("compression", weights, report);
    in_parallel(static_cast<int>(baseline) + 1, settings.threads, [&](int job) {
        // The jobs that take longest run first, so that all threads end at about the same time.
        const std::size_t i = baseline - static_cast<std::size_t>(job);
        const Preset &preset = *settings.preset;
        study.runs[i] = i == baseline ? compress_direct(preset, vessel, settings.protocol, progress.watch(i))
                                      : compress_baseline(preset, settings.modes[i], vessel,
                                                          settings.protocol, progress.watch(i));
        progress.say(said(study.runs[i]));
    });
}

void add_stability(Study &study, const StudySettings &settings, const Report &report)
{
    std::vector<double> weights;
    for (const Preset &preset : presets()) weights.push_back(preset.substeps);
    study.stability.resize(presets().size());
    Progress progress("stability of the presets", weights, report);
    in_parallel(static_cast<int>(presets().size()), settings.threads, [&](int job) {
        const Preset &preset = presets()[job];
        const Watch watch = progress.watch(job);
        // Each of the three calls below does a third of the work of a preset.
        const auto measure = [&](Mode::Kind kind, int iterations, double third) {
            return smallest_stable_substeps(preset, {kind, iterations},
                                            [&](double share) { return watch((third + share) / 3.0); });
        };
        study.stability[job] = {&preset, measure(Mode::Kind::penalty, 1, 0.0),
                                measure(Mode::Kind::local, 10, 1.0), measure(Mode::Kind::global, 1, 2.0)};
        watch(1.0);
    });
}

} // namespace

Study make_study(const StudySettings &settings, const Vessel &vessel, const Report &report)
{
    Study study;
    study.preset = settings.preset;
    study.protocol = settings.protocol;
    add_runs(study, settings, vessel, report);
    if (settings.with_stability) add_stability(study, settings, report);
    if (settings.with_times) {
        Progress progress("timing", {1.0}, report);
        study.times = time_steps(study.runs, *settings.preset, vessel, settings.protocol, progress.watch(0));
    }
    return study;
}

const CompressionResult *find_run(const Study &study, const std::string &token)
{
    for (const CompressionResult &run : study.runs)
        if (run.token == token) return &run;
    return nullptr;
}

std::vector<std::string> order_faults(const Study &study)
{
    std::vector<std::string> faults;
    const CompressionResult *above = nullptr;
    for (const char *token : {"penalty", "local5", "local10", "local25", "local50"}) {
        const CompressionResult *run = find_run(study, token);
        if (!run) continue;
        if (above && !(above->pushing_pct > run->pushing_pct))
            faults.push_back(above->name + " is not compressed more than " + run->name);
        above = run;
    }
    const CompressionResult *direct = find_run(study, "direct");
    for (const CompressionResult &run : study.runs) {
        if (!run.is_sound) faults.push_back(run.name + " burst");
        if (direct && &run != direct && run.is_sound && !(run.pushing_pct > direct->pushing_pct))
            faults.push_back(run.name + " is compressed less than the direct solver");
    }
    return faults;
}

} // namespace vcsim3
