// Measures how long a replay takes to show any chosen second of a ten-minute recording (docs/bench.md). The
// program first makes the session: a J wire in the shipped aorta, with contrast medium, fluoroscopy and
// pauses.
#include "firmware/bench/bench.h"
#include "host/command/cli.hpp"
#include "host/live/replay_room.hpp"
#include "host/script/session.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <unistd.h>
#include <vector>

using namespace crn;

namespace
{

constexpr int minutes = 10, views = 60;
const char *const scene_file = "out/aorta.scene";

// Every minute the wire goes forward and back under fluoroscopy, turns, and then rests.
std::string script()
{
    std::string text = "fluoro rate 3.75 p/s\n";
    for (int minute = 0; minute < minutes; ++minute)
        text += "fluoro on\nadvance 200 mm at 20 mm/s\nfluoro off\nrotate 360 deg\n"
                "withdraw 180 mm at 20 mm/s\nwait 38 s\n";
    return text;
}

std::string make_recording()
{
    const SceneFile scene = read_scene(scene_file);
    const std::vector<Instrument> tools = {read_instrument("shared/examples/instruments/j_wire.toml")};
    PictureSettings settings;
    settings.scene_path = scene_file;
    settings.bodies_path = bodies_beside(scene_file);
    const SceneAnatomy anatomy = read_anatomy(settings);
    const crn_wire_entry entry = entry_of(scene, tools.size(), {});
    Device device(scene, tools, entry, host_rig());
    const std::string path = "/tmp/cournand_bench_replay_" + std::to_string(getpid()) + ".rec";
    Recorder recorder(path, device.recording_header("bench"));
    const std::unique_ptr<Patient> patient = make_patient(settings, anatomy, tools);
    RunSettings run;
    run.begin = entry_commands(scene);
    run_session(device, *patient, parse_session(script(), "bench"), &recorder, nullptr, run);
    return path;
}

// Shows the pictures of many different seconds of the recording while the C-arm's angles change, and returns
// the time for the slowest picture.
double slowest_ms(const bench_case *)
{
    const std::string path = make_recording();
    PictureSettings settings;
    ReplayRoom room(path, "", settings);
    std::remove(path.c_str());
    while (room.prepare(10'000)) {
    }
    double slowest = 0.0;
    for (std::uint32_t i = 0; i < views; ++i) {
        CArm carm = room.picture({0, {}}).carm;
        carm.primary_deg = -60.0 + 2.0 * i;
        const std::uint32_t second = (i * 367u) % (room.ticks() / 1000u);
        const auto begin = std::chrono::steady_clock::now();
        room.picture({second * 1000u + 999u, carm});
        slowest = std::max(
            slowest,
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
    return slowest;
}

const bench_case cases[] = {
    {"suite.scrub_ms", "ms", "minutes=10 size=512 view=slowest", nullptr, 0, slowest_ms, 0},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
