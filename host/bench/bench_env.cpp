// Measures the C library's simulations as reinforcement learning uses them (docs/bench.md). The first case
// inserts a wire in steps of 7.5 Hz on one core, and reads the state after each step. Further cases measure
// two threads that share many simulations, the restoring of a snapshot, and X-ray pictures with masks. The
// anatomy is the shipped aorta.
#include "firmware/bench/bench.h"
#include "host/base/tests/folder.hpp"
#include "host/cases/unpack.hpp"
#include "host/library/cournand.h"
#include <algorithm>
#include <ctime>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace
{

constexpr std::uint32_t step_ticks = 133;
constexpr int steps = 12, rounds = 6, worlds_of_scaling = 8;
constexpr double tip_element_max_mm = 3.0, fine_mm = 12.0;
constexpr float push_m_per_s = 0.035f, approach_m_per_s = 0.06f;
const std::string wire_file = "shared/examples/instruments/j_wire.toml";

void done(cournand_status status)
{
    if (status != COURNAND_OK) bench_fail(cournand_error_text());
}

template <class Struct> Struct sized()
{
    Struct made{};
    made.struct_bytes = sizeof made;
    return made;
}

const crn::tests::Folder &folder()
{
    static const crn::tests::Folder kept("bench-env");
    return kept;
}

cournand_scene *aorta()
{
    static cournand_scene *const scene = [] {
        const std::string path = folder().file("aorta");
        crn::unpack_scene("shared/examples/scenes/aorta.tar.xz", path,
                          [](std::size_t, std::size_t) { return true; });
        cournand_scene *opened = nullptr;
        done(cournand_scene_open((path + "/aorta.scene").c_str(), nullptr, &opened));
        return opened;
    }();
    return scene;
}

// Writes a J wire whose elements have the given length. The elements in the J are shorter where the core
// needs this, and the wire is short enough for the largest number of elements that the core permits.
std::string even_wire(double element_mm)
{
    std::ifstream file(wire_file);
    std::stringstream text;
    text << file.rdbuf();
    const auto set = [](const std::string &in, const std::string &key, double value) {
        return std::regex_replace(in, std::regex("(" + key + " = \\{ value = )[0-9.]+,"),
                                  "$01" + std::to_string(value) + ",");
    };
    std::string made = set(text.str(), "shaft_mm", element_mm);
    made = set(made, "tip_mm", std::min(element_mm, tip_element_max_mm));
    made = set(made, "fine_mm", fine_mm);
    made = std::regex_replace(made, std::regex("to_mm = 1450"), "to_mm = 850");
    const std::string path = folder().file("wire.toml");
    std::ofstream(path) << made;
    return path;
}

// `elements` is the number of rod elements inside the patient when the wire is fully inserted. If `elements`
// is 0, the wire has the elements of the shipped file.
cournand_world *world_of(int elements)
{
    const std::string path = elements == 0 ? wire_file : even_wire(600.0 / elements);
    cournand_tool *wire = nullptr;
    cournand_world *world = nullptr;
    done(cournand_tool_open(path.c_str(), &wire));
    done(cournand_world_create(aorta(), &wire, 1, nullptr, &world));
    done(cournand_tool_free(wire));
    return world;
}

void move(cournand_world *world, float speed_m_per_s, std::uint32_t ticks)
{
    const float action[COURNAND_ACTION_FLOATS] = {speed_m_per_s};
    done(cournand_world_move(world, action, ticks));
}

std::uint32_t read_state(cournand_world *world)
{
    auto pose = sized<cournand_pose>();
    auto reading = sized<cournand_reading>();
    auto place = sized<cournand_place>();
    done(cournand_world_pose(world, &pose));
    done(cournand_world_read(world, &reading));
    done(cournand_world_tip(world, 0, &place));
    return pose.node_count;
}

// Pushes the wire almost to a depth of 0.6 m, so that half of the measured steps end before this depth.
std::vector<std::uint8_t> approached(cournand_world *world)
{
    const double before_m = 0.6 - 0.5 * steps * step_ticks * 1e-3 * push_m_per_s;
    auto pose = sized<cournand_pose>();
    done(cournand_world_pose(world, &pose));
    const double way_m = before_m - pose.inserted_m[0];
    move(world, approach_m_per_s, static_cast<std::uint32_t>(way_m / approach_m_per_s * 1e3));
    std::size_t bytes = 0;
    done(cournand_world_snapshot_bytes(world, &bytes));
    std::vector<std::uint8_t> snapshot(bytes);
    done(cournand_world_save(world, snapshot.data(), snapshot.size()));
    return snapshot;
}

double processor_s()
{
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double steps_per_s(int elements)
{
    cournand_world *world = world_of(elements);
    const std::vector<std::uint8_t> snapshot = approached(world);
    double best = 0.0;
    std::uint32_t nodes = 0;
    for (int round = 0; round < rounds; round++) {
        done(cournand_world_restore(world, snapshot.data(), snapshot.size()));
        const double begin = processor_s();
        for (int step = 0; step < steps; step++) {
            move(world, push_m_per_s, step_ticks);
            nodes = read_state(world);
        }
        best = std::max(best, steps / (processor_s() - begin));
    }
    if (elements != 0 && std::abs(static_cast<int>(nodes) - elements) > elements / 10)
        bench_fail(("the wire has " + std::to_string(nodes) + " nodes in the body").c_str());
    done(cournand_world_free(world));
    return best;
}

double run_steps(const bench_case *self)
{
    return steps_per_s(self->argument);
}

double run_simulated(const bench_case *self)
{
    return steps_per_s(self->argument) * step_ticks * 1e-3;
}

// Returns how well two threads share many simulations: 100 (in %) if two threads take half the time of one.
double run_scaling(const bench_case *)
{
    std::vector<cournand_world *> worlds;
    for (int i = 0; i < worlds_of_scaling; i++) worlds.push_back(world_of(0));
    const std::vector<std::uint8_t> snapshot = approached(worlds[0]);
    std::vector<float> actions(worlds.size() * COURNAND_ACTION_FLOATS, 0.0f);
    for (std::size_t i = 0; i < worlds.size(); i++) actions[i * COURNAND_ACTION_FLOATS] = push_m_per_s;
    double least_us[2] = {1e18, 1e18};
    for (int round = 0; round < rounds; round++)
        for (const std::uint32_t threads : {1u, 2u}) {
            cournand_pool *pool = nullptr;
            done(cournand_pool_create(threads, &pool));
            for (cournand_world *world : worlds)
                done(cournand_world_restore(world, snapshot.data(), snapshot.size()));
            const double begin = bench_now_us();
            done(cournand_pool_move(pool, worlds.data(), worlds.size(), actions.data(), step_ticks, nullptr));
            least_us[threads - 1] = std::min(least_us[threads - 1], bench_now_us() - begin);
            done(cournand_pool_free(pool));
        }
    return 100.0 * least_us[0] / (2.0 * least_us[1]);
}

double run_restore(const bench_case *)
{
    cournand_world *world = world_of(0);
    const std::vector<std::uint8_t> snapshot = approached(world);
    double least_us = 1e18;
    for (int branch = 0; branch < 2000; branch++) {
        const double begin = bench_now_us();
        done(cournand_world_restore(world, snapshot.data(), snapshot.size()));
        least_us = std::min(least_us, bench_now_us() - begin);
    }
    return least_us;
}

// The benchmark's argument is the number of pixels along an edge of the picture. The picture has noise and
// masks, and the C-arm rests.
double run_picture(const bench_case *self)
{
    cournand_world *world = world_of(0);
    approached(world);
    cournand_renderer *renderer = nullptr;
    done(cournand_renderer_create(aorta(), 1, &renderer));
    auto place = sized<cournand_place>();
    done(cournand_world_tip(world, 0, &place));
    auto view = sized<cournand_view>();
    std::copy_n(place.tip_m, 3, view.isocentre_m);
    view.size = static_cast<std::uint32_t>(self->argument);
    view.flags = COURNAND_VIEW_LABELS;
    double least_us = 1e18;
    for (int frame = 0; frame < 60; frame++) {
        move(world, push_m_per_s, 1);
        view.seed++;
        auto picture = sized<cournand_picture>();
        const double begin = bench_now_us();
        done(cournand_render(renderer, world, &view, &picture));
        least_us = std::min(least_us, bench_now_us() - begin);
    }
    return least_us * 1e-3;
}

const bench_case cases[] = {
    {"env.steps_per_s", "1/s", "elements=256 wire=inserting", nullptr, 0, run_steps, 256},
    {"env.steps_per_s", "1/s", "elements=128 wire=inserting", nullptr, 0, run_steps, 128},
    {"env.steps_per_s", "1/s", "mesh=shipped wire=inserting", nullptr, 0, run_steps, 0},
    {"env.simulated_s_per_s", "1", "elements=256 wire=inserting", nullptr, 0, run_simulated, 256},
    {"env.simulated_s_per_s", "1", "elements=128 wire=inserting", nullptr, 0, run_simulated, 128},
    {"env.simulated_s_per_s", "1", "mesh=shipped wire=inserting", nullptr, 0, run_simulated, 0},
    {"env.scaling_pct", "%", "threads=2 worlds=8", nullptr, 0, run_scaling, 0},
    {"env.restore_us", "us", "mesh=shipped", nullptr, 0, run_restore, 0},
    {"env.picture_ms", "ms", "size=128 masks=yes view=kept", nullptr, 0, run_picture, 128},
    {"env.picture_ms", "ms", "size=512 masks=yes view=kept", nullptr, 0, run_picture, 512},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
