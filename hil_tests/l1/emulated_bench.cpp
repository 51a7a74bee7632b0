#include "hil_tests/l1/emulated_bench.hpp"
#include "hil_tests/l1/bench_server.hpp"

namespace hil
{

EmulatedBench::EmulatedBench(const PlantSettings &settings, const crn::EmulatorOptions &options)
    : Bench(settings), emulator_(options), pipe_(emulator_, [this](std::uint32_t ms) { advance(ms); })
{
}

crn_port_outputs EmulatedBench::edge(const crn_port_inputs &inputs)
{
    make_rig_edge(emulator_, inputs, static_cast<std::uint32_t>(plant().milliseconds()));
    return take_rig_outputs(emulator_.page());
}

void EmulatedBench::hold(bool held)
{
    if (held) {
        emulator_.pause();
    } else {
        emulator_.resume();
    }
}

crn_port_outputs EmulatedBench::restart()
{
    emulator_.power_cycle();
    return take_rig_outputs(emulator_.page());
}

} // namespace hil
