// seldinger surface
#include "host/app/cli.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/replay.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace seld
{

int command_surface(const SurfaceOptions &options)
{
    SurfaceSettings settings = options.surface;
    check_outputs({{"the recording", options.recording},
                   {"--scene", options.scene},
                   {"--bodies", settings.bodies_path}},
                  {{"--output", settings.output}});
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
    std::sort(ticks.begin(), ticks.end());
    ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
    const SceneFile scene = recorded_scene(recording.header, options.scene);
    settings.scene_path = scene.path;
    if (settings.bodies_path.empty()) settings.bodies_path = bodies_beside(scene.path);
    SurfaceSink sink(settings, ticks);
    Device device(scene, recording.header.tools, recording.header.entry, recording.header.rig);
    check_core(recording.header, device.identity());
    watch_for_interrupt();
    const ReplayResult result = replay_recording(device, recording, &sink, {});
    if (result.was_interrupted) {
        std::fprintf(stderr, "seldinger: interrupted: only %zu of %zu moments are in the file\n",
                     sink.moments(), ticks.size());
        return 1;
    }
    print_files({settings.output});
    return 0;
}

} // namespace seld
