#include "hil_tests/l0/sim_bench.hpp"
#include "host/link/link.hpp"
#include <new>

namespace hil
{

SimBench::SimBench(const PlantSettings &settings) : Bench(settings), sim_(seld_sim_create(8u << 20))
{
    if (sim_ == nullptr) throw std::bad_alloc();
    seld_sim_set_plant(sim_, &plant().inputs());
}

SimBench::~SimBench()
{
    seld_sim_destroy(sim_);
}

seld_port_outputs SimBench::edge(const seld_port_inputs &inputs)
{
    seld_sim_set_plant(sim_, &inputs);
    seld_sim_timer(sim_, 1);
    return seld_sim_read_outputs(sim_);
}

void SimBench::pass_frozen_ms()
{
    seld_sim_freeze(sim_, 1);
}

seld_port_outputs SimBench::restart()
{
    seld_sim_reset(sim_);
    has_restarted_ = true;
    return seld_sim_read_outputs(sim_);
}

void SimBench::write(std::span<const std::uint8_t> bytes)
{
    if (has_restarted_) {
        has_restarted_ = false;
        throw seld::LinkError("the device started again; begin with HELLO");
    }
    seld_sim_write(sim_, bytes.data(), bytes.size());
}

std::size_t SimBench::read(std::span<std::uint8_t> bytes)
{
    return seld_sim_read(sim_, bytes.data(), bytes.size());
}

void SimBench::pass_time_ms(std::uint32_t milliseconds)
{
    advance(milliseconds);
}

} // namespace hil
