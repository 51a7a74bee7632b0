#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/cases/tube_scene.h"
#include "host/base/format.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/instrument.hpp"
#include "host/session/device.hpp"
#include <cstdarg>

namespace hil
{

namespace
{

constexpr std::uint32_t host_every_ms = 8;

} // namespace

const std::vector<std::uint8_t> &tube_scene()
{
    static const std::vector<std::uint8_t> scene = [] {
        std::vector<std::uint8_t> bytes(4u << 20);
        bytes.resize(hil_tube_scene(bytes.data(), bytes.size()));
        return bytes;
    }();
    return scene;
}

std::string text(const char *format, ...)
{
    va_list values;
    va_start(values, format);
    std::string result = crn::formatted_with(format, values);
    va_end(values);
    return result;
}

void check(bool is_true, const char *format, ...)
{
    if (is_true) return;
    va_list values;
    va_start(values, format);
    std::string result = crn::formatted_with(format, values);
    va_end(values);
    throw Failure(result);
}

void check_same(const Ending &a, const Ending &b, const char *what)
{
    check(a.states.size() == b.states.size(), "%s: %zu ticks and %zu ticks", what, a.states.size(),
          b.states.size());
    for (std::size_t i = 0; i < a.states.size(); i++) {
        const crn_wire_tick_state &left = a.states[i], &right = b.states[i];
        check(left.hash_lane0 == right.hash_lane0 && left.hash_lane1 == right.hash_lane1,
              "%s: hashes differ from tick %u on: %08x %08x and %08x %08x", what, unsigned{left.tick},
              unsigned{left.hash_lane0}, unsigned{left.hash_lane1}, unsigned{right.hash_lane0},
              unsigned{right.hash_lane1});
    }
    check(a.hash == b.hash, "%s: final hash %016llx and %016llx", what,
          static_cast<unsigned long long>(a.hash), static_cast<unsigned long long>(b.hash));
}

crn_wire_rig plant_rig()
{
    const AxisSettings along{}, about = rotation_axis_settings;
    crn_wire_rig rig = crn::host_rig();
    for (crn_wire_track &track : rig.tracks) {
        track.damping_mN_s_per_m = static_cast<std::uint32_t>(along.viscous * 1e3);
        track.damping_nN_m_s_per_rad = static_cast<std::uint32_t>(about.viscous * 1e9);
        track.coupling_N_per_m = 1000;
        track.coupling_mN_s_per_m = 200;
        track.coupling_uN_m_per_rad = 2000;
        track.coupling_nN_m_s_per_rad = 400;
    }
    return rig;
}

void set_up(crn::Link &link)
{
    static const crn::Instrument wire = crn::read_instrument("shared/examples/instruments/j_wire.toml");
    link.hello();
    link.load_scene(tube_scene());
    link.load_tools({&wire.table, 1});
    crn_wire_entry entry{};
    entry.direction_x_q30 = 1 << 30;
    entry.inserted_um_count = 1;
    entry.inserted_um[0] = 30000;
    link.set_entry(entry);
    link.set_rig(plant_rig());
}

crn_wire_tick_input sample_input(std::uint32_t tick)
{
    const auto t = static_cast<std::int32_t>(tick);
    crn_wire_tick_input input{};
    input.hands_count = 1;
    input.hands[0].translation_counts = t < 300 ? 200 * t : 60000 - 50 * (t - 300);
    input.hands[0].rotation_counts = 40 * t;
    return input;
}

Ending lockstep_session(crn::Link &link, std::uint32_t ticks, std::uint32_t batch,
                        const std::function<void(std::uint32_t tick)> &between,
                        const std::function<crn_wire_tick_input(std::uint32_t tick)> &input_of)
{
    Ending ending;
    link.use_lockstep();
    link.arm();
    link.start();
    std::vector<crn_wire_tick_input> inputs;
    while (link.tick() < ticks) {
        inputs.clear();
        for (std::uint32_t i = 0; i < batch && link.tick() + i < ticks; i++)
            inputs.push_back(input_of(link.tick() + i));
        const auto states = link.step(inputs, false);
        ending.states.insert(ending.states.end(), states.begin(), states.end());
        if (between) between(link.tick());
    }
    ending.tick = link.tick();
    ending.hash = link.read_hash64().hash;
    return ending;
}

Ending host_only_session(std::uint32_t ticks, std::uint32_t batch)
{
    crn::SimTransport pipe;
    crn::Link link(pipe);
    set_up(link);
    return lockstep_session(link, ticks, batch);
}

void start_free_run(Bench &bench, crn::Link &link)
{
    link.use_free_run();
    link.arm();
    bench.advance(1); // the device has sampled the rig
    link.arm_motors();
    link.start();
}

std::vector<crn_wire_tick_state> keep_talking(crn::Link &link)
{
    link.send_input(sample_input(0)); // the rig's own encoders count
    return link.free_run(0);
}

void keep_running(crn::Link &link, std::uint32_t milliseconds, Ending *ending)
{
    for (std::uint32_t ms = 0; ms < milliseconds; ms += host_every_ms) {
        link.send_input(sample_input(0)); // that the host is there; the rig's own encoders count
        const auto states = link.free_run(std::min(host_every_ms, milliseconds - ms));
        if (ending) ending->states.insert(ending->states.end(), states.begin(), states.end());
    }
    if (!ending) return;
    const crn::Hash64 hash = link.read_hash64();
    ending->tick = hash.tick;
    ending->hash = hash.hash;
}

void push_by_spring_hand(Plant &plant)
{
    plant.track(0).translation.set_hand(Hand::spring);
    plant.track(0).translation.move_hand(0.06);
    plant.track(0).rotation.move_hand(2.0);
}

} // namespace hil
