#include "hil_tests/l1/emulated_bench.hpp"

namespace hil
{

namespace
{

std::uint32_t word(std::int32_t value)
{
    return static_cast<std::uint32_t>(value);
}

void put_inputs(const seld_port_inputs &from, rig_inputs &to)
{
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        const seld_port_track &track = from.tracks[k];
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

} // namespace

EmulatedBench::EmulatedBench(const PlantSettings &settings, const seld::EmulatorOptions &options)
    : Bench(settings), emulator_(options), pipe_(emulator_, [this](std::uint32_t ms) { advance(ms); })
{
}

seld_port_outputs EmulatedBench::outputs_now()
{
    rig_outputs &page = emulator_.page().device.outputs;
    seld_port_outputs outputs{};
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        outputs.motors[k] = {static_cast<std::int32_t>(rig_read(&page.axial_mN[k])),
                             static_cast<std::int32_t>(rig_read(&page.torque_uN_m[k]))};
    }
    outputs.drive = rig_read(&page.drive) != 0;
    outputs.enable = rig_read(&page.enable) != 0;
    outputs.lamp = static_cast<std::uint8_t>(rig_read(&page.lamp));
    return outputs;
}

seld_port_outputs EmulatedBench::edge(const seld_port_inputs &inputs)
{
    rig_page &page = emulator_.page();
    rig_host_half &host = page.host;
    // What was said before this edge is heard before it, on every run.
    emulator_.wait([&] { return rig_read(&page.device.to_device_tail) == host.to_device_head; }, "a request");
    rig_write(&host.inputs_begin, host.inputs_begin + 1);
    std::atomic_thread_fence(std::memory_order_release);
    put_inputs(inputs, host.inputs);
    rig_write(&host.inputs_end, host.inputs_begin);
    host.milliseconds = static_cast<std::uint32_t>(plant().milliseconds());
    const std::uint32_t edge = host.edge + 1;
    rig_write(&host.edge, edge);
    emulator_.wait([&] { return rig_read(&page.device.edge_done) == edge; }, "a tick");
    return outputs_now();
}

void EmulatedBench::hold(bool held)
{
    if (held) {
        emulator_.pause();
    } else {
        emulator_.resume();
    }
}

seld_port_outputs EmulatedBench::restart()
{
    emulator_.power_cycle();
    return outputs_now();
}

} // namespace hil
