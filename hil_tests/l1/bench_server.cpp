#include "hil_tests/l1/bench_server.hpp"
#include <atomic>
#include <cstdio>
#include <cstring>
#include <unistd.h>

namespace hil
{

namespace
{

std::uint32_t word(std::int32_t value)
{
    return static_cast<std::uint32_t>(value);
}

// Returns false if the program at the other end has closed the connection.
bool read_all(int file, void *bytes, std::size_t count)
{
    auto *place = static_cast<char *>(bytes);
    while (count > 0) {
        const ssize_t got = ::read(file, place, count);
        if (got <= 0) return false;
        place += got;
        count -= static_cast<std::size_t>(got);
    }
    return true;
}

bool write_all(int file, const void *bytes, std::size_t count)
{
    const auto *place = static_cast<const char *>(bytes);
    while (count > 0) {
        const ssize_t sent = ::write(file, place, count);
        if (sent <= 0) return false;
        place += sent;
        count -= static_cast<std::size_t>(sent);
    }
    return true;
}

void carry_out(crn::Emulator &emulator, const BenchRequest &request)
{
    switch (request.order) {
    case BenchOrder::power_on: // starts the time of a new rig
        emulator.page().host.milliseconds = 0;
        [[fallthrough]];
    case BenchOrder::power_cycle:
        emulator.power_cycle();
        break;
    case BenchOrder::edge:
        make_rig_edge(emulator, request.inputs, request.milliseconds);
        break;
    case BenchOrder::hold:
        emulator.pause();
        break;
    case BenchOrder::release:
        emulator.resume();
        break;
    }
}

} // namespace

void put_rig_inputs(const crn_port_inputs &from, rig_inputs &to)
{
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        const crn_port_track &track = from.tracks[k];
        to.tracks[k] = {word(from.hands[k].translation_counts),
                        word(from.hands[k].rotation_counts),
                        word(track.force_raw),
                        track.translation_sensor,
                        track.rotation_sensor,
                        track.force_sensor,
                        track.over_current};
    }
    to.syringe_counts = word(from.syringe_counts);
    to.syringe_sensor = from.syringe_sensor;
    to.inflator_raw = word(from.inflator_raw);
    to.inflator_sensor = from.inflator_sensor;
    to.buttons = from.buttons;
    to.switches = 0;
    if (from.emergency_stop) to.switches |= RIG_EMERGENCY_STOP;
    if (from.supply_good) to.switches |= RIG_SUPPLY_GOOD;
    if (from.stage_on) to.switches |= RIG_STAGE_ON;
    if (from.local_unlock) to.switches |= RIG_LOCAL_UNLOCK;
}

crn_port_outputs take_rig_outputs(rig_page &page)
{
    rig_outputs &from = page.device.outputs;
    crn_port_outputs outputs{};
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        outputs.motors[k] = {static_cast<std::int32_t>(rig_read(&from.axial_mN[k])),
                             static_cast<std::int32_t>(rig_read(&from.torque_uN_m[k]))};
    }
    outputs.drive = rig_read(&from.drive) != 0;
    outputs.enable = rig_read(&from.enable) != 0;
    outputs.lamp = static_cast<std::uint8_t>(rig_read(&from.lamp));
    return outputs;
}

void make_rig_edge(crn::Emulator &emulator, const crn_port_inputs &inputs, std::uint32_t milliseconds)
{
    rig_page &page = emulator.page();
    rig_host_half &host = page.host;
    // All messages that were sent before a millisecond begins are received before the work of this
    // millisecond begins, so every run of a test gives the same result.
    emulator.wait([&] { return rig_read(&page.device.to_device_tail) == host.to_device_head; }, "a request");
    rig_write(&host.inputs_begin, host.inputs_begin + 1);
    std::atomic_thread_fence(std::memory_order_release);
    put_rig_inputs(inputs, host.inputs);
    rig_write(&host.inputs_end, host.inputs_begin);
    host.milliseconds = milliseconds;
    const std::uint32_t edge = host.edge + 1;
    rig_write(&host.edge, edge);
    emulator.wait([&] { return rig_read(&page.device.edge_done) == edge; }, "a tick");
}

bool serve_bench(crn::Emulator &emulator, int connection)
{
    BenchRequest request;
    for (;;) {
        if (!read_all(connection, &request, sizeof request)) return true;
        BenchAnswer answer{};
        try {
            carry_out(emulator, request);
        } catch (const crn::EmulatorError &error) {
            std::snprintf(answer.trouble, sizeof answer.trouble, "%s", error.what());
        }
        answer.outputs = take_rig_outputs(emulator.page());
        answer.edge_counts = rig_read(&emulator.page().device.edge_counts);
        if (!write_all(connection, &answer, sizeof answer)) return false;
    }
}

} // namespace hil
