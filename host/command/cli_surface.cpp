// cournand surface
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/report/session_summary.hpp"
#include "host/session/replay.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crn
{

namespace
{

constexpr std::size_t emptied_ticks = 500; // after the inflator reached 0: by then the balloon has folded

struct Stages {
    std::size_t positioned = 0, inflated = 0, released = 0; // ticks
};

// Finds three ticks of the first inflation, which opens a lesion more than later ones: before the inflation,
// at its highest pressure, and shortly after the pressure has been released.
Stages stages_of(const Recording &recording, const std::string &path)
{
    const auto pressure = [&](std::size_t tick) { return recording.ticks[tick].input.inflator_raw; };
    const std::size_t count = recording.ticks.size();
    std::size_t first = 0;
    while (first < count && pressure(first) == 0) ++first;
    if (first == count)
        throw std::runtime_error(path + ": --stages: no balloon is inflated in it; name moments with --at");
    Stages stages{first > 0 ? first - 1 : 0, first, first};
    for (; stages.released < count && pressure(stages.released) > 0; ++stages.released)
        if (pressure(stages.released) >= pressure(stages.inflated)) stages.inflated = stages.released;
    stages.released = std::min(stages.released + emptied_ticks, count);
    return stages;
}

std::uint32_t told(const char *name, std::size_t tick)
{
    say(stdout, "%-12s %8.3f s\n", name, static_cast<double>(tick) * 1e-3);
    return static_cast<std::uint32_t>(tick);
}

} // namespace

int command_surface(const SurfaceOptions &options)
{
    SurfaceSettings settings = options.surface;
    check_outputs({{"the recording", options.recording},
                   {"--scene", options.scene},
                   {"--bodies", settings.bodies_path}},
                  {{"--output", settings.output}, {"--png", settings.png}});
    const Recording recording = read_recording(options.recording);
    const double length_s = static_cast<double>(recording.ticks.size()) * 1e-3;
    std::vector<std::uint32_t> ticks;
    for (const double at_s : options.at_s) {
        if (!(at_s >= 0.0 && at_s <= length_s))
            throw std::runtime_error(options.recording + ": --at " + std::to_string(at_s) +
                                     " is not between its begin and its end at " + std::to_string(length_s) +
                                     " s");
        ticks.push_back(static_cast<std::uint32_t>(std::lround(at_s * 1e3)));
    }
    if (options.stages) {
        const Stages stages = stages_of(recording, options.recording);
        ticks.push_back(told("positioned", stages.positioned));
        ticks.push_back(told("inflated", stages.inflated));
        ticks.push_back(told("released", stages.released));
    }
    if (ticks.empty()) throw UsageError("surface: name moments with --at, or --stages");
    std::sort(ticks.begin(), ticks.end());
    ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
    const SceneFile scene = recorded_scene(recording.header, options.scene);
    settings.scene_path = scene.path;
    if (settings.bodies_path.empty()) settings.bodies_path = bodies_beside(scene.path);
    SurfaceSink sink(settings, ticks);
    Device device(scene, recording.header.tools, recording.header.entry, recording.header.rig, {},
                  recording.header.line);
    check_core(recording.header, device.identity());
    watch_for_interrupt();
    const ReplayResult result = replay_recording(device, recording, nullptr, &sink, {});
    if (result.was_interrupted) {
        say(stderr, "cournand: interrupted: only %zu of %zu moments are in the file\n", sink.panels().size(),
            ticks.size());
        return 1;
    }
    print_files({settings.output});
    if (!settings.png.empty()) print_files({settings.png});
    return 0;
}

} // namespace crn
